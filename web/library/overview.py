"""The list of protocols, each with the checker's result and the outcomes of its runs."""

import asyncio
import re
from collections.abc import Callable
from pathlib import Path
from statistics import median

from ...system.tasks import end, spawn
from ..local.refusal import Refusal
from ..models.protocols import CheckedText, CheckText, ProtocolSummary, ProtocolText
from ..models.runs import RunSummary
from ..report.formatting import seconds_between
from .library import Library
from .text_check import TextCheck

PATIENCE_S = 1.5
"""How long the list waits for the checker; results that come later are shown the next time."""
MARK = re.compile(r"""^\s*\{?\s*["']?labrun["']?\s*:""", re.MULTILINE)
TITLE = re.compile(r"""^\s*["']?name["']?\s*:\s*["']?([^"'\n,#]*)""", re.MULTILINE)


class Overview:
    """Identifies each text by its revision, so that it is checked once."""

    def __init__(
        self, library: Library, looking: TextCheck, runs: Callable[[], list[RunSummary]]
    ) -> None:
        self._library = library
        self._looking = looking
        self._runs = runs
        self._known: dict[tuple[str, str, int], ProtocolSummary] = {}
        self._looks: dict[tuple[str, str, int], asyncio.Task[None]] = {}

    async def every(self) -> list[ProtocolSummary]:
        """All protocol files, by name."""
        found = []
        texts = await asyncio.to_thread(self._texts)
        newest = max((_newest(self._library.folder / text.name) for text in texts), default=0)
        for text in texts:
            key = (text.name, text.revision, newest)
            if key not in self._known and key not in self._looks:
                work = self._look(key, text)
                self._looks[key] = spawn(f"check {text.name}", work, expected=(Refusal,))
        if self._looks:
            await asyncio.wait(self._looks.values(), timeout=PATIENCE_S)
        for text in texts:
            known = self._known.get((text.name, text.revision, newest)) or _unchecked(text)
            found.append(self._with_runs(known))
        return found

    def forget(self, name: str) -> None:
        """A protocol was saved: drop the results of its earlier texts."""
        for key in [key for key in self._known if key[0] == name]:
            del self._known[key]

    async def close(self) -> None:
        """Stop waiting for checks."""
        await end(*self._looks.values())

    def _texts(self) -> list[ProtocolText]:
        texts = []
        for name in self._library.names():
            try:
                text = self._library.read(name)
            except Refusal:
                continue  # deleted meanwhile, or not text: not a protocol in any case
            if MARK.search(text.text):
                texts.append(text)
        return texts

    async def _look(self, key: tuple[str, str, int], text: ProtocolText) -> None:
        try:
            asked = CheckText(text=text.text, name=text.name)
            told = await self._looking.check(asked)
            if len(self._known) > 5000:
                self._known.clear()
            self._known[key] = _checked(text, told)
        finally:
            del self._looks[key]

    def _with_runs(self, known: ProtocolSummary) -> ProtocolSummary:
        ours = [run for run in self._runs() if run.file == known.name]
        good = [run for run in ours if run.fate == "succeeded"]
        took = [seconds_between(run.began_at, run.ended_at) for run in good if run.ended_at]
        return known.model_copy(
            update={
                "runs": len(ours),
                "succeeded": len(good),
                "median_s": median(took) if took else None,
            }
        )


def _newest(path: Path) -> int:
    try:
        return path.stat().st_mtime_ns
    except OSError:
        return 0


def _unchecked(text: ProtocolText) -> ProtocolSummary:
    said = TITLE.search(text.text)
    return ProtocolSummary(
        name=text.name, title=said[1].strip() if said else text.name, summary="", roles={},
        revision=text.revision, modified=text.modified, size=len(text.text.encode()),
    )  # fmt: skip


def _checked(text: ProtocolText, told: CheckedText) -> ProtocolSummary:
    errors = [problem for problem in told.problems if problem.severity == "error"]
    plain = _unchecked(text)
    return plain.model_copy(
        update={
            "title": told.title or plain.title,
            "summary": told.summary,
            "roles": {role.role: role.contract for role in told.roles},
            "errors": len(errors),
            "warnings": len(told.problems) - len(errors),
            "first_error": errors[0].message if errors else None,
        }
    )
