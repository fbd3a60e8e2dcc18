"""`labrun problem CODE`: what a problem means, why it is one, and how to fix it."""

from typing import Annotated

import typer

from ..exit_status import PROBLEMS
from ..language.suggest import listed
from .options import say

Codes = Annotated[
    list[str] | None, typer.Argument(metavar="CODE...", help="Such as E204.", show_default=False)
]
NEAREST = 6


def problem(codes: Codes = None) -> None:
    """Print the manual page of a problem; without a code, list all of them."""
    from ..problems.manual import all_codes, page, said_of, words

    if not codes:
        for code, title in all_codes().items():
            print(f"{code}  {title}")
        print("\n`labrun problem E204` explains why it is a problem, and shows YAML that passes.")
        return
    unknown = False
    for index, code in enumerate(codes):
        found = page(code.strip().upper().strip("[]"))
        if found is None:
            say(f"there is no problem {code}; {_near(code, all_codes())}")
            unknown = True
            continue
        said = [words(one) for one in said_of(found, found.fails) if one.code == found.code]
        parts = [found.text(), "What labrun reports:", *("    " + line for line in said)]
        print("\n\n" * bool(index) + "\n\n".join(parts).replace("\n   = ", "\n       = "))
    if unknown:
        raise typer.Exit(PROBLEMS)


def _near(code: str, known: dict[str, str]) -> str:
    """Codes that look like it, or whose titles mention it."""
    wanted = code.strip().upper()
    family = [one for one in known if len(wanted) > 1 and one[:2] == wanted[:2]]
    same_number = [one for one in known if one[1:] == wanted[1:]]
    spoken = [one for one, title in known.items() if code.casefold() in title.casefold()]
    near = [*same_number, *(spoken if not wanted[:1].isdigit() else []), *family]
    near += [one for one in known if wanted.isdigit() and one.endswith(wanted)]
    if not near:
        return "`labrun problem` lists them all"
    shown = list(dict.fromkeys(near))[:NEAREST]
    return "similar: " + listed(f"{one} ({known[one]})" for one in shown)
