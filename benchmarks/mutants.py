"""How many small planted faults the tests see: mutants of the engine's and the servers' core.

A seeded sample of cosmic-ray's mutants, the same number of each file, is tried one by one in a clone
of this repository; each meets, up to the first failure, the tests that are meant to see it. Rows go
to a file as JSON, one a mutant; a second call goes on after those that are in it.
Run: pip install cosmic-ray, then python benchmarks/mutants.py ROWS [--count N] [--seed N]
"""

import argparse
import json
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

from cosmic_ray.mutating import mutate_code  # pyright: ignore[reportMissingImports]
from cosmic_ray.plugins import get_operator  # pyright: ignore[reportMissingImports]

HERE = Path(__file__).resolve().parents[1]
SERVED, JOURNAL = "tests/drivers/server/test_", "tests/engine/journal/test_"
SESSIONS, MEANING = "tests/engine/runner/test_", "tests/engine/semantics/test_"
FILES = {
    "drivers/server/ledger.py": {SERVED: "ledger slow_ledger server"},
    "drivers/server/lease.py": {SERVED: "lease owner server"},
    "drivers/server/owner.py": {SERVED: "owner held_goals owner_sequences server"},
    "drivers/server/device.py": {SERVED: "owner held_goals server"},
    "drivers/server/execution.py": {SERVED: "execution held_goals"},
    "engine/dispatch/dispatcher.py": {
        "tests/engine/dispatch/test_": "dispatcher outcomes lost_with_server",
        SESSIONS: "between_sessions stopped", MEANING: "background timeout",
    },
    "engine/dispatch/probe.py": {
        "tests/engine/dispatch/test_": "probe", SESSIONS: "between_sessions", MEANING: "once",
    },
    "engine/journal/course.py": {JOURNAL: "course history"},
    "engine/journal/history.py": {JOURNAL: "history", SESSIONS: "between_sessions state_lost"},
    "engine/journal/past.py": {JOURNAL: "history", SESSIONS: "between_sessions", MEANING: "once"},
    "engine/runner/safe_state.py": {SESSIONS: "safe_state between_sessions state_lost"},
    "engine/tree/nodes/earlier.py": {
        "tests/engine/tree/test_": "earlier", SESSIONS: "between_sessions", MEANING: "once ending",
    },
    "engine/tree/nodes/retry.py": {"tests/engine/tree/test_": "retry", MEANING: "retry fallback"},
    "engine/tree/nodes/loop.py": {
        "tests/engine/tree/test_": "loop", MEANING: "foreach repeat_while rules background overlap",
    },
}  # fmt: skip
"""The tests of each file, those first that are nearest to it."""
COMPARISONS = ("Eq_NotEq", "NotEq_Eq", "Lt_LtE", "Lt_Gt", "LtE_Lt", "LtE_Gt", "Gt_GtE", "Gt_Lt", "GtE_Gt",
               "GtE_Lt", "Is_IsNot", "IsNot_Is")  # fmt: skip
OPERATORS = [
    *(f"ReplaceComparisonOperator_{name}" for name in COMPARISONS),
    *(f"ReplaceBinaryOperator_{name}" for name in ("Add_Sub", "Sub_Add", "Mul_Div", "Div_Mul")),
    "ReplaceUnaryOperator_Delete_Not", "ReplaceUnaryOperator_Delete_USub", "AddNot",
    "ReplaceTrueWithFalse", "ReplaceFalseWithTrue", "ReplaceAndWithOr", "ReplaceOrWithAnd",
    "ReplaceBreakWithContinue", "ReplaceContinueWithBreak", "NumberReplacer",
    "RemoveDecorator", "ZeroIterationForLoop",
]  # fmt: skip


def mutants(file: Path) -> list[tuple[str, int, str]]:
    """All mutants of a file as operator, occurrence and its text."""
    source, found = file.read_text(), []
    for operator in OPERATORS:
        occurrence = 0
        made = get_operator(f"core/{operator}")()
        while (text := mutate_code(source, made, occurrence)) is not None:
            found.append((operator, occurrence, text))
            occurrence += 1
    return found


def sample(clone: Path, count: int, seed: int) -> list[tuple[str, str, int, str]]:
    """The same number of each file, in an order that any first part of it is a sample, too."""
    drawn = random.Random(seed)
    by_file = {path: mutants(clone / path) for path in FILES}
    for found in by_file.values():
        drawn.shuffle(found)
    rounds = range(max(map(len, by_file.values())))
    order = [(p, *by_file[p][i]) for i in rounds for p in FILES if i < len(by_file[p])]
    return order[:count]


def changed_line(before: str, after: str) -> tuple[int, str, str]:
    """Where they differ first, and both lines."""
    lines = zip(before.splitlines(), after.splitlines(), strict=False)
    return next((n, a.strip(), b.strip()) for n, (a, b) in enumerate(lines, 1) if a != b)


def judge(clone: Path, path: str, text: str, python: str, limit_s: float) -> tuple[str, str]:
    """`killed`, `time` or `survived`, and the test that saw it."""
    before = (clone / path).read_text()
    (clone / path).write_text(text)
    tests = [f"{where}{name}.py" for where, names in FILES[path].items() for name in names.split()]
    command = [python, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider", "--no-header",
               "--tb=line", f"--timeout={limit_s}", *tests]  # fmt: skip
    here = dict(os.environ, PYTHONPATH=str(clone.parent), PYTHONDONTWRITEBYTECODE="1")
    process = subprocess.Popen(
        command, cwd=clone, env=here, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
        start_new_session=True,
    )  # fmt: skip
    try:
        told, _ = process.communicate(timeout=limit_s)
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        process.communicate()
        return "time", ""
    finally:
        (clone / path).write_text(before)
    if process.returncode == 0:
        return "survived", ""
    if process.returncode in (4, 5):  # wrong paths, or nothing collected
        raise SystemExit(told)
    if "Failed: Timeout" in told:
        return "time", ""
    lines = (line for line in told.splitlines() if line.startswith(("FAILED", "ERROR")))
    return "killed", next(lines, "an error before the first test")[:200]


def main() -> None:
    """Judge what is not yet in the file of rows; print the counts."""
    asked = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    asked.add_argument("rows", type=Path)
    asked.add_argument("--count", type=int, default=200)
    asked.add_argument("--seed", type=int, default=20261123)
    asked.add_argument("--limit", type=float, default=60.0, help="seconds for the tests of one")
    asked.add_argument("--python", default=sys.executable, help="the interpreter of the tests")
    given = asked.parse_args()
    rows = [json.loads(line) for line in given.rows.open()] if given.rows.exists() else []
    done = {(row["file"], row["operator"], row["occurrence"]) for row in rows}
    with tempfile.TemporaryDirectory(prefix="labrun-mutants-") as folder:
        clone = Path(folder) / "labrun"
        subprocess.run(["git", "clone", "-q", str(HERE), str(clone)], check=True)
        for path, operator, occurrence, text in sample(clone, given.count, given.seed):
            if (path, operator, occurrence) in done:
                continue
            line, before, after = changed_line((clone / path).read_text(), text)
            began = time.monotonic()
            verdict, seen_by = judge(clone, path, text, given.python, given.limit)
            row = {"file": path, "operator": operator, "occurrence": occurrence, "line": line,
                   "was": before, "is": after, "verdict": verdict, "seen_by": seen_by,
                   "seconds": round(time.monotonic() - began, 1)}  # fmt: skip
            with given.rows.open("a") as file:
                file.write(json.dumps(row) + "\n")
            rows.append(row)
    print(dict(Counter(row["verdict"] for row in rows)), "of", len(rows))


if __name__ == "__main__":
    main()
