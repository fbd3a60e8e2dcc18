"""`labrun graph FILE`: the tree of a protocol, as Mermaid or DOT."""

from pathlib import Path
from typing import Annotated

import typer

from ..views.forecast import outlook
from ..views.graph.dot import dot
from ..views.graph.mermaid import MOST_EDGES, edges, mermaid
from ..views.graph.tree import phases
from .checked_protocol import checked_file
from .options import Bind, File, Lab, Params, fail, say

WRITERS = {"mermaid": mermaid, "dot": dot}
SUFFIXES = {".mmd": "mermaid", ".mermaid": "mermaid", ".md": "mermaid", ".dot": "dot", ".gv": "dot"}
Format = Annotated[
    str | None,
    typer.Option(
        "--format", help="mermaid or dot; default: by the suffix of -o.", show_default=False
    ),
]
Output = Annotated[
    Path | None,
    typer.Option("-o", "--output", help="A file: .mmd, .md, .dot or .gv.", show_default=False),
]


def graph(
    file: File, format: Format = None, output: Output = None, lab: Lab = None, bind: Bind = None,
    param: Params = None,
) -> None:  # fmt: skip
    """Write the tree of a protocol: one node per step, not per point."""
    name = _format(format, output)
    checked = checked_file(file, lab, bind, param, needed=False)
    trees = phases(outlook(checked))
    text = WRITERS[name](trees)
    if name == "mermaid" and edges(trees) > MOST_EDGES:
        say(
            f"Mermaid draws {MOST_EDGES} arrows unless its maxEdges is raised, and this tree has "
            f"{edges(trees):,}; --format dot has no such limit"
        )
    if output is None:
        print(text, end="")
        return
    if output.suffix == ".md":
        text = f"```mermaid\n{text}```\n"
    try:
        output.write_text(text, encoding="utf-8")
    except OSError as fault:
        fail(f"{output} cannot be written: {fault.strerror or fault}")
    print(output)


def _format(format: str | None, output: Path | None) -> str:
    """The requested format, or that of the file's suffix."""
    if output is not None and output.suffix.lower() in (".svg", ".png", ".pdf"):
        fail(
            f"-o {output}: write the tree as text, then let Graphviz draw it: "
            f"labrun graph FILE -o tree.dot, then dot -T{output.suffix[1:]} tree.dot -o {output}"
        )
    if format is None:
        return SUFFIXES.get(output.suffix.lower(), "mermaid") if output is not None else "mermaid"
    if format not in WRITERS:
        fail(f"--format {format}: choose mermaid or dot")
    return format
