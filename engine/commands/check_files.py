"""What `labrun check` does once its options are understood, without what understands options."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from ...system.output import read_or_not
from ..check import check_file
from ..exit_status import PROBLEMS, SUCCEEDED
from ..problems.print import print_problems


def check_files(
    files: Sequence[Path], *, lab: Path | None = None, bind: Mapping[str, str] | None = None,
    params: Mapping[str, str] | None = None, format: str = "text",
) -> int:  # fmt: skip
    """Print every problem of these protocols; the exit status."""
    found, ok = [], True
    lacking: dict[str, str] = {}
    for file in files:
        checked = check_file(file, lab=lab, bind=bind, params=params, needed=False)
        found += [problem for problem in checked.problems if problem not in found]
        ok = ok and checked.ok
        if checked.lab is not None:
            lacking |= checked.lab.lacking(role.device for role in checked.roles.values())
    with read_or_not():
        print_problems(found, format=format)
        if not found and format == "text":
            what = str(files[0]) if len(files) == 1 else f"{len(files)} protocols"
            print(f"{what}: no problems.")
        for device, why in lacking.items() if format == "text" else ():
            print(f"To run it from here: {device} cannot work, since {why}")
    return SUCCEEDED if ok else PROBLEMS
