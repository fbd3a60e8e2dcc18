"""`labrun explain FILE`: the protocol as P = [A1, ..., AT], with sizes and counts."""

from ..views.explain import explain_protocol
from .checked_protocol import checked_file
from .options import Bind, File, Lab, Params


def explain(file: File, lab: Lab = None, bind: Bind = None, param: Params = None) -> None:
    """Show what a protocol does, in order: its action sets, how often, on which devices."""
    for line in explain_protocol(checked_file(file, lab, bind, param, needed=False)):
        print(line)
