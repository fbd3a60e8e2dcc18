import pytest

from labrun.reduction.figures.layout import MOST_WIDTH_IN, lay_out
from labrun.reduction.figures.paper import PAGE_IN, TWO_COLUMNS_IN


@pytest.mark.parametrize("n", [1, 3, 12, 24])
@pytest.mark.parametrize("size", [(4.2, 10.2), (4.8, 2.4), (100, 1), (1, 60), (3, 3)])
def test_panels_fit_on_a_page_and_do_not_overlap(n, size):
    layout = lay_out(n, *size, under=0.13, footer=0.4)
    boxes = [layout.at(i) for i in range(n)]
    apart = all(
        a[0] + a[2] <= b[0] + 1e-9 or b[0] + b[2] <= a[0] + 1e-9
        or a[1] + a[3] <= b[1] + 1e-9 or b[1] + b[3] <= a[1] + 1e-9
        for k, a in enumerate(boxes) for b in boxes[:k]
    )  # fmt: skip

    assert apart
    assert layout.size[0] <= TWO_COLUMNS_IN + 0.01 and layout.size[1] <= PAGE_IN + 0.01
    assert all(x >= 0 and y >= 0.4 and x + w <= layout.size[0] for x, y, w, _ in boxes)


def test_all_panels_are_at_one_scale():
    layout = lay_out(3, 4.8, 2.4, under=0.13, footer=0.4)

    assert layout.panel[0] / 4.8 == pytest.approx(layout.panel[1] / 2.4)
    assert layout.panel[0] <= MOST_WIDTH_IN


def test_a_smaller_sample_keeps_the_scale_and_the_top():
    layout = lay_out(2, 4.0, 2.0, under=0.13, footer=0.4)
    left, bottom, width, height = layout.at(1)
    small = layout.of_smaller(1, 2.0, 1.0)

    assert small == pytest.approx((left + width / 4, bottom + height / 2, width / 2, height / 2))
