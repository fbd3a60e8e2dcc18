"""Render the files of a new device: its contract put into templates."""

from importlib.resources import files
from pprint import pformat
from string import Template
from typing import Any

from ....schemas.contract import Action, Contract
from ....schemas.good_calls import good_call, lasting, slow_clock
from . import parts, pieces

YAML_WORDS = {"on", "off", "yes", "no"}


def own_texts(name: str) -> dict[str, str]:
    """File name -> text, of a contract to start from, and of a driver in bytes with its twin."""
    words = _names(name) | {"contract": f"{name}@1"}
    return {
        f"{name}.yaml": _render("contract", words),
        f"{name}.py": _render("driver_bytes", words),
    }


def python_texts(name: str, contract: Contract, contract_file: str | None) -> dict[str, str]:
    """File name -> text, of driver, twin and their test."""
    words = _words(name, contract, contract_file)
    return {
        f"{name}.py": _render("driver", words),
        f"sim_{name}.py": _render("twin", words),
        f"test_{name}.py": _render("test", words),
    }


def device_text(name: str, contract: Contract, *, own: bool = False) -> str:
    """The lines of a lab for the new device; `own` if its driver speaks in bytes."""
    words = _names(name) | {"contract": contract.type}
    return _render("device_bytes" if own else "device", words)


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
    simple = {
        n: a
        for n, a in contract.actions.items()
        if n not in probes and a.effect == "pure" and not a.required()
    }
    shown = set(contract.status.get("properties", {}))
    looked = [n for n, a in simple.items() if shown & set(a.returns.get("properties", {}))]
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


def _words(name: str, contract: Contract, contract_file: str | None) -> dict[str, str]:
    """The values for all placeholders of the Python templates."""
    actions = contract.actions
    sends = any(action.path_params()[0] for action in actions.values())
    gets = any(action.returned_paths() for action in actions.values())
    longest = lasting(contract)
    base64 = [word for word, used in (("b64decode", gets), ("b64encode", sends)) if used]
    base64_import = f"from base64 import {', '.join(base64)}\n" if base64 else ""
    sha_import = "from hashlib import sha256\n" if gets else ""
    message = "from labrun.schemas.messages import FileContent\n"
    return _names(name) | {
        "contract": contract.type,
        "action": longest,
        "lasting": longest,
        "slow": f"{slow_clock(contract):g}",
        "base64_driver": base64_import,
        "sha_driver": sha_import,
        "message_import": message if gets else "",
        "driver_actions": "\n".join(pieces.driver_action(n, a) for n, a in actions.items()),
        "send_files": pieces.SEND_FILES if sends else "",
        "answer": pieces.GET_FILES if gets else pieces.NO_FILES,
        "twin_imports": f"{sha_import}\n" if gets else "",
        "state": _entries(parts.memory(contract), 12),
        "shown": "[" + ", ".join(f'"{n}"' for n in contract.status.get("properties", {})) + "]",
        "twin_actions": "\n".join(pieces.twin_action(n, a) for n, a in actions.items()),
        "file_method": pieces.FILE_METHOD if gets else "",
        "base64_import": "from base64 import b64decode, b64encode\n" if gets and sends else (
            "from base64 import b64encode\n" if gets else
            "from base64 import b64decode\n" if sends else ""),
        "sha_import": "from hashlib import sha256\n" if sends else "",
        "test_message_import": message if sends else "",
        "good": _entries({n: good_call(a) for n, a in actions.items()}, 4),
        "contract_file": "None" if contract_file is None else f'HERE / "{contract_file}"',
        "files": pieces.sent_files(contract),
        "take_files": pieces.TAKE_FILES if sends else "",
        "give_files": pieces.GIVE_FILES if gets else "",
    }  # fmt: skip


def _entries(values: dict[str, Any], indent: int) -> str:
    lines = (f'{" " * indent}"{n}": {pformat(v, width=1000)},' for n, v in values.items())
    return "\n".join(lines).replace("'", '"')


def _render(template: str, words: dict[str, str]) -> str:
    text = files("labrun.engine.new.device").joinpath(f"{template}.txt").read_text(encoding="utf-8")
    return Template(text).substitute(words)
