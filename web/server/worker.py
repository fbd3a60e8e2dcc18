"""A process for long computations: `python -m labrun.web.server.worker`, one JSON line each way.

It ends by itself when its parent has gone, because its input ends then.
"""

import json
import sys
import traceback
from collections.abc import Callable
from typing import Any

from ..local.refusal import Refusal, not_installed

Work = Callable[[dict[str, Any]], dict[str, Any]]


def works() -> dict[str, Work]:
    """The available functions, by name."""
    from ..library.rehearse_work import rehearse
    from ..library.text_check_work import look
    from ..results.curve_work import curve
    from ..results.peak_work import peaks
    from ..runs.compare_work import changes
    from ..runs.release_work import prepare

    return {
        "look": look,
        "changes": changes,
        "rehearse": rehearse,
        "peaks": peaks,
        "curve": curve,
        "release": prepare,
    }


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
            answer = _refused(refusal)
        except ImportError as fault:
            lacking = not_installed(fault)
            answer = _failed(fault) if lacking is None else _refused(lacking)
        except Exception as fault:  # the next request may succeed; who asked logs the traceback
            answer = _failed(fault)
        print(json.dumps(answer), file=out, flush=True)


def _refused(refusal: Refusal) -> dict[str, Any]:
    return {"ok": False, "status": refusal.status, "fault": refusal.fault.model_dump()}


def _failed(fault: Exception) -> dict[str, Any]:
    trace = "".join(traceback.format_exception(fault))
    return {"ok": False, "kind": type(fault).__name__, "message": str(fault), "trace": trace}


if __name__ == "__main__":
    main()
