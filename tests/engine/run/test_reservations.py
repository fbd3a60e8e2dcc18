"""All orders of small programs: nothing blocks for ever, and nobody comes between what is reserved.

Each program is a list of `do DEVICE`, or of (devices, program) for a reservation; they run beside each other.
"""

from itertools import combinations_with_replacement, count

import pytest

from labrun.engine.run.reservations import Reservations

A, B, AB = frozenset("a"), frozenset("b"), frozenset("ab")
PROGRAMS = (
    ["a"], ["a", "b"], ["b", "a"], [(AB, ["a", "b"])], [(AB, ["b", "a"]), "c"],
    [(A, ["a", "a"]), (B, ["b"])], [(AB, ["a", (A, ["a"]), "b"])], ["c", (A, ["a", "c"]), "b"],
)  # fmt: skip


def flat(program, around=()):
    """Its moments: (ask, devices), (do, device), (release,)."""
    for part in program:
        if isinstance(part, str):
            yield "do", part
        else:
            yield "ask", part[0]
            yield from flat(part[1])
            yield "release", None


class World:
    """A dispatcher of the smallest kind around the real reservations."""

    def __init__(self, programs):
        self.reservations = Reservations()
        self.left = [list(flat(program)) for program in programs]
        self.begun = [False] * len(programs)
        self.around = [None] * len(programs)
        self.queue, self.running = [], {}
        self.asking = {}
        self.moments, self.granted = count(), {}

    def options(self):
        begin = [("begin", n) for n, begun in enumerate(self.begun) if not begun]
        return [*begin, *(("end", device) for device in sorted(self.running))]

    def choose(self, option):
        what, which = option
        if what == "begin":
            self.begun[which] = True
            self._next(which)
        else:
            self._next(self.running.pop(which)[0])
        while self._round():
            pass

    def _next(self, n):
        if not self.left[n]:
            return
        what, which = self.left[n].pop(0)
        if what == "do":
            self.queue.append((self.reservations.next(), which, self.around[n], n))
        elif what == "ask":
            self.asking[n] = self.around[n] = self.reservations.ask(which, self.around[n])
        else:
            self.reservations.release(self.around[n])
            self.around[n] = self.around[n].within
            self._next(n)

    def _round(self):
        singles = [(k, d, r) for k, d, r, _ in self.queue if self.reservations.may_use(d, r)]
        granted = self.reservations.grant(singles)
        for one in self.reservations.held:
            self.granted.setdefault(one, next(self.moments))
        for one in list(self.queue):
            _, device, reservation, n = one
            if device not in self.running and self.reservations.may_use(device, reservation):
                self.queue.remove(one)
                self.running[device] = n, next(self.moments)
        for n, asked in list(self.asking.items()):
            if asked.granted:
                del self.asking[n]
                self._next(n)
        return granted

    def check(self):
        for one in self.reservations.held:
            owner = next(n for n, r in enumerate(self.around) if r and one in r.chain())
            for device in one.devices & self.running.keys():
                n, since = self.running[device]
                assert n == owner or since < self.granted[one], "somebody came in between"


@pytest.mark.parametrize("beside", [2, pytest.param(3, marks=pytest.mark.soak)])
def test_no_order_of_small_programs_blocks(beside):
    orders = 0
    for programs in combinations_with_replacement(PROGRAMS, beside):
        prefixes = [()]
        while prefixes:
            prefix = prefixes.pop()
            world = World(programs)
            for choice in prefix:
                world.choose(choice)
                world.check()
            options = world.options()
            if beside == 3 and len(prefix) > 4:  # after that, in one order
                options = options[:1]
            prefixes += [(*prefix, option) for option in options]
            if not options:
                orders += 1
                assert not any(world.left) and not world.queue and not world.asking, prefix

    assert orders > 100


def test_whoever_asks_first_comes_first():
    reservations = Reservations()
    first, second, third = (reservations.ask(devices, None) for devices in (AB, A, B))

    reservations.grant()
    assert (first.granted, second.granted, third.granted) == (True, False, False)

    fourth = reservations.ask(A, first)
    reservations.grant()
    assert fourth.granted, "within the first, though others wait for it"

    reservations.release(fourth)
    reservations.release(first)
    reservations.grant()
    assert second.granted and third.granted


def test_a_reservation_passes_no_single_action_that_asked_before_it():
    reservations = Reservations()
    single = reservations.next()
    one = reservations.ask(A, None)

    reservations.grant([(single, "a", None)])
    assert not one.granted

    reservations.grant()
    assert one.granted
