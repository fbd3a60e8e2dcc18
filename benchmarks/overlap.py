"""How long a loop with iterations at once takes beside the best schedule that OR-Tools finds.

Samples are weighed, filled, heated and measured, each on a device that all of them share. The solver knows
all durations beforehand and may do the samples in any order, another one on each device. labrun's loop lets
whoever asks first for a device have it, and begins the samples as they are listed, or in the shortest order:
knowing the durations, too, or durations that are each up to 30 % off. Rehearsed by the whole engine on a
virtual clock; durations are drawn at random. Needs ortools.
Run: python benchmarks/overlap.py [--sets 50] [--samples 8]
"""

import argparse
import itertools
import random
import statistics
import tempfile
from pathlib import Path

STAGES = ("weigh", "dispense", "heat", "measure")
KINDS = {
    "any durations, 1 to 10 min each": ((1, 10), (1, 10), (1, 10), (1, 10)),
    "heating takes longest, 8 to 20 min": ((1, 3), (2, 6), (8, 20), (2, 6)),
}
ORDERS = (
    "shortest order, over the best of any order",
    "shortest order by durations up to 30 % off, over the same",
    "order listed, over the best of any order",
    "order listed, over the best that begins them as listed",
)
LIMIT_S = 20.0
"""Of the solver, for one set."""
CONTRACT = """
type: station@1
summary: Is busy for as long as it is told
actions:
  work:
    effect: once
    duration: 1 min
    takes: told
    params: {type: object, properties: {take: &time {type: number, unit: s}, told: *time}}
"""
DRIVER = '''
from labrun.drivers.simulated.twins.twin import Twin


class Station(Twin):
    """Implements station@1."""

    contract = without = "station@1"

    async def work(self, goal, *, take=0.0, told=0.0):
        await self.clock.sleep(take)
        return {}
'''
PROTOCOL = """
labrun: 1
name: overlap
devices: {devices}
steps:
  - foreach: {{sample: {samples}}}
    at_once: {at_once}
    order: {order}
    steps:
{steps}
"""

Durations = list[list[int]]
"""Minutes, a row for each sample, in the order of the stages."""


def rehearsed(
    folder: Path, durations: Durations, order: str, told: list[list[float]] | None = None
) -> float:
    """Minutes that labrun takes, by a rehearsal; `told` are the durations that it knows beforehand."""
    from labrun.engine.check import check_file
    from labrun.engine.rehearse.rehearse import Rehearsal

    rows = [
        {f"s{n}": f"{took} min" for n, took in enumerate(row)}
        | {f"t{n}": f"{took} min" for n, took in enumerate(known)}
        for row, known in zip(durations, told or durations, strict=True)
    ]
    steps = "\n".join(
        f"      - {{do: {stage}.work, timeout: 2 h, with: "
        f"{{take: '${{{{ sample.s{n} }}}}', told: '${{{{ sample.t{n} }}}}'}}}}"
        for n, stage in enumerate(STAGES)
    )
    path = folder / "overlap.yaml"
    devices = "{" + ", ".join(f"{stage}: station@1" for stage in STAGES) + "}"
    path.write_text(
        PROTOCOL.format(devices=devices, samples=rows, at_once=len(rows), order=order, steps=steps),
        "utf-8",
    )
    checked = check_file(path, lab=folder / "lab.yaml")
    assert checked.ok, checked.problems
    totals = Rehearsal(checked).play()
    assert totals.fate == "succeeded", totals.reason
    return totals.lasts_s / 60


def best(durations: Durations, *, in_order: bool = False) -> tuple[float, bool]:
    """Minutes of the best schedule that was found, and whether it is known to be the best.

    `in_order`: of those that begin the samples in the order in which they are listed.
    """
    from ortools.sat.python import cp_model

    model, horizon = cp_model.CpModel(), sum(map(sum, durations))
    on_device: list[list] = [[] for _ in STAGES]
    ends, begins = [], []
    for row in durations:
        before = 0
        for n, took in enumerate(row):
            start = model.new_int_var(0, horizon, "")
            end = model.new_int_var(0, horizon, "")
            on_device[n].append(model.new_interval_var(start, took, end, ""))
            model.add(start >= before)
            begins += [start] if not n else []
            before = end
        ends.append(before)
    for intervals in on_device:
        model.add_no_overlap(intervals)
    if in_order:
        for earlier, later in itertools.pairwise(begins):
            model.add(earlier <= later)
    last = model.new_int_var(0, horizon, "")
    model.add_max_equality(last, ends)
    model.minimize(last)
    solver = cp_model.CpSolver()
    solver.parameters.max_time_in_seconds, solver.parameters.num_workers = LIMIT_S, 2
    solver.parameters.random_seed = 1
    status = solver.solve(model)
    assert status in (cp_model.OPTIMAL, cp_model.FEASIBLE)
    return solver.objective_value, status == cp_model.OPTIMAL


def main() -> None:
    """Print how much longer than the best, median and worst, for each kind of durations."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--sets", type=int, default=50)
    parser.add_argument("--samples", type=int, default=8)
    said = parser.parse_args()
    drawn = random.Random(1)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "station.yaml").write_text(CONTRACT, encoding="utf-8")
        (folder / "station.py").write_text(DRIVER, encoding="utf-8")
        devices = "\n".join(
            f"  {stage}: {{contract: station@1, driver: './station.py:Station'}}"
            for stage in STAGES
        )
        lab = f"name: bench\ncontracts: [./station.yaml]\ndevices:\n{devices}\n"
        (folder / "lab.yaml").write_text(lab, encoding="utf-8")
        for kind, ranges in KINDS.items():
            over: dict[str, list[float]] = {name: [] for name in ORDERS}
            alone, proved = [], 0
            for _ in range(said.sets):
                durations = [[drawn.randint(*one) for one in ranges] for _ in range(said.samples)]
                told = [[took * drawn.uniform(0.7, 1.3) for took in row] for row in durations]
                shortest, is_best = best(durations)
                proved += is_best
                listed = rehearsed(folder, durations, "listed")
                known = rehearsed(folder, durations, "shortest")
                unsure = rehearsed(folder, durations, "shortest", told)
                beside = best(durations, in_order=True)[0]
                lasts = (known / shortest, unsure / shortest, listed / shortest, listed / beside)
                for name, ratio in zip(ORDERS, lasts, strict=True):
                    over[name].append(100 * (ratio - 1))
                alone.append(sum(map(sum, durations)) / shortest)
            print(f"{kind}; {proved} of {said.sets} schedules known to be the best")
            for name, parts in over.items():
                print(
                    f"  {name:<60}  {statistics.median(parts):5.1f} % (median)  {max(parts):5.1f} % (worst)"
                )
            print(f"  one by one, over the best  {statistics.median(alone):.2f} times", flush=True)


if __name__ == "__main__":
    main()
