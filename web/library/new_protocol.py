"""New protocols: from a template, a text, another protocol, or the protocol of a past run."""

from collections.abc import Callable
from pathlib import Path

from ...engine.check import check_text
from ...engine.lab.lab import LoadedLab
from ...engine.new.protocol import TEMPLATES, CannotMake, new_protocol, protocol_name, template_text
from ...engine.run.folder import FolderFault, protocol_file
from ..local.refusal import Refusal
from ..models.protocols import NewProtocol, ProtocolText, Template
from .library import Library


class NewProtocols:
    """Creates files in the library; `run_place` gives the folder of a run, or refuses."""

    def __init__(
        self,
        library: Library,
        lab: LoadedLab,
        lab_file: Path | None,
        run_place: Callable[[str], Path],
    ) -> None:
        self._library = library
        self._lab = lab
        self._lab_file = lab_file
        self._run_place = run_place

    def templates(self) -> list[Template]:
        """The templates to start from."""
        return [Template(name=name, summary=summary) for name, summary in TEMPLATES.items()]

    async def make(self, asked: NewProtocol) -> ProtocolText:
        """A new file; its name gets a suffix if it has none."""
        given = [asked.template, asked.text, asked.copy_of, asked.run]
        if sum(one is not None for one in given) > 1:
            raise Refusal(422, "INVALID", "give one of template, text, copy_of and run")
        name, text = self._named(asked), self._text(asked)
        return self._library.create(name, text)

    def _named(self, asked: NewProtocol) -> str:
        folder, mark, file = asked.name.rpartition("/")
        try:
            plain = protocol_name(file.removesuffix(".json"))
        except CannotMake as fault:
            raise Refusal(422, "WRONG_NAME", str(fault)) from fault
        suffix = ".json" if file.endswith(".json") else ".yaml"
        return f"{folder}{mark}{plain}{suffix}"

    def _text(self, asked: NewProtocol) -> str:
        if asked.text is not None:
            if "\0" in asked.text or "\ufffd" in asked.text:  # what a browser makes of other bytes
                raise Refusal(422, "NO_TEXT", f"{asked.name} is not UTF-8 text: not a protocol")
            return asked.text
        if asked.copy_of is not None:
            return self._library.read(asked.copy_of).text
        if asked.run is not None:
            return self._of_run(asked.run)
        return self._from_template(asked.name, asked.template or "minimal")

    def _of_run(self, run: str) -> str:
        folder = self._run_place(run)
        try:
            return protocol_file(folder).read_text(encoding="utf-8")
        except (FolderFault, OSError) as fault:
            raise Refusal(409, "UNREADABLE", f"the protocol of {run} does not exist") from fault

    def _from_template(self, name: str, template: str) -> str:
        try:
            example = check_text(template_text(template), f"{template}.yaml", lab=self._lab_file)
            if example.protocol is None:
                raise CannotMake(f"the template {template} does not fit this lab")
            plain = protocol_name(name.rpartition("/")[2])
            return new_protocol(plain, template, example.protocol, self._lab).text
        except CannotMake as fault:
            raise Refusal(422, "NO_TEMPLATE", str(fault)) from fault
