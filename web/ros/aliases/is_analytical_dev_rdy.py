"""`/is_analytical_dev_rdy`: whether the analyser would take a goal now."""

from .is_gantry_rdy import IsReady
from .paper import Paper

NAME, CONTRACT = "/is_analytical_dev_rdy", "libs_analyzer@1"


def add(paper: Paper, name: str, device: str) -> None:
    """Offer it."""
    paper.offered.offers.services[name] = IsReady(paper, name, device)
