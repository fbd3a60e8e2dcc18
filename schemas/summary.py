"""What a run came to, beside its journal: `summary.json`."""

from typing import Any

from .journal import Points
from .model import Model


class Summary(Model):
    """The journal in brief; `size` and `last` (the hash of its last record) say which journal.

    `params`: as in the journal, without long ones. `values`: numbers that it came to, each with its
    unit: outputs by name, the mean of a column as `TABLE.COLUMN`. `samples`: by the parameter
    `sample` and by columns of that name.
    """

    run: str
    protocol: str
    began: str
    ended: str
    fate: str
    reason: str = ""
    holes: int = 0
    resumes: int = 0
    points: Points
    params: dict[str, Any]
    devices: list[str]
    samples: list[str]
    values: dict[str, tuple[float, str]]
    size: int
    last: str
