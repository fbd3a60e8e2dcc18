"""Find recorded buttons in a picture of the screen, whatever the current size of the program.

Normalised correlation of the grey template (TM_CCOEFF_NORMED) over 25 sizes from half to double
proposes places; each is then fitted more finely, separately in width and height, since letters do
not scale evenly. A place is accepted if grey and edges both fit, colours and contrast are those
of the template, no other recorded button fits better there, and the size is that of the program:
all its buttons are drawn at one. Without the last two, a small "Sync" passes for "Delete".
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from hashlib import blake2b
from operator import itemgetter
from typing import Any

import numpy as np

from ...system.start import later

with later("cv2"):
    import cv2

Picture = np.ndarray
"""Rows x columns x 3, uint8, RGB."""
Box = tuple[int, int, int, int]
"""x, y, width, height in pixels."""

SCALES = tuple(float(s) for s in np.geomspace(0.5, 2.0, 25))
THRESHOLD = 0.7
ALONE = 0.1
"""How much better a button has to fit where no other one confirms the size."""
ONE_PROGRAM = 0.09
"""How far sizes of buttons of one program differ, as a part of it; more by this much where letters are
drawn at half of it, by whole pixels."""
MORE_WHERE_SMALL = 0.03
LEAST_SIDE, LEAST_AREA, LEAST_CONTRAST = 10, 300, 6.0
GREY_BELOW, CONTRAST_ABOVE = 0.72, 1.7
"""Contrast beside the template's: below the first the button is greyed out."""
FAINTEST, LEAST_INK = 0.08, 3.0
EDGE_DOWN, EDGE_ACROSS = 0.2, 0.1
COLOUR_WITHIN = 40.0
"""How far the mean colour may be from the template's, in RGB counts."""
AGREE = 0.7
"""Of all templates, the part that has to fit at one size before the others are believed for it."""
TWIN_WITHIN = 0.06
HOPEFUL = 0.55
PLACES, FEW_PLACES = 7, 4
KEPT = 200
"""How many answers are kept, without their pictures."""
_ANSWERS: dict[bytes, "dict[str, Sighting]"] = {}


@dataclass(frozen=True, slots=True)
class Template:
    """What a button looks like, as it was recorded."""

    name: str
    picture: Picture
    threshold: float = THRESHOLD


@dataclass(frozen=True, slots=True)
class Hit:
    """A place where a template fits: how well (-1..1), at which size, and in which colours."""

    name: str
    score: float
    scale: float
    box: Box
    contrast: float
    colour: float
    doubt: str = ""

    @property
    def grey(self) -> bool:
        """True where it is there, but greyed out: pressing it does nothing."""
        return self.contrast < GREY_BELOW

    @property
    def centre(self) -> tuple[float, float]:
        x, y, w, h = self.box
        return x + w / 2, y + h / 2


@dataclass(frozen=True, slots=True)
class Sighting:
    """What was seen of one template: the places that are believed, best first, and the best other."""

    name: str
    hits: tuple[Hit, ...] = ()
    nearest: Hit | None = None
    hint: str = ""

    @property
    def sure(self) -> Hit | None:
        """The one place, if there is exactly one."""
        return self.hits[0] if len(self.hits) == 1 else None

    def words(self) -> str:
        """What was seen, for a person."""
        if self.sure is not None:
            hit, grey = self.sure, ", greyed out" if self.sure.grey else ""
            x, y = hit.centre
            return (
                f"{self.name} at {x:.0f},{y:.0f} (fit {hit.score:.2f}, size {hit.scale:.2f}{grey})"
            )
        if self.hits:
            places = " and ".join("{:.0f},{:.0f}".format(*hit.centre) for hit in self.hits)
            return f"{self.name} is there {len(self.hits)} times, at {places}"
        if self.nearest is None:
            return f"{self.name} is not visible" + (f": {self.hint}" if self.hint else "")
        x, y = self.nearest.centre
        return (
            f"{self.name} is not visible; the best match is at {x:.0f},{y:.0f} with "
            f"{self.nearest.doubt or f'a fit of {self.nearest.score:.2f}'}"
        )


def unfit(picture: Picture) -> str | None:
    """Why a picture cannot be used as a template; None if it can."""
    height, width = picture.shape[:2]
    if min(height, width) < LEAST_SIDE or height * width < LEAST_AREA:
        return (
            f"{width} x {height} pixels are too few to be distinctive; at least "
            f"{LEAST_SIDE} each way and {LEAST_AREA} in all: include the whole button"
        )
    if float(_grey(picture).std()) < LEAST_CONTRAST:
        return "it is a single colour; include the button's text and border"
    return None


def look_for(
    picture: Picture,
    templates: Sequence[Template],
    scale: float | None = None,
    rivals: Sequence[Template] = (),
) -> dict[str, Sighting]:
    """Name -> what was seen of it. With `scale`, the program's size is known and only that is tried.

    `rivals` are not looked for; but a place that one of them fits better is not believed. A program
    comes back to pictures that it had before: the same bytes are not searched twice.
    """
    asked = _digest(picture, templates, scale, rivals)
    known = _ANSWERS.get(asked)
    if known is None:
        known = _ANSWERS[asked] = _seen(picture, templates, scale, rivals)
        if len(_ANSWERS) > KEPT:
            _ANSWERS.pop(next(iter(_ANSWERS)), None)
    return dict(known)


def _digest(
    picture: Picture, templates: Sequence[Template], scale: float | None, rivals: Sequence[Template]
) -> bytes:
    every = [*templates, *rivals]
    digest = blake2b(repr((len(templates), scale, [(t.name, t.threshold) for t in every])).encode())
    for each in (picture, *(t.picture for t in every)):
        digest.update(repr(each.shape).encode())
        digest.update(each.tobytes())
    return digest.digest()


def _seen(
    picture: Picture, templates: Sequence[Template], scale: float | None, rivals: Sequence[Template]
) -> dict[str, Sighting]:
    grey = _grey(picture)
    found = {t.name: _candidates(picture, grey, t, _near(scale)) for t in templates}
    if scale is None and (scale := _common_scale(found)) is not None:
        # What was crowded out by places of another size may be there yet.
        found = {t.name: _candidates(picture, grey, t, _near(scale)) for t in templates}
    others = {t.name: t for t in (*templates, *rivals)}
    judged = {
        t.name: [replace(h, doubt=_doubt(h, t, scale)) for h in found[t.name]] for t in templates
    }
    sights = {
        name: _sighting(name, [_held_against(picture, grey, h, others, found) for h in hits])
        for name, hits in judged.items()
    }
    if scale is not None:
        inner = {name: _inner(template) for name, template in others.items()}
        for template in templates:
            if not sights[template.name].hits:
                sights[template.name] = _greyed(
                    picture, grey, template, scale, inner, sights[template.name]
                )
    return sights


def common_scale(sights: Iterable[Sighting]) -> float | None:
    """The size at which a program is drawn, from what was seen of it."""
    sizes = sorted(sight.hits[0].scale for sight in sights if sight.hits)
    return sizes[len(sizes) // 2] if sizes else None


def differs(one: Picture, other: Picture) -> bool:
    """Whether two pictures of the same place differ by more than a blinking cursor."""
    if one.shape != other.shape:
        return True
    changed = (np.abs(one.astype(np.int16) - other.astype(np.int16)).max(axis=2) > 24).sum()
    return int(changed) > 60


def _near(scale: float | None) -> tuple[float, ...]:
    if scale is None:
        return SCALES
    return tuple(scale * (1 + part) for part in (-0.05, 0.0, 0.05))


def _grey(picture: Picture) -> np.ndarray:
    return cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY)


def _resized(picture: Picture, across: float, down: float) -> Picture:
    height, width = picture.shape[:2]
    size = max(1, round(width * across)), max(1, round(height * down))
    return cv2.resize(
        picture, size, interpolation=cv2.INTER_AREA if across < 1 else cv2.INTER_CUBIC
    )


def _soft(grey: np.ndarray, height: int) -> np.ndarray:
    """Blurred by a small part of the button's height: letters are never drawn twice the same."""
    sigma = min(1.0, 0.035 * height)
    return cv2.GaussianBlur(grey, (0, 0), sigma) if sigma > 0.2 else grey


def _edges(grey: np.ndarray, height: int) -> np.ndarray:
    soft = _soft(grey, height).astype(np.float32)
    size = cv2.magnitude(cv2.Sobel(soft, cv2.CV_32F, 1, 0), cv2.Sobel(soft, cv2.CV_32F, 0, 1))
    return _soft(size, height)


def _candidates(
    picture: Picture, grey: np.ndarray, template: Template, scales: Sequence[float]
) -> list[Hit]:
    """The best distinct places of one template, each finely fitted."""
    proposed: list[tuple[float, float, Box]] = []
    plain = _grey(template.picture)
    for scale in scales:
        shape = _resized(plain, scale, scale)
        height, width = shape.shape
        if height >= grey.shape[0] or width >= grey.shape[1] or min(height, width) < 5:
            continue
        fits = cv2.matchTemplate(_soft(grey, height), _soft(shape, height), cv2.TM_CCOEFF_NORMED)
        proposed += _peaks(fits, scale, width, height)
    if not proposed:
        return []
    most = PLACES if len(scales) > 3 else FEW_PLACES
    # Also what is most alike in another colour: where nothing is found, that is what is told.
    alike = max(proposed, key=lambda p: p[0])
    proposed.sort(
        key=lambda p: (_apart(picture, template, p[2]) <= COLOUR_WITHIN, p[0]), reverse=True
    )
    places = _distinct([alike, *proposed], most)
    return [_again(picture, grey, template, _fitted(picture, grey, template, p)) for p in places]


def _again(picture: Picture, grey: np.ndarray, template: Template, hit: Hit) -> Hit:
    """The hit fitted about its own size: the proposal's may have been off by more than a fit reaches."""
    if hit.score < HOPEFUL or hit.colour > COLOUR_WITHIN:
        return hit
    place = hit.score, hit.scale, hit.box
    finer = _fitted(picture, grey, template, place, above=hit.score)
    return finer if finer.score > hit.score else hit


def _peaks(fits: np.ndarray, scale: float, width: int, height: int) -> list[Any]:
    fits = np.nan_to_num(fits, nan=-1.0, posinf=-1.0, neginf=-1.0)
    peaks = []
    for _ in range(3):
        _, score, _, (x, y) = cv2.minMaxLoc(fits)
        peaks.append((float(score), scale, (x, y, width, height)))
        rows, columns = (
            slice(max(0, y - height // 2), y + height // 2 + 1),
            slice(max(0, x - width // 2), x + width // 2 + 1),
        )
        fits[rows, columns] = -1.0
    return peaks


def _distinct(proposed: list[Any], most: int) -> list[Any]:
    """One proposal a place and rough size: the same place may be taken at a wrong size first."""
    kept: list[Any] = []
    for score, scale, box in proposed:
        same = [k for k in kept if overlap(k[2], box) > 0.3 and abs(k[1] / scale - 1) < 0.15]
        if not same and len(kept) < most:
            kept.append((score, scale, box))
    return kept


def _fitted(
    picture: Picture, grey: np.ndarray, template: Template, place: Any,
    reach: tuple[float, float] | None = None, above: float = -1.0,
) -> Hit:  # fmt: skip
    """The same place with width and height fitted by themselves, scored on grey and on edges.

    `reach` is how far it may lie off, across and down, in pixels. What scores no better than `above`
    is of no use to the caller, and only told to be so: the edges, which cost most, are then left out.
    """
    _, scale, (x, y, width, height) = place
    across_by, down_by = (max(3, round(n)) for n in reach or (0.08 * width, 0.15 * height))
    left, top = max(0, x - across_by), max(0, y - down_by)
    around = grey[top : y + height + down_by, left : x + width + across_by]
    softened, plain = _soft(around, height), _grey(template.picture)
    tried: dict[tuple[int, ...], tuple[float, np.ndarray, np.ndarray, float]] = {}
    for across in np.linspace(0.94, 1.06, 7):
        for down in (0.95, 1.0, 1.05):
            shape = _resized(plain, scale * across, scale * down)
            rows, columns = shape.shape
            smaller = scale * across < 1  # beyond its own size it is drawn in another way
            kind = (rows, columns, smaller)
            if rows > around.shape[0] or columns > around.shape[1] or kind in tried:
                continue
            fits = cv2.matchTemplate(softened, _soft(shape, height), cv2.TM_CCOEFF_NORMED)
            fits = np.nan_to_num(fits, nan=-1.0)
            size = scale * float(np.sqrt(across * down))
            tried[kind] = float(fits.max()), fits, shape, size
    best: tuple[float, Box, float] = (above, (x, y, around.shape[1], around.shape[0]), scale)
    edged = None
    for most, by_grey, shape, size in sorted(tried.values(), key=itemgetter(0), reverse=True):
        if (3 * most + 1) / 4 <= best[0]:  # however well the edges fit
            break
        edged = _edges(around, height) if edged is None else edged
        by_edge = cv2.matchTemplate(edged, _edges(shape, height), cv2.TM_CCOEFF_NORMED)
        fits = np.nan_to_num((np.minimum(by_grey, by_edge) + (by_grey + by_edge) / 2) / 2, nan=-1.0)
        _, score, _, (dx, dy) = cv2.minMaxLoc(fits)
        if score > best[0]:
            rows, columns = shape.shape
            best = (float(score), (left + dx, top + dy, columns, rows), size)
    return _coloured(picture, template, *best)


def _apart(picture: Picture, template: Template, box: Box) -> float:
    """How far the mean colour of a place is from the template's, in RGB counts."""
    x, y, width, height = box
    patch, own = picture[y : y + height, x : x + width], template.picture
    return float(np.linalg.norm(np.array(cv2.mean(patch)) - np.array(cv2.mean(own))))


def _coloured(picture: Picture, template: Template, score: float, box: Box, scale: float) -> Hit:
    x, y, width, height = box
    patch, own = picture[y : y + height, x : x + width], template.picture
    colour = _apart(picture, template, box)
    shape = _resized(own, width / own.shape[1], height / own.shape[0])
    contrast = float(_grey(patch).std() / max(1.0, _grey(shape).std()))
    return Hit(template.name, min(score, 1.0), scale, box, contrast, colour)


def _common_scale(found: dict[str, list[Hit]]) -> float | None:
    """The size on which most templates agree; None where it is another program's window."""
    good = [
        [hit for hit in hits if hit.score >= THRESHOLD and hit.colour <= COLOUR_WITHIN]
        for hits in found.values()
    ]

    sizes = [hit.scale for hits in good for hit in hits]
    agreeing = max((_agreeing(good, scale) for scale in sizes), key=_weight, default=[])
    if len(agreeing) < max(2, math.ceil(AGREE * len(found))):
        return None
    return sorted(hit.scale for hit in agreeing)[len(agreeing) // 2]


def _agreeing(good: list[list[Hit]], scale: float) -> list[Hit]:
    """The best hit of each template at a size, each at a place of its own."""
    bests = [
        max((h for h in hits if _of_size(h, scale)), key=_score, default=None) for hits in good
    ]
    taken: list[Hit] = []
    for hit in sorted((h for h in bests if h is not None), key=_score, reverse=True):
        if all(overlap(hit.box, other.box) < 0.4 for other in taken):
            taken.append(hit)
    return taken


def _score(hit: Hit) -> float:
    return hit.score


def _weight(hits: list[Hit]) -> tuple[int, float]:
    return len(hits), sum(hit.score**2 for hit in hits)


def _of_size(hit: Hit, scale: float) -> bool:
    return abs(hit.scale / scale - 1) < ONE_PROGRAM + MORE_WHERE_SMALL * (1 / scale - 1)


def _doubt(hit: Hit, template: Template, scale: float | None) -> str:
    wanted = template.threshold + (ALONE if scale is None else 0.0)
    if hit.score < wanted:
        return f"a fit of {hit.score:.2f}, where {wanted:g} is required"
    if scale is not None and not _of_size(hit, scale):
        return f"size {hit.scale:.2f}, where the program's others are drawn at {scale:.2f}"
    if hit.colour > COLOUR_WITHIN:
        return f"another colour ({hit.colour:.0f} counts apart)"
    if hit.contrast > CONTRAST_ABOVE:
        return f"{hit.contrast:.1f} times the contrast"
    return ""


def _held_against(
    picture: Picture,
    grey: np.ndarray,
    hit: Hit,
    others: dict[str, Template],
    found: dict[str, list[Hit]],
) -> Hit:
    """The hit, doubted where another template fits its place better than its own."""
    if hit.doubt:
        return hit
    for name, other in others.items():
        if name == hit.name:
            continue
        fits = [r for r in found.get(name, ()) if overlap(r.box, hit.box) > 0.4]
        fits += _fits_there(picture, grey, hit, other)
        fits = [r for r in fits if r.colour <= max(COLOUR_WITHIN, hit.colour)]
        best = max(fits, key=lambda r: _beside(r, hit), default=None)
        if best is not None and _beside(best, hit) > hit.score:
            words = f"a fit of {hit.score:.2f}, but it is {name} ({best.score:.2f})"
            return replace(hit, doubt=words)
    return hit


def _beside(rival: Hit, hit: Hit) -> float:
    """A rival's fit, less where it fits only a part of the place: "folder" is in "In a new folder"."""
    part = rival.box[2] * rival.box[3] / max(1, hit.box[2] * hit.box[3])
    return rival.score * min(1.0, part) ** 0.25


def _fits_there(picture: Picture, grey: np.ndarray, hit: Hit, other: Template) -> list[Hit]:
    """How another template fits over the place of a hit, at the same size.

    Of a wider one the place may be any part: a label's last word is often alike to a shorter label.
    """
    x, y = hit.centre
    height, width = (round(n * hit.scale) for n in other.picture.shape[:2])
    box = max(0, round(x - width / 2)), max(0, round(y - height / 2)), width, height
    if overlap(box, hit.box) < 0.5 or width >= grey.shape[1] or height >= grey.shape[0]:
        return []
    wider, higher = max(0, width - hit.box[2]), max(0, height - hit.box[3])
    reach = max(0.25 * width, 0.5 * wider + 0.25 * hit.box[2]), 0.15 * height + 0.5 * higher
    fitted = _fitted(picture, grey, other, (0.0, hit.scale, box), reach, above=hit.score)
    return [fitted] if overlap(fitted.box, hit.box) > 0.4 else []


def _inner(template: Template) -> Template:
    """A button's words without its border, which stays as it is when the words are greyed out."""
    height, width = template.picture.shape[:2]
    down, across = round(EDGE_DOWN * height), round(EDGE_ACROSS * width)
    part = template.picture[down : height - down, across : width - across]
    return replace(template, picture=np.ascontiguousarray(part))


def _greyed(
    picture: Picture, grey: np.ndarray, template: Template, scale: float,
    inner: dict[str, Template], sight: Sighting,
) -> Sighting:  # fmt: skip
    """The button greyed out: the same words, far fainter; what was seen before where it is not."""
    found = []
    for hit in _candidates(picture, grey, inner[template.name], _near(scale)):
        x, y, w, h = hit.box
        faint = FAINTEST < hit.contrast < GREY_BELOW
        ink = float(grey[y : y + h, x : x + w].std()) > LEAST_INK
        if hit.score < template.threshold or not (faint and ink) or hit.colour > 2 * COLOUR_WITHIN:
            continue
        if not _held_against(picture, grey, hit, inner, {}).doubt:
            across, down = round(w * EDGE_ACROSS), round(h * EDGE_DOWN)
            box = max(0, x - across), max(0, y - down), w + 2 * across, h + 2 * down
            found.append(replace(hit, box=box))
    return _sighting(template.name, found) if found else sight


def _sighting(name: str, hits: list[Hit]) -> Sighting:
    believed = sorted((h for h in hits if not h.doubt), key=lambda h: h.score, reverse=True)
    if not believed:
        nearest = max(hits, key=lambda h: h.score, default=None)
        return Sighting(name, (), nearest)
    places: list[Hit] = []
    for hit in believed:
        apart = all(overlap(hit.box, other.box) < 0.2 for other in places)
        if apart and hit.score >= believed[0].score - TWIN_WITHIN:
            places.append(hit)
    return Sighting(name, tuple(places))


def moved(sight: Sighting, across: int, down: int) -> Sighting:
    """The same sight, seen in a picture of which the one that was looked at is a part."""

    def there(hit: Hit) -> Hit:
        x, y, width, height = hit.box
        return replace(hit, box=(x + across, y + down, width, height))

    nearest = None if sight.nearest is None else there(sight.nearest)
    return replace(sight, hits=tuple(map(there, sight.hits)), nearest=nearest)


def overlap(one: Box, other: Box) -> float:
    """The common area as a part of the smaller box, 0..1."""
    ax, ay, aw, ah = one
    bx, by, bw, bh = other
    across = min(ax + aw, bx + bw) - max(ax, bx)
    down = min(ay + ah, by + bh) - max(ay, by)
    return max(0, across) * max(0, down) / max(1, min(aw * ah, bw * bh))
