"""A process for what computes for long: `python -m labrun.web.worker`, a line of JSON each way.

It ends by itself when whoever started it has gone: then its input ends.
"""

import json
import sys
from collections.abc import Callable
from typing import Any

Work = Callable[[dict[str, Any]], dict[str, Any]]


def works() -> dict[str, Work]:
    """What can be asked for, by name."""
    from .results.peak_work import peaks
    from .shelf.rehearse_work import rehearse

    return {"rehearse": rehearse, "peaks": peaks}


def main() -> None:
    """Answer requests, one after the other, until there are no more."""
    out = sys.stdout
    sys.stdout = sys.stderr  # whatever a library prints must not come between the answers
    known = works()
    for line in sys.stdin:
        asked = json.loads(line)
        try:
            answer = {"ok": True, "told": known[asked["work"]](asked["asked"])}
        except Exception as fault:  # the next request is another one
            answer = {"ok": False, "kind": type(fault).__name__, "message": str(fault)}
        print(json.dumps(answer), file=out, flush=True)


if __name__ == "__main__":
    main()
