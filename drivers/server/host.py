"""A device server in the running event loop: create, open and serve devices, and leave them safe."""

import socket
import ssl
import sys
from collections.abc import AsyncIterator, Iterator
from contextlib import ExitStack, asynccontextmanager, contextmanager, nullcontext
from functools import partial
from pathlib import Path

from pydantic import ValidationError

from ...schemas.contract import Contract
from ...schemas.model import first_fault
from ...system.extras import in_words
from ..driver import Place
from ..find import DriverFault, check_driver, check_installed, find_driver
from . import tokens
from .arguments import LimitFault, read_limits
from .device import ServedDevice
from .gate import is_loopback
from .ledger import Ledger, LedgerFault
from .listen import bind, listening
from .server import DeviceClosed, DeviceServer
from .settings import DeviceSettings, ServerSettings, TlsFiles


class ServeFault(Exception):
    """A server that cannot start, with the reason."""


def make_device(
    name: str, device: DeviceSettings, settings: ServerSettings, server: DeviceServer
) -> ServedDevice:
    """A device with its driver, not opened yet; raises ServeFault if they do not match."""
    folder = Path(settings.folder) / name
    try:
        contract = Contract.model_validate(device.contract)
        driver_class = find_driver(device.driver, Path(settings.base))
        if (base := str(Path(settings.base).resolve())) not in sys.path:
            sys.path.append(base)  # the class of an instrument may be in a file beside the lab
        check_installed(driver_class, device.config)
        check_driver(driver_class, contract)
        limits = read_limits(device.limits, contract)
        folder.mkdir(parents=True, exist_ok=True)
        world = Path(settings.world or settings.folder)
        world.mkdir(parents=True, exist_ok=True)
        place = Place(name, device.config, limits, folder, world, contract)
        return ServedDevice(
            place, driver_class(place), contract, server.ledger, server.tell, settings.stop_grace_s
        )
    except ValidationError as fault:
        raise ServeFault(f"device {name}: its contract: {first_fault(fault)}") from fault
    except (DriverFault, LimitFault, OSError, ValueError) as fault:
        raise ServeFault(f"device {name}: {fault}") from fault
    except Exception as fault:  # a driver's own __init__ may raise anything about its config
        raise ServeFault(f"device {name}: {in_words(fault)}") from fault


def _anew(settings: ServerSettings, server: DeviceServer, name: str) -> ServedDevice:
    return make_device(name, settings.devices[name], settings, server)


@asynccontextmanager
async def serving(settings: ServerSettings) -> AsyncIterator[tuple[DeviceServer, str]]:
    """A device server and its address, for as long as the block lasts; raises ServeFault."""
    if settings.token is None and not is_loopback(settings.host):
        raise ServeFault(
            f"{settings.host} can be reached from other machines, so a token is required; "
            f"give `token`, or serve on 127.0.0.1"
        )
    tls = None if settings.tls is None else _certificate(settings.tls)
    try:
        ledger = Ledger(Path(settings.folder) / "ledger.sqlite")
    except LedgerFault as fault:
        raise ServeFault(str(fault)) from fault
    token = settings.token or (tokens.made() if settings.own_token else None)
    server = DeviceServer(ledger, token, settings.host)
    try:
        devices = [make_device(n, d, settings, server) for n, d in settings.devices.items()]
        listener = _bind(settings)
        scheme = "https" if tls else "http"
        url = f"{scheme}://{_host_text(settings.host)}:{listener.getsockname()[1]}"
        try:
            anew = partial(_anew, settings, server) if settings.patient else None
            await server.open(devices, anew)
            with _findable(url, token) if settings.token is None else nullcontext():
                async with listening(server.app, listener, tls):
                    try:
                        yield server, url
                    finally:
                        await server.make_safe()
        except DeviceClosed as fault:
            raise ServeFault(str(fault)) from fault
        finally:
            listener.close()
    finally:
        await server.close()


@contextmanager
def _findable(url: str, token: str | None) -> Iterator[None]:
    with ExitStack() as keeping:
        try:
            if token is not None:
                keeping.enter_context(tokens.findable(url, token))
        except OSError as fault:
            words = f"{fault.strerror or fault}: {fault.filename}"
            raise ServeFault(f"the server's token cannot be kept: {words}; give a token") from fault
        yield


def _certificate(files: TlsFiles) -> tuple[str, str]:
    try:
        ssl.create_default_context(ssl.Purpose.CLIENT_AUTH).load_cert_chain(
            files.certificate, files.key
        )
    except OSError as fault:  # ssl.SSLError is one, too
        raise ServeFault(
            f"the certificate {files.certificate} with the key {files.key} cannot be used: {fault}"
        ) from fault
    return files.certificate, files.key


def _bind(settings: ServerSettings) -> socket.socket:
    try:
        return bind(settings.host, settings.port)
    except OSError as fault:
        raise ServeFault(
            f"port {settings.port} on {settings.host} cannot be used: {fault.strerror or fault}; "
            "if another program is on it, `labrun serve --port` chooses another"
        ) from fault


def _host_text(host: str) -> str:
    if host in ("0.0.0.0", "::", ""):  # an address to listen on, not one to call
        return "127.0.0.1" if host != "::" else "[::1]"
    return f"[{host}]" if ":" in host else host
