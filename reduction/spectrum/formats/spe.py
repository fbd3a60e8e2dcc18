"""Princeton Instruments .spe of WinSpec and WinView (2.x) and of LightField (3.0), as its maker describes it.

LightField writes the wavelengths as XML behind the frames, WinSpec as a polynomial in its header.
"""

import struct
from typing import Any
from xml.etree import ElementTree

import numpy as np

from ..axis import USUAL_NM, Unit
from ..fault import Unreadable
from ..readout import Readout
from ..spectrum import FloatArray

NAME = "a Princeton Instruments .spe file"
HEADER, LAST_VALUE = 4100, b"\x55\x55"
TYPES = {0: "<f4", 1: "<i4", 2: "<i2", 3: "<u2", 5: "<f8", 6: "<u1", 8: "<u4"}
NAMED_TYPES = {
    "MonochromeUnsigned16": "<u2", "MonochromeUnsigned32": "<u4", "MonochromeFloating32": "<f4",
}  # fmt: skip
AXES = 3, 4, 5
"""WinSpec's numbers of nm and cm-1: 3 and 4 in some descriptions of its header, 4 and 5 in others, so
that the values decide."""
SHORTEST_NM, LEAST_WAVENUMBER = 100.0, 8_000.0  # cm-1, below which are Raman shifts
MOST_TRACKS = 32  # more rows are a picture


def begins(raw: bytes) -> bool:
    return len(raw) >= HEADER and raw[HEADER - 2 : HEADER] == LAST_VALUE


def read(raw: bytes) -> Readout:
    version, behind = _said(raw, "f", 1992), _said(raw, "Q", 678)
    try:
        if version >= 3 and behind:
            return _lightfield(raw, ElementTree.fromstring(raw[behind:]))
        return _winspec(raw)
    except (struct.error, ElementTree.ParseError, ValueError, KeyError) as fault:
        if isinstance(fault, Unreadable):
            raise
        raise Unreadable(f"this is {NAME}, but it is damaged ({fault}); is it complete?") from fault


def _winspec(raw: bytes) -> Readout:
    width, height, frames = _said(raw, "H", 42), _said(raw, "H", 656), _said(raw, "i", 1446)
    order = min(raw[3101], 5)
    if not raw[3098] or raw[3100] not in AXES:
        raise _no_axis(
            "over Raman shifts" if raw[3100] == max(AXES) + 1 else "without a calibrated axis"
        )
    pixel = np.arange(1, width + 1, dtype=np.float64)
    axis = np.polynomial.polynomial.polyval(pixel, struct.unpack_from(f"<{order + 1}d", raw, 3263))
    unit: Unit = "nm" if axis.max() <= USUAL_NM else "cm-1"
    if axis.min() < (SHORTEST_NM if unit == "nm" else LEAST_WAVENUMBER):
        raise _no_axis(f"over {axis.min():g} to {axis.max():g}, neither nm nor wavenumbers")
    kind = np.dtype(TYPES[_said(raw, "h", 108)])
    shots = _frames(raw, kind, (frames, height, width), height * width * kind.itemsize)
    return Readout(np.asarray(axis, np.float64), shots, unit)


def _lightfield(raw: bytes, said: ElementTree.Element) -> Readout:
    frame = next(one for one in _all(said, "DataBlock") if one.get("type") == "Frame")
    regions = [one for one in _all(frame, "DataBlock") if one.get("type") == "Region"]
    if len(regions) != 1:
        raise Unreadable(
            f"{NAME} with {len(regions)} regions of the sensor: export them one by one"
        )
    written = next((one.text for one in _all(said, "Wavelength")), None)
    written = written or next((one.text for one in _all(said, "WavelengthError")), None)
    if not written:
        raise _no_axis("without a calibrated axis")
    width, height = int(regions[0].get("width", 0)), int(regions[0].get("height", 0))
    axis = np.array([float(pair.split(",")[0]) for pair in written.replace(",", " ").split()])
    ids = regions[0].get("calibrations", "").split(",")
    place = next((one for one in _all(said, "SensorMapping") if one.get("id") in ids), None)
    if place is not None and len(axis) != width:
        begin, binned = int(place.get("x", 0)), int(place.get("xBinning", 1))
        axis = axis[begin : begin + width * binned].reshape(width, binned).mean(axis=1)
    kind = np.dtype(NAMED_TYPES[frame.get("pixelFormat", "")])
    shape = (int(frame.get("count", 1)), height, width)
    return Readout(axis, _frames(raw, kind, shape, int(frame.get("stride", 0))), "nm")


def _frames(raw: bytes, kind: np.dtype, shape: tuple[int, int, int], stride: int) -> FloatArray:
    """The tracks of every frame, one below the other; a frame may have its time behind it."""
    frames, height, width = shape
    if height > MOST_TRACKS:
        raise Unreadable(f"{NAME} with a picture of {height} rows, not spectra: bin it vertically")
    if min(shape) < 1 or len(raw) < HEADER + frames * stride:
        raise Unreadable(f"{NAME} that promises {frames} frames of {width} pixels: is it complete?")
    each = [
        np.frombuffer(raw, kind, height * width, HEADER + at * stride).reshape(height, width)
        for at in range(frames)
    ]
    return np.concatenate(each).astype(np.float64)


def _no_axis(what: str) -> Unreadable:
    return Unreadable(
        f"{NAME} {what}: calibrate the spectrograph in LightField or WinSpec, or export wavelengths and "
        "counts as text (File, Export)"
    )


def _all(within: ElementTree.Element, name: str) -> list[ElementTree.Element]:
    return within.findall(f".//{{*}}{name}")


def _said(raw: bytes, form: str, at: int) -> Any:
    return struct.unpack_from(f"<{form}", raw, at)[0]
