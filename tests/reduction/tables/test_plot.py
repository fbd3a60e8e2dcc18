"""Lithium's fraction of the cations: one number in tables, maps, figures and the command."""

import re

import pytest

from labrun.reduction import Spectrum
from labrun.reduction.plasma.lithium_share import NO_CATIONS
from labrun.reduction.tables.plasma_rows import plasma_row
from labrun.reduction.tables.plot import cation_fraction


@pytest.fixture(scope="module")
def with_lithium(reduced):
    for number in range(20):
        truth, reduction = reduced("train", number)
        if cation_fraction(reduction) is not None:
            return Spectrum(truth.wavelength_nm, truth.intensity), reduction
    raise AssertionError("no spectrum with lithium among the first twenty")


def test_the_table_has_the_fraction_of_the_cations(with_lithium):
    _, reduction = with_lithium
    found, row = cation_fraction(reduction), plasma_row(reduction)

    assert row["li_cation_fraction"] == [found.share]
    assert row["li_cation_fraction_err"] == [found.share_error]
    assert row["li_cation_fraction_low"] == [found.low] < [found.share]
    assert row["li_cation_fraction_high"] == [found.high] > [found.share]
    assert not NO_CATIONS & set(found.elements)


def test_the_command_says_the_number_of_the_table(with_lithium, capsys):
    from labrun.reduction.commands.spectrum import _print

    _, reduction = with_lithium
    _print(reduction)
    said = re.search(
        r"Li cation fraction ([\d.]+) ± ([\d.]+) \(atoms, of ", capsys.readouterr().out
    )

    assert float(said[1]) == pytest.approx(plasma_row(reduction)["li_cation_fraction"][0], abs=6e-4)
