"""The process in which a function of a protocol's own is called: one call, from standard input.

It imports nothing of labrun, and labrun imports it nowhere: it is started as a script. What the function
prints goes to standard error.
"""

import contextlib
import faulthandler
import json
import sys

MEMORY = 8 * 1024**3
"""Bytes; beyond, it gets a MemoryError before the machine, and the run with it, gets none."""


def main() -> None:
    asked = json.loads(sys.stdin.buffer.read())
    # Whoever asked ends this process in time; should that one be gone, it ends by itself.
    faulthandler.dump_traceback_later(asked["limit_s"], exit=True)
    with contextlib.suppress(ImportError, ValueError, OSError):  # none on Windows
        import resource

        resource.setrlimit(resource.RLIMIT_AS, (MEMORY, resource.getrlimit(resource.RLIMIT_AS)[1]))
    answers, sys.stdout = sys.stdout, sys.stderr
    try:
        names = {"__name__": "labrun_function", "__file__": asked["file"]}
        exec(compile(asked["text"], asked["file"], "exec"), names)
        result = names[asked["function"]](**asked["given"])
        told = json.dumps({"result": result}, default=_plain)
    except BaseException as fault:  # SystemExit as well: it is the experimenter's code
        told = json.dumps(
            {
                "error": type(fault).__name__,
                "message": str(fault),
                "line": _line(fault, asked["file"]),
            }
        )
    answers.write(told)
    answers.flush()


def _plain(value):
    """Numbers and lists of other libraries, such as NumPy's."""
    if hasattr(value, "tolist"):
        return value.tolist()
    raise TypeError(f"it gave {type(value).__name__}, which is no plain value")


def _line(fault, file):
    """The line of the function's file in which it failed."""
    if isinstance(fault, SyntaxError):
        return fault.lineno
    trace, line = fault.__traceback__, None
    while trace is not None:
        if trace.tb_frame.f_code.co_filename == file:
            line = trace.tb_lineno
        trace = trace.tb_next
    return line


if __name__ == "__main__":
    main()
