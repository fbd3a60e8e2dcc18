"""Lines of one's own: read from a CSV file, beside the shipped ones and instead of them."""

import numpy as np
import pytest

from labrun.reduction.elements.elements import predominant_line
from labrun.reduction.lines.lines import line_table, lines_of, use_lines
from labrun.reduction.lines.more_lines import LinesFault, read_lines

HEADING = "element,stage,wavelength_air_nm,a_ki_per_s,g_i,g_k,e_i_ev,e_k_ev\n"
OSMIUM = "Os,1,305.866,2.9e7,9,11,0,4.0524\n"


@pytest.fixture(autouse=True)
def shipped_afterwards():
    yield
    use_lines(None)


def test_an_element_that_the_table_lacks_is_brought():
    before = len(line_table())
    with pytest.raises(ValueError, match="no lines of 'Os'"):
        lines_of("Os")
    use_lines(HEADING + OSMIUM)

    assert len(line_table()) == before + 1
    assert np.all(np.diff(line_table().wavelength_nm) >= 0)
    assert predominant_line("Os").wavelength_nm == pytest.approx(305.9549, abs=1e-3)  # vacuum


def test_without_them_everything_is_as_before():
    before = predominant_line("Li")
    use_lines(HEADING + OSMIUM)
    use_lines(None)

    assert predominant_line("Li") == before
    with pytest.raises(ValueError, match="no lines of 'Os'"):
        predominant_line("Os")


def test_a_line_between_the_same_levels_replaces_the_shipped_one():
    shipped = lines_of("Li")
    row = int(np.argmin(np.abs(shipped.wavelength_nm - 670.961)))
    levels = f"{shipped.e_i_ev[row]},{shipped.e_k_ev[row]}"
    use_lines(
        f"element,stage,wavelength_vacuum_nm,a_ki_per_s,g_i,g_k,e_i_ev,e_k_ev\n"
        f"Li,1,670.961,5e7,2,4,{levels}\n"
    )
    changed = lines_of("Li")

    assert len(changed) == len(shipped)
    assert changed.a_ki_per_s[np.argmin(np.abs(changed.wavelength_nm - 670.961))] == 5e7


def test_an_export_of_nist_is_read_as_it_is():
    table = read_lines(
        '"element","sp_num","obs_wl_air(nm)","ritz_wl_air(nm)","Aki(s^-1)","Acc","Ei(eV)","Ek(eV)",'
        '"g_i","g_k","Type"\n'
        '"Li","1","=""670.7760""","=""670.77601""","3.6894e+07","AAA","=""0.00000000""",'
        '"=""1.84786""","2","4",\n'
        '"Li","1","","=""999.0""","","","=""[0.0]""","=""[1.2411]""","2","2",\n'
    )

    assert len(table) == 1
    assert table.wavelength_nm[0] == pytest.approx(670.9612, abs=1e-3)
    assert (table.g_k[0], table.accuracy[0]) == (4, "AAA")


NIST = "element,sp_num,ritz_wl_air(nm),Aki(s^-1),Acc,Ei(eV),Ek(eV),J_i,J_k\n"


@pytest.mark.parametrize(
    ("levels", "note"),
    [
        ('"=""[0]""","=""4.0524?"""', "1 of 2 lines have a level that NIST marks ?"),
        ('0&dagger;,"=""4.0524"""', "1 of 2 lines have a level that NIST marks †"),
        ("0+x,[4.0524+x]", "1 of 2 lines have levels that are known up to a common shift (+x)"),
        ("0,4.1524", "rows left out: 1 (a wavelength that is not that of the levels)"),
        ("0,4.0524aux", "rows left out: 1 (e_k_ev is '4.0524aux', not a number)"),
        ("0,", "rows left out: 1 (no levels)"),
    ],
)
def test_marks_of_nist_are_read_and_told(levels, note):
    notes = []
    table = read_lines(
        f"{NIST}Os,1,305.866,2.9e7,B,{levels},4,5\nOs,1,305.9,1e7,B,0,4.052,4,5\n", notes
    )

    assert len(notes) == 1 and notes[0].startswith(note)
    assert table.e_k_ev[0] == pytest.approx(4.0524, abs=1e-3)
    assert (table.g_i[0], table.g_k[0]) == (9, 11)


def test_rows_of_an_export_that_are_no_lines_of_atoms_or_ions_are_counted():
    notes = []
    rows = ["Os,3,305.866,2.9e7,B,0,4.0524,4,5", "D,1,656.1,4e7,A,10.2,12.09,1/2,3/2",
            "Os,1,305.866,,B,0,4.0524,4,5", "Os,1,305.866,2e7,B,0,4.0524,,",
            "Os,2,305.866,2.9e7,B,0,4.0524,7/2,9/2"]  # fmt: skip
    table = read_lines(NIST + "\n".join(rows), notes)

    assert (len(table), table.g_k[0]) == (1, 10)
    assert notes == [
        "rows left out: 1 (stage III or higher), 1 (isotopes), 1 (no transition probability), "
        "1 (no statistical weights)"
    ]


def test_an_export_may_be_in_angstrom_and_wavenumbers_with_tabs_and_ga():
    table = read_lines(
        "obs_wl_vac(A)\tgA(s^-1)\tEi(cm-1)\tEk(cm-1)\tg_i\tg_k\telement\tsp_num\n"
        '"6709.612"\t1.47576e8\t"0.00"\t"14903.983"\t2\t4\t"Li"\t1\n'
    )

    assert table.wavelength_nm[0] == pytest.approx(670.9612, abs=1e-4)
    assert table.a_ki_per_s[0] == pytest.approx(3.6894e7)
    assert table.e_k_ev[0] == pytest.approx(1.84786, abs=1e-5)


@pytest.mark.parametrize("column", ["193.0905", "193.0272"])
def test_what_tables_call_air_below_200_nm_is_what_its_levels_say(column):
    text = "element,stage,wavelength_air_nm,a_ki_per_s,g_i,g_k,e_i_ev,e_k_ev\n"
    table = read_lines(f"{text}C,1,{column},3.67e8,5,3,1.263728,7.684768\n")

    assert table.wavelength_nm[0] == pytest.approx(193.0905, abs=1e-3)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("element,stage\nLi,1\n", "no column a_ki_per_s, g_i, g_k, e_i_ev, e_k_ev, wavelength_vac"),
        (HEADING, "no line in it has a transition probability"),
        (HEADING + "Xx,1,305.9,1e7,9,11,0,4.05\n", "row 2: 'Xx' is not the symbol of an element"),
        (HEADING + "Os,3,305.9,1e7,9,11,0,4.05\n", "row 2: stage is 1 (I, atoms) or 2"),
        (HEADING + "Os,1,305.9,fast,9,11,0,4.05\n", "row 2: a_ki_per_s is 'fast', not a number"),
        (HEADING + "Os,1,305.9,-1e7,9,11,0,4.05\n", "row 2: a_ki_per_s is -1e+07, not above 0"),
        (HEADING + "Os,1,3058.66,1e7,9,11,0,4.0524\n", "make a line at 305.953 nm, not 3059.494"),
        (HEADING + "Os,1,305.9,1e7,9,11,4.05,0.1\n", "make a line at inf nm"),
        (HEADING + "Mt,1,305.9,1e7,9,11,0,4.0524\n", "the levels of Mt I are not known"),
    ],
)
def test_what_cannot_be_used_is_said_with_its_row(text, words):
    shipped = len(line_table())
    with pytest.raises(LinesFault) as told:
        use_lines(text)

    assert words in str(told.value)
    assert len(line_table()) == shipped
