"""A shaker as the SiLA 2 package serves it, in a process of its own; what it does is in FOLDER/done.jsonl.

`work_s` is how long it shakes; `{"certificate": true}` encrypts, and leaves the CA in FOLDER/ca.pem.
"""

# ruff: noqa: N802, N803 - these are SiLA's names

import json
import socket
import sys
import threading
from pathlib import Path
from queue import Queue

from sila2.framework import DefinedExecutionError, Feature
from sila2.server import FeatureImplementationBase, SilaServer

folder, habits = Path(sys.argv[1]), json.loads(Path(sys.argv[2]).read_text("utf-8"))
RPM = """<DataType><Constrained><DataType><Basic>Real</Basic></DataType><Constraints>
<MaximalInclusive>1500</MaximalInclusive><MinimalInclusive>0</MinimalInclusive>
<Unit><Label>rpm</Label><Factor>0.016666</Factor><Offset>0</Offset>
<UnitComponent><SIUnit>Second</SIUnit><Exponent>-1</Exponent></UnitComponent></Unit>
</Constraints></Constrained></DataType>"""


def basic(kind):
    return f"<DataType><Basic>{kind}</Basic></DataType>"


def part(tag, name, inner, words=""):
    return (
        f"<{tag}><Identifier>{name}</Identifier><DisplayName>{name}</DisplayName>"
        f"<Description>{words or name}</Description>{inner}</{tag}>"
    )


def seen(how):
    return f"<Observable>{how}</Observable>"


SCHEMA = "http://www.sila-standard.org"
WHERE = f"{SCHEMA} https://gitlab.com/SiLA2/sila_base/raw/master/schema/FeatureDefinition.xsd"
FDL = f"""<?xml version="1.0" encoding="utf-8" ?>
<Feature xmlns="{SCHEMA}" xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" xsi:schemaLocation="{WHERE}"
 SiLA2Version="1.0" FeatureVersion="1.0" Originator="org.example" Category="shaking">
<Identifier>Shaking</Identifier><DisplayName>Shaking</DisplayName><Description>It shakes</Description>
""" + "".join([
    part("Command", "SetSpeed", seen("No") + part("Parameter", "TargetSpeed", RPM)
         + "<DefinedExecutionErrors><Identifier>Unbalanced</Identifier></DefinedExecutionErrors>", "Fast"),
    part("Command", "Shake", seen("Yes") + part("Parameter", "Label", basic("String"))
         + part("Response", "Turns", basic("Integer")) + part("Response", "Note", basic("String"))),
    part("Command", "StopNow", seen("No")),
    part("Command", "Upload", seen("No") + part("Parameter", "Data", basic("Binary"))),
    part("Command", "Weigh", seen("Yes") + part("Parameter", "Label", basic("String"))
         + part("Response", "Result", f"<DataType><Structure>{part('Element', 'Mass', RPM)}"
                f"{part('Element', 'Stable', basic('Boolean'))}</Structure></DataType>")
         + part("IntermediateResponse", "Mass", basic("Real"))),
    part("Property", "Climate", seen("No") + f"<DataType><Structure>{part('Element', 'Damp', RPM)}"
         f"{part('Element', 'Note', basic('String'))}</Structure></DataType>"),
    part("Property", "Speed", seen("Yes") + RPM),
    part("Property", "Count", seen("No") + basic("Integer")),
    part("Property", "Steps", seen("No") + f"<DataType><List>{RPM}</List></DataType>"),
    part("DefinedExecutionError", "Unbalanced", "", "The load is unbalanced"),
]) + "</Feature>"  # fmt: skip


def done(what, **more):
    with (folder / "done.jsonl").open("a", encoding="utf-8") as file:
        file.write(json.dumps({"done": what, **more}) + "\n")


class Shaking(FeatureImplementationBase):
    count = 0
    stop = threading.Event()
    turn = threading.Lock()
    _Speed_producer_queue = Queue()  # by this name the library finds what clients subscribe to

    def get_Count(self, *, metadata):
        return self.count

    def get_Climate(self, *, metadata):
        return (40.0, "dry")

    def Weigh(self, Label, *, metadata, instance):
        instance.begin_execution()
        for mass in (1.0, 2.0):
            instance.send_intermediate_response(mass)
        return 2.5, True

    def get_Steps(self, *, metadata):
        return [100.0, 200.0]

    def Speed_on_subscription(self, *, metadata):
        return None

    def SetSpeed(self, TargetSpeed, *, metadata):
        if TargetSpeed == 1313:
            raise DefinedExecutionError(
                FEATURE.defined_execution_errors["Unbalanced"], "balance it"
            )
        self._Speed_producer_queue.put(TargetSpeed)
        done("speed", to=TargetSpeed)
        return ()

    def StopNow(self, *, metadata):
        self.stop.set()
        done("stop")
        return ()

    def Upload(self, Data, *, metadata):
        return ()

    def Shake(self, Label, *, metadata, instance):
        instance.begin_execution()
        self.stop.clear()
        with self.turn:
            if not self.stop.wait(habits.get("work_s", 0.3)):
                type(self).count += 1
                done("dispense", given=Label)
        return self.count, Label


FEATURE = Feature(FDL)
SERVER = SilaServer("Shaker", "Shaker", "A shaker", "1.0", "https://example.org")
shaking = Shaking(SERVER)
shaking._Speed_producer_queue.put(0.0)
SERVER.set_feature_implementation(FEATURE, shaking)
with socket.socket() as free:
    free.bind(("127.0.0.1", 0))
    port = free.getsockname()[1]
if habits.get("certificate"):
    from sila2.server.encryption import generate_self_signed_certificate

    key, certificate = generate_self_signed_certificate(SERVER.server_uuid, "127.0.0.1")
    SERVER.start("127.0.0.1", port, key, certificate, enable_discovery=False)
    (folder / "ca.pem").write_bytes(certificate)
else:
    SERVER.start_insecure("127.0.0.1", port, enable_discovery=False)
done("on")
(folder / "where.part").write_text(f"sila2://127.0.0.1:{port}")
(folder / "where.part").replace(folder / "where")
threading.Event().wait()
