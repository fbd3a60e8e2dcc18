"""Lay panels of one map out on a page, all at the same scale, as large as the page allows."""

from dataclasses import dataclass

from .paper import ONE_COLUMN_IN, PAGE_IN, TWO_COLUMNS_IN

MOST_WIDTH_IN, MOST_HEIGHT_IN = 2.1, 3.2  # of one panel
NARROWEST_IN = 0.72  # room for a panel's title
MARGIN_IN, GAP_IN, TITLE_IN = 0.08, 0.12, 0.19


@dataclass(frozen=True, slots=True)
class Layout:
    """Places of panels in inches. scale: inches per unit of length."""

    columns: int
    rows: int
    scale: float
    panel: tuple[float, float]
    slot: tuple[float, float]
    size: tuple[float, float]
    top: float

    def at(self, index: int) -> tuple[float, float, float, float]:
        """Left, bottom, width and height of a panel."""
        row, column = divmod(index, self.columns)
        spare = self.slot[0] - GAP_IN - self.panel[0]
        left = MARGIN_IN + column * self.slot[0] + spare / 2
        bottom = self.size[1] - self.top - row * self.slot[1] - TITLE_IN - self.panel[1]
        return left, bottom, *self.panel

    def of_smaller(self, index: int, across: float, up: float) -> tuple[float, float, float, float]:
        """The same of a map that is smaller than the panel, in units: in the middle, at the top."""
        left, bottom, width, height = self.at(index)
        wide, high = across * self.scale, up * self.scale
        return left + (width - wide) / 2, bottom + height - high, wide, high


def lay_out(
    n: int, across: float, up: float, under: float, footer: float, heading: float = 0.0,
    least_width: float = ONE_COLUMN_IN, beside: float = 0.0, narrowest: float = NARROWEST_IN,
) -> Layout:  # fmt: skip
    """Panels for n maps that are `across` x `up` units large.

    under: inches that each panel needs below it; footer, heading: that the page needs;
    beside: inches that stay free at the right, not counted in the layout's width;
    narrowest: inches across that a panel has even where its map is narrower.
    """
    options = [
        _with_columns(n, c, across, up, under, footer + heading, beside, narrowest)
        for c in range(1, n + 1)
    ]
    # The largest panels; of equal ones those in the fewest rows.
    columns, scale = max(enumerate(options, 1), key=lambda o: (round(o[1], 6), o[0]))
    rows = -(-n // columns)
    panel = across * scale, up * scale
    slot = max(panel[0], narrowest) + GAP_IN, panel[1] + TITLE_IN + under
    width = max(2 * MARGIN_IN + columns * slot[0] - GAP_IN, min(least_width, TWO_COLUMNS_IN))
    height = 2 * MARGIN_IN + heading + rows * slot[1] + footer
    return Layout(columns, rows, scale, panel, slot, (width, height), MARGIN_IN + heading)


def _with_columns(n, columns, across, up, under, spent, beside, narrowest) -> float:
    rows = -(-n // columns)
    wide = (TWO_COLUMNS_IN - beside - 2 * MARGIN_IN + GAP_IN) / columns - GAP_IN
    high = (PAGE_IN - 2 * MARGIN_IN - spent) / rows - TITLE_IN - under
    if wide < narrowest:
        return 0.0 if columns > 1 else MOST_WIDTH_IN / across
    most = ONE_COLUMN_IN - 2 * MARGIN_IN if n == 1 and not beside else MOST_WIDTH_IN
    scale = min(min(wide, most) / across, min(high, MOST_HEIGHT_IN) / up)
    return max(scale, 1e-9)
