"""Write the lab's contracts as an interface package that colcon builds: `labrun ros --interfaces DIR`."""

from collections.abc import Iterable, Iterator
from pathlib import Path
from xml.sax.saxutils import escape

from ... import __version__
from ...engine.lab.lab import LoadedLab
from .aliases.kinds import PAPER_PACKAGE, paper_kinds
from .interfaces.kinds import ActionKind, Message, ServiceKind
from .interfaces.own_kinds import run_protocol
from .interfaces.render import file_text, message_text
from .offers.offered_lab import contract_kinds

Kind = Message | ActionKind | ServiceKind
LICENSE = "MIT"

PACKAGE_XML = """\
<?xml version="1.0"?>
<?xml-model href="http://download.ros.org/schema/package_format3.xsd" schematypens="http://www.w3.org/2001/XMLSchema"?>
<package format="3">
  <name>{name}</name>
  <version>{version}</version>
  <description>{summary}</description>
  <maintainer email="nobody@example.org">labrun</maintainer>
  <license>{license}</license>

  <buildtool_depend>ament_cmake</buildtool_depend>
  <buildtool_depend>rosidl_default_generators</buildtool_depend>
  <depend>action_msgs</depend>
  <exec_depend>rosidl_default_runtime</exec_depend>
  <member_of_group>rosidl_interface_packages</member_of_group>

  <export>
    <build_type>ament_cmake</build_type>
  </export>
</package>
"""
CMAKE = """\
# Made by `labrun ros --interfaces`; make it again when a contract changes.
cmake_minimum_required(VERSION 3.8)
project({name})

find_package(ament_cmake REQUIRED)
find_package(rosidl_default_generators REQUIRED)
find_package(action_msgs REQUIRED)

rosidl_generate_interfaces(${{PROJECT_NAME}}
{files}
  DEPENDENCIES action_msgs
)

ament_export_dependencies(rosidl_default_runtime)
ament_package()
"""


def write_interfaces(lab: LoadedLab, package: str, folder: Path) -> list[Path]:
    """The packages' folders, each below `folder`; raises OSError.

    The paper's own types are a second package if the lab uses its names.
    """
    summary = f"Actions, services and messages of the lab {lab.lab.name}"
    written = [_write(folder / package, package, summary, lab_kinds(lab, package))]
    paper = paper_kinds(lab.lab)
    if paper:
        summary = "The interfaces that the paper's programs use"
        written.append(_write(folder / PAPER_PACKAGE, PAPER_PACKAGE, summary, paper))
    return written


def lab_kinds(lab: LoadedLab, package: str) -> list[Kind]:
    """Every interface of a lab."""
    kinds: list[Kind] = [run_protocol(package)]
    for one in contract_kinds(lab, package).values():
        kinds += [one.status, *one.actions.values(), *one.services.values()]
    return kinds


def package_files(package: str, summary: str, kinds: Iterable[Kind]) -> dict[str, str]:
    """File -> its text."""
    files = dict(sorted(_interface_files(package, kinds)))
    named = "\n".join(f'  "{name}"' for name in files)
    files["package.xml"] = PACKAGE_XML.format(
        name=package, version=__version__, summary=escape(summary), license=LICENSE
    )
    files["CMakeLists.txt"] = CMAKE.format(name=package, files=named)
    return files


def _write(folder: Path, package: str, summary: str, kinds: Iterable[Kind]) -> Path:
    files = package_files(package, summary, kinds)
    for old in (
        path for kind in ("msg", "srv", "action") for path in (folder / kind).glob(f"*.{kind}")
    ):
        old.unlink()  # of a contract that the lab no longer has
    for name, text in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text, encoding="utf-8")
    return folder


def _interface_files(package: str, kinds: Iterable[Kind]) -> Iterator[tuple[str, str]]:
    for kind in kinds:
        messages = [kind] if isinstance(kind, Message) else []
        parts = kind.nested() if isinstance(kind, Message) else _nested(kind)
        for message in (*messages, *parts):
            if message.package == package:
                yield f"msg/{message.name}.msg", message_text(message)
        if not isinstance(kind, Message):
            yield f"{kind.group}/{kind.name}.{kind.group}", file_text(kind)


def _nested(kind: ActionKind | ServiceKind) -> Iterator[Message]:
    for part in kind.parts():
        yield from part.nested()
