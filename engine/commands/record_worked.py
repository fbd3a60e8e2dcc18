"""The questions of `labrun record-program`, and what it writes."""

import time
from pathlib import Path
from typing import Any

import typer

from ...schemas.contract import Action, Contract
from ...schemas.contracts import read_contract, shipped_contracts
from .options import WrongUsage, say
from .record_interactively import asked, point_at
from .screen_picture import view_of_screen

LAB = "lab.yaml"


def record_worked(output: Path, named: str, watch: list[Path], title: str | None) -> None:
    """Each action is worked once by a person; then buttons and lab.yaml are written."""
    contract, file = _contract(named)
    if (output / LAB).exists():
        raise WrongUsage(f"{output / LAB} is there already; choose another folder")
    if title is None:
        title = asked("Part of the title of the program's window")
    if not title:
        raise WrongUsage(
            "without the title of its window, nobody knows which presses are the program's"
        )
    view_of_screen(title)  # told now where no window, or more than one, is called so
    probes = {action.probe for action in contract.actions.values()}
    actions: dict[str, Any] = {}
    typer.echo("Work the program slowly, with the mouse, in its own window, as it stands idle.")
    for name, action in contract.actions.items():
        if name in probes:
            continue
        told = _action(name, action, output, title, watch)
        if told is None:
            break
        actions[name] = told
    _write(output, contract, file, actions)


def _contract(named: str) -> tuple[Contract, Path | None]:
    if named in shipped_contracts():
        return shipped_contracts()[named], None
    path = Path(named)
    try:
        return read_contract(path), path
    except (OSError, ValueError) as fault:
        raise WrongUsage(f"--contract {named}: {fault}") from fault


def _action(
    name: str, action: Action, output: Path, title: str, watch: list[Path]
) -> dict[str, Any] | None:
    """How one action is done; None where the person wants to end."""
    takes = f", with {', '.join(action.param_schemas())}" if action.param_schemas() else ""
    question = (
        f"\n{name} ({action.summary}{takes}): Enter, then work it; s: it has no steps, q: end"
    )
    answer = asked(question)
    if answer == "q":
        return None
    if answer == "s":
        return {"steps": []}
    while True:
        before = {folder: _names(folder) for folder in watch}
        deeds, later = _watched(name)
        steps = _steps(name, deeds, later, action, output, title)
        if (
            steps
            or asked("No press in the program was seen. Enter: work it again, s: no steps") == "s"
        ):
            break
    if not steps:
        return {"steps": []}
    told: dict[str, Any] = {"steps": steps}
    if (proof := _proof(name, action, before, steps, output, title)) is not None:
        told["proof"] = proof
        path = next(
            (p for p, s in action.param_schemas().items() if s.get("format") == "path"), None
        )
        if path is not None and "new" in proof:
            told["file"] = path
    return told


def _watched(name: str) -> tuple[list[Any], Any]:
    """What the person did until Enter was pressed here, and the last look at the screen."""
    from ...drivers.window_program.desktop import open_input, open_windows
    from ...drivers.window_program.watching import Watch

    with Watch(open_windows(), open_input()) as watch:
        asked(f"  recording {name}: work it now, wait until it is done, come back, Enter")
        return list(watch.deeds), watch.last()


def _steps(
    name: str, deeds: list[Any], later: Any, action: Action, output: Path, title: str
) -> list[dict[str, str]]:
    """The steps; what was pressed is recorded as `NAME_1`, `NAME_2`..."""
    from ...drivers.window_program.deeds import NotCut, cut_out, hits
    from ...drivers.window_program.recording import Marked, cut, save

    found, left = hits(deeds, title)
    for words in left:
        say(f"left out: {words}")
    steps: list[dict[str, str]] = []
    for number, hit in enumerate(found, 1):
        button = f"{name}_{number}"
        picture = hit.press.before.picture
        try:
            box, at = cut_out(hit, later)
        except NotCut as fault:
            say(f"{fault}; record it by hand: labrun record-program --buttons -o {output}")
            continue
        marked = Marked({button: box}, {button: at}, {button: hit.where})
        save(output, cut(picture, marked), marked, title, picture)
        steps.append({"click": button})
        if hit.typed:
            steps.append({"type": _text(hit.typed, action)})
        steps += [{"press": key} for key in hit.keys]
    typer.echo("  " + ", ".join(f"{word} {what}" for step in steps for word, what in step.items()))
    return steps


def _text(typed: str, action: Action) -> str:
    """What stands for a typed text: a parameter, a name unique for each goal, or itself."""
    words = [*action.param_schemas(), "name"]
    choices = ", ".join(words)
    while True:
        answer = asked(f"  {typed!r} was typed: is it {choices} (Enter: always the same)")
        if not answer:
            return typed.replace("{", "{{").replace("}", "}}")
        if answer in words:
            return f"{{{answer}}}"
        if any(f"{{{word}}}" in answer for word in words):
            return answer  # C:/data/{name}.csv
        typer.echo(f"  one of {choices}, or a text that holds one in braces: C:/data/{{name}}.csv")


def _proof(
    name: str, action: Action, before: dict[Path, set[str]], steps: list[dict[str, str]],
    output: Path, title: str,
) -> dict[str, str] | None:  # fmt: skip
    """What shows that it is done: a new file, a picture, or words in a title."""
    for folder, names in before.items():
        new = sorted(_names(folder) - names)
        if (
            len(new) == 1
            and asked(f"  {new[0]} is new in {folder}: is that the proof? (n: no)") != "n"
        ):
            return {"new": str(folder.absolute()), "called": _pattern(new[0], steps)}
    if action.effect == "pure" and asked("  Does anything show that it is done? (y: yes)") != "y":
        return None
    while True:
        words = asked(
            "  What shows that it is done? p: a part of the screen, f FOLDER: a new file there, "
            "t WORDS: these words in a title"
        )
        kind, _, rest = words.partition(" ")
        if kind == "p" and point_at(output, f"{name}_done", title, "dialog"):
            return {"shows": f"{name}_done"}
        if kind == "f" and Path(rest).is_dir():
            return {"new": str(Path(rest).absolute()), "called": "*"}
        if kind == "t" and rest:
            return {"title": rest}


def _pattern(new: str, steps: list[dict[str, str]]) -> str:
    """What the next ones are called: `{name}*.csv` where the name was typed, else `*.csv`."""
    typed = any("{name}" in step.get("type", "") for step in steps)
    return ("{name}*" if typed else "*") + Path(new).suffix


def _names(folder: Path) -> set[str]:
    return {path.name for path in folder.iterdir()}


def _write(output: Path, contract: Contract, file: Path | None, actions: dict[str, Any]) -> None:
    from ruamel.yaml import YAML

    from ...drivers.window_program.buttons import ButtonsFault, read_buttons
    from ...drivers.window_program.config import read_config

    config = {"buttons": str(output.absolute()), "actions": actions}
    device = contract.type.partition("@")[0]
    entry = {"contract": contract.type, "driver": "window_program", "config": config}
    lab: dict[str, Any] = {"name": device, "devices": {device: entry}}
    if file is not None:
        lab["contracts"] = [str(file.absolute())]
    output.mkdir(parents=True, exist_ok=True)
    with (output / LAB).open("w", encoding="utf-8") as out:
        out.write(f"# Recorded by labrun record-program on {time.strftime('%Y-%m-%d')}\n")
        YAML().dump(lab, out)
    say(f"{output / LAB} holds {', '.join(actions) or 'nothing'}")
    try:
        read_config(config, contract)
        read_buttons(output, needed=())
    except (ValueError, ButtonsFault) as fault:
        say(f"it is not complete: {fault}")
        return
    say(
        f"try it, with a hand on the program: labrun call --lab {output / LAB} "
        f"{device}.{next(iter(actions))}; `labrun record-program --find -o {output}` shows what is seen"
    )
