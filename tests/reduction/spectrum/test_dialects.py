"""Every dialect that instruments write is read back the same, or refused with a way on."""

import gzip

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from labrun.reduction import Unreadable, read_shots, read_spectrum

N = 60
X = np.round(np.linspace(200.0338, 961.2, N), 4)
Y = np.round(np.abs(np.random.default_rng(3).normal(400, 300, N)) + 1, 3)
OCEAN = """Data from sample_HG_0001.txt Node

Date: Fri Jan 31 11:58:08 CET 2019
User: lab
Spectrometer: HR4C1234
Integration Time (sec): 1.000000E-1
Number of Pixels in Spectrum: 60
>>>>>Begin Spectral Data<<<<<
"""
SUITE = """SpectraSuite Data File
++++++++++++++++++++++++++++++++++++
Date: Mon Jun 11 14:59:44 JST 2018
Integration Time (usec): 60000 (USB4F06998)
Number of Pixels in Processed Spectrum: 60
>>>>>Begin Processed Spectral Data<<<<<
"""
AVANTES = """
Integration time [ms]: {t}
Averaging Nr. [scans]: 9
Smoothing Nr. [pixels]: 0
Data measured with spectrometer [name]: 0911147U1
Wave   ;Sample   ;Dark     ;Reference;Scope
[nm]   ;[counts] ;[counts] ;[counts]

"""
SOLIS = """

Date and Time:,Fri Jan 31 11:58:08 2020
Software Version:,4.30.30024.0
Exposure Time (secs):,0.05
"""


def rows(form, x=X, y=Y):
    return "".join(form.format(a, b) for a, b in zip(x, y, strict=True))


def commas(text):
    return text.replace(".", ",")


DIALECTS = {
    "sciaps": "wavelength,intensity\n" + rows("{},{}\n"),
    "bare": rows("{},{}\n"),
    "crlf": ("wavelength,intensity\n" + rows("{},{}\n")).replace("\n", "\r\n"),
    "old mac": ("wavelength,intensity\n" + rows("{},{}\n")).replace("\n", "\r"),
    "quoted": '"Wavelength","Counts"\n' + rows('"{}","{}"\n'),
    "semicolon comma": "Wellenlänge;Zähler\n" + commas(rows("{};{}\n")),
    "tab comma": commas(rows("{}\t{}\n")),
    "spaces comma": commas(rows(" {}   {}\n")),
    "quoted commas": "nm,counts\n" + commas(rows('"{}"|"{}"\n')).replace("|", ","),
    "commas for both": commas(rows("{}|{}\n", X, np.round(Y, 1))).replace("|", ","),
    "percent": "% LIBS, gate 1 us\n% nm counts\n" + rows("{} {}\n"),
    "hash": "#sample 7\n#wavelength\tcounts\n" + rows("{}\t{}\n") + "# end\n",
    "comment between": rows("{} {}\n").replace("\n", "\n# half\n", 1),
    "ocean": OCEAN + rows("{}\t{}\n"),
    "spectrasuite": SUITE + rows("{}\t{}\n") + ">>>>>End Processed Spectral Data<<<<<\n",
    "jaz": SUITE + "W\tD\tR\tS\tP\n" + rows("{0}\t3.5\t7.5\t9.9\t{1}\n"),
    "avantes": AVANTES.format(t="15.000") + rows(" {};  {};   31.5;   41.5;\n"),
    "avantes comma": AVANTES.format(t="15,000") + commas(rows(" {};  {};   31.5;   41.5;\n")),
    "avantes, units of its own": "Wave ;Dark ;Ref ;Sample ;Absolute Irradiance\n"
    "[nm] ;[counts] ;[counts] ;[counts] ;[mW/cm2/nm]\n\n"
    + commas(rows("{0};31.5;41.5;{1};0.5\n")),
    "avantes 7": "0911147U1- \nspectrometer name: 0911147U1" + 45 * "\0" + "\nWave   ;Sample\n"
    "[nm]   ;[counts]\n" + rows("{};{}\n"),
    "andor asc": rows("{},{}\n") + SOLIS,
    "andor top": SOLIS.replace("\n\n", "") + "\n" + rows("{},{}\n"),
    "descending": "nm;counts\n" + rows("{};{}\n", X[::-1], Y[::-1]),
    "angstrom": "Wavelength (Å),Intensity\n" + rows("{},{}\n", np.round(10 * X, 3)),
    "angstrom in a word": "wavelength [Angstrom],I\n" + rows("{},{}\n", np.round(10 * X, 3)),
    "picometre": "Wavelength (pm)\tcounts\n" + rows("{:.1f}\t{}\n", 1000 * X),
    "micrometre": "wavelength [µm];counts\n" + rows("{:.7f};{}\n", X / 1000),
    "swapped": "intensity,wavelength\n" + rows("{},{}\n", Y, X),
    "swapped and bare": rows("{},{}\n", Y, X),
    "pixel first": "Pixel,Wavelength,Counts\n" + "".join(
        f"{i},{a},{b}\n" for i, (a, b) in enumerate(zip(X, Y, strict=True))),
    "pixel bare": "".join(f"{i} {a} {b}\n" for i, (a, b) in enumerate(zip(X, Y, strict=True))),
    "with errors": "wavelength,intensity,std\n" + rows("{0},{1},2.25\n"),
    "trailing separator": rows("{};{};\n"),
    "thousands by points": ("nm;counts\n" + rows("{};{:,.3f}\n", X, 1000 * Y)).translate(
        str.maketrans(".,", ",.")),
    "thousands by points beside commas": "nm;counts\n" + "".join(
        f"{a:.4f}".replace(".", ",") + f";{1000 * b:,.0f}\n".replace(",", ".")
        for a, b in zip(X, Y, strict=True)),
    "sep line": "sep=;\nWave;Int\n" + rows("{};{}\n"),
    "flags": "wavelength,counts,ok\n" + "".join(
        f"{a},{b},{int(b > 300)}\n" for a, b in zip(X, Y, strict=True)),
    "two kinds of wavelength": "wl_air,wl_vac,counts\n" + "".join(
        f"{a},{1.00028 * a:.4f},{b}\n" for a, b in zip(X, Y, strict=True)),
    "numbers of columns above rows": ",".join(map(str, range(N))) + "\n" + ",".join(map(str, X)) + "\n"
    + ",".join(map(str, Y)) + "\n",
    "numpy in rows": " ".join(f"{a:.18e}" for a in X) + "\n" + " ".join(f"{b:.18e}" for b in Y) + "\n",
    "pandas, turned": "," + ",".join(map(str, range(N))) + "\nwavelength," + ",".join(map(str, X))
    + "\nintensity," + ",".join(map(str, Y)) + "\n",
    "pandas": ",wavelength,intensity\n" + "".join(
        f"{i},{a},{b}\n" for i, (a, b) in enumerate(zip(X, Y, strict=True))),
    "symbols": "lambda\tI\tsigma_I\n" + rows("{0}\t{1}\t2.25\n"),
    "mean of shots": "wavelength,mean,std\n" + rows("{0},{1},9.5\n"),
    "scientific comma": commas(rows("{:.6E};{:.6E}\n")),
    "fortran": rows("{:.6E} {:.6E}\n").replace("E", "D"),
    "bars": "nm|counts\n" + rows("{}|{}\n"),
    "b&w tek": "Date;2014-05-02\nPixel;Wavelength;Raman Shift;Dark;Raw data #1;Dark Subtracted #1;%TR #1;\n"
    + "".join(f"{i};{a};0;100;{b + 100};{b};1.0;\n" for i, (a, b) in enumerate(zip(X, Y, strict=True))),
    "b&w tek, pixels beyond the range": "File Version;BWSpec4.11\n"
    "Pixel;Wavelength;Wavenumber;Raman Shift;Dark;Reference;Raw data #1;Dark Subtracted #1;%TR #1;\n"
    + commas("0;   ;   ;   ;9.5;8.5;7.5;6.5;0.0;\n" + rows("1;{0};9.5;3.5;100.0;9.5;7.5;{1};1.0;\n")
             + "2;   ;   ;   ;9.5;8.5;7.5;6.5;0.0;\n"),
    "labspec": "#AxisType[1]=\tSpectr\n#AxisUnit[1]=\tnm\n" + rows("{}\t{}\n"),
    "empty columns": "Wave;Int;;;\n" + rows("{};{};;;\n"),
    "in rows": ",".join(map(str, X)) + "\n" + ",".join(map(str, Y)) + "\n",
    "raw and smoothed": "nm,Raw,Smoothed,Normalized\n" + rows("{0},{1},7.5,.5\n"),
    "scope of all": "Wave;Sample;Dark;Reference;Scope\n" + rows("{0};9.5;3.5;7.5;{1}\n"),
    "thousands": "nm;counts\n" + rows("{};{:,.3f}\n", X, 1000 * Y),
    "thousands apart": ("nm;counts\n" + rows("{};{:,.3f}\n", X, 1000 * Y)).translate(
        str.maketrans(".,", ",\xa0")),
    "thousands by apostrophes": ("nm;counts\n" + rows("{};{:,.3f}\n", X, 1000 * Y)).replace(",", "'"),
}  # fmt: skip
SCALED = dict.fromkeys(
    (
        "thousands",
        "thousands by points",
        "thousands by points beside commas",
        "thousands apart",
        "thousands by apostrophes",
    ),
    1000.0,
)


@pytest.mark.parametrize("name", DIALECTS)
@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "utf-16-be", "cp1252"])
def test_what_is_written_in_a_dialect_is_read_back_the_same(name, encoding):
    found = read_spectrum(DIALECTS[name].encode(encoding))
    tenths = name == "commas for both"

    assert found.wavelength_nm == pytest.approx(X, rel=1e-12)
    assert found.intensity == pytest.approx(
        (np.round(Y, 1) if tenths else Y) * SCALED.get(name, 1.0), rel=1e-12
    )


def test_gzip_is_unpacked_and_a_part_of_it_is_refused():
    packed = gzip.compress(DIALECTS["sciaps"].encode())

    assert read_spectrum(packed).intensity.tolist() == Y.tolist()
    with pytest.raises(Unreadable, match="ends before its end"):
        read_spectrum(packed[:-20])
    with pytest.raises(Unreadable, match="damaged"):
        read_spectrum(packed[:30] + b"\xff\xff\xff\xff" + packed[34:])


@given(
    st.lists(
        st.tuples(st.integers(1_500_000, 9_500_000), st.integers(0, 655_350)),
        min_size=4, max_size=30, unique_by=lambda row: row[0],
    ),
    st.sampled_from([(",", "."), (";", "."), ("\t", "."), ("  ", "."), (";", ","), ("\t", ",")]),
    st.sampled_from(["", "wavelength{}counts\n", "# made by hand\n", "a: 1\nb: 2{}3 4\n\n"]),
    st.booleans(), st.booleans(),
)  # fmt: skip
def test_any_spectrum_in_any_dialect_is_read_back(table, marks, head, descending, packed):
    separator, decimal = marks
    table = sorted(table, reverse=descending)
    if len({count for _, count in table}) == 1:
        return
    lines = [f"{x / 1e4:.4f}{separator}{y / 10:.1f}\n" for x, y in table]
    raw = (head.format(separator) + "".join(lines).replace(".", decimal)).encode()
    found = read_spectrum(gzip.compress(raw) if packed else raw)

    assert found.wavelength_nm.tolist() == [x / 1e4 for x, _ in sorted(table)]
    assert found.intensity.tolist() == [y / 10 for _, y in sorted(table)]


def shots_text(form, *shots, head=""):
    return head + "".join(form.format(*row) for row in zip(X, *shots, strict=True))


@pytest.mark.parametrize(
    "head",
    [
        "",
        "wavelength,shot 1,shot 2,shot 3\n",
        "wavelength,17,18,19\n",
        "# burst of 3\n",
        "wavelength,a,b,c\nIntegration time,1.05,1.05,2\n",
    ],
)
def test_several_columns_are_shots_and_their_mean_says_so(head):
    text = shots_text("{},{},{},{}\n", Y, 1.5 * Y + 3, 0.5 * Y + 1, head=head)

    assert len(read_shots(text.encode())) == 3
    found = read_spectrum(text.encode())
    assert found.intensity == pytest.approx(Y + 4 / 3)
    assert found.notes[-1] == "the mean of 3 shots"


@pytest.mark.parametrize("heading", ["Wellenlänge,Dunkel,Signal", "波长,暗光谱,样品"])
@pytest.mark.parametrize("encoding", ["utf-8", "native"])
def test_the_dark_is_no_shot_in_other_languages(heading, encoding):
    text = (
        heading
        + "\n"
        + "".join(f"{a},{99 + i % 3},{b}\n" for i, (a, b) in enumerate(zip(X, Y, strict=True)))
    )
    native = "cp1252" if "ä" in text else "gb18030"
    found = read_spectrum(text.encode(native if encoding == "native" else encoding))

    assert found.intensity.tolist() == Y.tolist()


def test_typeset_signs_and_words_for_channels_without_a_count_are_read():
    text = "200,\u22121.5\n201,\u00a02\n202,#N/A\n203,OVER\n204,1.#QNAN\n205,3\n"
    found = read_spectrum(text.encode())

    assert found.intensity.tolist() == pytest.approx([-1.5, 2, *[np.nan] * 3, 3], nan_ok=True)


def test_columns_beside_the_counts_are_named_and_left_out():
    found = read_spectrum(DIALECTS["avantes"].encode())

    assert "not used: column 3 (Dark [counts]), column 4 (Reference [counts])" in found.notes


def test_columns_without_names_that_are_no_shots_are_a_question():
    text = shots_text("{} {} {}\n", Y, np.sqrt(Y)).encode()

    with pytest.raises(Unreadable, match="too unlike to be shots of one spectrum; say which with"):
        read_spectrum(text)
    assert read_spectrum(text, columns=("1", "2")).intensity.tolist() == Y.tolist()


@pytest.mark.parametrize("columns", [("1", "3"), ("nm", "b"), ("NM", "B")])
def test_columns_may_be_said(columns):
    text = shots_text("{};{};{}\n", Y, Y + 1, head="nm;a;b\n").encode()

    assert read_spectrum(text, columns=columns).intensity.tolist() == (Y + 1).tolist()


@pytest.mark.parametrize(
    ("columns", "sentence"),
    [(("1", "4"), "no column 4; the table has 3"), (("nm", "c"), "no columns are headed 'c'")],
)
def test_columns_that_are_not_there_are_told(columns, sentence):
    text = shots_text("{};{};{}\n", Y, Y + 1, head="nm;a;b\n").encode()

    with pytest.raises(Unreadable, match=sentence):
        read_spectrum(text, columns=columns)


def test_spectra_one_below_the_other_are_shots():
    text = rows("{} {}\n") + rows("{} {}\n", X, Y + 2)
    found = read_spectrum(text.encode())

    assert found.intensity == pytest.approx(Y + 1)
    assert found.notes[0] == "2 spectra stand one below the other"


def test_where_detectors_overlap_each_is_used_up_to_the_middle():
    x = np.concatenate([np.linspace(410, 900, 100), np.linspace(200, 420, 100)])
    y = np.concatenate([np.full(100, 50.0), np.full(100, 3.0)]) + np.arange(200.0) % 2
    found = read_spectrum(rows("{:.3f},{:.2f}\n", x, y).encode())

    assert np.all(found.intensity[found.wavelength_nm < 415] < 10)
    assert np.all(found.intensity[found.wavelength_nm > 415] > 10)
    assert len(found) == 200 - 3 - 2  # above 415 of the one, below it of the other
    assert found.notes == (
        "the wavelengths go back at 1 places: 2 ranges",
        "where two ranges overlap, each was used up to the middle",
    )


@pytest.mark.parametrize("decimals", [2, 3, 8])
@pytest.mark.parametrize("descending", [False, True])
def test_detectors_that_were_sorted_into_one_another_are_taken_apart(decimals, descending):
    x = np.concatenate([np.arange(200, 232, 0.0612), np.arange(228.02, 260, 0.0533)])
    x = x + 2e-5 * (x - 230) ** 2
    who = np.where(np.arange(len(x)) < 523, 3.0, 50.0)
    order = np.argsort(x, kind="stable")[:: -1 if descending else 1]
    text = rows(f"{{:.{decimals}f}},{{:.2f}}\n", x[order], who[order] + order % 2)
    found = read_spectrum(text.encode())

    middle = 0.5 * (x[523] + x[522])
    low = found.wavelength_nm < middle - 0.02
    assert np.all(found.intensity[low] < 10)
    assert np.all(found.intensity[found.wavelength_nm > middle + 0.02] > 10)
    assert len(x) - 60 > len(found) > len(x) - 150  # 4 nm of both, less what may be either's
    assert "two detectors had been sorted into one another (228.0 to 23" in found.notes[0]


def test_channels_that_stand_in_one_another_otherwise_are_told():
    orders = [np.linspace(a, a + 10, 300) + 1e-3 * k for k, a in enumerate(range(200, 240, 3))]
    x = np.sort(np.concatenate(orders))
    found = read_spectrum(rows("{:.5f},{:.2f}\n", x, 100.0 + np.arange(len(x)) % 7).encode())

    assert "many channels stand closer together" in found.notes[0]


def test_detectors_of_one_gain_and_equal_grids_are_kept_whole():
    x = np.sort(np.concatenate([np.arange(200, 232, 0.0612), np.arange(228.02, 260, 0.0533)]))
    found = read_spectrum(rows("{:.3f},{:.2f}\n", x, 100.0 + np.arange(len(x)) % 7).encode())
    grid = np.linspace(200, 260, 900)
    again = np.sort(np.concatenate([grid, grid[400:500]]))
    twice = read_spectrum(rows("{:.4f},{:.2f}\n", again, 9.0 + np.arange(1000) % 7).encode())

    assert len(found) == len(np.unique(np.round(x, 3)))
    assert len(twice) == 900
    assert twice.notes == ("100 wavelengths occur again; their counts were averaged",)


def test_a_gap_or_a_change_of_pitch_is_no_overlap():
    x = np.cumsum(np.repeat([0.13, 0.065, 0.03, 0.09], 200) * np.linspace(1.1, 0.9, 800)) + 200
    x[400:] += 20
    found = read_spectrum(rows("{:.3f},{:.2f}\n", x, 100.0 + np.arange(800) % 7).encode())

    assert len(found) == 800
    assert found.notes == ()


def side_by_side(*groups, head=""):
    return head + "".join(
        ",".join(map(str, sum(row, ()))) + "\n" for row in zip(*groups, strict=True)
    )


def two_ranges():
    return [list(zip(x, y, strict=True)) for x, y in ((X[:30], Y[:30]), (X[30:], Y[30:]))]


@pytest.mark.parametrize("head", ["", "Wave,Counts,Wave,Counts\n", "nm 1,ch 1,nm 2,ch 2\n"])
def test_ranges_side_by_side_are_one_spectrum(head):
    found = read_spectrum(side_by_side(*two_ranges(), head=head).encode())

    assert found.wavelength_nm.tolist() == X.tolist()
    assert found.intensity.tolist() == Y.tolist()
    assert "2 ranges stand side by side, each with its wavelengths" in found.notes


def test_ranges_of_different_length_stand_side_by_side():
    lines = side_by_side(*two_ranges(), head="Wave,Counts,Wave,Counts\n").splitlines()
    lines[-1] = ",".join(lines[-1].split(",")[:2]) + ",,"
    found = read_spectrum("\n".join(lines).encode())

    assert found.wavelength_nm.tolist() == X[:-1].tolist()


def test_an_axis_beside_each_shot_is_one_axis():
    shots = [list(zip(X, y, strict=True)) for y in (Y, 2 * Y)]
    found = read_spectrum(side_by_side(*shots, head="wl,I,wl,I\n").encode())

    assert found.intensity == pytest.approx(1.5 * Y)
    with pytest.raises(Unreadable, match="of the same range, and each its own"):
        read_spectrum(side_by_side(shots[0], [(x + 0.02, y) for x, y in shots[1]]).encode())


def test_a_second_scale_is_no_shot():
    text = shots_text("{},{},{}\n", 1e7 / X, Y, head="Wavelength (nm),Wavenumber (cm-1),Counts\n")

    assert read_spectrum(text.encode()).intensity.tolist() == Y.tolist()


WIDE = np.round(np.linspace(200.0338, 961.2, 80), 4)
BURST = np.round(np.abs(np.random.default_rng(4).normal(400, 300, (3, 80))) + 1, 1)


def in_rows(heading, begin, head="", mark="{}", separator=","):
    lines = [separator.join([heading, *map(mark.format, WIDE)])]
    lines += [separator.join([begin.format(k), *map(str, row)]) for k, row in enumerate(BURST)]
    return head + "\n".join(lines) + "\n"


@pytest.mark.parametrize(
    "text",
    [
        in_rows("sample", "rock {}"),
        in_rows("sample;class", "rock;{}", separator=";"),
        in_rows(",no,SiO2", '{},"basalt, a",49.1', head="meta,meta,comp" + ",wvl" * 80 + "\n"),
        in_rows("sample;class", "rock;{}", separator=";").replace(".", ","),
        in_rows("sample,SiO2,TiO2", '"basalt {}",49.1,1.2'),
        in_rows('""', '"{}"', mark='"X{}"'),
        in_rows("Time", "0.{}", mark="{} nm"),
        in_rows("Time", "0.{}").replace("\n", ",\n").replace(",\n", "\n", 1),
        in_rows("\t", "{}\t7", separator="\t"),
        in_rows("\t", "10:00:0{}\t1670000", head=OCEAN, separator="\t"),
        in_rows("x", "{}", head="# a map\n").replace("x,", "# ", 1).replace("\n0,", "\n", 1)
        .replace("\n1,", "\n", 1).replace("\n2,", "\n", 1),
    ],
)  # fmt: skip
def test_a_row_for_each_spectrum_is_read_with_the_wavelengths_above(text):
    found = read_shots(text.encode())

    assert found.wavelength_nm.tolist() == WIDE.tolist()
    assert found.intensity.tolist() == BURST.tolist()


@pytest.mark.parametrize("again", ["{}", "{}.1"])
def test_rows_of_detectors_that_share_a_wavelength_are_read_whole(again):
    heading = [*map(str, WIDE[:40]), again.format(WIDE[39]), *map(str, WIDE[40:])]
    lines = [",".join(["sample", *heading])]
    lines += [",".join(map(str, [k, *row[:40], row[39], *row[40:]])) for k, row in enumerate(BURST)]
    found = read_shots("\n".join(lines).encode())

    assert found.wavelength_nm.tolist() == WIDE.tolist()
    assert found.intensity.tolist() == BURST.tolist()


def test_rows_over_angstrom_and_over_overlapping_detectors_are_read():
    angstrom = in_rows("sample", "rock {}").replace("\n", "\n#", 1).split("#")
    above = ",".join(["sample", *(f"{10 * x:.3f}" for x in WIDE)])
    over = np.concatenate([WIDE[:45], WIDE[38:] + 0.01])
    twice = [
        ",".join(map(str, over)),
        *(",".join(map(str, range(7, 7 + len(over)))) for _ in range(2)),
    ]

    with pytest.raises(Unreadable, match="use --unit angstrom"):
        read_shots(f"{above}\n{angstrom[1]}".encode())
    found = read_shots(f"{above}\n{angstrom[1]}".encode(), unit="angstrom")
    assert found.wavelength_nm == pytest.approx(WIDE)
    assert len(read_shots("\n".join(twice).encode()).wavelength_nm) == 42 + 39


def test_wavelengths_above_rows_are_not_cut_short():
    text = in_rows("sample", "rock {}")
    words = ",".join(["sample", *map(str, WIDE[:60]), "label", *map(str, WIDE[:60] + 800)])

    with pytest.raises(Unreadable, match=r"interrupted by 'label', column 62"):
        read_shots(f"{words}\n{text.splitlines()[1]}".encode())


def test_where_pyhat_says_the_wavelengths_are_few_are_enough():
    text = "meta,comp,wvl,wvl,wvl\nid,SiO2,585.1,585.3,585.5\nA,50,1,2,3\nB,60,4,5,6\n"
    found = read_shots(text.encode())

    assert found.wavelength_nm.tolist() == [585.1, 585.3, 585.5]
    assert found.intensity.tolist() == [[1, 2, 3], [4, 5, 6]]
    with pytest.raises(Unreadable, match=r"interrupted by 'SiO2', column 3"):
        read_shots(b"meta,wvl,comp,wvl,wvl\nid,585.1,SiO2,585.3,585.5\nA,1,50,2,3\nB,4,60,5,6\n")


def test_rows_of_several_samples_are_named():
    found = read_spectrum(in_rows("sample", "rock {}").encode())

    assert "the spectra are the rows of the table: rock 0, rock 1, rock 2" in found.notes


def test_a_row_that_was_cut_off_is_named():
    text = in_rows("sample", "rock {}")

    with pytest.raises(
        Unreadable, match="line 4 has 71 columns, and the line of wavelengths has 81"
    ):
        read_spectrum(
            "\n".join(
                [*text.splitlines()[:3], ",".join(text.splitlines()[3].split(",")[:71])]
            ).encode()
        )


def test_many_shots_in_columns_are_not_taken_for_rows():
    shots = [Y + k for k in range(150)]
    text = shots_text(
        "{}" + ",{}" * 150 + "\n", *shots, head="nm," + ",".join(map(str, range(150, 300))) + "\n"
    )

    assert len(read_shots(text.encode())) == 150


@pytest.mark.parametrize("number", ["{:.4f}", "{:.7e}"])
def test_shots_with_a_comma_and_a_blank_between_are_read(number):
    text = shots_text(", ".join([number] * 31) + "\n", *(Y + k for k in range(30)))

    assert read_shots(text.encode()).intensity[29] == pytest.approx(Y + 29, rel=1e-6)


def test_words_and_numbers_beside_the_counts_are_left_out():
    named = "label,wavelength,intensity\n" + rows("diopside,{},{}\n")
    frames = (
        "Frame,Row,Wavelength,Intensity\n" + rows("1,1,{},{}\n") + rows("2,1,{},{}\n", X, Y + 2)
    )
    strips = rows("{}\t1\t{}\n")
    parts = "Wavelength (nm),Sum,Ca I,Ca II\n" + shots_text("{},{},{},{}\n", Y, 0.3 * Y, 0.7 * Y)
    found = [read_spectrum(text.encode()) for text in (named, frames, strips, parts)]

    assert [one.intensity.tolist() for one in found] == [
        Y.tolist(),
        pytest.approx(Y + 1),
        Y.tolist(),
        Y.tolist(),
    ]


def test_spectra_with_a_heading_each_one_below_the_other_are_shots():
    block = "Spectrum {}\nWavelength,Counts\n"
    found = read_shots(
        (block.format(1) + rows("{},{}\n") + block.format(2) + rows("{},{}\n", X, Y + 2)).encode()
    )

    assert found.intensity.tolist() == [Y.tolist(), pytest.approx(Y + 2)]
    with pytest.raises(Unreadable, match="one column"):
        read_shots((rows("{},{}\n") + "Peaks\n393.4,500\n").encode())


@pytest.mark.parametrize(
    ("heading", "values"),
    [
        ("Wavenumber (cm-1)", 1e7 / X),
        ("Energy [eV]", 1239.841984 / X),
        ("Wavelength (m)", X * 1e-9),
    ],
)
def test_other_scales_become_wavelengths(heading, values):
    found = read_spectrum((f"{heading},Counts\n" + rows("{:.12g},{}\n", values)).encode())

    assert found.wavelength_nm == pytest.approx(X)
    assert found.intensity.tolist() == Y.tolist()


def test_different_samples_in_one_file_are_not_averaged():
    x, rng = np.linspace(200, 900, 600), np.random.default_rng(8)
    lines = rng.choice(600, (3, 25))
    samples = rng.normal(100, 3, (3, 600))
    for k in range(3):
        samples[k, lines[k]] += rng.exponential(5000, 25)
    text = "nm,Al,Cu,talc\n" + "".join(
        ",".join(f"{v:.2f}" for v in row) + "\n" for row in np.column_stack([x, *samples])
    )

    with pytest.raises(Unreadable, match="too unlike one another to be shots of one sample"):
        read_spectrum(text.encode())
    assert len(read_shots(text.encode())) == 3
    assert read_spectrum(text.encode(), columns=("nm", "Cu")).intensity == pytest.approx(
        samples[1], abs=0.01
    )


def test_a_column_without_lines_is_taken_for_a_dark_and_told():
    x, rng = np.linspace(200, 900, 600), np.random.default_rng(8)
    light, dark = rng.normal(300, 3, (2, 600))
    light[rng.choice(600, 25)] += 5000
    columns = zip(x, light, dark, strict=True)
    text = "nm,A,B\n" + "".join(f"{a:.4f},{b:.3f},{c:.3f}\n" for a, b, c in columns)
    found = read_spectrum(text.encode())

    assert found.intensity == pytest.approx(light, abs=1e-3)
    assert (
        "column 2 (A), column 3 (B) (if they are none, say which with --columns" in found.notes[0]
    )
    assert found.notes[1] == "1 of 2 columns or shots show no lines, as a dark spectrum; left out"


@pytest.mark.parametrize("before", ["ROI,Frame,Row,Column", "Exposure Started,Frame,Row,Column"])
def test_frames_in_long_tables_are_shots(before):
    text = before + ",Wavelength,Intensity\n" + "".join(
        f"1,{k + 1},1,{i + 1},{a},{b + k}\n"
        for k in range(3) for i, (a, b) in enumerate(zip(X, Y, strict=True))
    )  # fmt: skip
    found = read_shots(text.encode())

    assert found.wavelength_nm.tolist() == X.tolist()
    assert found.intensity == pytest.approx(np.stack([Y, Y + 1, Y + 2]))


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        (rows("{},0\n"), "every intensity is 0"),
        (rows("{},1000\n"), "every intensity is 1000: is this the column of counts"),
        (rows("500.25,{1}\n"), "60 rows have only 1 different wavelengths"),
        (rows("{:.0f},{}\n", np.repeat(X[:20], 3)), "60 rows have only 20 different"),
        ("pixel,raw\n" + "".join(f"{i + 150},{y}\n" for i, y in enumerate(Y)), "headed 'pixel'"),
        ("".join(f"{i},{y}\n" for i, y in enumerate(Y)), "channel numbers"),
        ("".join(f"{i + 1},{y},{600 - y},\n" for i, y in enumerate(Y)), "channel numbers"),
        (
            rows("{},{}\n", np.linspace(1900, 2900, N)),
            "no heading says the unit .* --unit angstrom",
        ),
        ("SIMPLE  =    T" + "\0" * 5000, "a FITS file; save its table as CSV"),
        ("MATLAB 7.3 MAT-file" + "\0" * 5000, "a MATLAB file"),
        ("Raman shift (cm-1),counts\n" + rows("{},{}\n"), "not a wavelength"),
        ("Frequency (GHz),counts\n" + rows("{},{}\n", 3e8 / X), "not a wavelength"),
        ("Wave;Absorbance\n[nm];[AU]\n" + rows("{};{}\n"), "has no counts of light that a plasma"),
        ("Wave,%R\n" + rows("{},{}\n"), "has no counts of light that a plasma"),
        (
            "# Mode: Reflectance\nWave,Sample 1\n" + rows("{},{}\n"),
            "above its numbers stands '# Mode:",
        ),
        ("Reflectance\n" + rows("{},{}\n"), "above its numbers stands 'Reflectance'"),
        ("nm,log10(counts)\n" + rows("{},{}\n"), r"column 2 \(log10\(counts\)\) has no counts"),
        ("nm;counts\n" + "".join(f"{i + 200};12,34{i % 10}\n" for i in range(60)), "may be 12.340"),
        (rows("{},{}\n").rstrip()[: -len(str(Y[-1])) - 3], "cut off while it was written"),
        (rows("{:.4f},{:.2f}\n").rstrip()[:-1], r"ends within a number \('961.2000,"),
        (commas(rows("{:.4f};{:.2f}\n")).rstrip()[:-4], "cut off while it was written"),
        ("2048 3\n" + rows("{} {}\n"), r"first line of numbers \(2048\) is not in the order"),
        ("##TITLE= x\n##JCAMP-DX=4.24\n" + rows("{} {}\n"), "JCAMP-DX file without a spectrum"),
        ('{"a": "' + 140_000 * "b" + '"}', "no line of it is two numbers"),
        (
            "px,nm,I\n"
            + "".join(
                f"{i},{'' if i == 9 else x},{y}\n"
                for i, (x, y) in enumerate(zip(X, Y, strict=True))
            ),
            "a wavelength is not a number; are these the columns of the spectrum",
        ),
        ('{"wavelength": [200, 201], "counts": [1, 2]}', "no line of it is two numbers"),
        (rows("{},{}\n") + "962.1,5,7\n", "line 61 has 3 columns"),
        ("PK\x03\x04\0\0", "a zip archive; unpack it"),
        ("PK\x03\x04\1\0" * 200, "a zip archive; unpack it"),
        (
            "PK\x03\x04" + 22 * "\0" + "\x0d\0\0\0xl/styles.xml" + 60 * "\0",
            "this is a spreadsheet, but its",
        ),
        ("WDF1" + "\0" * 600, "a Renishaw .wdf file; save it in WiRE as .txt"),
        ("Raman", "no line of it is two numbers"),
        (" \x1c \n\f\n", "line 1 has one column"),
        (
            "Symbol,Wavelength,Stage,A\n" + "H,656.28,1,0.6\n" + 'He,"x"\n' * 3,
            "no line of it|is not|has 2 columns",
        ),
        (
            rows("{},{}\n", np.linspace(105.2, 1690.5, N)),
            "nothing says what the axis is, from 105.2 to 1690.5",
        ),
        (rows("{},{}\n", np.linspace(12.5, 3726.5, N)), "are these Raman shifts"),
        (
            "#Spectro (cm-1)=\t540.8\n" + rows("{}\t{}\n", np.linspace(120, 990, N)),
            "outside the range of any",
        ),
        ("rel. 1/cm,counts\n" + rows("{},{}\n"), "not a wavelength"),
        (
            "#a\n" + rows("{},{}\n") + "#b\n" + rows("{:.4f},{}\n", X + 0.03),
            "2 spectra stand one below the other",
        ),
        ("P" + "\0" * 4100 + "\3\4\5\1" * 900, "not text"),
        ("\x89PNG\r\n\x1a\n\0\0", "a picture"),
        ("Dear colleague,\nhere are the spectra.\nBest\n", "no line of it is two numbers"),
    ],
)
def test_what_would_be_a_silent_wrong_reading_is_refused(text, sentence):
    with pytest.raises(Unreadable, match=sentence):
        read_spectrum(text.encode("latin-1") if text[0] in "P\x89" else text.encode())
