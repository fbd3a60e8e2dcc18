"""Draw element maps side by side, as a paper would print them."""

from .element_maps import draw_element_maps, element_maps_figure
from .map_panel import round_length

__all__ = ["draw_element_maps", "element_maps_figure", "round_length"]
