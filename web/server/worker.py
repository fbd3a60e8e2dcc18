"""A process for long computations: `python -m labrun.web.server.worker`, one JSON line each way.

It ends by itself when its parent has gone, because its input ends then.
"""

import json
import sys
import traceback
from collections.abc import Callable
from typing import Any

from ..local.refusal import Refusal

Work = Callable[[dict[str, Any]], dict[str, Any]]


def works() -> dict[str, Work]:
    """The available functions, by name."""
    from ..library.rehearse_work import rehearse
    from ..library.text_check_work import look
    from ..results.peak_work import peaks
    from ..runs.compare_work import changes

    return {"look": look, "changes": changes, "rehearse": rehearse, "peaks": peaks}


def main() -> None:
    """Answer requests one by one until there are no more."""
    out = sys.stdout
    sys.stdout = sys.stderr  # output of libraries must not mix with the answers
    known = works()
    for line in sys.stdin:
        asked = json.loads(line)
        try:
            answer = {"ok": True, "told": known[asked["work"]](asked["asked"])}
        except Refusal as refusal:
            answer = {"ok": False, "status": refusal.status, "fault": refusal.fault.model_dump()}
        except Exception as fault:  # the next request may succeed; who asked logs the traceback
            answer = {"ok": False, "kind": type(fault).__name__, "message": str(fault)}
            answer["trace"] = traceback.format_exc()
        print(json.dumps(answer), file=out, flush=True)


if __name__ == "__main__":
    main()
