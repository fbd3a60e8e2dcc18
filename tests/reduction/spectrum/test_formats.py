"""Binary formats, written here byte by byte as instruments write them, and read back the same."""

import io
import struct
import zipfile

import numpy as np
import pytest

from labrun.reduction import Unreadable, read_shots, read_spectrum
from labrun.reduction.spectrum.formats import library

N = 64
X = np.linspace(200.0, 900.0, N)
Y = np.round(np.abs(np.random.default_rng(4).normal(500, 300, N)), 2).astype(np.float32)


def spc(x=X, shots=(Y,), kind=3, even=True, quantity=4, log=b""):
    """Galactic's new format, little-endian; kind 1: wavenumbers, 2: micrometres, 3: nanometres.

    quantity 2: absorbance, 4: counts.
    """
    flags = (0x80 if not even else 0) | (0x04 if len(shots) > 1 else 0)
    head = struct.pack(
        "<BBBBIddIBBBB", flags, 0x4B, 0, 0x80, len(x), x[0], x[-1], len(shots), kind, quantity, 0, 0
    )
    head += struct.pack("<I", 2019 << 20 | 1 << 16 | 31 << 11 | 11 << 6 | 58)
    body = b"" if even else x.astype("<f4").tobytes()
    for at, shot in enumerate(shots):
        body += struct.pack("<BBHfffIIf4x", 0, 0x80, at, at, at, 0, len(x), 0, 0)
        body += shot.astype("<f4").tobytes()
    if log:
        head = head.ljust(248, b"\0") + struct.pack("<I", 512 + len(body))
        body += struct.pack("<5I44x", 64 + len(log), 4096, 64, 0, 0) + log
    return head.ljust(512, b"\0") + body


def sif(shots=(Y,), axis="190.0 10.0 0 0"):
    """Andor Solis, version 65567: axis is a polynomial in the pixel, from 1."""
    zeros = "0 " * 16
    text = (
        "Andor Technology Multi-Channel File\n65538 1\n65567 0 0 1 1731005709 -49.2           "
        f"0 0.1 0.1 0.1 1 \0 0.1 1e-06 0 1 1 0 0 0.1 {zeros}0 1 8\nDU401\n{N} 256 8\nfile.sif \n"
        "65538 4\nnote\n65538         0 0\n" + "skip\n" * 8 + "65540 Shamrock\nskip\n"
        + "0 " * 8 + "\n" * 8 + f"65539 {axis}\n0 1 0 0\n0 1 0 0\n0\n422\n13\n13\n"
        f"10\nWavelength6\nCounts5\nPixel65541 1 256 {N} 1 {len(shots)} 1 {N * len(shots)} {N}\n"
        f"65538 1 256 {N} 1 256 1 0\n" + "0\n" * len(shots) + "0\n"
    )  # fmt: skip
    return text.encode() + b"".join(shot.astype("<f4").tobytes() for shot in shots)


def raw8(*channels):
    """AvaSoft 8: each channel its wavelengths, counts, dark and reference."""
    raw = b"AVS84" + bytes([len(channels)])
    for at, (x, y, dark) in enumerate(channels):
        head = struct.pack("<bB2x10s64sB", at, 0, b"1204091U1", b"mine", 1)
        head += struct.pack("<HHfIIBBHBBBBBHIIfH", 0, len(x) - 1, 1.05, 0, 1, 0, 0, 0, 0, 0, 0, 0, 2,
                            0, 0, 0, 0.0, 0)  # fmt: skip
        head += struct.pack("<IIfffff5d130s", 0, 0, 20, 20, 0, 0, 1, *[0.0] * 5, b"made here")
        columns = (x, y, dark, np.zeros(len(x)))
        data = head + b"".join(np.asarray(c).astype("<f4").tobytes() for c in columns)
        raw += struct.pack("<H2x", len(data) + 4) + data + b"\0" * 10
    return raw


def hdf5(tmp_path, fill):
    h5py = pytest.importorskip("h5py")
    with h5py.File(tmp_path / "s.h5", "w") as file:
        fill(file)
    return (tmp_path / "s.h5").read_bytes()


@pytest.mark.parametrize("even", [True, False])
def test_a_galactic_file_is_read_back(even):
    pytest.importorskip("spc_io")
    found = read_spectrum(spc(even=even))

    assert found.wavelength_nm == pytest.approx(X, rel=1e-7)
    assert found.intensity.tolist() == Y.tolist()


def test_a_galactic_file_of_several_spectra_gives_shots_and_micrometres_are_converted():
    pytest.importorskip("spc_io")
    found = read_shots(spc(X / 1000, (Y, Y + 2), kind=2))

    assert found.wavelength_nm == pytest.approx(X)
    assert (found.intensity[1] - found.intensity[0]).tolist() == pytest.approx([2] * N, abs=1e-4)
    assert found.notes == ("wavelengths in um, as the file says",)


def test_a_log_of_free_text_does_not_keep_a_galactic_file_from_being_read():
    pytest.importorskip("spc_io")

    assert read_spectrum(spc(log=b"baseline corrected\r\n")).intensity.tolist() == Y.tolist()


def test_a_galactic_file_over_wavenumbers_and_a_part_of_one_are_refused():
    pytest.importorskip("spc_io")
    with pytest.raises(Unreadable, match="with 'absorbance', and no counts of light"):
        read_spectrum(spc(quantity=2))
    with pytest.raises(Unreadable, match="in its old format, or none; save it in the new one"):
        read_spectrum(spc()[:1] + b"M" + spc()[2:])
    with pytest.raises(Unreadable, match="whose axis is XWAVEN, not a wavelength"):
        read_spectrum(spc(kind=1))
    with pytest.raises(Unreadable, match="is the file complete"):
        read_spectrum(spc()[:-30])


def test_an_andor_file_is_read_back_with_its_shots():
    pytest.importorskip("sif_parser")
    found = read_shots(sif((Y, 2 * Y)))

    assert found.wavelength_nm == pytest.approx(190 + 10 * np.arange(1, N + 1))
    assert found.intensity.tolist() == [Y.tolist(), (2 * Y).tolist()]


def test_an_andor_file_without_a_calibration_or_its_end_is_refused():
    pytest.importorskip("sif_parser")
    with pytest.raises(Unreadable, match="channel numbers"):
        read_spectrum(sif(axis="0 1 0 0"))
    for cut in (200, 500, len(sif()) - 40):
        with pytest.raises(Unreadable, match="is the file complete"):
            read_spectrum(sif()[:cut])


def test_an_avasoft_file_joins_its_spectrometers_and_subtracts_the_dark():
    pytest.importorskip("avaread")
    half = N // 2
    dark = np.full(half, 31.5)
    found = read_spectrum(raw8((X[:half], Y[:half], dark), (X[half:], Y[half:], dark)))

    assert found.wavelength_nm == pytest.approx(X, rel=1e-7)
    assert found.intensity == pytest.approx(Y - 31.5, abs=1e-4)
    with pytest.raises(Unreadable, match="is the file complete"):
        read_spectrum(raw8((X, Y, np.zeros(N)))[:-60])


def avasoft_7(version=70.0, times=3):
    """Floats throughout: a polynomial of the pixel, the pixels from 10, counts with reference and dark."""
    polynomial = [*np.polynomial.polynomial.polyfit(np.arange(10, 10 + N), X, 1), 0, 0, 0]
    columns = (Y, np.full(N, 900.0), np.full(N, 31.5))[:times]
    head = [
        version,
        *([0.0] * 73 if version == 70 else []),
        *polynomial,
        *([0.0] * 9 if version == 60 else []),
    ]
    head += [10.0, 9.0 + N, *([0.0] * (19 if version == 70 else 2))]
    floats = np.concatenate([head, np.stack(columns, axis=1).ravel(), [95.0, 20.0, 0.0]])
    return floats.astype("<f4").tobytes()


def spe_header(n, **values):
    head = bytearray(4100)
    places = {
        "x": ("H", 42), "kind": ("h", 108), "y": ("H", 656), "xml": ("Q", 678), "frames": ("i", 1446),
        "version": ("f", 1992), "valid": ("B", 3098), "unit": ("B", 3100), "order": ("B", 3101),
    }  # fmt: skip
    said = {"x": n, "y": 1, "frames": 1, "version": 2.5, **values}
    for name, value in said.items():
        struct.pack_into("<" + places[name][0], head, places[name][1], value)
    head[4098:] = b"\x55\x55"
    return head


def winspec(unit=3, valid=1, axis=X, order=1):
    head = spe_header(N, kind=0, frames=2, valid=valid, unit=unit, order=order)
    terms = np.polynomial.polynomial.polyfit(np.arange(1, N + 1), axis, order)
    struct.pack_into(f"<{order + 1}d", head, 3263, *terms)
    return bytes(head) + np.stack([Y, 2 * Y]).astype("<f4").tobytes()


def lightfield(height=1, regions=1, axis=X):
    """Three frames, each with its time behind it, over the middle of a wider sensor, binned by two."""
    wide = np.interp(
        np.arange(2 * N + 20), 10.5 + 2 * np.arange(N), axis, left=-np.inf, right=np.inf
    )
    wide = np.concatenate([np.arange(10.0), np.repeat(axis, 2), np.arange(10.0)])
    frame = np.tile(Y, height).astype("<f4").tobytes() + bytes(8)
    region = f'<DataBlock type="Region" calibrations="2,3" width="{N}" height="{height}"/>'
    xml = (
        '<SpeFormat xmlns="http://www.princetoninstruments.com/spe/2009"><DataFormat><DataBlock type="Frame" '
        f'count="3" pixelFormat="MonochromeFloating32" stride="{len(frame)}">{regions * region}</DataBlock>'
        "</DataFormat><Calibrations><WavelengthMapping><Wavelength>" + ",".join(map(str, wide))
        + f'</Wavelength></WavelengthMapping><SensorMapping id="3" x="10" width="{2 * N}" xBinning="2"/>'
        "</Calibrations></SpeFormat>"
    )  # fmt: skip
    head = spe_header(N, version=3.0, xml=4100 + 3 * len(frame))
    return bytes(head) + 3 * frame + xml.encode()


def zipped(**files):
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, text in files.items():
            archive.writestr(name.replace("__", "/").replace("_xml", ".xml"), text)
    return packed.getvalue()


def procspec(counts="pixelValues", dark=31.5):
    def of(name, values):
        return f"<{name}>" + "".join(f"<double>{v}</double>" for v in values) + f"</{name}>"

    half = N // 2
    sources = [(X, Y)] if dark else [(X[:half], Y[:half]), (X[half:], Y[half:])]
    xml = "".join(of(counts, y) + of("channelWavelengths", x) for x, y in sources)
    xml = f"<sourceSpectra>\x01\xff{xml}</sourceSpectra>"
    if dark:
        xml += f"<darkSpectrum>{of('pixelValues', np.full(N, dark))}</darkSpectrum>"
    return zipped(ps_0_xml=f"<p>{xml}</p>".encode("latin-1"), OOISignatures_xml="<a/>")


SHEETS = "http://schemas.openxmlformats.org/spreadsheetml/2006/main"
PARTS = "http://schemas.openxmlformats.org/package/2006/relationships"
OFFICE = "http://schemas.openxmlformats.org/officeDocument/2006/relationships"


def workbook(*sheets):
    """Each a list of rows of numbers and words."""

    def cell(one):
        if isinstance(one, str):
            return f'<c t="inlineStr"><is><t>{one}</t></is></c>'
        return f"<c><v>{one}</v></c>"

    parts = {
        "[Content_Types].xml": "<Types/>",
        "_rels/.rels": f'<Relationships xmlns="{PARTS}"><Relationship Id="r1" '
        f'Type="{OFFICE}/officeDocument" Target="xl/workbook.xml"/></Relationships>',
        "xl/workbook.xml": f'<workbook xmlns="{SHEETS}" xmlns:r="{OFFICE}"><sheets>'
        + "".join(f'<sheet name="S{k}" sheetId="{k}" r:id="r{k}"/>' for k in range(1, len(sheets) + 1))
        + "</sheets></workbook>",
        "xl/_rels/workbook.xml.rels":
        '<Relationships xmlns="' + PARTS + '">'
        + "".join(f'<Relationship Id="r{k}" Type="{OFFICE}/worksheet" Target="worksheets/s{k}.xml"/>'
                  for k in range(1, len(sheets) + 1)) + "</Relationships>",
    }  # fmt: skip
    for k, rows in enumerate(sheets, 1):
        lines = "".join(f"<row>{''.join(map(cell, row))}</row>" for row in rows)
        parts[f"xl/worksheets/s{k}.xml"] = (
            f'<worksheet xmlns="{SHEETS}"><sheetData>{lines}</sheetData></worksheet>'
        )
    return zipped(**parts)


ROWS = [
    ["Sample", "steel"],
    ["Wavelength (nm)", "Counts"],
    *zip(X.tolist(), Y.tolist(), strict=True),
]


def matlab():
    from scipy.io import savemat

    packed = io.BytesIO()
    savemat(
        packed, {"s": {"wavelength": X[:, None], "counts": np.stack([Y, Y + 2])}, "title": "steel"}
    )
    return packed.getvalue()


def altered(raw, *changes):
    """With other bytes at some places; these end the process that SciPy reads it in."""
    other = bytearray(raw)
    for at, byte in changes:
        other[at] = byte
    return bytes(other)


def npz(**arrays):
    packed = io.BytesIO()
    np.savez(packed, **arrays)
    return packed.getvalue()


def arrow(kind):
    pa, of = pytest.importorskip("pyarrow"), pytest.importorskip(f"pyarrow.{kind}")
    packed = io.BytesIO()
    table = pa.table({"wavelength": X, "intensity": Y.astype(float), "dark": np.ones(N)})
    getattr(of, "write_table" if kind == "parquet" else "write_feather")(table, packed)
    return packed.getvalue()


@pytest.mark.parametrize(
    ("raw", "counts"),
    [
        (lambda: avasoft_7(), [Y - 31.5]),
        (lambda: avasoft_7(60.0, 1), [Y]),
        (winspec, [Y, 2 * Y]),
        (lambda: winspec(unit=4), [Y, 2 * Y]),
        (lightfield, [Y, Y, Y]),
        (procspec, [Y - 31.5]),
        (lambda: procspec(dark=0), [Y]),
        (lambda: workbook(ROWS), [Y]),
        (lambda: workbook([["notes", "none"]], ROWS), [Y]),
        (matlab, [Y, Y + 2]),
        (lambda: npz(wl=X, spectra=np.stack([Y, Y + 2]).T), [Y, Y + 2]),
        (lambda: npz(table=np.stack([X, Y, Y + 2], axis=1)), [Y, Y + 2]),
        (lambda: arrow("parquet"), [Y]),
        (lambda: arrow("feather"), [Y]),
    ],
    ids=(
        "avasoft 7", "avasoft 6", "winspec", "winspec, nm as 4", "lightfield", "procspec",
        "two spectrometers", "workbook", "second sheet", "matlab", "npz", "npz of one table",
        "parquet", "feather",
    ),
)  # fmt: skip
def test_a_file_of_a_program_of_its_own_is_read_back(raw, counts):
    found = read_shots(raw())

    assert found.wavelength_nm == pytest.approx(X, rel=1e-6)
    assert found.intensity == pytest.approx(np.stack(counts), abs=1e-3)


@pytest.mark.parametrize(
    ("raw", "sentence"),
    [
        (lambda: avasoft_7()[:-100], "AvaSoft 7 file of 64 pixels with 170 numbers after its heading"),
        (lambda: winspec(valid=0), "without a calibrated axis: calibrate the spectrograph"),
        (lambda: winspec(unit=6), "over Raman shifts"),
        (lambda: winspec(unit=5, axis=X * 4), "neither nm nor wavenumbers"),
        (lambda: winspec()[:-4], "promises 2 frames of 64 pixels: is it complete"),
        (lambda: lightfield(height=40), "a picture of 40 rows, not spectra"),
        (lambda: lightfield(regions=2), "with 2 regions of the sensor"),
        (lambda: lightfield()[:-40], "is it complete"),
        (lambda: procspec("pixelValue"), "without wavelengths and counts of one length"),
        (lambda: procspec()[:-40], "damaged"),
        (lambda: workbook(ROWS, ROWS), r"with 2 sheets of numbers \(S1, S2\); save the one"),
        (lambda: workbook([["a", "b"]]), r"with no sheets of numbers \(S1\)"),
        (lambda: workbook(ROWS)[:-60], "its reader stopped"),
        (lambda: npz(a=X, b=Y), "MATLAB or .npz file does not say .* name both, as in --columns"),
        (lambda: matlab()[:-60], "is the file complete"),
        (
            lambda: altered(matlab(), (763, 128), (301, 12), (592, 9), (833, 16)),
            "its reader stopped: .* is the file complete",
        ),
        (lambda: arrow("parquet")[:-60], "is the file complete"),
    ],
)  # fmt: skip
def test_a_file_of_a_program_of_its_own_that_is_no_spectrum_is_refused(raw, sentence):
    pytest.importorskip("python_calamine")
    with pytest.raises(Unreadable, match=sentence):
        read_spectrum(raw())


JCAMP = (
    "##TITLE= quartz\n##JCAMP-DX= 4.24 $$ by hand\n##DATA TYPE= EMISSION SPECTRUM\n"
    "##XUNITS= {unit}\n##YUNITS= COUNTS\n##XFACTOR= 1.0\n##YFACTOR= 0.5\n"
    "##FIRSTX= {first}\n##LASTX= {last}\n##NPOINTS= {n}\n"
)
EVEN = np.linspace(200.0, 326.0, N)


def jcamp_even(numbers="{:.0f}", per_line=7, unit="NANOMETERS"):
    lines = [
        f"{EVEN[k]:.1f}" + "".join("+" + numbers.format(2 * y) for y in Y[k : k + per_line])
        for k in range(0, N, per_line)
    ]
    head = JCAMP.format(unit=unit, first=200.0, last=326.0, n=N)
    return (head + "##XYDATA=(X++(Y..Y))\n" + "\n".join(lines) + "\n##END=\n").encode()


def test_plain_jcamp_is_read_in_either_form():
    pairs = JCAMP.format(unit="MICROMETERS", first=X[0] / 1000, last=X[-1] / 1000, n=N)
    pairs += "##XYPOINTS= (XY..XY)\n" + "".join(
        f"{x / 1000:.8f}, {2 * y:.4f}\n" for x, y in zip(X, Y, strict=True)
    )  # fmt: skip
    even, uneven = read_spectrum(jcamp_even()), read_spectrum((pairs + "##END=\n").encode())

    assert even.wavelength_nm == pytest.approx(EVEN)
    assert even.intensity == pytest.approx(np.round(2 * Y) / 2)
    assert uneven.wavelength_nm == pytest.approx(X, rel=1e-6)
    assert uneven.intensity == pytest.approx(Y, abs=1e-3)


@pytest.mark.parametrize(
    ("raw", "sentence"),
    [
        (jcamp_even()[:-60], "promises 64 points and has 5"),
        (jcamp_even().replace(b"200.0+", b"200.0A", 1), "in a compressed form"),
        (jcamp_even().replace(b"##LASTX= 326.0", b"##LASTX= 526.0"), "do not begin where"),
        (jcamp_even().replace(b"##LASTX= 326.0", b"##LASTX= ?"), "LASTX is '[?]', not a number"),
        (jcamp_even().replace(b"(X++(Y..Y))", b"(X++(R..R))"), "without a spectrum in it"),
        (jcamp_even().replace(b"COUNTS", b"Logarithm epsilon"), "and no counts of light"),
        (jcamp_even() + b"##NTUPLES=\n", "with several spectra"),
    ],
)
def test_other_jcamp_is_refused_with_a_sentence(raw, sentence):
    with pytest.raises(Unreadable, match=sentence):
        read_spectrum(raw)


def test_the_default_plot_of_a_nexus_file_is_read(tmp_path):
    def fill(file):
        file.attrs["default"] = "entry"
        entry = file.create_group("entry")
        entry.attrs["default"] = "libs"
        libs = entry.create_group("libs")
        libs.attrs.update(signal="counts", axes=["shot", "lambda"])
        libs["counts"] = np.stack([Y, Y + 1])
        libs["lambda"] = 10 * X
        libs["lambda"].attrs["units"] = "angstrom"
        libs["other"] = np.arange(N)

    found = read_shots(hdf5(tmp_path, fill))

    assert found.wavelength_nm == pytest.approx(X)
    assert found.intensity.tolist() == [Y.tolist(), (Y + 1).tolist()]


def test_datasets_are_known_by_their_names_or_asked_for(tmp_path):
    def plain(file):
        file["wavelength"], file["intensity"], file["dark"] = X, Y, np.ones(N)

    def unclear(file):
        file["a/x1"], file["a/y1"], file["a/y2"] = X, Y, Y + 1

    def scanned(file):
        file.create_group("a").attrs.update(signal="scan", axes=["row", "."])
        file["a/scan"], file["a/row"] = np.stack([Y, Y + 1]), np.arange(2)

    def numbered(file):
        file["Wavelengths/1"], file["Spectra/001"] = X, np.stack([Y, Y + 1])

    assert read_spectrum(hdf5(tmp_path, plain)).intensity.tolist() == Y.tolist()
    assert len(read_shots(hdf5(tmp_path, numbered))) == 2
    with pytest.raises(Unreadable, match=r"name both, as in --columns .* it has /a/x1 \(64,\)"):
        read_spectrum(hdf5(tmp_path, unclear))
    with pytest.raises(Unreadable, match=r"name both, as in --columns .* it has /a/row \(2,\)"):
        read_spectrum(hdf5(tmp_path, scanned))
    found = read_spectrum(hdf5(tmp_path, unclear), columns=("a/x1", "a/y2"))
    assert found.intensity.tolist() == (Y + 1).tolist()
    with pytest.raises(Unreadable, match="no dataset a/z"):
        read_spectrum(hdf5(tmp_path, unclear), columns=("a/x1", "a/z"))
    with pytest.raises(Unreadable, match="is the file complete"):
        read_spectrum(hdf5(tmp_path, plain)[:-300])


@pytest.mark.parametrize(
    "raw", [spc(), sif(), raw8((X, Y, Y)), workbook(ROWS), b"\x89HDF\r\n\x1a\n" + b"\0" * 600]
)
def test_without_its_reader_a_file_says_how_to_install_it(monkeypatch, raw):
    def missing(name):
        raise ModuleNotFoundError(f"No module named {name!r}", name=name)

    monkeypatch.setattr(library, "import_module", missing)
    with pytest.raises(Unreadable, match=r'python -m pip install "labrun\[formats\]"'):
        read_spectrum(raw)


def test_a_table_that_has_two_readings_says_which_it_was_given():
    times = np.arange(10.0) * 20
    table = np.vstack([X, np.outer(times + 300, np.ones(N)) + Y])
    packed, across = io.BytesIO(), io.BytesIO()
    np.save(packed, table)
    np.save(across, table.T)

    assert (
        "first row of the table is read as the wavelengths"
        in read_shots(packed.getvalue()).notes[0]
    )
    assert "first column of the table" in read_shots(across.getvalue()).notes[0]
    assert read_shots(npz(table=np.stack([X, Y, Y + 2]))).notes == ()
