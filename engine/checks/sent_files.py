"""A file that an action reads lies beside the protocol, or an earlier step writes it.

W426. A file that an action reads, such as a calibration, is looked for in the run's folder, where earlier
steps have written theirs, and beside the protocol. A name that is found in neither is probably misspelt, and
the action would fail when the run reaches it.

Passes:

    devices: {libs: libs_analyzer@1, reduce: spectrum_reducer@1}
    steps:
      - {do: libs.export, with: {shot: shot-1, file: spectra/shot-1.csv}}
      - {do: reduce.reduce, with: {spectrum: spectra/shot-1.csv}}

Fails:

    devices: {libs: libs_analyzer@1, reduce: spectrum_reducer@1}
    steps:
      - {do: libs.export, with: {shot: shot-1, file: spectra/shot-1.csv}}
      - {do: reduce.reduce, with: {spectrum: spectra/shot1.csv}}
"""

from collections.abc import Iterator

from ...schemas.problem import Problem
from ..language.suggest import closest
from ..language.used_files import FileFault, find_file
from ..survey.sent_files import LARGEST, known_text, named_files
from .context import Context
from .paths import AND_SO_ON, beginning

CODES = {"W426": "a file that is not there, and that no step writes"}


def check(context: Context) -> Iterator[Problem]:
    """Every argument that names a file to read, where its name is known beforehand."""
    read, written = named_files(context.survey)
    begun = [beginning(spot) for spot in written]
    if None in begun:
        return  # it may be any name
    whole = [text for text in map(known_text, written) if text is not None]
    for name, spot in read.items():
        if any(_may_be(name, one) for one in begun if one):
            continue
        try:
            find_file(context.survey.source.path, name, LARGEST, context.survey.opened.folders)
        except FileFault as fault:
            near = closest(name, whole)
            hint = f"did you mean {near}?" if near else "a misspelt name, or a file to be put there"
            message = f"no step writes it, and {fault}"
            yield context.source.problem(spot.place, "W426", message, hint)


def _may_be(name: str, written: str) -> bool:
    known = written.removesuffix(AND_SO_ON)
    return name == written or (known != written and name.startswith(known))
