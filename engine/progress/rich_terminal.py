"""Progress in a terminal: a bar for each loop, what runs now, and the lines that matter above."""

import sys

from rich.console import Console, Group
from rich.live import Live
from rich.progress_bar import ProgressBar
from rich.table import Table
from rich.text import Text

from ...schemas.event import KINDS, Event
from ...system.keyboard import Keyboard
from ...system.pace import duration_text, rate_text
from ...system.process import user_name
from ..control.control import Control
from ..run.questions import Question, WrongAnswer
from ..run.run import Run
from .progress import Progress, choices_text, ending_lines, ending_text, harmless, line_of

FRAMES_A_SECOND = 8
STYLES = {"control": "yellow", "report": "green"}


class RichWatch:
    """Draws the run and takes answers to its questions from the keyboard."""

    kinds = KINDS - {"step", "safe"}

    def __init__(self, run: Run, control: Control, console: Console | None = None) -> None:
        self.run = run
        self.control = control
        self.console = console or Console()
        self.progress = Progress()
        self.live: Live | None = None
        self.keyboard = Keyboard(sys.stdin.fileno(), self._typed)

    def __call__(self, event: Event) -> None:
        self.progress.take(event)
        match event.event:
            case "run":
                self.console.print(f"run [bold]{event.path}[/]", highlight=False)
                self._show()
            case "question" if event.state == "open":
                self._ask(event)
            case "answer":
                self._answered()
            case "finished":
                self._end(event)
            case _:
                if line := line_of(event):
                    self._say(line, STYLES.get(event.event, ""))
                elif self.live is None and not self._open_questions():
                    self._show()

    # --- drawing

    def _show(self) -> None:
        if self.live is None:
            self.live = Live(
                get_renderable=self._draw, console=self.console, transient=True,
                refresh_per_second=FRAMES_A_SECOND, redirect_stderr=False,
            )  # fmt: skip
            self.live.start()

    def _hide(self) -> None:
        if self.live is not None:
            self.live.stop()
            self.live = None

    def _draw(self) -> Group:
        parts: list[Table | Text] = [
            self._loop(loop) for loop in list(self.progress.loops.values())
        ]
        parts.append(Text(f"  now  {self.progress.now() or self.progress.phase}", style="dim"))
        return Group(*parts)

    def _loop(self, loop) -> Table:
        name = loop.path.rpartition("/")[2]
        line = Table.grid(padding=(0, 1))
        line.add_row(
            Text(name, style="bold"),
            ProgressBar(total=1 if loop.total == 0 else loop.total, completed=loop.done, width=32),
            Text(loop.done_text),
            Text(rate_text(loop.rate) if loop.rate else ""),
            Text(f"{duration_text(loop.left_s)} left" if loop.rate else ""),
            Text(f"{loop.failed} failed" if loop.failed else "", style="red"),
        )
        return line

    def _say(self, text: str, style: str = "") -> None:
        self.console.print(harmless(text), style=style or None, highlight=False, markup=False)

    def _end(self, event: Event) -> None:
        self._hide()
        colour = {"succeeded": "green", "aborted": "yellow"}.get(event.state, "red")
        self._say(ending_text(event), colour)
        for line in ending_lines(event):
            self._say(line)

    # --- questions

    def _open_questions(self) -> list[Question]:
        return [q for q in self.run.questions.open.values() if q.choice is None]

    def _ask(self, event: Event) -> None:
        self._hide()
        asked = harmless(f" {event.text} [{choices_text(event)}] ")
        self.console.print(
            Text.assemble(("?", "bold"), asked), end=""
        )  # no markup: [yes/no] is text
        self.keyboard.open()

    def _typed(self, line: str) -> None:
        open_questions = self._open_questions()
        if not open_questions:
            return
        question = open_questions[0]
        pairs = [part for part in line.split() if "=" in part]
        values = {pair.partition("=")[0]: pair.partition("=")[2] for pair in pairs}
        word = " ".join(part for part in line.split() if part not in pairs)
        fitting = [c for c in question.choices if word and c.lower().startswith(word.lower())]
        by = f"{user_name()} (terminal)"
        try:
            self.run.questions.answer(
                question.path, fitting[0] if len(fitting) == 1 else word, by, values
            )
        except WrongAnswer as fault:
            self._say(f"{fault}", "yellow")

    def _answered(self) -> None:
        if not self._open_questions():
            self.keyboard.close()
            self._show()
