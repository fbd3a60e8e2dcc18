"""A run's actions, programs, parameters and devices, as entities of the crate."""

from typing import Any
from urllib.parse import quote

from ...engine.run.folder import ASKED, CONTRACTS, JOURNAL, LAB
from .crate_text import Entity, name_of, ref, refs, time
from .files import PAGE, KeptFile
from .formatting import split_quantity, value
from .inputs import contract_file
from .page import verdict
from .report_data import ReportData

STATUS = "http://schema.org/{}ActionStatus"


def run_action(data: ReportData) -> Entity:
    digest = data.digest
    asked = [file.path for file in data.inventory.files if _is_input(data, file)]
    neither = {*asked, *(figure.path for figure in data.figures)}
    results = [file.path for file in data.inventory.files if file.path not in neither]
    entity = {
        "@id": "#run", "@type": "CreateAction", "name": f"Run of the protocol {data.name}",
        "description": _how(data),
        "instrument": refs(map(_program_id, _run_versions(data))),
        "object": refs([*map(name_of, asked), *(param["@id"] for param in params(data))]),
        "result": refs(map(name_of, results)),
        "actionStatus": STATUS.format(_status(data)),
    }  # fmt: skip
    if digest.began:
        entity["startTime"] = time(digest.began)
    if digest.ended and data.fate != "running":
        entity["endTime"] = time(digest.ended)
    if _status(data) == "Failed":
        entity["error"] = verdict(data)
    return entity


def _how(data: ReportData) -> str:
    spans = data.digest.spans
    roles = ", ".join(f"{role} by {device}" for role, device in data.roles.items())
    told = [f"Devices in their roles: {roles or 'none'}."]
    if data.inputs.simulated:
        told.append("All devices were simulated.")
    if len(spans.lives) > 1:
        told.append(
            f"{len(spans.lives)} engine sessions; for {spans.away_s:.1f} s no engine was running."
        )
    told.append("Who started the run is not recorded.")
    return " ".join(told)


def _status(data: ReportData) -> str:
    return {"succeeded": "Completed", "running": "Active"}.get(data.fate, "Failed")


def report_action(data: ReportData) -> Entity:
    drawn = [name_of(file.path) for file in data.figures]
    tables = [name for name in data.digest.tables if (data.folder / name).is_file()]
    return {
        "@id": "#report", "@type": "CreateAction", "name": "Report and figures of the run",
        "description": "Made from the run's folder alone; can be remade at any time.",
        "instrument": ref(_program_id(data.versions["labrun"])),
        "object": refs(map(name_of, [JOURNAL, *tables])),
        "result": refs([PAGE, *drawn]),
        "endTime": time(data.made_at), "actionStatus": STATUS.format("Completed"),
    }  # fmt: skip


def _is_input(data: ReportData, file: KeptFile) -> bool:
    folders = [CONTRACTS, *(change.folder for change in data.digest.changes)]
    asked = (data.inputs.protocol_name, LAB, ASKED)
    return file.path in asked or any(file.path.startswith(f"{folder}/") for folder in folders)


def _run_versions(data: ReportData) -> list[str]:
    return list(dict.fromkeys(life.labrun for life in data.digest.spans.lives)) or [
        data.versions["labrun"]
    ]


def _program_id(version: str) -> str:
    return f"#labrun-{quote(version)}"


def programs(data: ReportData) -> list[Entity]:
    found = dict.fromkeys([*_run_versions(data), data.versions["labrun"]])
    needs = [f"{n} {v}" for n, v in data.versions.items() if n != "labrun"]
    return [
        {
            "@id": _program_id(version), "@type": "SoftwareApplication", "name": "labrun",
            "description": "Runs laboratory experiments written as YAML and keeps a journal of them",
            "softwareVersion": version,
            **({"softwareRequirements": needs} if version == data.versions["labrun"] else {}),
        }
        for version in found
    ]  # fmt: skip


def params(data: ReportData) -> list[Entity]:
    started = data.digest.started
    if started is None:
        return []
    return [_param(data, name, told) for name, told in started.params.items()]


def _param(data: ReportData, name: str, told: Any) -> Entity:
    entity: Entity = {"@id": f"#param-{quote(name)}", "@type": "PropertyValue", "name": name}
    if isinstance(told, dict) and "$quantity" in told:
        magnitude, unit = split_quantity(told)
        number = told["$quantity"][0]
        entity |= {
            "value": number if isinstance(number, int | float) else magnitude,
            "unitText": unit,
        }
    else:
        entity["value"] = told if isinstance(told, str | int | float | bool) else value(told)
    origin = "Set for this run." if data.inputs.given(name) else "The protocol's default."
    summary = str(data.inputs.param(name).get("summary", ""))
    return entity | {
        "description": f"{summary[:1].upper()}{summary[1:]}. {origin}" if summary else origin
    }


def devices(data: ReportData) -> list[str]:
    return sorted(set(data.roles.values()))


def device_id(device: str) -> str:
    return f"#device-{quote(device)}"


def device_entity(data: ReportData, device: str) -> Entity:
    inputs = data.inputs
    contract = inputs.contract_of(device)
    roles = " and ".join(role for role, played in data.roles.items() if played == device)
    entity: Entity = {
        "@id": device_id(device), "@type": "IndividualProduct", "name": device,
        "description": f"Played the role {roles}; reached by {inputs.reached_by(device) or 'unknown'}"
        + (", simulated" if inputs.simulated else ""),
    }  # fmt: skip
    boots = data.digest.boots.get(device, [])
    if boots:
        entity["identifier"] = f"ledger {boots[-1].ledger}"
    path = contract_file(contract)
    if any(file.path == path for file in data.inventory.files):
        entity |= {"category": contract, "subjectOf": ref(name_of(path))}
    return entity
