"""What `labrun reduce` does: find spectra, reduce them, write tables, report the result."""

import signal
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ...system.start import without
from .run_name import RUNS
from .say import CTRL_C, FAILED, NOT_REACHED, PARTLY, PROBLEMS, TERMINATED, say
from .words import calibration, closure, columns, known_response, own_lines

MEDIA = ("air", "vacuum")
MOST_NAMED = 3  # skipped files of one reason that are named; summary.json has all


class WrongUsage(ValueError):
    """The command line cannot be carried out; the text says what to write instead."""


@dataclass(frozen=True, slots=True)
class Asked:
    """The command line."""

    files: list[Path]
    out: Path | None
    elements: str | None
    medium: str | None
    unit: str | None
    columns: str | None
    lines: Path | None
    response: Path | None
    calibration: Path | None
    closure: str | None
    jobs: int | None
    dask: str | None
    watch: bool
    until_idle_s: float | None
    figures: bool


def reduce_asked(asked: Asked) -> int:
    """Run the command; return the exit status. User and machine errors are printed as sentences."""
    from ..batch.executor import ExecutorFault, ExecutorUnreachable
    from ..batch.job import NotOurs

    try:
        with _ended_by_signals():
            return _reduce(asked)
    except (WrongUsage, NotOurs) as fault:
        say(str(fault))
        return PROBLEMS
    except ExecutorUnreachable as fault:
        say(str(fault))
        return NOT_REACHED
    except ExecutorFault as fault:
        kept = "hold what was reduced before" if asked.watch else "are unchanged"
        say(f"{fault}; the tables {kept}")
        return FAILED
    except OSError as fault:
        say(f"{fault.filename or 'the folder for the tables'}: {fault.strerror or fault}")
        return FAILED
    except KeyboardInterrupt:
        say("stopped; no table was changed")
        return CTRL_C
    except _Ended:
        say("terminated; no table was changed")
        return TERMINATED


def _reduce(asked: Asked) -> int:
    from ..batch.batch import Batch
    from ..batch.gather import default_out, gather, root_of
    from ..batch.job import job_in
    from ..batch.summary import Circumstances
    from .ending import tell_ending
    from .progress import Shown

    settings = _settings(asked)
    out = asked.out or default_out(asked.files)
    with Shown() as shown, closing(_crew(asked, settings, shown)) as executor:
        found = gather(asked.files, out)
        say_skipped(found)
        _need_spectra(found, asked)
        if asked.dask is None:  # there, others read them
            _need_readers(found, asked)
        about = Circumstances(settings, _workers(executor), root_of(asked.files), found.left_aside)
        # pyarrow asks for pandas, which takes longer to import than a hundred spectra to write.
        with job_in(out, about) as job, without("pandas", everywhere=True):
            batch = Batch(executor, job.spool, shown.take)
            if asked.watch:
                _watch(asked, job, batch, shown)
            else:
                shown.expect(len(found.spectra))
                batch.add(found.spectra)
                if not _finished(batch, shown):
                    return CTRL_C
            executor.close()
            about.waited_s = shown.waited_s
            counts = job.write()
    drawn = _overview(out, counts) if asked.figures else None
    tell_ending(counts, about, out, [] if drawn is None else [drawn])
    if not counts.failed:
        return 0
    return PARTLY if counts.reduced else FAILED


def _finished(batch: Any, shown: Any) -> bool:
    try:
        batch.run()
    except KeyboardInterrupt:
        shown.say(f"stopped after {shown.done} of {shown.total} spectra; no table was changed")
        return False
    return True


def _watch(asked: Asked, job: Any, batch: Any, shown: Any) -> None:
    from ..batch.watch import Watch

    watch = Watch(asked.files, job, batch, lambda fresh, found: shown.expect(len(fresh)))
    shown.say("watching; Ctrl-C ends it")
    try:
        watch.run(asked.until_idle_s)
    except KeyboardInterrupt:
        shown.say("stopped watching; writing the tables")


def _settings(asked: Asked) -> Any:
    from ..batch.settings import Settings
    from ..spectrum.axis import UNITS

    for path in asked.files:
        if not path.exists():
            raise WrongUsage(f"{path} does not exist, and no run in {RUNS} is called so")
    if asked.medium not in (None, *MEDIA):
        raise WrongUsage(f"--medium {asked.medium}: choose air or vacuum")
    if asked.unit not in (None, *UNITS):
        raise WrongUsage(f"--unit {asked.unit}: choose {', '.join(UNITS)}")
    if asked.jobs is not None and asked.jobs < 1:
        raise WrongUsage(f"--jobs {asked.jobs}: at least one process is needed")
    if asked.until_idle_s is not None and not (asked.watch and asked.until_idle_s > 0):
        raise WrongUsage("--until-idle SECONDS (above 0) needs --watch")
    if asked.closure is not None and asked.calibration is not None:
        raise WrongUsage("--closure is without standards, --calibration by them: choose one")
    if asked.watch and not any(path.is_dir() for path in asked.files):
        raise WrongUsage("--watch needs a folder to watch")
    lines = _given(own_lines, asked.lines)  # first: it may have lines of the elements asked for
    response = _given(known_response, asked.response)
    return Settings(
        _elements(asked.elements), asked.medium, asked.unit,  # type: ignore[arg-type]
        _given(columns, asked.columns), lines, response,
        _given(lambda path: calibration(path, response), asked.calibration),
        _given(closure, asked.closure),
    )  # fmt: skip


def _given(read: Callable[[Any], Any], option: Any) -> Any:
    try:
        return read(option)
    except ValueError as fault:
        raise WrongUsage(str(fault)) from None


def _elements(text: str | None) -> tuple[str, ...] | None:
    if text is None:
        return None
    from ..elements.elements import predominant_line

    symbols = tuple(dict.fromkeys(word.capitalize() for word in text.replace(",", " ").split()))
    if not symbols:
        raise WrongUsage("--elements: write symbols, as in --elements Li,K,Si")
    for symbol in symbols:
        try:
            predominant_line(symbol)
        except ValueError as fault:
            raise WrongUsage(f"--elements {text}: {fault}") from None
    return symbols


def say_skipped(found: Any) -> None:
    """Name what is skipped, files of one reason together."""
    from ..batch.source import natural

    by_reason: dict[str, list[str]] = {}
    for name, reason in found.left_aside:
        by_reason.setdefault(reason, []).append(name)
    for reason, names in by_reason.items():
        say(f"skipped: {_few(sorted(names, key=natural))} ({reason})")


def unread(paths: list[Path]) -> tuple[list[str], int]:
    """A sentence for each format whose library is not installed, and how many of the files have one."""
    from ..spectrum.read import without_reader

    lacking = without_reader(paths)
    told = [f"{_few([path.name for path in those])}: {why}" for why, those in lacking.items()]
    return told, sum(map(len, lacking.values()))


def _need_readers(found: Any, asked: Asked) -> None:
    """Say before any work what cannot be read here; raise if that is all there is."""
    told, n = unread([one.path for one in found.spectra])
    for sentence in told:
        say(sentence)
    if told and n == len(found.spectra) and not asked.watch:
        raise WrongUsage("nothing was reduced")


def _few(names: list[str]) -> str:
    more = f" and {len(names) - MOST_NAMED:,} more" if len(names) > MOST_NAMED else ""
    return f"{', '.join(names[:MOST_NAMED])}{more}"


def _need_spectra(found: Any, asked: Asked) -> None:
    if found.spectra or asked.watch:
        return
    n = len(found.left_aside)
    why = f"none of its {n:,} files may be one" if n else "it is empty"
    raise WrongUsage(f"no spectrum found in {', '.join(map(str, asked.files))}: {why}")


def _crew(asked: Asked, settings: Any, shown: Any) -> Any:
    from ..batch.pool import Pool, cores

    if asked.dask is None:
        folders = any(path.is_dir() for path in asked.files)
        most = cores() if folders else min(cores(), len(asked.files))
        pool = Pool(asked.jobs or most, settings, shown.compiling)
        pool.call_up()
        return pool
    from ..batch.cluster import Cluster

    cluster = Cluster(asked.dask, settings)
    if cluster.differing:
        shown.say(cluster.differing)
    return cluster


def _workers(executor: Any) -> str:
    address = getattr(executor, "address", None)
    return f"{executor.room} processes" if address is None else f"dask at {address}"


def _overview(out: Path, counts: Any) -> Path | None:
    from ..tables.overview import draw_overview

    return draw_overview(out, counts.reduced)


class _Ended(BaseException):
    """SIGTERM or SIGHUP: as final as Ctrl-C, but not from the keyboard."""


@contextmanager
def _ended_by_signals() -> Iterator[None]:
    def end(number: int, frame: object) -> None:
        raise _Ended

    before = {}
    for name in ("SIGTERM", "SIGHUP"):
        number = getattr(signal, name, None)
        if number is not None:
            before[number] = signal.signal(number, end)
    try:
        yield
    finally:
        for number, old in before.items():
            signal.signal(number, old)
