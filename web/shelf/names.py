"""Names of protocols: relative to their folder, and never leading out of it."""

from pathlib import Path, PurePosixPath

from ..guard.refusal import Refusal

SUFFIXES = (".yaml", ".yml", ".json")
DEEPEST = 4
LONGEST = 200


def wrong_name(name: str) -> str:
    """Why a name cannot be that of a protocol; empty where it can."""
    pure = PurePosixPath(name)
    if not name.isprintable() or len(name.encode()) > LONGEST:
        return "it is too long, or has characters that cannot be seen"
    if "\\" in name or ":" in name or pure.is_absolute() or str(pure) != name:
        return "it is relative to the folder of protocols, with / between folders"
    if not pure.parts or any(part.startswith(".") or part != part.strip() for part in pure.parts):
        return "none of its parts begins with a dot or has spaces around it"
    if len(pure.parts) > DEEPEST:
        return f"it is at most {DEEPEST} folders deep"
    if pure.suffix.lower() not in SUFFIXES:
        return f"it ends with {', '.join(SUFFIXES)}"
    return ""


def place_of(folder: Path, name: str) -> Path:
    """Where a protocol of this name lies; raises Refusal where it would be outside the folder."""
    why = wrong_name(name)
    if why:
        raise Refusal(422, "WRONG_NAME", f"{name[:80]!r} is no name for a protocol: {why}")
    path = folder / name
    if not path.resolve().is_relative_to(folder.resolve()):
        raise Refusal(422, "WRONG_NAME", f"{name!r} is a link that leads out of the folder")
    return path
