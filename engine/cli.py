"""The command line: `labrun FILE`, and the commands beside it."""

# What a command needs is imported when it is called: a start costs what it uses.
import atexit
import gc
import importlib
import io
import os
import sys
from copy import copy

from .exit_status import CTRL_C, FAULT, PROBLEMS, SUCCEEDED

GROUPS = {
    "Write a protocol": (
        "new", "check", "problem", "explain", "words", "preview", "graph", "fmt", "schema",
        "docs",
    ),
    "Run it": (
        "run", "rehearse", "pause", "continue", "abort", "answer", "change", "resume", "release", "torture",
    ),
    "Look at runs": ("runs", "compare", "label", "report", "export"),
    "Devices": (
        "devices", "setup", "status", "stop", "call", "calibrate-camera", "locate", "record-program",
        "record-buttons", "find-buttons",
    ),
    "Spectra": ("reduce", "map", "spectrum", "lines", "calibrate"),
    "Serve": ("serve", "web", "ros", "mcp"),
}  # fmt: skip
"""As `labrun --help` shows them; a command that is in none of these comes last."""

FROM_ENTRY_POINTS = {"reduce", "map", "spectrum", "lines", "calibrate", "web", "ros", "mcp"}
COMMANDS = tuple(
    name for names in GROUPS.values() for name in names if name not in FROM_ENTRY_POINTS
)
"""Each is a function of the same name in `engine/commands/`; others come as entry points."""

MODULES = {
    "continue": "continue_run",
    "calibrate-camera": "calibrate_camera",
    "record-program": "record_program",
    "record-buttons": "record_buttons",
    "find-buttons": "find_buttons",
}
PARTS = {"calibrate": {"camera": "calibrate-camera"}}
"""Commands of ours that are also found within another's group."""
SUMMARY = "Laboratory experiments as YAML: checked, run, and never lost."


def arguments(argv: list[str], known: set[str]) -> list[str]:
    """`labrun FILE` means `labrun run FILE`; anything else is left as it is."""
    first = argv[0] if argv else ""
    is_file = first.endswith((".yaml", ".yml", ".json")) or os.path.exists(first)  # noqa: PTH110
    if first and not first.startswith("-") and first not in known and is_file:
        return ["run", *argv]
    return argv


def ros_args(argv: list[str]) -> list[str]:
    """`--ros-args ... [--]`, as ROS launches its programs with, as one option `--ros-args=...`."""
    if argv[:1] != ["ros"] or "--ros-args" not in argv:
        return argv
    import shlex

    at = argv.index("--ros-args")
    end = argv.index("--", at) if "--" in argv[at:] else len(argv)
    words = shlex.join([word for word in argv[at + 1 : end] if word != "--ros-args"])
    return [*argv[:at], f"--ros-args={words}", *argv[end + 1 :]]


def main() -> None:
    """Run the command line; never a traceback for what a person wrote."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):  # what a console cannot show is a `?` there
            stream.reconfigure(errors="replace")
    argv = sys.argv[1:]
    plugins = _plugins() if _asks_more(argv) else {}
    argv = ros_args(arguments(argv, {*COMMANDS, *plugins}))
    try:
        status = _status(argv, plugins)
    except KeyboardInterrupt:
        status = CTRL_C
    except Exception as fault:  # ours: it is told with its traceback
        status = _of_the_disk(fault) or _not_installed(argv, fault) or _own_fault()
    sys.exit(status)


def _status(argv: list[str], plugins: dict) -> int | str | None:
    """What a command ends with, whether or not somebody stays to read all of it."""
    from ..system.output import read_or_not, reader_is_gone

    status: int | str | None = SUCCEEDED
    with read_or_not():
        try:
            _run(argv, plugins)
        except SystemExit as end:
            fault = end.__context__
            if fault is not None and reader_is_gone(fault):  # typer's 1 for it says nothing
                raise fault from None
            status = end.code
    return status


def _asks_more(argv: list[str]) -> bool:
    """Plug-ins are looked up only where one of our own commands is not what is asked for."""
    ours = (*COMMANDS, "--version")
    return not argv or (argv[0] not in ours and not argv[0].endswith((".yaml", ".yml")))


def _plugins() -> dict:
    from importlib.metadata import entry_points

    return {plugin.name: plugin for plugin in entry_points(group="labrun.commands")}


def _run(argv: list[str], plugins: dict) -> None:
    if argv == ["--version"]:
        _show_version(True)
    atexit.register(gc.freeze)  # what a start has loaded need not be looked through once more
    if argv[:1] == ["check"] and argv[1:] and not any(word.startswith("-") for word in argv[1:]):
        _check_plainly(argv[1:])
    from functools import partial
    from typing import Annotated

    from ..system.start import collector_at_rest, spare_plugins

    with collector_at_rest():
        import typer

        spare_plugins()
    app = typer.Typer(help=SUMMARY, no_args_is_help=True, pretty_exceptions_enable=False)

    def options(
        version: Annotated[
            bool,
            typer.Option(
                "--version",
                callback=_show_version,
                is_eager=True,
                help="Show the version and exit.",
            ),
        ] = False,
    ) -> None:
        """Options before the command."""

    app.callback(help=SUMMARY)(options)
    every = {name: partial(_command, name) for name in COMMANDS}
    every |= {name: point.load for name, point in plugins.items()}
    groups = {name: group for group, names in GROUPS.items() for name in names}
    groups |= {name: "Other" for name in every if name not in groups}
    # Loading all of them takes longer than many of them need.
    wanted = (
        argv[:1] if argv[:1] and argv[0] in every else [name for name in groups if name in every]
    )
    with collector_at_rest():
        for name in wanted:
            command = every[name]()
            if isinstance(command, typer.Typer):
                command = copy(command)  # it stays its module's own
                command.registered_commands = list(command.registered_commands)
                for part, ours in PARTS.get(name, {}).items():
                    command.command(part)(_command(ours))
                app.add_typer(command, name=name, rich_help_panel=groups[name])
            else:
                app.command(name, rich_help_panel=groups[name])(command)
    app(argv, prog_name="labrun")


def _check_plainly(files: list[str]) -> None:
    """`labrun check FILE...`: without options nothing has to understand them, a third of the time."""
    from pathlib import Path

    from ..system.start import collector_at_rest, patterns_when_used, spare_plugins

    with collector_at_rest(), patterns_when_used():
        spare_plugins()
        importlib.import_module("yaml")  # for its patterns; what reads a file imports it later
        of_files = importlib.import_module(".commands.check_files", __package__)
        gc.freeze()  # or the collector would look through it all as soon as it may
    status = of_files.check_files([Path(file) for file in files])
    for stream in filter(None, (sys.stdout, sys.stderr)):
        stream.flush()
    # Nothing is open: taking everything down piece by piece would be a tenth of what a check takes.
    os._exit(status)


def _show_version(wanted: bool) -> None:
    if wanted:
        from .. import __version__

        print(f"labrun {__version__}")
        raise SystemExit


def _command(name: str):
    module = importlib.import_module(f".commands.{MODULES.get(name, name)}", __package__)
    return getattr(module, MODULES.get(name, name))


def _of_the_disk(fault: Exception) -> int:
    """Say what a disk or its owner refuses, wherever that shows; 0 if that is not what went wrong."""
    from ..system.files import FULL, REFUSED

    if not isinstance(fault, OSError) or fault.errno not in (REFUSED if fault.filename else FULL):
        return 0
    place = f"{fault.filename}: " if fault.filename else "what it prints cannot be written: "
    print(f"labrun: {place}{fault.strerror}", file=sys.stderr)
    if not fault.filename:  # what is left unwritten would be tried once more at the end
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    return PROBLEMS


def _not_installed(argv: list[str], fault: Exception) -> int:
    """Say which line adds the library that a command lacks; 0 if that is not what went wrong."""
    from ..system.extras import not_installed

    least = "numpy" if argv[:1] == ["lines"] else None  # the other commands that need it need more
    why = not_installed(fault, least) if isinstance(fault, ImportError) else None
    if why is None:
        return 0
    print(f"labrun {argv[0] if argv else ''}: {why}", file=sys.stderr)
    return PROBLEMS


def _own_fault() -> int:
    """One line, and a log with versions: this is for us to fix, not for the user to read."""
    import platform
    import tempfile
    import traceback

    from .. import __version__

    kind, fault, _ = sys.exc_info()
    words = f"labrun: internal error ({kind.__name__ if kind else 'unknown'})"
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
    except OSError:  # no room for a log, either
        print(f"{words}: {fault}", file=sys.stderr)
    return FAULT
