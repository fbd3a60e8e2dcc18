"""Deliver one message to one receiver, or say why it could not be."""

import asyncio
import base64
import smtplib
from dataclasses import dataclass
from email.message import EmailMessage
from pathlib import Path

import aiohttp

from ..models.settings import Mail, Receiver

LIMIT_S = 20.0
LARGEST_MAP = 2_000_000


class NotDelivered(Exception):
    """The text says what refused it."""


@dataclass(frozen=True, slots=True)
class Message:
    """What happened, for people; `event` for programs, `picture` a PNG of what was measured."""

    event: str
    text: str
    bench: str
    at: str
    run: str = ""
    device: str = ""
    picture: Path | None = None


async def deliver(message: Message, receiver: Receiver, mail: Mail) -> None:
    """Send it once; raises NotDelivered."""
    try:
        async with asyncio.timeout(LIMIT_S):
            if receiver.kind == "mail":
                await asyncio.to_thread(_mail, message, receiver.to, mail)
            else:
                await _post(message, receiver)
    except TimeoutError:
        raise NotDelivered(f"{receiver.to} did not answer within {LIMIT_S:.0f} s") from None
    except (OSError, aiohttp.ClientError, ValueError, smtplib.SMTPException) as fault:
        raise NotDelivered(f"{receiver.to}: {fault or type(fault).__name__}") from fault


async def _post(message: Message, receiver: Receiver) -> None:
    """A chat's incoming hook reads `text`; a webhook gets everything, with the map as base64."""
    body: dict[str, object] = {"text": f"{message.bench}: {message.text}"}
    if receiver.kind == "webhook":
        png = await asyncio.to_thread(_png, message.picture)
        body = {
            "event": message.event, "text": message.text, "bench": message.bench, "at": message.at,
            "run": message.run, "device": message.device,
            "map_png": base64.b64encode(png).decode() if png else None,
        }  # fmt: skip
    async with (
        aiohttp.ClientSession() as session,
        session.post(receiver.to, json=body, allow_redirects=False) as answer,
    ):
        if answer.status >= 300:
            raise NotDelivered(
                f"{receiver.to} answered {answer.status} {answer.reason or ''}".strip()
            )


def _mail(message: Message, to: str, mail: Mail) -> None:
    letter = EmailMessage()
    letter["Subject"] = f"{message.bench}: {' '.join(message.text.split())}"[:200]
    letter["From"], letter["To"] = mail.sender or to, to
    letter.set_content(f"{message.text}\n\n{message.run or message.device}\n{message.at}\n")
    png = _png(message.picture)
    if png:
        letter.add_attachment(png, maintype="image", subtype="png", filename="map.png")
    with smtplib.SMTP(mail.host, mail.port, timeout=LIMIT_S) as server:
        if mail.tls:
            server.starttls()
        if mail.user:
            password = Path(mail.password_file).read_text(encoding="utf-8").strip()
            server.login(mail.user, password)
        server.send_message(letter)


def _png(path: Path | None) -> bytes:
    try:
        if path is None or path.stat().st_size > LARGEST_MAP:
            return b""
        return path.read_bytes()
    except OSError:
        return b""
