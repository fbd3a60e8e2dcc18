"""`labrun mcp`: serve agents over stdin and stdout."""

from ...engine.commands.options import usable_lab
from ..local.options import Folder, Lab, Runs, protocol_folder


def mcp(folder: Folder = None, lab: Lab = None, runs: Runs = None) -> None:
    """Let an agent read, write, check and rehearse protocols, and start what a person has released."""
    import asyncio

    from .server import serve

    protocols = protocol_folder(folder)
    usable_lab(lab)
    asyncio.run(serve(protocols, (runs or protocols / "runs").resolve(), lab and lab.resolve()))
