"""Galactic .spc (GRAMS), as Ocean Optics, Horiba and others write it; read by spc-io."""

import logging
from io import BytesIO

import numpy as np

from ..axis import Unit
from ..columns import check_light
from ..fault import Unreadable
from ..readout import Readout
from .library import library, spoiled

NAME = "a Galactic .spc file"
LIBRARY = "spc_io"
VERSIONS = (0x4B, 0x4C, 0x4D)  # new, big-endian, old
HAMAMATSU = b"IM"  # a picture of a streak camera begins as an old file does
HEADER = 512
LOG = 248  # where the header says where the log is: one of free text would stop the reader
ZIP = b"PK\x03\x04"  # whose second byte is that of a version, too
UNITS: dict[str, Unit] = {"XNMETR": "nm", "XUMETR": "um"}
UNNAMED = "XARB"
NEW = 0x4B  # the version that spc-io reads
NO_LIGHT = {
    "YABSRB": "absorbance", "YKMONK": "Kubelka-Munk units", "YLOGDR": "log(1/R)", "YDECBL": "dB",
    "YEXTCF": "extinction", "YTRANS": "transmission", "YREFLEC": "reflectance",
}  # fmt: skip


def begins(raw: bytes) -> bool:
    """Its second byte is a version; text has no zero bytes in its header."""
    told = len(raw) > HEADER and raw[1] in VERSIONS and not raw.startswith((ZIP, HAMAMATSU))
    return told and b"\0" in raw[:HEADER]


def read(raw: bytes) -> Readout:
    spc_io = library(LIBRARY, NAME)
    if raw[1] != NEW:
        raise Unreadable(
            f"{NAME} in its old format, or none; save it in the new one, or export it as text"
        )
    logging.getLogger("spc_io").setLevel(logging.ERROR)  # a date that is missing is no news
    try:
        file = spc_io.SPC.from_bytes_io(BytesIO(raw[:LOG] + bytes(4) + raw[LOG + 4 :]))
        subs = [file[at] for at in range(len(file))]
        axes = [np.asarray(sub.xarray, dtype=np.float64) for sub in subs]
        shots = [np.asarray(sub.yarray, dtype=np.float64) for sub in subs]
        name, quantity = str(file.xtype), NO_LIGHT.get(str(file.ytype), "")
    except Exception as fault:  # what it raises has no common base
        raise spoiled(NAME, fault) from fault
    if name not in UNITS and name != UNNAMED:
        raise Unreadable(
            f"{NAME} whose axis is {name}, not a wavelength: export the spectrum over wavelengths"
        )
    check_light(quantity, NAME)
    if any(axis.shape != axes[0].shape or not np.array_equal(axis, axes[0]) for axis in axes):
        raise Unreadable(
            f"{NAME} with {len(axes)} spectra on different axes: export them one by one"
        )
    return Readout(axes[0], np.stack(shots), UNITS.get(name))
