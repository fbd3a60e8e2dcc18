"""The run as an RO-Crate 1.1 after the profile Process Run Crate 0.5: what made what, for machines."""

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
from .crate_words import (
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
)  # fmt: skip
from .files import CRATE, PAGE, KeptFile, look
from .material import Material
from .page import verdict

CONTEXT = [
    f"{SPECIFICATION}/context",
    {"sha256": "http://schema.org/sha256"},
]


def crate_text(material: Material) -> str:
    """The crate's metadata file; call it when the page is written, since it holds its hash."""
    graph = [_descriptor(), _root(material), *_about(material), *_data(material)]
    return json.dumps({"@context": CONTEXT, "@graph": graph}, indent=1, ensure_ascii=False) + "\n"


def _descriptor() -> Entity:
    return {
        "@id": CRATE, "@type": "CreativeWork",
        "conformsTo": ref(SPECIFICATION), "about": ref("./"),
    }  # fmt: skip


def _root(material: Material) -> Entity:
    top = [file.path for file in material.inventory.files if "/" not in file.path]
    folders = sorted(_folders(material))
    parts = [*map(name_of, top), PAGE, *(f"{name_of(name)}/" for name in folders)]
    used = [device_id(device) for device in devices(material)]
    return {
        "@id": "./", "@type": "Dataset", "conformsTo": ref(PROFILE),
        "name": f"{material.name} ({material.folder.name})",
        "description": f"{material.inputs.protocol.get('summary', '')} {verdict(material)} {ABOUT}".strip(),
        "identifier": material.folder.name,
        "datePublished": time(material.story.ended or material.made_at),
        "license": ref("#licence"),
        "hasPart": refs(parts),
        "mentions": refs(["#run", "#report", *used]),
    }  # fmt: skip


def _about(material: Material) -> list[Entity]:
    return [
        {"@id": PROFILE, "@type": "CreativeWork", "name": "Process Run Crate", "version": "0.5"},
        {"@id": "#licence", "@type": "CreativeWork", **LICENCE},
        run_action(material),
        report_action(material),
        *programs(material),
        *params(material),
        *(device_entity(material, device) for device in devices(material)),
    ]


def _data(material: Material) -> list[Entity]:
    page = look(material.folder, PAGE)
    held = [_file(material, file) for file in [*material.inventory.files, page]]
    return [*held, *(_folder(name, paths) for name, paths in sorted(_folders(material).items()))]


def _file(material: Material, file: KeptFile) -> Entity:
    told = described(file, material.story.writers.get(file.path, ""), material.inputs.protocol_name)
    entity: Entity = {
        "@id": name_of(file.path), "@type": "File", "name": file.path,
        "encodingFormat": file.format,
    }  # fmt: skip
    if told:
        entity["description"] = told
    if not file.fault:
        entity |= {"contentSize": str(file.size), "sha256": file.sha256}
    return entity


def _folders(material: Material) -> dict[str, list[str]]:
    found: dict[str, list[str]] = {}
    for file in material.inventory.files:
        if "/" in file.path:
            found.setdefault(file.path.rpartition("/")[0], []).append(file.path)
    return found


def _folder(name: str, paths: list[str]) -> Entity:
    return {
        "@id": f"{name_of(name)}/", "@type": "Dataset", "name": name,
        "description": FOLDERS.get(name, "Files that devices delivered"),
        "hasPart": refs(map(name_of, paths)),
    }  # fmt: skip
