"""A source meter as PyMeasure's Keithley2400 speaks to it: `python source_meter_peer.py FOLDER HABITS.json`.

It is a process of its own, over TCP; each trigger takes `work_s`, adds a point to its buffer and a line
to FOLDER/done.jsonl.
"""

import contextlib
import json
import socket
import sys
import threading
import time
from pathlib import Path

folder, habits = Path(sys.argv[1]), json.loads(Path(sys.argv[2]).read_text("utf-8"))
state = {"points": 0, "volts": 0.0, "output": 0}
turn = threading.Lock()


def done(what, **more):
    with (folder / "done.jsonl").open("a", encoding="utf-8") as file:
        file.write(json.dumps({"done": what, **more}) + "\n")


def answer(line):
    """The answer to a command, None for none."""
    name, _, given = line.strip().lstrip(":").partition(" ")
    match name.upper():
        case "*IDN?":
            return "KEITHLEY INSTRUMENTS INC.,MODEL 2400,1234567,C30"
        case "SOURCE:VOLTAGE":
            state["volts"] = float(given)
            done("volts", to=state["volts"])
        case "SOURCE:VOLTAGE?":
            return f"{state['volts']:+.6E}"
        case "*TRG":
            time.sleep(habits.get("work_s", 0.0))
            state["points"] += 1
            done("trigger")
        case "TRACE:POINTS:ACTUAL?":
            return str(state["points"])
    return None


def serve(connection):
    left = b""
    with connection, contextlib.suppress(OSError):
        while data := connection.recv(4096):
            *lines, left = (left + data).split(b"\n")
            for line in lines:
                with turn:
                    told = answer(line.decode("ascii", "replace"))
                if told is not None:
                    connection.sendall(told.encode() + b"\n")


listener = socket.create_server(("127.0.0.1", 0))
done("on")
(folder / "where.part").write_text(f"127.0.0.1:{listener.getsockname()[1]}")
(folder / "where.part").replace(folder / "where")
while True:
    threading.Thread(target=serve, args=(listener.accept()[0],), daemon=True).start()
