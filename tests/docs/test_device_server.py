"""The page on the wire: every field and code is on it, its frames are as the models say."""

import json
import re
from pathlib import Path
from typing import get_args

from labrun.schemas.messages import (
    DeviceDescription,
    FileContent,
    Goal,
    GoalError,
    GoalReport,
    GoalState,
    LeaseRequest,
    QueryAnswer,
    Refusal,
    ServerDescription,
)

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "reference" / "device-server.md").read_text(encoding="utf-8")
FRAMES = re.findall(r"^([←→]) 4[23]/action,(\d*)(\[.*\])$", PAGE, re.M)
MODELS = (
    Goal, GoalReport, GoalError, FileContent, LeaseRequest, DeviceDescription, ServerDescription, QueryAnswer,
)  # fmt: skip
REQUESTS = {"goal": Goal, "lease": LeaseRequest}
ANSWERS = {"describe": ServerDescription, "goal": GoalReport, "query": QueryAnswer}


def test_every_field_state_and_code_is_on_the_page():
    words = set(re.findall(r"\w+", " ".join(re.findall(r"`([^`\n]+)`", PAGE))))
    fields = {name for model in MODELS for name in model.model_fields}

    assert {*fields, *get_args(GoalState), *get_args(Refusal)} - words == set()


def test_the_frames_of_the_page_are_as_the_models_say():
    asked = {}
    for way, number, text in FRAMES:
        said = json.loads(text)
        if way == "→":
            asked[number] = event = said[0]
            REQUESTS.get(event, dict)(**said[1])
        elif number and said[0].pop("ok"):
            ANSWERS.get(asked[number], dict)(**said[0])
        elif not number and said[0] == "update":
            GoalReport(**said[1])

    assert set(asked.values()) >= {
        "describe",
        "lease",
        "goal",
        "query",
        "cancel",
        "release",
        "stop",
    }


def test_the_test_on_the_page_stands_in_its_file():
    name, code = re.findall(r"```python\n# ([\w/.]+)\n(.*?)```", PAGE, re.S)[0]

    assert code in (ROOT / name).read_text(encoding="utf-8")
