"""Progress in a notebook: the lines of `labrun run`, and a bar for the loop that is under way."""

import sys
import warnings
from importlib.util import find_spec
from typing import Any, TextIO

from ...schemas.event import Event
from ..progress.plain import PlainWatch


class BarWatch(PlainWatch):
    """Lines as PlainWatch has them; in place of its counts a bar of tqdm's, of the outermost loop."""

    def __init__(self, out: TextIO | None = None) -> None:
        super().__init__(out)
        self._bar: Any = None
        self._loop = ""

    def __call__(self, event: Event) -> None:
        if event.event == "finished" and self._bar is not None:
            self._close()
        super().__call__(event)
        if event.event == "iteration" and event.path == self._loop and event.state == "ended":
            self._show(event.data["done"], event.data["failed"])
            self._close()

    def _now_and_then(self) -> str:
        loop = next(iter(self.progress.loops.values()), None)
        if loop is not None and self._bar is None:
            self._loop = loop.path
            self._bar = _tqdm()(total=loop.total, file=self.out, unit=" points")
        if loop is not None and loop.path == self._loop:
            self._show(loop.done, loop.failed)
        return ""

    def _show(self, done: int, failed: int) -> None:
        self._bar.set_postfix_str(f"{failed} failed", refresh=False)
        self._bar.update(done - self._bar.n)

    def _close(self) -> None:
        self._bar.close()
        self._loop, self._bar = "", None


def in_a_notebook() -> bool:
    """Whether this is a kernel of Jupyter's, so that a person may be asked and shown widgets."""
    ipython = sys.modules.get("IPython")
    return ipython is not None and hasattr(ipython.get_ipython(), "kernel")


def watch() -> PlainWatch:
    """How a run shows its progress here: in a notebook with a bar, if tqdm is installed."""
    return BarWatch() if in_a_notebook() and find_spec("tqdm") else PlainWatch()


def _tqdm() -> Any:
    """The bar: a widget where ipywidgets are."""
    import tqdm

    if not in_a_notebook() or not find_spec("ipywidgets"):
        return tqdm.tqdm
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", tqdm.TqdmExperimentalWarning)
        from tqdm.autonotebook import tqdm as widget
    return widget
