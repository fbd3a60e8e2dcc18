"""Progress for programs: each event as one line of JSON."""

import sys
from typing import TextIO

from ...schemas.event import Event


class JsonWatch:
    """Writes each event as it happens."""

    def __init__(self, out: TextIO | None = None) -> None:
        self.out = out or sys.stdout

    def __call__(self, event: Event) -> None:
        print(event.model_dump_json(), file=self.out, flush=True)
