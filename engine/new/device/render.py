"""Render the files of a new device: its contract put into templates."""

import json
from importlib.resources import files
from string import Template
from typing import Any

from ....schemas.contract import Action, Contract
from ....schemas.good_calls import duration_s, good_call
from .names import STOPS

PACKED = {"number": "<f", "integer": "<i", "boolean": "<?"}
YAML_WORDS = {"on", "off", "yes", "no"}


def contract_text(name: str) -> str:
    """A contract to start from."""
    return _render("contract", _names(name) | {"contract": f"{name}@1"})


def driver_text(name: str, contract: Contract, count: dict[str, str] | None = None) -> str:
    """A driver in bytes, and its twin; `count` says which action counts which."""
    probes = {action.probe for action in contract.actions.values()}
    said = {n: a for n, a in contract.actions.items() if n not in probes}
    free = [n for n, a in said.items() if a.effect != "once" and not a.required()]
    abort = next((n for n in (*contract.safe_state, *STOPS) if n in free), None)
    errors = list(dict.fromkeys(error for a in said.values() for error in a.errors))
    commands = (
        _command(0x10 + number, one, said[one], (count or {}).get(one))
        for number, one in enumerate(said)
    )
    words = {
        "contract": contract.type,
        "commands": "\n".join(commands),
        "abort": "None" if abort is None else f'"{abort}"',
        "status": json.dumps(_looked(contract)),
        "refusals": "{" + ", ".join(f'{n}: "{e}"' for n, e in enumerate(errors, 1)) + "}",
    }
    return _render("driver", _names(name) | words)


def _command(number: int, name: str, action: Action, count: str | None) -> str:
    """Its line, with a comment on what has no number of bytes of its own: texts, lists, files."""
    said, left = [f"command=0x{number:02X}"], list[str]()
    for key, schemas in (
        ("sends", action.param_schemas()), ("reads", action.returns.get("properties", {})),
    ):  # fmt: skip
        packed = {n: PACKED[kind] for n, s in schemas.items() if (kind := _kind(s)) in PACKED}
        left += [n for n in schemas if n not in packed]
        said += [f"{key}={json.dumps(packed)}"] if packed else []
    said += [f'count="{count}"'] if count else []
    limit_s = 10 * duration_s(action)
    said += [f'timeout="{limit_s:g} s"'] if limit_s > 10 else []
    note = f"  # and {', '.join(left)}: of no fixed size" if left else ""
    return f'    "{name}": Command({", ".join(said)}),{note}'


def _kind(schema: dict[str, Any]) -> Any:
    kind = schema.get("type")
    return next((one for one in kind if one != "null"), None) if isinstance(kind, list) else kind


def device_text(name: str, contract: Contract) -> str:
    """The lines of a lab for the new device."""
    return _render("device", _names(name) | {"contract": contract.type})


def speaking_text(name: str, language: str) -> str:
    """The lines of a lab for a device that is said there, in SCPI or in lines."""
    return _render(f"speaks_{language}", _names(name))


def speaking_contract_text(name: str, language: str, contract: Contract) -> str:
    """The lines of a lab for a device that keeps this contract, in SCPI or in lines."""
    driver, key = ("scpi", "query") if language == "scpi" else ("text", "send")
    probes = {action.probe for action in contract.actions.values()}
    said = [
        f"      {_spoken(one, action, key)}"
        for one, action in contract.actions.items()
        if one not in probes
    ]
    looked = _looked(contract)
    idle = ", ".join(looked)
    lines = [
        f"{name}:",
        f"  contract: {contract.type}",
        f"  driver: {driver}                        # `sim_{driver}` is its twin, and needs no instrument",
        "  config:",
        "    resource: /dev/ttyUSB0            # or host:port, GPIB0::22::INSTR",
        f"    status: [{idle}]" if looked else "    # status: [what is read when it is idle]",
        "    actions:                          # make them your instrument's; the contract says the rest",
        *said,
    ]
    return "".join(f"  {line}\n" for line in lines)


def _looked(contract: Contract) -> list[str]:
    """The actions that read what the status shows."""
    shown = set(contract.status.get("properties", {}))
    probes = {action.probe for action in contract.actions.values()}
    free = {n: a for n, a in contract.actions.items() if n not in probes and not a.required()}
    return [
        n
        for n, a in free.items()
        if a.effect == "pure" and shown & set(a.returns.get("properties", {}))
    ]


def _spoken(name: str, action: Action, key: str) -> str:
    """An action as a guess: its name, its parameters, and what it returns between commas."""
    returns = action.returns.get("properties", {})
    words = name.upper() + "".join(f" {{{param}}}" for param in action.param_schemas())
    asks = bool(returns)
    if key == "query":
        said = (
            f'query: "{words.replace(" ", "? ", 1) if " " in words else words + "?"}"'
            if asks
            else f'write: "{words}"'
        )
    else:
        said = f'send: "{words}"' + ("" if asks else ", answer: OK")
    block = ", block: file" if action.path_params()[1] else ""
    return f'"{name}": {{{said}{block}}}' if name in YAML_WORDS else f"{name}: {{{said}{block}}}"


def lab_text(name: str, contract: Contract, contract_file: str | None, device: str) -> str:
    """A lab with only this device."""
    simple = [n for n, a in contract.actions.items() if not good_call(a)]
    quiet = min(simple or contract.actions, key=lambda n: contract.actions[n].effect != "pure")
    own = "" if contract_file is None else f"contracts: [./{contract_file}]\n"
    more = {"quiet": quiet, "contracts": own, "device": device.rstrip()}
    return _render("lab", _names(name) | more)


def class_name(name: str) -> str:
    """`hot_plate` -> `HotPlate`."""
    return "".join(part.capitalize() for part in name.split("_"))


def _names(name: str) -> dict[str, str]:
    return {"name": name, "Class": class_name(name), "Words": name.replace("_", " ").capitalize()}


def _render(template: str, words: dict[str, str]) -> str:
    text = files("labrun.engine.new.device").joinpath(f"{template}.txt").read_text(encoding="utf-8")
    return Template(text).substitute(words)
