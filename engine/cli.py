"""The command line: `labrun FILE`, and the commands beside it."""

import importlib
import os
import sys
import tempfile
import traceback
from importlib.metadata import entry_points
from pathlib import Path
from typing import Annotated

from .exit_status import CTRL_C, FAULT, PROBLEMS

COMMANDS = (
    "run",
    "resume",
    "runs",
    "pause",
    "continue",
    "abort",
    "answer",
    "check",
    "problem",
    "explain",
    "fmt",
    "graph",
    "words",
    "preview",
    "new",
    "schema",
    "serve",
    "devices",
    "call",
    "calibrate-camera",
    "locate",
    "report",
    "rehearse",
    "torture",
    "record-buttons",
    "find-buttons",
)
"""Each is a function of the same name in `engine/commands/`; others come as entry points."""

MODULES = {
    "continue": "go_on",
    "calibrate-camera": "calibrate_camera",
    "record-buttons": "record_buttons",
    "find-buttons": "find_buttons",
}
SUMMARY = "Laboratory experiments as YAML: checked, run, and never lost."


def arguments(argv: list[str], known: set[str]) -> list[str]:
    """`labrun FILE` means `labrun run FILE`; anything else is left as it is."""
    first = argv[0] if argv else ""
    is_file = first.endswith((".yaml", ".yml", ".json")) or Path(first).exists()
    if first and not first.startswith("-") and first not in known and is_file:
        return ["run", *argv]
    return argv


def main() -> None:
    """Run the command line; never a traceback for what a person wrote."""
    argv = sys.argv[1:]
    plugins = {p.name: p for p in entry_points(group="labrun.commands")} if _asks_more(argv) else {}
    argv = arguments(argv, {*COMMANDS, *plugins})
    try:
        _run(argv, plugins)
    except KeyboardInterrupt:
        sys.exit(CTRL_C)
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        sys.exit(PROBLEMS)
    except Exception:
        sys.exit(_own_fault())


def _asks_more(argv: list[str]) -> bool:
    """Plug-ins are looked up only where one of our own commands is not what is asked for."""
    return not argv or argv[0] not in COMMANDS


def _run(argv: list[str], plugins: dict) -> None:
    import typer

    app = typer.Typer(
        help=SUMMARY, no_args_is_help=True, add_completion=False, pretty_exceptions_enable=False
    )

    def options(
        version: Annotated[
            bool, typer.Option("--version", callback=_say_version, is_eager=True, help="Say it.")
        ] = False,
    ) -> None:
        """What stands before a command."""

    app.callback(help=SUMMARY)(options)
    asked = argv[:1]  # loading all of them takes longer than many of them need
    own = [name for name in COMMANDS if [name] == asked]
    others = {name: point for name, point in plugins.items() if [name] == asked}
    if not own and not others:
        own, others = list(COMMANDS), plugins
    for name in own:
        app.command(name)(_command(name))
    for name, point in others.items():
        app.command(name)(point.load())
    app(argv, prog_name="labrun")


def _say_version(wanted: bool) -> None:
    if wanted:
        from .. import __version__

        print(f"labrun {__version__}")
        raise SystemExit


def _command(name: str):
    module = importlib.import_module(f".commands.{MODULES.get(name, name)}", __package__)
    return getattr(module, MODULES.get(name, name))


def _own_fault() -> int:
    """One line, and a log with versions: this is ours to mend, not the user's to read."""
    import platform

    from .. import __version__

    kind, fault, _ = sys.exc_info()
    words = f"labrun: a fault in labrun itself ({kind.__name__ if kind else 'unknown'})"
    told = traceback.format_exc()
    try:
        with tempfile.NamedTemporaryFile(
            "w", prefix="labrun-fault-", suffix=".log", delete=False, encoding="utf-8"
        ) as log:
            log.write(
                f"labrun {__version__}, Python {platform.python_version()}, {platform.platform()}\n"
            )
            log.write(f"{sys.argv}\n\n{told}")
        print(f"{words}; please report it with {log.name}", file=sys.stderr)
    except OSError:  # no room for a log, either: the fault's own words have to do
        print(f"{words}: {fault}", file=sys.stderr)
    return FAULT
