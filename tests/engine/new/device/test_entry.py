"""A lab entry of what a source knows: as YAML that checks, the guessed effects marked, chosen by name."""

import pytest

from labrun.engine.lab.lab import load_lab
from labrun.engine.new.device import entry
from labrun.engine.new.device.entry import entry_text, only
from labrun.engine.new.device.sources import SOURCES, Described, described
from labrun.engine.new.protocol import CannotMake

KNOWN = Described(
    driver="ophyd",
    config={"instrument": "sim.SynAxis", "abort": "stop", "safe_state": ["stop"]},
    actions={
        "home": {"call": "home", "params": {"y": {"enum": ["on", "1", "a b"]}}, "effect": "once"},
        "read_x": {"get": "x", "returns": {"x": {"type": "number", "unit": "mm/s"}}},
        "stop": {"call": "stop", "effect": "idempotent"},
    },
    notes={"instrument": "its class"},
)


def test_it_is_yaml_that_checks_and_marks_what_is_a_guess(tmp_path):
    text = entry_text("stage", KNOWN)
    (tmp_path / "lab.yaml").write_text(f"devices:\n{text}", "utf-8")
    lab, problems = load_lab(tmp_path / "lab.yaml")

    assert problems == []
    assert lab.lab.devices["stage"].config["actions"] == KNOWN.actions
    assert "instrument: sim.SynAxis     # its class" in text
    assert text.index("read_x") < text.index("`effect` is a guess") < text.index("home")


def test_some_of_its_actions_are_chosen_by_name():
    chosen = only(KNOWN, "read_*, home")

    assert list(chosen.actions) == ["home", "read_x", "stop"]  # what ends them stays
    assert chosen.config == KNOWN.config
    with pytest.raises(
        CannotMake, match=r"no action fits Home; did you mean home\?; there is home, read_x"
    ):
        only(KNOWN, "read_x,Home")


def test_the_contract_test_is_short():
    assert 'case = Case.of_lab(Path(__file__).parent / "lab.yaml", "hot_plate")' in entry.test_text(
        "hot_plate", "lab.yaml"
    )
    assert len(entry.test_text("hot_plate", "lab.yaml").splitlines()) < 12


@pytest.mark.parametrize("scheme", SOURCES)
def test_an_instrument_that_is_not_there_is_refused_with_a_sentence(scheme):
    with pytest.raises(CannotMake, match=r"nowhere|pip install"):
        described(f"{scheme}:nowhere.Nothing")


def test_what_may_stand_after_an_address_is_said():
    with pytest.raises(CannotMake, match=r"\?insecure or \?root_certs=FILE\.pem"):
        described("sila2://10.0.0.9:50052?tls=no")
