"""Who has used a device since the present tree began, of several strands that run beside each other."""

from dataclasses import dataclass, field


@dataclass(slots=True)
class Strands:
    """The newest use of each device, and the newest by another strand than that."""

    _newest: dict[str, tuple[str, int]] = field(default_factory=dict)
    _other: dict[str, tuple[str, int]] = field(default_factory=dict)

    def note(self, device: str, n: int, strand: str) -> None:
        """A device was sent something that may change it, by record `n`."""
        before = self._newest.get(device)
        if before is not None and before[0] != strand:
            self._other[device] = before
        self._newest[device] = strand, n

    def since(self, device: str, n: int, strand: str) -> bool:
        """Whether another strand has used a device after record `n`."""
        both = (self._newest.get(device), self._other.get(device))
        return any(one is not None and one[0] != strand and one[1] > n for one in both)

    def clear(self) -> None:
        """A new tree begins: what it does again, it does in its own order."""
        self._newest.clear()
        self._other.clear()
