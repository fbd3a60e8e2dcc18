"""The schema for editors accepts what the checker accepts, and finds what a schema can find."""

import copy
import json
import random
import re
from functools import cache
from pathlib import Path
from typing import Any, get_args

import pytest
from jsonschema import Draft202012Validator
from jsonschema.exceptions import best_match

from labrun.engine.check import CHECKS, check_text
from labrun.engine.lab.lab import load_lab
from labrun.engine.lab_schema.models import closed
from labrun.engine.lab_schema.schema import lab_schema, schema_text
from labrun.engine.lab_schema.snippets import SNIPPETS
from labrun.engine.lab_schema.words import CHOICES, WORDS, words_for
from labrun.engine.language.source import parse_source
from labrun.schemas.protocol import (
    STEP_KINDS,
    Defaults,
    KeepGoing,
    Param,
    Protocol,
    Retry,
    StepBase,
    Until,
    Watch,
)

HERE = Path(__file__).parents[1]
ROOT = HERE.parents[1]
SHIPPED = [
    *sorted((ROOT / "protocols").glob("*.yaml")),
    *sorted((ROOT / "protocols").glob("*.json")),
    *sorted((HERE / "examples").glob("*.yaml")),
]
FAULTY = sorted((HERE / "faulty").glob("*.yaml"))
STRUCTURAL = {
    "E110", "E111", "E112", "E113", "E114", "E115", "E117", "E201", "E202", "E203", "E205", "E206",
}  # fmt: skip
UNSEEN = {
    "yaml_key_is_a_list": "JSON has no such key: an editor refuses the YAML before it asks the schema",
    "argument_number_of_a_loop_over_texts": "what an expression is, only the checker computes",
    "overlap_order_of_one_after_the_other": "which keys go together, only the checker knows",
    "use_a_broken_protocol": "the fault is in another file",
}
"""Faulty protocols of these codes that no schema can detect -> why."""

HEAD = "labrun: 1\nname: t\ndevices: {gantry: gantry@1, libs: libs_analyzer@1}\n"


@cache
def schema(lab: Path | None = None) -> dict[str, Any]:
    loaded, problems = load_lab(lab)
    assert loaded is not None and problems == []
    return lab_schema(loaded)


@cache
def validator(lab: Path | None = None) -> Draft202012Validator:
    return Draft202012Validator(schema(lab))


def faults(data: Any, lab: Path | None = None) -> list[Any]:
    return list(validator(lab).iter_errors(data))


def data_of(text: str) -> Any:
    """The data of YAML text; None if it is not YAML, which an editor reports by itself."""
    source, _ = parse_source(text, Path("t.yaml"), "t.yaml")
    return None if source is None else source.data


def told(text: str, lab: Path | None = None) -> tuple[str, str]:
    """The place and keyword of the most relevant fault found by a standard validator."""
    best = best_match(iter(faults(data_of(text), lab)))
    return ("", "") if best is None else ("/".join(map(str, best.absolute_path)), best.validator)


def nodes(node: Any) -> list[dict[str, Any]]:
    inner = (
        list(node.values()) if isinstance(node, dict) else node if isinstance(node, list) else []
    )
    return [node] * isinstance(node, dict) + [found for value in inner for found in nodes(value)]


# --- the schema itself


def test_the_schema_is_valid_whole_small_and_the_same_every_time():
    loaded, _ = load_lab(None)
    made = schema()
    text = schema_text(loaded)
    wanted = {n["$ref"] for n in nodes(made) if "$ref" in n}
    Draft202012Validator.check_schema(made)

    assert all(name.startswith("#/$defs/") for name in wanted)
    assert {f"#/$defs/{name}" for name in made["$defs"]} == wanted
    assert len(text.encode()) < 400_000
    assert text == schema_text(load_lab(None)[0]) and json.loads(text) == made


def test_every_pattern_is_one_that_python_and_javascript_read_alike():
    patterns = {n["pattern"] for n in nodes(schema()) if isinstance(n.get("pattern"), str)}

    for pattern in patterns:
        re.compile(pattern)
        assert not re.search(r"\(\?P|\(\?<|\\Z|\\A|\(\?i", pattern)


@pytest.mark.parametrize(
    "model",
    [Protocol, Param, Defaults, Retry, KeepGoing, Until, Watch, StepBase, *STEP_KINDS],
    ids=lambda m: m.__name__,
)
def test_every_key_of_a_model_is_there_with_words(model):
    shape = closed(model)
    keys = {field.alias or name for name, field in model.model_fields.items()}

    assert set(shape["properties"]) == keys
    assert shape["additionalProperties"] is False
    assert all(words_for(model, key) for key in keys)


def test_no_word_is_left_of_a_key_that_is_gone():
    models = [Protocol, Param, Defaults, Retry, KeepGoing, Until, Watch, *STEP_KINDS]
    keys = {f.alias or n for m in models for n, f in m.model_fields.items()}
    full = {f"{m.__name__}.{f.alias or n}" for m in models for n, f in m.model_fields.items()}

    assert set(WORDS) | set(CHOICES) <= keys | full


def test_every_choice_has_its_words():
    assert set(CHOICES["Param.type"]) == set(get_args(Param.model_fields["type"].annotation))
    for made in nodes(schema()):
        if "enumDescriptions" in made:
            assert len(made["enumDescriptions"]) == len(made["enum"])


@pytest.mark.parametrize("snippet", SNIPPETS, ids=lambda snippet: snippet["label"])
def test_a_snippet_that_is_filled_in_is_in_order(snippet):
    body = re.sub(r"\$\{\d:([^}]*)\}", r"\1", json.dumps(snippet["body"]))
    step = json.loads(body.replace("\\\\$", "$").replace("role.action", "gantry.home", 1))
    step = json.loads(json.dumps(step).replace("role.action", "libs.locate"))
    protocol = {
        "labrun": 1,
        "name": "t",
        "devices": {"gantry": "gantry@1", "libs": "libs_analyzer@1"},
    }

    assert faults({**protocol, "steps": [step]}) == []
    assert check_text(json.dumps({**protocol, "steps": [step]}), "t.json").ok


# --- what it accepts


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.name)
def test_every_shipped_protocol_passes(path):
    assert faults(data_of(path.read_text(encoding="utf-8"))) == []


def fragments() -> list[str]:
    """Every protocol in the manual pages and the docs, and every faulty one that only warns."""
    pages = [block for family in CHECKS for block in indented(family.__doc__ or "")]
    for path in [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]:
        pages += re.findall(r"^```ya?ml\n(.*?)^```", path.read_text(encoding="utf-8"), re.M | re.S)
    pages = [
        p if "labrun: 1" in p else f"labrun: 1\nname: page\n{p}" for p in pages if "steps:" in p
    ]
    return pages + [path.read_text(encoding="utf-8") for path in FAULTY]


def indented(text: str) -> list[str]:
    blocks = re.findall(r"(?:^    .*\n|^\n)+", text, re.M)
    return ["\n".join(line[4:] for line in block.splitlines()).strip() + "\n" for block in blocks]


@pytest.mark.soak
def test_every_fragment_that_the_checker_lets_pass_passes():
    passing = [text for text in fragments() if check_text(text, "page.yaml").ok]
    refused = {text: told(text) for text in passing if told(text) != ("", "")}

    assert refused == {}
    assert len(passing) > 15


def mutants(count: int, seed: int) -> list[Any]:
    """Shipped protocols with one value removed, renamed, or replaced by another from the file."""
    chance = random.Random(seed)
    whole = [data_of(path.read_text(encoding="utf-8")) for path in SHIPPED]
    made = []
    for _ in range(count):
        data = copy.deepcopy(chance.choice(whole))
        holders = [n for n in nodes(data) if n]
        around, other = chance.choice(holders), chance.choice(holders)
        key, theirs = chance.choice(list(around)), chance.choice(list(other))
        if chance.random() < 0.3:
            del around[key]
        elif chance.random() < 0.3:
            around[chance.choice([key + "x", theirs])] = around.pop(key)
        else:
            others = [other[theirs], 3, -1, 2.5, True, "text", "4 s", "1 mm", "${{ 1 }}", [], {}]
            around[key] = copy.deepcopy(chance.choice(others))
        made.append(data)
    return made


@pytest.mark.soak
def test_a_mutant_that_the_checker_lets_pass_passes_and_most_structural_faults_are_seen():
    seen = structural = 0
    for mutant in mutants(150, seed=4):
        text = json.dumps(mutant)
        checked = check_text(text, "mutant.json")
        found = faults(mutant)
        if checked.ok:
            assert found == [], text
        elif STRUCTURAL & {p.code for p in checked.problems if p.severity == "error"}:
            structural += 1
            seen += bool(found)

    assert structural > 30
    assert seen / structural > 0.9


VALID = """
- {do: gantry.move_to, with: {x: 1, y: "${{ 1 mm }}", z: 2 mm}}
- {do: gantry.move_to, with: {x: 0.1 inch, feed: 10 mm/min}, timeout: "${{ 2 * 3 }}", when: false}
- {do: gantry.home, retry: 3, timeout: 20, fallback: [{do: gantry.home}, [{log: a}, {fail: b}]]}
- {do: gantry.home, retry: {attempts: 3, wait: 1 s, factor: 2, on: [Timeout, HomingFailed]}}
- {any: [{do: gantry.home}, {steps: [{do: libs.locate}]}]}
- {parallel: [{do: gantry.home}, {do: libs.locate}], on_failure: cancel}
- {repeat: 3, steps: [{log: a}]}
- {repeat: "${{ 3 }}", keep_going: {max_failed: 1}, steps: [{log: a}], collect: {a: 1}}
- {while: "${{ true }}", max: 4, steps: [{log: a}]}
- {if: "${{ true }}", then: [{log: a}], else: [{log: b}]}
- {use: ./other.yaml, with: {x: 1 mm, any: [1]}, devices: {stage: gantry}}
- {foreach: {p: [1, 2]}, key: "${{ p }}", steps: [{log: "${{ p }}"}]}
- {confirm: Ready?, timeout: 5 min}
- {ask: Which?, choices: [a, b]}
- {wait: 100 ms}
- {set: {a: 1 mm, b: "${{ 2 }}", c: [1, {d: 2}]}}
- {require: "${{ true }}"}
- {id: a, name: The end, log: done, on_error: pause, on_unknown: ask}
""".strip().splitlines()


@pytest.mark.parametrize("step", VALID)
def test_every_kind_of_step_passes(step):
    assert told(f"{HEAD}steps:\n  {step}\n") == ("", "")


# --- what it finds


@pytest.mark.parametrize("path", FAULTY, ids=lambda path: path.stem)
def test_every_structural_fault_of_the_corpus_is_seen(path):
    text = path.read_text(encoding="utf-8")
    codes = set(re.findall(r"[EW]\d{3}", text.splitlines()[0]))
    data = data_of(text)
    if not codes & STRUCTURAL or data is None or path.stem in UNSEEN:
        return

    assert faults(data), "no schema can see it? then say why in UNSEEN"


def test_the_list_of_unseen_faults_is_true():
    for name in UNSEEN:
        assert faults(data_of((HERE / "faulty" / f"{name}.yaml").read_text())) == []


MISTAKES = {
    "steps:\n  - doo: gantry.home": ("steps/0", "additionalProperties"),
    "steps:\n  - {do: gantry.home, wait: 3 s}": ("steps/0", "additionalProperties"),
    "steps:\n  - {do: gantry.hoem}": ("steps/0/do", "anyOf"),
    "steps:\n  - {do: gantri.home}": ("steps/0/do", "pattern"),
    "steps:\n  - {do: balance.zero}": ("steps/0/do", "pattern"),
    "steps:\n  - {do: gantry.move_to, with: {x: 4 s}}": ("steps/0/with/x", "pattern"),
    "steps:\n  - {do: gantry.move_to, with: {x: 731}}": ("steps/0/with/x", "maximum"),
    "steps:\n  - {do: gantry.move_to, with: {fed: 3}}": ("steps/0/with", "additionalProperties"),
    "steps:\n  - {do: libs.export, with: {shot: a}}": ("steps/0/with", "required"),
    "steps:\n  - do: libs.export": ("steps/0", "required"),
    "steps:\n  - steps: [{repeat: 2, steps: [{do: gantry.home, retry: often}]}]": (
        "steps/0/steps/0/steps/0/retry",
        "type",
    ),
    "steps:\n  - {do: gantry.home, timeout: 5 mm}": ("steps/0/timeout", "pattern"),
    "steps:\n  - {log: a, when: params.ready}": ("steps/0/when", "pattern"),
    "steps:\n  - {log: a, on_error: contnue}": ("steps/0/on_error", "enum"),
    "steps:\n  - {foreach: {i: 5}, steps: [{log: a}]}": ("steps/0/foreach/i", "type"),
    "steps:\n  - {log: a, fallback: [{ask: b, choices: [again]}]}": (
        "steps/0/fallback/0/choices/0",
        "enum",
    ),
    "steps:\n  - {log: a, fallback: [[{do: gantry.hoem}]]}": ("steps/0/fallback/0/0/do", "anyOf"),
    "steps: [{log: a}]\nfinally:\n  - {do: libs.dsarm}": ("finally/0/do", "anyOf"),
    "steps: [{log: a}]\nparams: {a: {type: quantity, default: 2 mm}}": ("params/a", "required"),
    "steps: [{log: a}]\nparams: {a: {type: number, unit: mm}}": ("params/a/unit", "type"),
    "steps: [{log: a}]\noutput: {a: 1}": ("", "additionalProperties"),
}


@pytest.mark.parametrize("body", MISTAKES)
def test_the_best_match_of_a_stock_validator_points_at_the_mistake(body):
    assert told(f"{HEAD}{body}\n") == MISTAKES[body]


def test_a_typical_mistake_is_one_fault_and_not_a_heap_of_them():
    for body in MISTAKES:
        if "gantry.home, retry" not in body:
            assert len(faults(data_of(f"{HEAD}{body}\n"))) <= 2, body


def test_roles_of_other_names_are_judged_by_the_action_alone():
    head = "labrun: 1\nname: t\ndevices: {scale: balance@1, gantry: gantry@1}\nsteps:\n  - "

    assert told(f"{head}{{do: scale.weigh, with: {{patience: 5 s}}}}") == ("", "")
    assert (
        told(f"{head}{{do: scale.weigh, with: {{patience: 5 mm}}}}")[0] == "steps/0/with/patience"
    )
    assert told(f"{head}{{do: scale.wiegh}}")[0] == "steps/0/do"
    assert told(f"{head}{{do: gantry.weigh}}")[0] == "steps/0/do"


def test_a_role_with_the_name_of_a_device_but_another_contract_is_not_judged_by_the_device():
    head = "labrun: 1\nname: t\ndevices: {gantry: balance@1}\nsteps:\n  - "

    assert told(f"{head}{{do: gantry.weigh}}") == ("", "")


# --- a lab with a contract and limits of its own

FURNACE = """
type: oven@1
summary: A tube furnace
actions:
  heat:
    summary: Go to a temperature
    danger: heat
    params:
      type: object
      required: [to]
      properties:
        to: {type: number, unit: degC, minimum: 20, maximum: 1200, description: The setpoint}
        rate: {type: number, unit: degC/min, exclusiveMinimum: 0}
        gas: {type: string, enum: [argon, air]}
        label: {type: string, pattern: "^[a-z]+$"}
        steps: {type: array, items: {type: object, properties: {hold: {type: number, unit: min}}}}
        quick: {type: boolean}
        odd: {oneOf: [{type: number}, {type: string}]}
  cool: {summary: Let it cool}
"""
LAB = """
name: ovens
contracts: [./furnace.yaml]
devices:
  oven: {contract: oven@1, url: "http://127.0.0.1:9", limits: {to: {minimum: 400 K, maximum: 900}}}
  stage: {contract: gantry@1, driver: sim_gantry, limits: {x: {maximum: 4 cm}, y: {minimum: 5}}}
"""


@pytest.fixture
def ovens(tmp_path):
    (tmp_path / "furnace.yaml").write_text(FURNACE)
    (tmp_path / "lab.yaml").write_text(LAB)
    return tmp_path / "lab.yaml"


def test_a_lab_with_a_contract_and_limits_of_its_own_narrows_the_ranges(ovens):
    made = schema(ovens)
    Draft202012Validator.check_schema(made)
    to = made["$defs"]["with-oven.heat"]["properties"]["to"]
    move = made["$defs"]["with-stage.move_to"]["properties"]

    assert (to["minimum"], to["maximum"]) == (pytest.approx(126.85), 900)
    assert to["description"] == "The setpoint. A temperature (degC), 126.85..900 degC."
    assert (move["x"]["minimum"], move["x"]["maximum"]) == (0, 40)
    assert (move["y"]["minimum"], move["y"]["maximum"]) == (5, 810)
    assert made["properties"]["devices"]["$ref"] == "#/$defs/devices"
    assert made["$defs"]["devices"]["additionalProperties"]["enum"] == ["oven@1", "gantry@1"]


@pytest.mark.parametrize(
    ("given", "place"),
    [
        ("to: 500 degC, rate: 5 degC/min, gas: argon, label: abc, quick: true", ""),
        (
            "to: '${{ 1 }}', gas: '${{ 1 }}', label: '${{ 1 }}', quick: '${{ 1 }}', odd: '${{ 1 }}'",
            "",
        ),
        ("to: 500, steps: [{hold: 5 min}, '${{ 1 }}']", ""),
        ("to: 500, steps: '${{ 1 }}', odd: [anything]", ""),
        ("to: 1000", "to"),
        ("to: 100", "to"),
        ("to: 5 mm", "to"),
        ("to: hot", "to"),
        ("to: 500, gas: helium", "gas"),
        ("to: 500, label: A1", "label"),
        ("to: 500, quick: 'yes'", "quick"),
        ("to: 500, rate: 0", "rate"),
        ("to: 500, steps: [{hold: 5 mm}]", "steps/0/hold"),
        ("to: 500, steps: many", "steps"),
    ],
)
def test_the_arguments_of_a_contract_of_its_own(ovens, given, place):
    text = f"labrun: 1\nname: t\ndevices: {{oven: oven@1}}\nsteps: [{{do: oven.heat, with: {{{given}}}}}]"
    where = told(text, ovens)[0]

    assert where == (f"steps/0/with/{place}" if place else "")


def test_two_labs_speak_of_their_own_devices_only(ovens):
    own = "labrun: 1\nname: t\ndevices: {oven: oven@1}\nsteps: [{do: oven.cool}]"

    assert told(own, ovens) == ("", "")
    assert told(own)[0] == "devices/oven"
    assert told(f"{HEAD}steps: [{{do: libs.locate}}]", ovens)[0] == "devices/libs"
