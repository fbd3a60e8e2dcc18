"""Names of protocols: relative to their folder, and never outside it."""

from pathlib import Path, PurePosixPath

from ...system import NO_FILE, WINDOWS
from ..local.refusal import Refusal

SUFFIXES = (".yaml", ".yml", ".json")
DEEPEST = 4
LONGEST = 200


def wrong_name(name: str) -> str:
    """Why a name is not valid for a protocol; empty if it is."""
    pure = PurePosixPath(name)
    if not name.isprintable() or len(name.encode()) > LONGEST:
        return "it is too long, or has invisible characters"
    if "\\" in name or ":" in name or pure.is_absolute() or str(pure) != name:
        return "it must be relative to the folder of protocols, with / between folders"
    if not pure.parts or any(part.startswith(".") or part != part.strip() for part in pure.parts):
        return "no part of it may begin with a dot or have spaces around it"
    if WINDOWS and any(NO_FILE.search(part) for part in pure.parts):
        return "on Windows no file can have it"
    if len(pure.parts) > DEEPEST:
        return f"it may be at most {DEEPEST} folders deep"
    if pure.suffix.lower() not in SUFFIXES:
        return f"it must end with {', '.join(SUFFIXES)}"
    return ""


def place_of(folder: Path, name: str) -> Path:
    """The path of a protocol of this name; raises Refusal if it would be outside the folder."""
    why = wrong_name(name)
    if why:
        raise Refusal(422, "WRONG_NAME", f"{name[:80]!r} is not a valid protocol name: {why}")
    path = folder / name
    if not path.resolve().is_relative_to(folder.resolve()):
        raise Refusal(422, "WRONG_NAME", f"{name!r} is a link to outside the folder")
    return path
