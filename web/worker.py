"""A process for what computes for long: `python -m labrun.web.worker`, a line of JSON each way.

It ends by itself when whoever started it has gone: then its input ends.
"""

import json
import sys
import traceback
from collections.abc import Callable
from typing import Any

from .guard.refusal import Refusal

Work = Callable[[dict[str, Any]], dict[str, Any]]


def works() -> dict[str, Work]:
    """What can be asked for, by name."""
    from .live.compare_work import changes
    from .results.peak_work import peaks
    from .shelf.look_work import look
    from .shelf.rehearse_work import rehearse

    return {"look": look, "changes": changes, "rehearse": rehearse, "peaks": peaks}


def main() -> None:
    """Answer requests, one after the other, until there are no more."""
    out = sys.stdout
    sys.stdout = sys.stderr  # whatever a library prints must not come between the answers
    known = works()
    for line in sys.stdin:
        asked = json.loads(line)
        try:
            answer = {"ok": True, "told": known[asked["work"]](asked["asked"])}
        except Refusal as refusal:
            answer = {"ok": False, "status": refusal.status, "fault": refusal.fault.model_dump()}
        except Exception as fault:  # the next request is another one
            answer = {"ok": False, "kind": type(fault).__name__, "message": str(fault)}
            answer["trace"] = traceback.format_exc()
        print(json.dumps(answer), file=out, flush=True)


if __name__ == "__main__":
    main()
