"""The run as an RO-Crate 1.1 with the Process Run Crate 0.5 profile: what made what, for machines."""

import json

from .crate_run import (
    device_entity,
    device_id,
    devices,
    params,
    programs,
    report_action,
    run_action,
)
from .crate_text import (  # fmt: skip
    ABOUT,
    FOLDERS,
    LICENCE,
    PROFILE,
    SPECIFICATION,
    Entity,
    described,
    name_of,
    ref,
    refs,
    time,
)
from .files import CRATE, PAGE, KeptFile, look
from .page import verdict
from .report_data import ReportData

CONTEXT = [
    f"{SPECIFICATION}/context",
    {"sha256": "http://schema.org/sha256"},
]


def crate_text(data: ReportData) -> str:
    """The crate's metadata file; call it after the page is written, because it holds its hash."""
    graph = [_descriptor(), _root(data), *_about(data), *_data(data)]
    return json.dumps({"@context": CONTEXT, "@graph": graph}, indent=1, ensure_ascii=False) + "\n"


def _descriptor() -> Entity:
    return {
        "@id": CRATE, "@type": "CreativeWork",
        "conformsTo": ref(SPECIFICATION), "about": ref("./"),
    }  # fmt: skip


def _root(data: ReportData) -> Entity:
    top = [file.path for file in data.inventory.files if "/" not in file.path]
    folders = sorted(_folders(data))
    parts = [*map(name_of, top), PAGE, *(f"{name_of(name)}/" for name in folders)]
    used = [device_id(device) for device in devices(data)]
    return {
        "@id": "./", "@type": "Dataset", "conformsTo": ref(PROFILE),
        "name": f"{data.name} ({data.folder.name})",
        "description": f"{data.inputs.protocol.get('summary', '')} {verdict(data)} {ABOUT}".strip(),
        "identifier": data.folder.name,
        "datePublished": time(data.digest.ended or data.made_at),
        "license": ref("#licence"),
        "hasPart": refs(parts),
        "mentions": refs(["#run", "#report", *used]),
    }  # fmt: skip


def _about(data: ReportData) -> list[Entity]:
    return [
        {"@id": PROFILE, "@type": "CreativeWork", "name": "Process Run Crate", "version": "0.5"},
        {"@id": "#licence", "@type": "CreativeWork", **LICENCE},
        run_action(data),
        report_action(data),
        *programs(data),
        *params(data),
        *(device_entity(data, device) for device in devices(data)),
    ]


def _data(data: ReportData) -> list[Entity]:
    page = look(data.folder, PAGE)
    held = [_file(data, file) for file in [*data.inventory.files, page]]
    return [*held, *(_folder(name, paths) for name, paths in sorted(_folders(data).items()))]


def _file(data: ReportData, file: KeptFile) -> Entity:
    told = described(file, data.digest.writers.get(file.path, ""), data.inputs.protocol_name)
    entity: Entity = {
        "@id": name_of(file.path), "@type": "File", "name": file.path,
        "encodingFormat": file.format,
    }  # fmt: skip
    if told:
        entity["description"] = told
    if not file.fault:
        entity |= {"contentSize": str(file.size), "sha256": file.sha256}
    return entity


def _folders(data: ReportData) -> dict[str, list[str]]:
    found: dict[str, list[str]] = {}
    for file in data.inventory.files:
        if "/" in file.path:
            found.setdefault(file.path.rpartition("/")[0], []).append(file.path)
    return found


def _folder(name: str, paths: list[str]) -> Entity:
    return {
        "@id": f"{name_of(name)}/", "@type": "Dataset", "name": name,
        "description": FOLDERS.get(name, "Files that devices delivered"),
        "hasPart": refs(map(name_of, paths)),
    }  # fmt: skip
