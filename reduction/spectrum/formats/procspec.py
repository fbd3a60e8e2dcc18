"""Ocean Optics .ProcSpec (SpectraSuite): a zip archive with the spectrum as XML.

Of several spectrometers each is a range of one spectrum.
"""

import re
from io import BytesIO
from zipfile import ZipFile

import numpy as np

from ..fault import Unreadable
from ..readout import Readout
from ..spectrum import FloatArray
from .zipped import first_name

NAME = "an Ocean Optics .ProcSpec file"
SPECTRUM = re.compile(r"ps_\d+\.xml")
MOST_BYTES = 2**27
SOURCE = re.compile(rb"<sourceSpectra>.*?</sourceSpectra>", re.S)
DARK = re.compile(rb"<darkSpectrum>.*?</darkSpectrum>", re.S)
PARTS = (b"channelWavelengths", b"pixelValues")
NUMBER = re.compile(rb"<double>([^<]*)</double>")


def begins(raw: bytes) -> bool:
    name = first_name(raw)
    return bool(SPECTRUM.fullmatch(name)) or name.startswith("OOI")


def read(raw: bytes) -> Readout:
    try:
        with ZipFile(BytesIO(raw)) as archive:
            names = [name for name in archive.namelist() if SPECTRUM.fullmatch(name)]
            if len(names) != 1:
                raise Unreadable(
                    f"{NAME} with {len(names)} spectra: export them one by one, as text"
                )
            if archive.getinfo(names[0]).file_size > MOST_BYTES:
                raise Unreadable(f"{NAME} of more than {MOST_BYTES:,} bytes: no spectrum has")
            xml = archive.read(names[0])
    except Unreadable:
        raise
    except Exception as fault:  # what a damaged archive raises has no common base
        raise Unreadable(f"this is {NAME}, but it is damaged ({fault}); copy it again") from fault
    # Its letters are of no one alphabet, at which a reader of XML would stop; numbers are plain.
    source = SOURCE.search(xml)
    axes, counts = (_arrays(source[0] if source else b"", name) for name in PARTS)
    if not axes or [len(one) for one in axes] != [len(one) for one in counts]:
        raise Unreadable(
            f"{NAME} without wavelengths and counts of one length; export it as text in SpectraSuite "
            "(File, Save, tab delimited)"
        )
    axis, shot = np.concatenate(axes), np.concatenate(counts)
    dark = [one for text in DARK.findall(xml) for one in _arrays(text, PARTS[1])]
    notes = ("the counts of the detector are read, not what the program made of them",)
    if len(counts) == 1 and dark and len(dark[0]) == len(shot):
        shot, notes = (
            shot - dark[0],
            (*notes, "the dark spectrum that the file holds was subtracted"),
        )
    return Readout(axis, shot[None], "nm", notes)


def _arrays(xml: bytes, name: bytes) -> list[FloatArray]:
    found = re.findall(rb"<%b>(.*?)</%b>" % (name, name), xml, re.S)
    return [np.array([float(one) for one in NUMBER.findall(text)]) for text in found]
