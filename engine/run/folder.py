"""A run's folder: made, found again, and locked against a second engine."""

import json
import os
import re
import secrets
import time
from contextlib import suppress
from datetime import datetime
from hashlib import sha256
from os.path import isdir, isfile
from pathlib import Path
from typing import IO

from ...schemas.contract import Contract
from ...schemas.lab import Lab
from ...system import WINDOWS
from ...system.files import lock_file, remove
from ..journal.course import Course
from ..language.used_files import COPIES, USED
from ..language.yaml_write import write_yaml

JOURNAL = "journal.jsonl"
LOCK = "engine.lock"
PROTOCOL = "protocol.yaml"
LAB = "lab.yaml"
CONTRACTS = "contracts"
SERVERS = "servers"
ASKED = "run.json"
LOOK_S = 0.2
"""A lock is tried for this long: longer than a check whether it is held takes."""
ROOM = 100
"""Characters of the longest name within a run's folder while it is written: `changed-1/contracts/...`."""


class FolderFault(Exception):
    """A run's folder that cannot be made, found or locked; the text says which and what to do."""


def new_run_folder(runs: Path, protocol_name: str) -> Path:
    """`runs/2026-11-21_pegmatite-map_7f3a91c2/`, new and empty.

    The ids of all its goals start with the name, also on servers shared with other folders of runs.
    """
    slug = re.sub(r"[^a-z0-9]+", "-", protocol_name.lower()).strip("-")[:40] or "run"
    day = datetime.now().astimezone().strftime("%Y-%m-%d")
    for _ in range(100):
        folder = runs / f"{day}_{slug}_{secrets.token_hex(4)}"
        try:
            folder.mkdir(parents=True)
            _make_sure_of_room_for_names(folder)
            return folder
        except FileExistsError:
            continue
        except OSError as fault:
            raise FolderFault(f"cannot create a run folder in {runs}: {fault.strerror}") from fault
    raise FolderFault(f"cannot find a free name for a run folder in {runs}")


def _make_sure_of_room_for_names(folder: Path) -> None:
    """Raise FolderFault where Windows would refuse a file's path in the middle of a run."""
    if not WINDOWS:
        return
    longest = folder / ("n" * ROOM)
    try:
        longest.write_bytes(b"")
        remove(longest)
    except FileNotFoundError:  # what Windows says of a path that is too long
        folder.rmdir()
        raise FolderFault(
            f"{folder.resolve()} leaves no room for the names of its files: a path may have 259 characters "
            f"on this Windows. Give a shorter `--runs`, or enable long paths (LongPathsEnabled)"
        ) from None


def keep_inputs(
    folder: Path, protocol_text: str, protocol_name: str, lab: Lab, lab_folder: Path | None,
    contracts: dict[str, Contract], asked: dict[str, object],
) -> None:  # fmt: skip
    """Copy protocol, lab and contracts into the folder, so that resume needs nothing else."""
    suffix = ".json" if protocol_name.endswith(".json") else ".yaml"
    (folder / f"protocol{suffix}").write_text(protocol_text, encoding="utf-8")
    (folder / CONTRACTS).mkdir(exist_ok=True)
    names = []
    for contract in contracts.values():
        name = f"{CONTRACTS}/{contract.type.replace('@', '-')}.yaml"
        _dump(folder / name, contract.model_dump(mode="json", exclude_none=True))
        names.append(f"./{name}")
    data = lab.model_dump(mode="json", exclude_none=True, exclude_defaults=True)
    data["contracts"] = names
    if lab_folder is not None and lab.folders:  # a changed protocol takes files from there, too
        data["folders"] = [str((lab_folder / name).resolve()) for name in lab.folders]
    for device in data["devices"].values():
        driver = device.get("driver", "")
        if lab_folder is not None and ".py" in driver and not Path(driver).is_absolute():
            device["driver"] = str((lab_folder / driver).resolve())
        python = device.get("python", "")
        if lab_folder is not None and Path(python).name != python:  # a link stays a link
            device["python"] = str((lab_folder / Path(python).expanduser()).absolute())
    _dump(folder / LAB, data)
    if "notify" in data or any("token" in device for device in data["devices"].values()):
        (folder / LAB).chmod(0o600)  # only resume needs what is secret there
    (folder / ASKED).write_text(json.dumps(asked, indent=1) + "\n", encoding="utf-8")


def hashes(folder: Path) -> dict[str, str]:
    """sha256 of every copy that the run uses: protocol, lab, contracts, parameters."""
    copies = [*folder.glob("protocol.*"), folder / LAB, folder / ASKED, folder / USED]
    copies += sorted((folder / CONTRACTS).glob("*.yaml"))
    copies += sorted((folder / COPIES).glob("*"))
    return {
        path.relative_to(folder).as_posix(): sha256(path.read_bytes()).hexdigest()
        for path in copies
        if path.is_file()
    }


def newest_copies(folder: Path, course: Course) -> Path:
    """The folder with the copies of protocol, lab and parameters that the run uses now."""
    return folder / course.changes[-1].folder if course.changes else folder


def check_hashes(folder: Path, course: Course) -> None:
    """Raise FolderFault if a copy was edited: it would no longer show what was done."""
    place = newest_copies(folder, course)
    found = hashes(place)
    for name, digest in (course.inputs.files if course.inputs is not None else {}).items():
        if found.get(name) != digest:
            raise FolderFault(
                f"{place / name} has changed since the run began. Restore it, or give your "
                f"version as a separate file: labrun resume {folder.name} --changed FILE"
            )


def _dump(path: Path, data: object) -> None:
    with path.open("w", encoding="utf-8") as file:
        write_yaml(data, file)


def protocol_file(folder: Path) -> Path:
    """The run's own copy of its protocol."""
    for name in (PROTOCOL, "protocol.json"):
        if (folder / name).is_file():
            return folder / name
    raise FolderFault(f"{folder} holds no protocol: it is not a run's folder, or it was changed")


def is_run(folder: Path) -> bool:
    """True for a folder that a run has left."""
    return (folder / JOURNAL).is_file()


def all_runs(runs: Path) -> list[Path]:
    """Every run's folder, oldest first."""
    if not runs.is_dir():
        return []
    found = [folder for folder in runs.iterdir() if folder.is_dir() and is_run(folder)]
    return sorted(found, key=lambda folder: (folder / JOURNAL).stat().st_mtime_ns)


def find_run(runs: Path, name: str) -> Path:
    """A run by its path, its name, or an end of its name such as `7f3a`; `last` is the newest."""
    if isdir(name):  # noqa: PTH112 -- Path.is_dir() raises for a name that is too long
        direct = Path(name).resolve()  # `.` has a name, too
        if is_run(direct):
            return direct
        raise FolderFault(f"{direct} is not a run's folder: it holds no {JOURNAL}")
    found = all_runs(runs)
    if name == "last" and found:
        return found[-1]
    fitting = [folder for folder in found if folder.name == name or folder.name.endswith(name)]
    if len(fitting) == 1:
        return fitting[0]
    if fitting:
        names = ", ".join(folder.name for folder in fitting)
        raise FolderFault(f"{name!r} matches several runs: {names}")
    what = f"no run {name!r} in {runs}"
    if isfile(name):  # noqa: PTH113 -- as above
        what = f"{name} is a file, not a run's folder; `labrun {name}` begins a run of a protocol"
    raise FolderFault(f"{what}; `labrun runs` lists the runs")


class FolderLock:
    """The operating system's lock on a run's folder: one engine at a time, gone with its process.

    Its file says which process took it, and where: a copy of the folder has a copy of that.
    """

    def __init__(self, folder: Path) -> None:
        self.path = folder / LOCK
        self._file: IO[str] | None = None

    def take(self) -> None:
        """Take the lock, or raise FolderFault: another engine has it, or the folder is a copy of another."""
        file = self.path.open("a+", encoding="utf-8", errors="surrogateescape")
        try:
            _lock_in_time(file)
        except OSError as fault:
            file.close()
            raise FolderFault(
                f"another engine is running {self.path.parent.name}; "
                "`labrun runs` shows it, `labrun abort` ends it"
            ) from fault
        here = self.path.parent.absolute()
        file.seek(0)
        there = Path(file.read().partition("\n")[2] or here)
        if _is_copy(here, there):
            file.close()
            raise FolderFault(
                f"{here} is a copy of {there}, which is still there; this one does not know what has "
                f"been done there since. Resume that one, or move it away if this is the one that counts"
            )
        file.truncate(0)
        file.write(f"{os.getpid()}\n{here}")
        file.flush()
        self._file = file

    def release(self) -> None:
        """Release the folder; of a run that never began nothing is left then."""
        if self._file is None:
            return
        self._file.close()
        self._file = None
        if WINDOWS:  # which could not delete the file while it was open
            with suppress(OSError):
                if list(self.path.parent.iterdir()) == [self.path]:
                    remove(self.path)
                    self.path.parent.rmdir()


def engine_of(folder: Path) -> int | None:
    """The process that took a folder last, whether or not it still has it."""
    try:
        return int((folder / LOCK).read_bytes().split(b"\n")[0])
    except (OSError, ValueError):
        return None


def _is_copy(here: Path, there: Path) -> bool:
    """True if both have the beginning of one run's journal, and each its own."""
    ours, theirs = here / JOURNAL, there / JOURNAL
    try:
        with ours.open("rb") as one, theirs.open("rb") as other:
            return not ours.samefile(theirs) and one.readline() == other.readline() != b""
    except OSError:
        return False


def is_live(folder: Path) -> bool:
    """True while an engine holds the folder."""
    lock = FolderLock(folder)
    if not lock.path.exists():
        return False
    try:
        file = lock.path.open("a+")
    except OSError:  # another person's run, or a disk that cannot be written
        file = lock.path.open()
    try:
        with file:
            lock_file(file)
        return False
    except OSError:
        return True


def _lock_in_time(file: IO[str]) -> None:
    """Lock; `is_live`, which only checks for an engine, holds it for an instant."""
    until = time.monotonic() + LOOK_S
    while True:
        try:
            return lock_file(file)
        except OSError:
            if time.monotonic() > until:
                raise
        time.sleep(LOOK_S / 20)
