"""What a run came to, beside its journal: `summary.json`."""

from .journal import Points
from .model import Model


class Summary(Model):
    """The journal in brief; `size` and `last` (the hash of its last record) say which journal."""

    run: str
    protocol: str
    began: str
    ended: str
    fate: str
    reason: str = ""
    holes: int = 0
    resumes: int = 0
    points: Points
    size: int
    last: str
