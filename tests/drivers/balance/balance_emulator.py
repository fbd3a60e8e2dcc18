"""A balance that speaks MT-SICS levels 0 and 1 on a pseudo-terminal, and misbehaves when told to."""

import contextlib
import os
import select
import termios
import threading
import time
import tty
from pathlib import Path

CAPACITY_G, ZERO_RANGE_G, UNDER_G = 220.0, 4.4, -5.0
KNOWN = ["@", "I0", "I1", "I2", "I3", "I4", "S", "SI", "SIR", "T", "TA", "TAC", "TI", "Z", "ZI"]
GARBAGE = b"\xf8\x80\xfe\x0c\xe0\xf8\n"


class BalanceEmulator:
    """What stands on the pan is `load_g`; `stable`, `busy`, `silent` and the like are its moods.

    `settles_after`: the readings that it takes to stand still. `lost`: of a zero or tare the command
    or the answer gets lost. `set` counts those that it has done.

    Its port is a symbolic link, as a cable that is plugged in again gets another terminal.
    """

    def __init__(self, link: Path, *, settles_after: int = 0, load_g: float = 12.5) -> None:
        self.link, self.stable, self.load_g = link, settles_after == 0, load_g
        self.settles_after, self.set, self.lost = settles_after, 0, ""
        self.zero_g = self.tare_g = 0.0
        self.serial_number, self.unit, self.baud = "B123456789", "g", termios.B9600
        self.busy = self.silent = False
        self.level = 1
        self.noise = b""
        self.says: str | None = None
        self.heard: list[str] = []
        self._repeats = False
        self._master = -1
        self._thread = threading.Thread(target=self._listen, daemon=True)
        self._stop = threading.Event()

    def __enter__(self) -> "BalanceEmulator":
        self.plug()
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._stop.set()
        self._thread.join(5)
        self.unplug()

    def plug(self) -> None:
        """Put the cable in: a terminal of its own, under the same name."""
        master, slave = os.openpty()
        tty.setraw(master)
        self.link.unlink(missing_ok=True)
        self.link.symlink_to(os.ttyname(slave))
        os.close(slave)
        self._master = master

    def unplug(self) -> None:
        """Pull the cable."""
        master, self._master = self._master, -1
        self.link.unlink(missing_ok=True)
        if master >= 0:
            os.close(master)

    def _listen(self) -> None:
        left, next_repeat = b"", 0.0
        while not self._stop.is_set():
            # A closed terminal, a number that was given away, nobody on the other side: all the same.
            with contextlib.suppress(OSError, ValueError):
                ready, _, _ = select.select([self._master], [], [], 0.02)
                if ready:
                    left += os.read(self._master, 1024)
                *lines, left = left.split(b"\r\n")
                for line in lines:
                    self._answer(line.decode("ascii", "replace"))
                if self._repeats and time.monotonic() > next_repeat:
                    next_repeat = time.monotonic() + 0.1
                    self._send(self._weight("S"))
                continue
            time.sleep(0.02)

    def _answer(self, line: str) -> None:
        self.heard.append(line)
        if self.silent:
            return
        if termios.tcgetattr(self._master)[4] != self.baud:
            os.write(self._master, GARBAGE)
        elif self.says is not None:
            self._send(self.says)
        elif line in ("T", "Z") and self.lost == "command":
            self.silent = True
        else:
            if line == "SI" and not self.stable and self.settles_after:
                self.settles_after -= 1
                self.stable = self.settles_after == 0
            self.silent = line in ("T", "Z") and self.lost == "answer"
            for answer in self._perform(*line.partition(" ")[::2]):
                self._send(answer)

    def _send(self, line: str) -> None:
        if self.silent:
            return
        noise, self.noise = self.noise, b""
        os.write(self._master, noise + line.encode("ascii") + b"\r\n")

    def _perform(self, name: str, word: str) -> list[str]:
        known = KNOWN if self.level else [one for one in KNOWN if not one.startswith("T")]
        if name not in known or (word and name != "TA"):
            return ["ES"]
        if name in ("S", "SI", "@"):
            self._repeats = False
        match name:
            case "@":
                self.tare_g = 0.0
                return [f'I4 A "{self.serial_number}"']
            case "I0":
                rows = [f'I0 B {int(one.startswith("T"))} "{one}"' for one in known]
                return [*rows[:-1], rows[-1].replace("B", "A", 1)]
            case "I1":
                return ['I1 A "01" "2.00" "2.20" "" ""']
            case "I2":
                return ['I2 A "XS204 Excellence 220.0090 g"']
            case "I3":
                return ['I3 A "2.10 10.28.0.493.142"']
            case "I4":
                return [f'I4 A "{self.serial_number}"']
            case "SIR":
                self._repeats = True
                return []
            case "TA":
                return [self._preset(word) if word else f"TA A {self.tare_g:10.4f} {self.unit}"]
            case "TAC":
                self.tare_g = 0.0
                return ["TAC A"]
        return [self._weigh(name)]

    def _weigh(self, name: str) -> str:
        waits = name in ("S", "T", "Z")
        gross = self.load_g - self.zero_g
        if self.busy or (waits and not self.stable):
            return f"{name[0] if name == 'SI' else name} I"
        if name in ("S", "SI"):
            return self._weight("S")
        most, least = (ZERO_RANGE_G, -ZERO_RANGE_G) if name[0] == "Z" else (CAPACITY_G, UNDER_G)
        beyond = self.load_g if name[0] == "Z" else gross
        if not least <= beyond <= most:
            return f"{name} {'+' if beyond > most else '-'}"
        self.set += 1
        if name[0] == "Z":
            self.zero_g, self.tare_g = self.load_g, 0.0
            return "Z A" if name == "Z" else f"ZI {self._mark()}"
        self.tare_g = gross
        return f"{name} {self._mark()} {gross:10.4f} {self.unit}"

    def _weight(self, name: str) -> str:
        gross = self.load_g - self.zero_g
        if gross > CAPACITY_G or gross < UNDER_G:
            return f"{name} {'+' if gross > 0 else '-'}"
        return f"{name} {self._mark()} {gross - self.tare_g:10.4f} {self.unit}"

    def _mark(self) -> str:
        return "S" if self.stable else "D"

    def _preset(self, word: str) -> str:
        try:
            self.tare_g = float(word.split()[0])
        except ValueError:
            return "TA L"
        return f"TA A {self.tare_g:10.4f} {self.unit}"
