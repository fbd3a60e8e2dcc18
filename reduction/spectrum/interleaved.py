"""Channels of two detectors that were sorted into one another where their ranges overlap.

Of unlike gain they would be a saw's teeth, and each tooth a line. The axis tells: each detector's own
channels are evenly spaced, and together they are not.
"""

import numpy as np

from .same_axis import of_axis
from .spectrum import FloatArray, IntArray

BEFORE = 16  # channels that tell a detector's pitch, and that end an overlap
# Of the pitch: a step of that length has a channel of another detector; from where a detector's next
# channel should be; between its steps.
SHORT, MUCH_SHORTER, NEAR, ALIKE = 0.8, 0.6, 0.04, 0.2
LEAST, EVEN, UNEVEN = 4, 0.85, 0.3  # channels of each in an overlap; parts of its steps
MOST_TRIED = 6  # places in a row that are no overlap
AHEAD = 12  # channels of the other between two of one detector
UNLIKE = 1.25  # ratio of light, from which two detectors' channels are not used together
MOST_CLOSE = 0.5  # of an overlap's channels that may be either's
SAME = 1.5  # roundings between channels that may be either's
FINE = 2.5  # roundings in a step, from which steps tell anything
MANY = 0.02  # of the channels; more are no accident


def taken_apart(
    nm: FloatArray, shots: FloatArray
) -> tuple[IntArray, list[tuple[float, float]], bool]:
    """Channels to keep, ascending; the overlaps in nm; and whether others are left in one another.

    nm: ascending, shape (n,). shots: counts, (s, n). Each detector is used up to the middle of an
    overlap; where both show as much light, all are kept.
    """
    every, short = np.arange(len(nm)), _too_short(nm)
    if len(short) < LEAST:
        return every, [], False
    rounding = _rounding(nm)
    if rounding * FINE > np.median(np.diff(nm)):
        return every, [], False
    counts = np.nan_to_num(shots).mean(axis=0)
    kept, overlaps, done, tried = np.ones(len(nm), bool), [], 0, 0
    alike = np.zeros(len(nm), bool)
    for at in short.tolist():
        if at < done or tried == MOST_TRIED:
            continue
        tried += 1
        first, second = _tracks(nm, max(at - 2, BEFORE, done), rounding)
        if len(second):
            begin, end = float(nm[second[0]]), float(nm[first[-1]])
            together = np.arange(second[0] - 1, done_at := int(first[-1]) + 1)
            same = max(SAME * rounding, NEAR * float(np.median(np.diff(nm[first]))))
            close = np.flatnonzero(np.diff(nm[together]) < same)
            done, tried = done_at, 0
            if len(close) > MOST_CLOSE * len(second) or _as_bright(nm, counts, first, second):
                alike[second] = True
                continue
            middle = 0.5 * (begin + end)
            kept[first[nm[first] > middle]] = False
            kept[second[nm[second] <= middle]] = False
            kept[together[close]] = kept[together[close] + 1] = False  # whose is whose is not told
            overlaps.append((begin, end))
        else:
            done = at + BEFORE
    plain = nm[kept & ~alike]
    close = _short(plain, MUCH_SHORTER)
    beyond = _short(-plain[::-1], MUCH_SHORTER)  # a gap is on one side only
    again = np.intersect1d(close, len(plain) - 2 - beyond)
    return every[kept], overlaps, len(again) > MANY * len(nm)


def _as_bright(nm: FloatArray, counts: FloatArray, first: IntArray, second: IntArray) -> bool:
    """Whether two detectors show as much light where both see it, so that their gains are one."""
    one = float(np.sum(np.interp(nm[second], nm[first], counts[first])))
    other = float(np.sum(counts[second]))
    return one > 0 < other and max(one / other, other / one) < UNLIKE


@of_axis
def _too_short(nm: FloatArray) -> IntArray:
    return _short(nm, SHORT)


def _short(nm: FloatArray, part: float) -> IntArray:
    """Channels after which the next is nearer than that part of the pitch before them."""
    if len(nm) <= 2 * BEFORE:
        return np.empty(0, np.int64)
    pitch = (nm[BEFORE:-1] - nm[: -BEFORE - 1]) / BEFORE
    return np.flatnonzero(np.diff(nm[BEFORE:]) < part * pitch) + BEFORE


def _rounding(nm: FloatArray) -> float:
    for decimals in range(6):
        if np.array_equal(np.round(nm, decimals), nm):
            return 10.0**-decimals
    return 0.0


def _tracks(nm: FloatArray, start: int, rounding: float) -> tuple[IntArray, IntArray]:
    """The channels of the detector that ends in an overlap, and of the one that begins in it; none
    where these do not account for all."""
    nothing = np.empty(0, np.int64)
    pitch = float(nm[start] - nm[start - BEFORE]) / BEFORE
    first, alone, at, beside = [start], 0, start, 0
    while at + 1 < len(nm):
        ahead = nm[at + 1 : at + 1 + AHEAD]
        off = np.abs(ahead - nm[at] - pitch)
        step = int(np.argmin(off))
        if off[step] > NEAR * pitch + 1.5 * rounding:
            break
        pitch += 0.1 * (float(ahead[step]) - float(nm[at]) - pitch)
        at += step + 1
        first.append(at)
        beside += step
        alone = 0 if step or not beside else alone + 1
        if alone >= BEFORE:  # by chance the other's channels follow where its own would be
            del first[-alone:]
            at = first[-1]
            break
    one = np.array(first)
    two = np.setdiff1d(np.arange(start, at), one)
    if len(two) < LEAST or at + 1 + LEAST >= len(nm):
        return nothing, nothing
    one = one[one > two[0] - AHEAD]
    own = np.diff(nm[np.concatenate([two, np.arange(at + 1, at + 1 + LEAST)])])
    usual, together = float(np.median(own)), np.diff(nm[two[0] : at + 1])
    even = float(np.mean(np.abs(own - usual) <= ALIKE * usual + 2 * rounding))
    jumps = np.abs(np.diff(together)) > ALIKE * float(np.mean(together)) + rounding
    if len(one) < LEAST or even < EVEN or not len(jumps) or np.mean(jumps) < UNEVEN:
        return nothing, nothing
    return one, two
