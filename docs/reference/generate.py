"""Write the pages of the reference that are made from code; a test compares them.

`cli.md` from the commands' own help, `contracts.md` from schemas/devices, `language.md` from the
models of a protocol and the descriptions that editors show, `python.md` from the docstrings of what
`import labrun` offers.
"""

import ast
import inspect
import re
from collections.abc import Callable, Iterable, Iterator
from importlib.metadata import entry_points
from pathlib import Path
from typing import Any, get_args, get_type_hints

import typer
from pydantic import BaseModel
from typer.models import ArgumentInfo, OptionInfo

import labrun
from labrun.engine.cli import COMMANDS, GROUPS, PARTS, _command
from labrun.engine.lab_schema.words import about, choices_for, words_for
from labrun.engine.language.functions import FUNCTIONS
from labrun.schemas import protocol
from labrun.schemas.contract import Action, Contract
from labrun.schemas.contracts import shipped_contracts

HERE = Path(__file__).parent
MADE = "<!-- Made by `python docs/reference/generate.py` from {}. -->"


def rows(head: Iterable[str], body: Iterable[Iterable[str]]) -> str:
    """A Markdown table."""
    lines = [list(head), ["---"] * len(list(head)), *[[cell(one) for one in row] for row in body]]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def cell(text: str) -> str:
    """Text that may stand in a table."""
    return " ".join(text.split()).replace("|", "\\|")


def first(text: str | None) -> str:
    """The first sentence of a docstring, as it is written."""
    return inspect.cleandoc(text or "").partition("\n\n")[0]


# --- the command line

CLI = """\
# The command line

`labrun COMMAND --help` says the same at a terminal. `labrun FILE` means `labrun run FILE`. Exit status:
0 succeeded, 1 failed or aborted, 2 problems in a file or wrong usage, 4 a device could not be reached,
70 an internal error in labrun, 130 Ctrl-C. A reader who has enough, as in `labrun runs | head -1`,
changes none of these.
"""


def cli() -> str:
    """Every command with its arguments and options."""
    plugins = {point.name: point for point in entry_points(group="labrun.commands")}
    parts = [CLI, MADE.format("the commands' own help")]
    for group, names in GROUPS.items():
        parts.append(f"## {group}")
        for name in names:
            found: Any = _command(name) if name in COMMANDS else plugins[name].load()
            if isinstance(found, typer.Typer):
                for one in found.registered_commands:
                    assert one.callback is not None
                    word = one.name or one.callback.__name__.replace("_", "-")
                    parts.append(_usage(f"{name} {word}", one.callback))
                for word, ours in PARTS.get(name, {}).items():
                    parts.append(_usage(f"{name} {word}", _command(ours)))
            else:
                parts.append(_usage(name, found))
    return "\n\n".join(part.strip() for part in parts) + "\n"


def _usage(name: str, function: Callable[..., Any]) -> str:
    words, table = [name], []
    hints = get_type_hints(function, include_extras=True)
    for one in inspect.signature(function).parameters.values():
        kind, *more = get_args(hints[one.name])
        info: Any = more[0]
        if isinstance(info, ArgumentInfo):
            word = (info.metavar or one.name.upper()).removesuffix("...")
            word = re.sub(r"^\[([^\[\]]*)\]$", r"\1", word)
            shown = word + "..." * ("list" in str(kind))
            words.append(shown if one.default is one.empty else f"[{shown}]")
            table += [(f"`{word}`", info.help)] if info.help else []
        else:
            table.append((f"`{_option(info, one, str(kind))}`", _says(info, one.default)))
    head = f"### labrun {name}\n\n```text\nlabrun {' '.join(words)}\n```"
    text = inspect.getdoc(function) or ""
    return "\n\n".join([head, text, *([rows(("", ""), table)] if table else [])])


def _option(info: OptionInfo, one: inspect.Parameter, kind: str) -> str:
    # Within Annotated, Typer keeps the first of the names as the default.
    given = [info.default, *(info.param_decls or ())]
    names = [name for name in given if isinstance(name, str) and name.startswith("-")]
    names = sorted(names or ["--" + one.name.replace("_", "-")], key=len)
    word = info.metavar or next((name for key, name in WORDS.items() if key in kind), "TEXT")
    return ", ".join(names) + ("" if "bool" in kind else f" {word}")


WORDS = {"Path": "PATH", "int": "NUMBER", "float": "NUMBER"}


def _says(info: OptionInfo, default: Any) -> str:
    said = info.help or ""
    plain = isinstance(default, str | int | float | Path) and not isinstance(default, bool)
    tell = plain and default != "" and "efault" not in said
    return f"{said} Default: `{default}`." if tell else said


# --- contracts


CONTRACTS = """\
# Contracts

What the devices that labrun knows can do. A protocol's role names one (`gantry: gantry@1`), a driver
keeps it. `labrun devices NAME` shows a lab's own devices like this; [how to write
one](../how-to/add-a-device.md).

*Takes*: what has a `*` is needed. *Effect*: `pure` changes nothing; `idempotent` may be repeated after a
crash; `once` must not happen twice by accident. What has a danger (laser, motion) waits for a person, or
for `--yes`. *Errors* say whether the action happened all the same; besides them any action may end with
`Timeout` (unknown), `Busy` (no), `Rejected` (no) and `Lost` (unknown).
"""


def contracts() -> str:
    """Every shipped contract with its actions."""
    parts = [CONTRACTS, MADE.format("schemas/devices")]
    return (
        "\n\n".join([*map(str.strip, parts), *map(_contract, shipped_contracts().values())]) + "\n"
    )


def _contract(contract: Contract) -> str:
    facts = [
        f"plays roles of {', '.join(f'`{one}`' for one in contract.also)}, too"
        * bool(contract.also),
        f"safe state: {', '.join(f'`{one}`' for one in contract.safe_state)}"
        * bool(contract.safe_state),
        f"when the engine is gone: {contract.on_lease_lapse}",
        "does several things at a time" * contract.concurrent,
    ]
    status = _fields(contract.status.get("properties", {}))
    body = [
        (
            f"`{name}`",
            action.summary,
            _params(action),
            _fields(_returned(action)),
            _nature(action),
            _errors(action),
        )
        for name, action in contract.actions.items()
    ]
    parts = [
        f"## {contract.type}",
        f"{contract.summary}. {'; '.join(filter(None, facts)).capitalize()}.",
    ]
    parts += [f"Its status: {status}."] if status else []
    parts.append(rows(("action", "does", "takes", "returns", "effect", "errors"), body))
    return "\n\n".join(parts)


def _returned(action: Action) -> dict[str, Any]:
    return action.returns.get("properties", {})


def _params(action: Action) -> str:
    return _fields(action.param_schemas(), action.required())


def _fields(fields: dict[str, Any], required: Iterable[str] = ()) -> str:
    return ", ".join(
        f"`{name}`{'*' * (name in required)}{_kind(said)}" for name, said in fields.items()
    )


def _kind(said: dict[str, Any]) -> str:
    low, high = said.get("minimum", said.get("exclusiveMinimum")), said.get("maximum")
    bounds = f"{low} to {high}" if None not in (low, high) else ""
    bounds = bounds or (
        f"from {low}" if low is not None else f"to {high}" if high is not None else ""
    )
    choices = "/".join(str(one) for one in said.get("enum", []))
    default = f"default {said['default']}" if "default" in said else ""
    kind = ", ".join(filter(None, (choices, f"{bounds} {said.get('unit', '')}".strip(), default)))
    return f" ({kind})" if kind else ""


def _nature(action: Action) -> str:
    return ", ".join(
        filter(None, (
            action.effect, action.danger or "", f"probe `{action.probe}`" * bool(action.probe),
            f"sets {action.sets}" * bool(action.sets), "meanwhile" * action.meanwhile,
            "can be cancelled" * action.cancel,
        ))
    )  # fmt: skip


def _errors(action: Action) -> str:
    return ", ".join(f"`{name}` ({error.happened})" for name, error in action.errors.items())


# --- the language


LANGUAGE = """\
# The language: every key

[Write a protocol](../how-to/write-a-protocol.md) shows them at work, [what each construct
does](semantics.md) says exactly what follows, and `labrun schema` gives the same to
[editors](../how-to/editors.md). The keys of a lab are in [Labs](../how-to/labs.md).
"""


def language() -> str:
    """Every key of a protocol, and every function of its expressions."""
    parts = [
        LANGUAGE,
        MADE.format("schemas/protocol.py, engine/lab_schema/words.py and engine/language"),
        "## The protocol",
        _keys(protocol.Protocol),
        "### One of `params`",
        _keys(protocol.Param),
        "### `defaults`",
        _keys(protocol.Defaults),
        "## Keys of any step",
        _keys(protocol.StepBase),
        "### `retry`",
        _keys(protocol.Retry),
        "## Steps",
    ]
    common = set(protocol.StepBase.model_fields)
    for kind in protocol.STEP_KINDS:
        parts += [f"### `{kind.KIND}`", first(about(kind)), _keys(kind, common)]
    for title, model in (
        ("One of `watch`", protocol.Watch),
        ("`keep_going`", protocol.KeepGoing),
        ("`wait: {until}`", protocol.Until),
    ):
        parts += [f"### {title}", first(about(model)), _keys(model)]
    functions = [
        (f"`{name}{_signature(function)}`", first(function.__doc__))
        for name, function in sorted(FUNCTIONS.items())
    ]
    parts += ["## Functions in expressions", rows(("", ""), functions)]
    return "\n\n".join(part.strip() for part in parts if part) + "\n"


def _keys(model: type[BaseModel], without: Iterable[str] = ()) -> str:
    body = []
    for name, field in model.model_fields.items():
        key = field.alias or name
        if name in without or key == getattr(model, "KIND", None):
            continue
        choices = "; ".join(f"`{one}`: {says}" for one, says in choices_for(model, key).items())
        body.append(
            (
                f"`{key}`{' (required)' * field.is_required()}",
                " ".join((words_for(model, key), choices)),
            )
        )
    return rows(("key", "means"), body) if body else ""


def _signature(function: Callable[..., Any]) -> str:
    names = []
    for one in inspect.signature(function).parameters.values():
        star = {one.VAR_POSITIONAL: "*", one.VAR_KEYWORD: "**"}.get(one.kind, "")
        names.append(f"[{one.name}]" if one.default is not one.empty else star + one.name)
    return f"({', '.join(names)})"


# --- Python


PYTHON = """\
# Python: `import labrun`

[How to use it](../how-to/notebook.md). It takes the same way as the commands: one check, one engine, one
run folder.
"""


def python() -> str:
    """What `import labrun` offers, from the source, so that every Python writes the same."""
    parts = [
        PYTHON,
        MADE.format("docstrings"),
    ]
    for name in sorted(labrun.__all__, key=lambda one: (one[0].isupper(), one)):
        place, _, there = labrun._WHERE[name].partition(":")
        path = Path(labrun.__file__).parent / (place.replace(".", "/") + ".py")
        tree = ast.parse(path.read_text("utf-8"))
        if not there:
            parts += [
                f"## labrun.{name}",
                ast.get_docstring(tree) or "",
                *_members(tree.body, f"labrun.{name}."),
            ]
            continue
        found = next(node for node in tree.body if isinstance(node, Named) and node.name == there)
        parts += list(_described(found, "labrun.", "##"))
    return "\n\n".join(part.strip() for part in parts if part) + "\n"


Named = ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef


def _described(node: Named, before: str, mark: str) -> Iterator[str]:
    yield f"{mark} {before}{node.name}"
    if not isinstance(node, ast.ClassDef):
        yield f"```python\n{_written(node)}\n```"
    yield ast.get_docstring(node) or ""
    if isinstance(node, ast.ClassDef):
        yield from _members(node.body, f"{node.name}.")


def _members(body: list[ast.stmt], before: str) -> Iterator[str]:
    said = []
    for node in body:
        if (
            isinstance(node, Named)
            and not node.name.startswith("_")
            and (text := ast.get_docstring(node))
        ):
            shown = (
                f"class {node.name}" if isinstance(node, ast.ClassDef) else _written(node, before)
            )
            said.append((f"`{shown}`", first(text)))
    if said:
        yield rows(("", ""), said)


def _written(node: ast.FunctionDef | ast.AsyncFunctionDef, before: str = "labrun.") -> str:
    is_value = any(ast.unparse(one).endswith("property") for one in node.decorator_list)
    given = node.args
    given.args = [one for one in given.args if one.arg not in ("self", "cls")]
    returns = f" -> {ast.unparse(node.returns)}" if node.returns else ""
    wait = "await " if isinstance(node, ast.AsyncFunctionDef) else ""
    return wait + before + node.name + ("" if is_value else f"({ast.unparse(given)})") + returns


PAGES: dict[str, Callable[[], str]] = {
    "cli.md": cli, "contracts.md": contracts, "language.md": language, "python.md": python,
}  # fmt: skip

if __name__ == "__main__":
    for name, page in PAGES.items():
        (HERE / name).write_text(page(), encoding="utf-8")
