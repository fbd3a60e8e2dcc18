"""What happened in a run, by what and with what: the crate's actions, programs, parameters, devices."""

from typing import Any
from urllib.parse import quote

from ..engine.run_folder import ASKED, CONTRACTS, JOURNAL, LAB
from .crate_words import Entity, name_of, ref, refs, time
from .files import PAGE, KeptFile
from .inputs import contract_file
from .material import Material
from .page import verdict
from .words import split_quantity, value

STATUS = "http://schema.org/{}ActionStatus"


def run_action(material: Material) -> Entity:
    story = material.story
    asked = [file.path for file in material.inventory.files if _is_input(material, file)]
    neither = {*asked, *(figure.path for figure in material.figures)}
    results = [file.path for file in material.inventory.files if file.path not in neither]
    entity = {
        "@id": "#run", "@type": "CreateAction", "name": f"Run of the protocol {material.name}",
        "description": _how(material),
        "instrument": refs(map(_program_id, _run_versions(material))),
        "object": refs([*map(name_of, asked), *(param["@id"] for param in params(material))]),
        "result": refs(map(name_of, results)),
        "actionStatus": STATUS.format(_status(material)),
    }  # fmt: skip
    if story.began:
        entity["startTime"] = time(story.began)
    if story.ended and material.fate != "running":
        entity["endTime"] = time(story.ended)
    if _status(material) == "Failed":
        entity["error"] = verdict(material)
    return entity


def _how(material: Material) -> str:
    spans = material.story.spans
    roles = ", ".join(f"{role} by {device}" for role, device in material.roles.items())
    told = [f"Devices in their roles: {roles or 'none'}."]
    if material.inputs.simulated:
        told.append("All devices were simulated.")
    if len(spans.lives) > 1:
        told.append(
            f"{len(spans.lives)} engines lived the run in turn; for {spans.away_s:.1f} s none did."
        )
    told.append("Who started the run is not recorded.")
    return " ".join(told)


def _status(material: Material) -> str:
    return {"succeeded": "Completed", "running": "Active"}.get(material.fate, "Failed")


def report_action(material: Material) -> Entity:
    drawn = [name_of(file.path) for file in material.figures]
    tables = [name for name in material.story.tables if (material.folder / name).is_file()]
    return {
        "@id": "#report", "@type": "CreateAction", "name": "Report and figures of the run",
        "description": "Made from the run's folder alone; can be made again at any time.",
        "instrument": ref(_program_id(material.versions["labrun"])),
        "object": refs(map(name_of, [JOURNAL, *tables])),
        "result": refs([PAGE, *drawn]),
        "endTime": time(material.made_at), "actionStatus": STATUS.format("Completed"),
    }  # fmt: skip


def _is_input(material: Material, file: KeptFile) -> bool:
    folders = [CONTRACTS, *(change.folder for change in material.story.changes)]
    asked = (material.inputs.protocol_name, LAB, ASKED)
    return file.path in asked or any(file.path.startswith(f"{folder}/") for folder in folders)


def _run_versions(material: Material) -> list[str]:
    return list(dict.fromkeys(life.labrun for life in material.story.spans.lives)) or [
        material.versions["labrun"]
    ]


def _program_id(version: str) -> str:
    return f"#labrun-{quote(version)}"


def programs(material: Material) -> list[Entity]:
    found = dict.fromkeys([*_run_versions(material), material.versions["labrun"]])
    needs = [f"{n} {v}" for n, v in material.versions.items() if n != "labrun"]
    return [
        {
            "@id": _program_id(version), "@type": "SoftwareApplication", "name": "labrun",
            "description": "Runs laboratory experiments that are written as YAML, and journals them",
            "softwareVersion": version,
            **({"softwareRequirements": needs} if version == material.versions["labrun"] else {}),
        }
        for version in found
    ]  # fmt: skip


def params(material: Material) -> list[Entity]:
    started = material.story.started
    if started is None:
        return []
    return [_param(material, name, told) for name, told in started.params.items()]


def _param(material: Material, name: str, told: Any) -> Entity:
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
    whence = "Set for this run." if material.inputs.given(name) else "The protocol's default."
    summary = str(material.inputs.param(name).get("summary", ""))
    return entity | {
        "description": f"{summary[:1].upper()}{summary[1:]}. {whence}" if summary else whence
    }


def devices(material: Material) -> list[str]:
    return sorted(set(material.roles.values()))


def device_id(device: str) -> str:
    return f"#device-{quote(device)}"


def device_entity(material: Material, device: str) -> Entity:
    inputs = material.inputs
    contract = inputs.contract_of(device)
    roles = " and ".join(role for role, played in material.roles.items() if played == device)
    entity: Entity = {
        "@id": device_id(device), "@type": "IndividualProduct", "name": device,
        "description": f"Played the role {roles}; reached by {inputs.reached_by(device) or 'unknown'}"
        + (", simulated" if inputs.simulated else ""),
    }  # fmt: skip
    boots = material.story.boots.get(device, [])
    if boots:
        entity["identifier"] = f"ledger {boots[-1].ledger}"
    path = contract_file(contract)
    if any(file.path == path for file in material.inventory.files):
        entity |= {"category": contract, "subjectOf": ref(name_of(path))}
    return entity
