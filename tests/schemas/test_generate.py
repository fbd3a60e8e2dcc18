"""The committed JSON Schemas are those of the models."""

import jsonschema
import pytest

from labrun.schemas.contracts import contracts_as_json
from labrun.schemas.generate import CONTRACTS, FOLDER, NAMES, schema_text


@pytest.mark.parametrize("name", NAMES)
def test_a_committed_schema_is_the_model_s_own(name):
    committed = (FOLDER / f"{name}.schema.json").read_text(encoding="utf-8")

    assert committed == schema_text(name), "run `python -m labrun.schemas.generate`"


@pytest.mark.parametrize("name", NAMES)
def test_every_schema_is_a_valid_2020_12_schema(name):
    import json

    jsonschema.Draft202012Validator.check_schema(json.loads(schema_text(name)))


def test_no_schema_is_left_behind_by_a_model_that_is_gone():
    committed = {path.name.removesuffix(".schema.json") for path in FOLDER.glob("*.json")}

    assert committed == set(NAMES)


def test_the_contracts_as_json_are_those_in_yaml():
    committed = CONTRACTS.read_text(encoding="utf-8")

    assert committed == contracts_as_json(), "run `python -m labrun.schemas.generate`"
