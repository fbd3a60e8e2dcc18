"""A labrun command on its own pseudo-terminal, in which lines are typed and keys pressed."""

import os
import pty
import re
import select
import subprocess
import sys
import threading
from pathlib import Path

PATIENCE_S = 500.0
LOOK_S = 0.5
ESCAPES = re.compile(r"\x1b\[[0-9;?]*[A-Za-z]|\r")


class Terminal:
    """`Terminal(folder, "run", "scan.yaml", COLUMNS="100")`, with what is added to the environment."""

    def __init__(self, folder: Path, *words: object, **environment: str) -> None:
        self.ours, theirs = pty.openpty()
        self.process = subprocess.Popen(
            [sys.executable, "-m", "labrun.engine", *map(str, words)],
            cwd=folder, stdin=theirs, stdout=theirs, stderr=theirs,
            preexec_fn=lambda: os.login_tty(theirs),
            env={**os.environ, "TERM": "xterm-256color", "COLUMNS": "200", **environment},
        )  # fmt: skip
        os.close(theirs)
        self.screen = ""
        self._typed = 0  # how much of the screen stood there when somebody typed last
        self._over = False
        self._news = threading.Condition()
        self._reading = threading.Thread(target=self._read)
        self._reading.start()

    def _read(self) -> None:
        told = ""
        while True:
            # Looked at twice a second: once a read slept on beside what there was to be read.
            if not select.select([self.ours], [], [], LOOK_S)[0]:
                continue
            try:
                told += os.read(self.ours, 65536).decode(errors="replace")
            except OSError:  # the command has ended
                break
            with self._news:
                self.screen = ESCAPES.sub("", told)
                self._news.notify_all()
        with self._news:
            self._over = True
            self._news.notify_all()

    def wait_for(self, words: str) -> None:
        """Until this stands on the screen, behind what stood there when something was typed last."""
        with self._news:
            self._news.wait_for(lambda: self._shows(words) or self._over, PATIENCE_S)
            assert self._shows(words), self.screen

    def _shows(self, words: str) -> bool:
        return words in self.screen[self._typed :]

    def press(self, keys: str) -> None:
        with self._news:
            self._typed = len(self.screen)
        os.write(self.ours, keys.encode())

    def answer(self, question: str, line: str) -> None:
        """Type a line when this has been asked."""
        self.wait_for(question)
        self.press(f"{line}\n")

    def end(self) -> int:
        """Its exit status; all that it said is on the screen then."""
        status = self.process.wait(PATIENCE_S)
        self._reading.join(PATIENCE_S)
        return status

    def close(self) -> None:
        if self.process.poll() is None:
            self.process.kill()
        self.end()
        os.close(self.ours)
