"""Write the JSON Schemas of everything that crosses a boundary, and the contracts as JSON.

`python -m labrun.schemas.generate` writes them into `schemas/json/` and `schemas/devices/`; a test
compares them.
"""

import json
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter

from .contract import Contract
from .contracts import READ, contracts_as_json
from .event import Event
from .journal import RECORD
from .lab import Lab
from .messages import Goal, GoalReport, LeaseRequest, QueryAnswer, ServerDescription
from .problem import Problem
from .protocol import protocol_as_json_schema

DIALECT = "https://json-schema.org/draft/2020-12/schema"
FOLDER = Path(__file__).parent / "json"
CONTRACTS = Path(__file__).parent / "devices" / READ

MODELS: dict[str, TypeAdapter[Any]] = {
    "contract": TypeAdapter(Contract),
    "lab": TypeAdapter(Lab),
    "problem": TypeAdapter(Problem),
    "journal_record": RECORD,
    "event": TypeAdapter(Event),
    "goal": TypeAdapter(Goal),
    "goal_report": TypeAdapter(GoalReport),
    "lease_request": TypeAdapter(LeaseRequest),
    "query_answer": TypeAdapter(QueryAnswer),
    "server_description": TypeAdapter(ServerDescription),
}
NAMES = ("protocol", *MODELS)


def schema_text(name: str) -> str:
    """One schema as the text of its file."""
    model = MODELS.get(name)
    made = model.json_schema(by_alias=True) if model else protocol_as_json_schema()
    schema = {"$schema": DIALECT, **made}
    return json.dumps(schema, indent=1, ensure_ascii=False) + "\n"


def main() -> None:
    """Write them all."""
    for name in NAMES:
        (FOLDER / f"{name}.schema.json").write_text(schema_text(name), encoding="utf-8")
    CONTRACTS.write_text(contracts_as_json(), encoding="utf-8")


if __name__ == "__main__":
    main()
