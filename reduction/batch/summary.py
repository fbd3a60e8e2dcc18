"""`summary.json`: what was reduced, by what, how, and how long it took."""

import json
from collections import Counter
from dataclasses import dataclass, field
from datetime import UTC, datetime
from hashlib import sha256
from pathlib import Path
from statistics import median
from typing import Any

from .settings import Settings
from .source import natural
from .spool import Spool
from .versions import versions

MADE_BY = "labrun reduce"
NAME = "summary.json"


@dataclass(slots=True)
class Circumstances:
    """The contents of a summary besides the spectra themselves.

    workers: as text. started: UTC. seconds: wall-clock time up to the tables. waited_s: of these,
    until the first spectrum was done: processes start, and compile on first use.
    """

    settings: Settings
    workers: str
    root: Path
    left_aside: list[tuple[str, str]] = field(default_factory=list)
    started: datetime = field(default_factory=lambda: datetime.now(UTC))
    seconds: float = 0.0
    waited_s: float = 0.0

    def rate(self, spectra: int) -> float:
        """Spectra per second, without the wait for the first one."""
        if spectra < 2:
            return spectra / max(self.seconds, 1e-9)
        return (spectra - 1) / max(self.seconds - self.waited_s, 1e-9)


@dataclass(slots=True)
class Counts:
    """Over all spectra; elements: in how many each is detected, uncertain; both by symbol.

    notes: the spectra of each note.
    """

    spectra: int = 0
    reduced: int = 0
    peaks: int = 0
    detected: Counter[str] = field(default_factory=Counter)
    uncertain: Counter[str] = field(default_factory=Counter)
    temperatures_k: list[float] = field(default_factory=list)
    seconds: list[float] = field(default_factory=list)
    failed: list[tuple[str, str]] = field(default_factory=list)
    notes: dict[str, list[str]] = field(default_factory=dict)


def counts_of(spool: Spool) -> Counts:
    """Add up the results in the spool."""
    counts = Counts()
    for done in sorted(spool.done(), key=lambda done: natural(done.name)):
        counts.spectra += 1
        if done.reason:
            counts.failed.append((done.name, done.reason))
            continue
        counts.reduced += 1
        counts.peaks += done.n_peaks
        counts.detected.update(done.detected)
        counts.uncertain.update(done.uncertain)
        counts.seconds.append(done.seconds)
        for note in done.notes:
            counts.notes.setdefault(note, []).append(done.name)
        if done.temperature_k is not None:
            counts.temperatures_k.append(done.temperature_k)
    return counts


def summary_of(spool: Spool, counts: Counts, about: Circumstances) -> dict[str, Any]:
    """The summary as plain values; `made_by` comes first, by which an old one is recognised."""
    settings = about.settings
    found = sorted(spool.done(), key=lambda done: natural(done.name))
    return {
        "made_by": MADE_BY,
        "started": about.started.isoformat(timespec="seconds"),
        "versions": versions(),
        "configuration": {
            "elements": None if settings.elements is None else list(settings.elements),
            "medium": settings.medium,
            "unit": settings.unit,
            "columns": None if settings.columns is None else list(settings.columns),
            "lines_sha256": _sha256(settings.lines),
            "response_sha256": _sha256(settings.response),
            "calibration_sha256": _sha256(settings.calibration),
            "closure": settings.closure,
        },
        "folder": str(about.root),
        "counts": {
            "spectra": counts.spectra,
            "reduced": counts.reduced,
            "failed": len(counts.failed),
            "left_aside": len(about.left_aside),
            "peaks": counts.peaks,
        },
        "elements": {
            name: {"detected": counts.detected[name], "uncertain": counts.uncertain[name]}
            for name in sorted({*counts.detected, *counts.uncertain})
        },
        "notes": [
            {"note": note, "spectra": len(names), "first": names[0]}
            for note, names in counts.notes.items()
        ],
        "median_temperature_k": round(median(counts.temperatures_k), 1)
        if counts.temperatures_k
        else None,
        "timings": {
            "workers": about.workers,
            "seconds": round(about.seconds, 3),
            "seconds_to_first": round(about.waited_s, 3),
            "spectra_per_second": round(about.rate(counts.spectra), 2),
            "seconds_per_spectrum": round(median(counts.seconds), 5) if counts.seconds else None,
        },
        "inputs": [
            {"spectrum": done.name, "bytes": done.size, "sha256": done.sha256 or None}
            for done in found
        ],
        "left_aside": [{"file": name, "reason": reason} for name, reason in about.left_aside],
    }


def write_summary(summary: dict[str, Any], folder: Path) -> Path:
    """Write it into the folder; returns the file."""
    path = folder / NAME
    path.write_text(json.dumps(summary, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    return path


def _sha256(text: str | None) -> str | None:
    return None if text is None else sha256(text.encode()).hexdigest()
