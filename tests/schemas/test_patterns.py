"""What is plainly right is right to jsonschema, too; all else is left to jsonschema."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from labrun.schemas.contracts import shipped_contracts
from labrun.schemas.patterns import RULES, _draft, plainly_right, validator

SCHEMAS = [
    schema
    for contract in shipped_contracts().values()
    for action in contract.actions.values()
    for schema in (action.params, action.returns)
]
VALUES = st.one_of(
    st.none(), st.booleans(), st.integers(-5, 900), st.floats(-5, 900), st.text(max_size=3)
)
NAMES = sorted({name for schema in SCHEMAS for name in schema.get("properties", {})})


@given(st.sampled_from(SCHEMAS), st.dictionaries(st.sampled_from(NAMES), VALUES, max_size=3))
def test_a_validator_agrees_with_jsonschema_on_every_shipped_schema(schema, value):
    ours, theirs = validator(schema), _draft()(schema)

    assert ours.is_valid(value) == theirs.is_valid(value)
    assert [e.message for e in ours.iter_errors(value)] == [
        e.message for e in theirs.iter_errors(value)
    ]


@given(
    st.fixed_dictionaries(
        {},
        optional={
            "type": st.sampled_from(
                ["number", "integer", "string", "boolean", "object", "array", ["null", "string"]]
            ),
            "minimum": st.integers(-2, 2), "exclusiveMaximum": st.integers(-2, 2),
            "enum": st.lists(VALUES, min_size=1, max_size=3), "minProperties": st.integers(0, 2),
            "required": st.lists(st.sampled_from("abc"), max_size=2, unique=True),
            "properties": st.dictionaries(st.sampled_from("abc"), st.booleans(), max_size=2),
            "additionalProperties": st.one_of(st.booleans(), st.just({"type": "string"})),
            "items": st.sampled_from([True, {}, {"type": "string"}, {"minimum": 0}]),
            "pattern": st.just("^a"), "not": st.just({"type": "number"}),
        },
    ),
    st.one_of(
        VALUES, st.lists(VALUES, max_size=2),
        st.dictionaries(st.sampled_from("abcd"), VALUES, max_size=3),
    ),
)  # fmt: skip
def test_what_is_plainly_right_is_right(schema, value):
    if plainly_right(schema, value):
        assert _draft()(schema).is_valid(value)


@pytest.mark.parametrize(
    ("schema", "value"),
    [
        ({"type": "number", "minimum": 0, "unit": "mm"}, 3),
        ({"type": "string", "enum": ["a", "b"]}, "b"),
        ({"type": "array", "items": {"type": "string", "pattern": "^[A-Z]"}}, ["Li", "K"]),
        ({"type": "object", "properties": {"x": {"type": "number"}}, "required": ["x"]}, {"x": 1}),
    ],
)
def test_what_devices_are_usually_sent_is_plainly_right(schema, value):
    assert plainly_right(schema, value)
    assert schema.keys() <= {*RULES, "unit"}
