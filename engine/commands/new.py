"""`labrun new NAME`: a commented protocol to start from; `labrun new device NAME`: a driver."""

import sys
from contextlib import suppress
from pathlib import Path
from typing import Annotated

import typer

from ..check import check_text
from ..exit_status import PROBLEMS
from ..new.protocol import (
    TEMPLATES,
    CannotMake,
    devices_of,
    new_protocol,
    protocol_name,
    template_text,
)
from ..problems.print import print_problems
from .options import Lab, failing_on

Names = Annotated[
    list[str],
    typer.Argument(
        metavar="[device] NAME",
        help="The name of the protocol; after the word `device`, the name of the device.",
        show_default=False,
    ),
]
Template = Annotated[
    str | None, typer.Option("--template", help=f"What to start from: {', '.join(TEMPLATES)}.")
]
Contract = Annotated[
    str | None,
    typer.Option(
        "--contract", help="For a device: its contract, as gantry@1 or a file; default: its own."
    ),
]
From = Annotated[
    str | None,
    typer.Option(
        "--from",
        metavar="SOURCE",
        help="For a device: what a library knows of it, such as pymeasure:keithley.Keithley2000.",
    ),
]
Speaks = Annotated[
    str | None,
    typer.Option("--speaks", metavar="scpi|lines", help="For a device that needs no Python."),
]
Only = Annotated[
    str | None,
    typer.Option(
        "--only", metavar="PATTERNS", help="Of what the source has, these actions: 'read_*,move'."
    ),
]


def new(
    name: Names,
    template: Template = None,
    contract: Contract = None,
    lab: Lab = None,
    source: From = None,
    only: Only = None,
    speaks: Speaks = None,
) -> None:
    """Write NAME.yaml, a protocol that checks clean; with `device`, a driver and all it needs."""
    with failing_on(CannotMake):
        if only is not None and source is None:
            raise CannotMake("--only chooses of what --from finds")
        if len(name) == 2 and name[0] == "device":
            if template is not None or lab is not None:
                raise CannotMake(
                    "--template and --lab are for protocols; a device takes --contract"
                )
            if speaks is not None:
                if source is not None:
                    raise CannotMake("--from says how it speaks; leave out --speaks")
                _speaking_device(name[1], speaks, contract)
            elif source is None:
                _new_device(name[1], contract)
            elif contract is None:
                _device_from(name[1], source, only)
            else:
                raise CannotMake("--from says the contract; leave out --contract")
        elif len(name) > 1:
            raise CannotMake(f"give one name; a name with spaces in quotes: {' '.join(name)!r}")
        elif contract is not None or source is not None or speaks is not None:
            option = "--contract" if contract else "--from" if source else "--speaks"
            raise CannotMake(f"{option} is for devices: labrun new device {name[0]}")
        elif name[0] == "device" and template is None:
            raise CannotMake(
                "which device? labrun new device kiln; "
                "a protocol of that name: labrun new device --template grid_scan"
            )
        else:
            _new_protocol(name[0], template or "grid_scan", lab)


def _new_protocol(name: str, template: str, lab: Path | None) -> None:
    plain = protocol_name(name)
    path = Path(f"{plain}.yaml")
    example = check_text(template_text(template), f"{template}.yaml", lab=lab)
    if example.lab is None or example.protocol is None:
        print_problems(example.problems, file=sys.stderr)
        raise typer.Exit(PROBLEMS)
    made = new_protocol(plain, template, example.protocol, example.lab)
    _write(path, made.text)
    _say_next(path, made.binds, lab)
    lacking = example.lab.lacking(devices_of(example.protocol, example.lab, made.binds))
    for device, why in lacking.items():
        print(f"To run it: {device} cannot work, since {why}; --template minimal needs nothing")


def _device_from(name: str, source: str, patterns: str | None) -> None:
    from ..new.device.entry import entry_text, only
    from ..new.device.make import LAB, device_name
    from ..new.device.sources import described

    known = described(source)
    known = known if patterns is None else only(known, patterns)
    if not _write_said(name, entry_text(device_name(name), known)):
        return
    where = ", ".join(f"`{key}`" for key in known.notes if key in known.config)
    print(
        f"{LAB} is written, with {len(known.actions)} actions. {f'Say {where}, look' if where else 'Look'} "
        "at the effects, leave out what you do not need. Next:"
    )
    print(f"  labrun devices {name} --lab {LAB}")
    print(f"  labrun call {name}.ACTION --lab {LAB}     # `driver: sim_{known.driver}` is its twin")
    print(f"  pytest test_{name}.py")


def _speaking_device(name: str, language: str, contract: str | None) -> None:
    from ..new.device.make import LAB, speaking_device

    if language not in ("scpi", "lines"):
        raise CannotMake(
            f"--speaks {language}: a device speaks scpi or lines; registers are --from modbus:registers.csv"
        )
    entry, contract_file = speaking_device(name, language, contract)
    if _write_said(name, entry, contract_file):
        print(f"{LAB} is written. Say where it is, and make its actions those of yours. Next:")
        print(f"  labrun devices {name} --lab {LAB}")
        print(f"  pytest test_{name}.py     # of its twin")


def _write_said(name: str, entry: str, contract_file: str | None = None) -> bool:
    """A lab with a device that is said there, and its contract test; False if there is a lab already."""
    from ..new.device.entry import test_text
    from ..new.device.make import LAB

    test = Path(f"test_{name}.py")
    if test.exists():
        raise CannotMake(f"{test} already exists; choose another name, or move it away")
    _write(test, test_text(name, LAB))
    if Path(LAB).exists():
        print(f"{LAB} already exists; add these lines to its `devices`:\n\n{entry}", end="")
        if contract_file is not None:
            print(f"\nand its contract:\n\ncontracts: [./{contract_file}]")
        return False
    own = "" if contract_file is None else f"contracts: [./{contract_file}]\n"
    _write(Path(LAB), f"{own}devices:\n{entry}")
    return True


def _new_device(name: str, contract: str | None) -> None:
    from ..new.device.make import LAB, new_device

    has_lab = Path(LAB).exists()
    made = new_device(name, contract, with_lab=not has_lab)
    there = [file for file in made.files if Path(file).exists()]
    if there:
        raise CannotMake(f"{there[0]} already exists; choose another name, or move it away")
    for file, text in made.files.items():
        _write(Path(file), text)
    print(f"{', '.join(made.files)} are written. Next:")
    print(f"  pytest test_{name}.py")
    print(f"  labrun serve {LAB} {name}")
    if contract is None:
        print(
            "Is it spoken to in SCPI or in lines of text? `--speaks scpi` or `lines` needs no Python."
        )
    if has_lab:
        print(f"\n{LAB} already exists; add these lines to its `devices`:\n\n{made.device}", end="")
        if made.contract_file is not None:
            print(f"\nand its contract:\n\ncontracts: [./{made.contract_file}]")


def _write(path: Path, text: str) -> None:
    """Write a new file: opened so that no race overwrites an existing one."""
    try:
        with path.open("x", encoding="utf-8", newline="\n") as file:
            file.write(text)
    except FileExistsError:
        raise CannotMake(f"{path} already exists; choose another name, or move it away") from None
    except OSError as fault:
        with suppress(OSError):
            path.unlink()  # where the disk is full, an empty one is there
        raise CannotMake(f"{path} cannot be written: {fault.strerror or fault}") from None


def _say_next(path: Path, binds: dict[str, str], lab: Path | None) -> None:
    file = f'"{path}"' if " " in str(path) else str(path)
    options = "".join(f" --bind {role}={device}" for role, device in binds.items())
    options = (f" --lab {lab}" if lab is not None else "") + options
    print(f"{path} is written. Next:")
    print(f"  labrun check {file}{options}")
    print(f"  labrun rehearse {file}{options}" if lab is not None else f"  labrun {file}{options}")
