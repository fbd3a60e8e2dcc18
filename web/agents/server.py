"""The MCP server: every call is logged, answered one at a time, and refused in a sentence."""

import asyncio
import json
import logging
from pathlib import Path
from typing import Any

from mcp.server import MCPServer  # pyright: ignore[reportMissingImports]
from mcp.server.mcpserver.exceptions import ToolError  # pyright: ignore[reportMissingImports]
from pydantic import ValidationError

from ... import __version__
from ...engine.python_api.faults import Refused as NotDone
from ...engine.run.folder import FolderFault
from ...schemas.model import first_fault
from ..local.clock import now_iso
from ..local.refusal import Refusal
from ..local.workers import WorkFailed
from ..models.base import FoundProblem
from .tools import Tools

LOG = logging.getLogger("labrun")
LONGEST_LOGGED = 2000
ABOUT = """labrun runs laboratory experiments that are written as YAML on real instruments.
Read `contracts` and an existing protocol first; write, check, rehearse. You cannot release a protocol, arm a
device, or confirm or answer anything: a person does. When a protocol is ready, ask the person to
release it, on the page of `labrun web` or by `labrun release FILE -p NAME=VALUE` in a terminal; then
`releases` lists it, and `launch` starts it once."""


class Server(MCPServer):
    """Tools of one folder of protocols; `log` gets a line for each call."""

    def __init__(self, tools: Tools, log: Path) -> None:
        super().__init__("labrun", instructions=ABOUT, version=__version__, log_level="ERROR")
        self._log = log
        self._turn = asyncio.Lock()
        for tool in tools.all():
            self.add_tool(tool, structured_output=False)

    async def call_tool(self, name: str, arguments: dict[str, Any], context: Any = None) -> Any:
        """One call at a time: what one has looked at, no other changes meanwhile."""
        async with self._turn:
            try:
                self._note(name, arguments, "asked")
                answer = await super().call_tool(name, arguments, context)
            except ToolError as fault:
                words = in_words(fault)
                self._note(name, arguments, "refused", words)
                raise ToolError(words) from None
            self._note(name, arguments, "done")
            return answer

    def _note(self, name: str, arguments: dict[str, Any], word: str, why: str = "") -> None:
        """A call that cannot be logged is not made."""
        said = json.dumps(arguments, ensure_ascii=False, default=str)[:LONGEST_LOGGED]
        line = {"at": now_iso(), "tool": name, "arguments": said, "is": word}
        line |= {"why": why} if why else {}
        try:
            self._log.parent.mkdir(parents=True, exist_ok=True)
            with self._log.open("a", encoding="utf-8", errors="replace") as file:
                file.write(json.dumps(line, ensure_ascii=False) + "\n")
        except OSError as fault:
            raise ToolError(f"{self._log} cannot be written: {fault.strerror}") from None


def in_words(fault: ToolError) -> str:
    """What an agent is told: a sentence, with the problems of a protocol below it."""
    why = fault.__cause__
    match why:
        case ValidationError():
            return first_fault(why)
        case Refusal():
            hint = f"; {why.fault.hint}" if why.fault.hint else ""
            return "\n".join([f"{why.fault.message}{hint}", *map(problem_line, why.fault.problems)])
        case FolderFault() | NotDone() | WorkFailed():
            return str(why)
        case OSError():
            return f"{why.strerror or why}: {why.filename or 'a file'}"
        case None | ToolError():
            return str(fault)
        case _:
            LOG.error("an agent's call failed", exc_info=why)
            return f"labrun's own fault ({type(why).__name__}); its log has more"


def problem_line(problem: FoundProblem) -> str:
    """As `labrun check` prints it."""
    hint = f" ({problem.hint})" if problem.hint else ""
    place = f"{problem.file}:{problem.line}:{problem.column}"
    return f"{place}: {problem.severity}[{problem.code}] {problem.message}{hint}"


async def serve(protocols: Path, runs: Path, lab: Path | None) -> None:
    """Serve until stdin ends."""
    tools = Tools(protocols, runs, lab)
    try:
        await Server(tools, protocols / ".labrun" / "agents.jsonl").run_stdio_async()
    finally:
        await tools.close()
