"""Tables of standards as people write them, and all that can be wrong with one."""

from pathlib import Path

import pytest

from labrun.reduction.calibration.standards import StandardsFault, read_standards, spectra_of


def problems(text):
    with pytest.raises(StandardsFault) as fault:
        read_standards(text, "s.csv")
    return fault.value.problems


def test_units_and_oxides_become_wt_per_cent_of_the_element():
    text = "sample,Li (ppm),SiO2 [wt %],Fe_mg/kg,note\nA,250,50,,glass\n\n# a remark\nB,0,,120 mg/kg,\n"
    found = read_standards(text, "s.csv")

    assert found.elements == ["Li", "Si", "Fe"]
    assert found.samples[0].wt_percent == {"Li": 0.025, "Si": pytest.approx(23.372, abs=1e-3)}
    assert found.samples[1].wt_percent == {"Li": 0.0, "Fe": pytest.approx(0.012)}
    assert found.notes == ("SiO2 [wt %]: wt % of Si are 0.46744 times it",)


@pytest.mark.parametrize(
    "heading",
    ["Fe2O3T (wt %)", "Fe2O3t (wt %)", "Fe2O3* wt%", "Fe2O3tot (%)", "Fe2O3(T) wt.%", "Fe2O3 total (%)",
     "Fe2O3_tot (Gew.-%)"],
)  # fmt: skip
def test_all_iron_as_one_oxide_is_headed_as_analyses_of_rocks_do(heading):
    found = read_standards(f"sample,{heading}\nBHVO-2,12.3\n", "s.csv")

    assert found.samples[0].wt_percent["Fe"] == pytest.approx(8.603, abs=1e-3)


def test_a_table_of_a_spreadsheet_with_decimal_commas_is_read():
    found = read_standards("Sample;File;K2O (%)\nA;a_*.csv|x.csv;2,5\n", "s.csv")

    assert found.samples[0].wt_percent["K"] == pytest.approx(2.5 * 0.83014, rel=1e-4)
    assert found.samples[0].files == ("a_*.csv", "x.csv")


def test_totals_and_what_a_rock_lost_when_it_glowed_are_no_elements():
    text = "sample,K (%),MOC Total,LOI (wt %),Sum\nA,2.5,98.2,1.1,99.3\n"
    found = read_standards(text, "s.csv")

    assert found.samples[0].wt_percent == {"K": 2.5}
    assert found.notes == ("MOC Total: left aside", "LOI (wt %): left aside", "Sum: left aside")


def test_a_cell_may_say_the_unit_of_its_column_in_other_words():
    found = read_standards("sample,Si (wt %),Li (ppm),K (mg/g)\nA,12.5 %,3 mg/kg,10\n", "s.csv")

    assert found.samples[0].wt_percent == pytest.approx({"Si": 12.5, "Li": 3e-4, "K": 1.0})


ONE = {"Si": pytest.approx(23.185, abs=1e-3), "Li": pytest.approx(4.8e-4)}


@pytest.mark.parametrize(
    "text",
    [
        "sample,SiO2,Li,note\nunits,wt %,ppm,\nBHVO-2,49.6,4.8,\nA,50,5,\n",
        ",SiO2,Li,sample\n,wt.-%,µg/g,\n1,49.6,4.8,BHVO-2\n2,50,5,A\n",
        "sample,SiO₂ (weight %),Li (µg g⁻¹)\nBHVO-2,49.6,4.8\nA,50,NaN\n",
        "sample,type,SiO2 (wt%),SiO2 err (wt%),±,Li (ng/g),sd,H2O+ (%)\nBHVO-2,basalt,49.6,.6,1,4800,9,2\n"
        "A,glass,50,1,1,n/a,,\n",
        "analyte,unit,BHVO-2,±,A\nSiO2,wt %,49.6,0.6,50\nLi,ppm,4.8,.1,−\n",
        ",BHVO-2,A\nSiO2 (wt %),49.6,50\nLi (ppm),4.8,5\n",
        "Sample;BHVO-2;A\nSiO2 (%);49,6;50\nLi (ppm);4,8;5\n",
        ",meta,meta,comp,comp,wvl,wvl\n,shot,sample,SiO2,Li (ppm),200.1,200.2\n"
        "0,1,BHVO-2,49.6,4.8,7,8\n1,2,A,50,5,7,8\n2,3,BHVO-2,49.6,4.8,8,9\n",
        "meta,comp,comp\nTarget,SiO2 (wt %),Li (ppm)\nBHVO-2,49.6,4.8\nA,50,5\n",
        "meta,comp,comp,comp,comp,comp\nTarget,SiO2,Fe(3+)/Fe(Total),Li2O,Li (ug/g),Ba (ug/g)\n"
        "BHVO-2,49.6,0.2,0,4.8,-23.17\nA,50,,,5,-9\n",
    ],
)
def test_other_shapes_of_a_table_are_read(text):
    found = read_standards(text, "s.csv")

    assert found.samples[0].wt_percent == ONE
    assert [one.sample for one in found.samples] == ["BHVO-2", "A"]
    assert found.rows == (("BHVO-2", "A", "BHVO-2") if "wvl" in text else ())


def test_what_was_left_aside_or_taken_for_granted_is_noted():
    turned = read_standards("analyte,unit,A,±\nSiO2,wt %,49.6,0.6\n", "s.csv")
    beside = read_standards("sample,type,Si (%),Si_err (%)\nA,glass,20,1\n", "s.csv")
    pyhat = read_standards(
        "meta,comp,comp,comp,comp,comp,comp\nTarget,SiO2,%LOI,SO3 Actual,Fe2O3T,FeO,Ba (ug/g)\n"
        "A,50,2,1,9,5,-3\n",
        "s.csv",
    )

    assert turned.notes[:2] == (
        "a column is a standard",
        "±: left aside, as errors of certificates",
    )
    assert beside.notes == (
        "type: left aside, as words",
        "Si_err (%): left aside, as an error of the certificates",
    )
    assert pyhat.notes[:4] == (
        "the standards' names are those of 'Target'",
        "%LOI, SO3 Actual, FeO: left aside",
        "amounts below 0, as a background leaves them, are taken as unknown: 1 of them",
        "SiO2, Fe2O3T: read as wt %, as no unit is said",
    )


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("meta,comp,wvl\nid,Li,200.1\nA,1,7\n", "s.csv:2: column 'Li': it has no unit"),
        ("meta,comp,comp\nid,FeO,Fe2O3\nA,1,7\n", "Fe has a column already"),
        (
            "meta,comp,wvl\nid,Li (%),200.1\nA,1,7\nA,2,7\n",
            "s.csv:4: 'A' has another composition than line 3",
        ),
        (
            "sample;Si (ppm);K (%)\nA;277.000;2,5\n",
            "s.csv:2: '277.000' may be 277000 or 277, since others have",
        ),
        ("sample,Li (ppm)\nA,bdl\n", "'bdl' is no concentration; leave it empty, or write 0"),
        ("sample,Li (ppm)\nA,n.d.\n", "'n.d.' is no concentration; leave it empty, or write 0"),
        (",A,A\nLi (ppm),1,2\n", "s.csv, column 3: 'A' has a row already, column 2"),
        (",A\nLi (ppm),x\n", "s.csv, column 2: Li (ppm): 'x' is not a number"),
        ("", "s.csv: it is empty"),
        ("name,Li (ppm)\nA,1\n", "s.csv:1: no column `sample`; it has name, Li (ppm)"),
        ("sample,Li\nA,1\n", "s.csv:1: column 'Li': it has no unit; write one of wt %,"),
        ("sample,Li (mol)\nA,1\n", "s.csv:1: column 'Li (mol)': the unit 'mol' is not known"),
        ("sample,Xy (ppm)\nA,1\n", "'Xy' is not an element"),
        ("sample,Mn total (%)\nA,1\n", "the unit 'total (%' is not known"),
        ("sample,Total Fe (ppm)\nA,1\n", "'Total' is not an element"),
        ("sample,Si (%),SiO2 (%)\nA,1,2\n", "column 'SiO2 (%)': Si has a column already"),
        ("sample,Li (wt %)\nA,120 ppm\n", "s.csv:2: Li (wt %): '120 ppm' is in another unit"),
        ("sample,Li (wt %)\nA,250\n", "250 wt % cannot be; is it in another unit?"),
        ("sample,Li (ppm)\nA,-3\n", "'-3' is below 0"),
        ('sample,Li (ppm)\nA,"1,5"\n', "'1,5' has a comma; write a point"),
        (
            "sample,Li (ppm)\nA,1,5\n",
            "s.csv:2: it has 3 cells, where the headings are 2; are there decimal",
        ),
        ("sample,Li (ppm)\nA,<5\n", "'<5' is no concentration; leave it empty"),
        ("sample,Li (ppm)\nA,many\n", "'many' is not a number"),
        ("sample,Li (ppm)\nA,1.2.3\n", "'1.2.3' is not a number"),
        ("sample,Li (ppm)\nA,1\nA,2\n", "s.csv:3: 'A' has a row already, line 2"),
        ("sample,Li (ppm)\nA,1\na,2\n", "s.csv:3: 'a' has a row already, line 2"),
        ("sample,Si (%)\nA,20 ± 1\n", "'20 ± 1': write the value alone; a certificate's error"),
        ("sample,Li (ppm)\n,1\n", "s.csv:2: the sample has no name"),
        ("sample,Si (%),Al (%)\nA,70,60\n", "the elements of A are 130.0 wt % together"),
        ("sample,SiO2 (%),Al2O3 (%)\nA,70,40\n", "what is written of A is 110.0 wt % together"),
        ("sample,Li (ppm)\nA,\n", "s.csv: no concentration of any element"),
    ],
)
def test_what_is_wrong_is_said_with_its_place(text, told):
    assert any(told in problem for problem in problems(text))


def test_all_problems_are_told_at_once():
    assert len(problems("sample,Li,Xy (ppm),K (%)\nA,1,2,<3\nB,1,2,x\n")) == 4


def test_spectra_belong_to_the_sample_whose_name_they_begin_with_or_whose_pattern_they_fit():
    table = read_standards(
        "sample,file,Li (ppm)\nA,,1\nA-1,,2\nC,run/7.csv|z_?.csv,3\nD,,4\n", "s.csv"
    )
    paths = [Path(p) for p in ("a_1.csv", "A-1.csv", "A-1_b.csv", "x/run/7.csv", "z_3.csv")]
    found = spectra_of(table, paths, "s.csv")

    assert found == {"A": paths[:1], "A-1": paths[1:3], "C": paths[3:], "D": []}


def test_blanks_hyphens_and_underscores_are_alike_in_names():
    table = read_standards("sample,Li (ppm)\nNIST 610,1\nA-1,2\nA_1,3\nA,4\n", "s.csv")
    paths = [Path(p) for p in ("nist_610_2.csv", "A-1.csv", "A_1.csv", "A_2.csv")]
    found = spectra_of(table, paths, "s.csv")

    assert found == {"NIST 610": paths[:1], "A-1": paths[1:2], "A_1": paths[2:3], "A": paths[3:]}


def test_spectra_of_no_sample_or_of_two_are_told():
    table = read_standards("sample,file,Li (ppm)\nA,,1\nB,x*,2\nC,x1*,3\n", "s.csv")
    with pytest.raises(StandardsFault) as fault:
        spectra_of(table, [Path("AB_1.csv"), Path("AB_2.csv"), Path("x1.csv")], "s.csv")

    assert "x1.csv: B and C of s.csv both claim this spectrum" in fault.value.problems[0]
    assert (
        "AB_1.csv: no row of s.csv is of this spectrum (and of 1 more)" in fault.value.problems[1]
    )
