"""A device that does what a test tells it, and writes down what it really did."""

import asyncio
import sys
import time
from hashlib import sha256
from typing import Any

from labrun.drivers.driver import ActionCanceled, ActionFailed, Driver, GoalContext, Place
from labrun.schemas.messages import FileContent

SECONDS = {"seconds": {"type": "number", "unit": "s", "minimum": 0, "maximum": 60}}
CONTRACT: dict[str, Any] = {
    "type": "scripted@1",
    "safe_state": ["halt"],
    "on_lease_lapse": "finish",
    "actions": {
        "hold": {
            "cancel": True,
            "params": {"type": "object", "additionalProperties": False, "properties": SECONDS},
            "returns": {"type": "object", "required": ["held"], "properties": {"held": {}}},
        },
        "held": {
            "cancel": True,
            "params": {"type": "object", "properties": SECONDS},
            "returns": {"type": "object"},
        },
        "nudge": {"meanwhile": True},
        "press": {"params": {"type": "object", "properties": SECONDS}},
        "sleep_through": {"cancel": True, "params": {"type": "object", "properties": SECONDS}},
        "go": {
            "effect": "idempotent",
            "params": {
                "type": "object",
                "additionalProperties": False,
                "required": ["x"],
                "properties": {"x": {"type": "number", "unit": "mm", "minimum": 0, "maximum": 10}},
            },
            "returns": {"type": "object", "properties": {"x": {"type": "number"}}},
        },
        "fail": {
            "params": {
                "type": "object",
                "properties": {"error": {"type": "string"}, "happened": {"type": "string"}},
            },
            "errors": {"Jammed": {"happened": "no"}},
        },
        "crash": {},
        "mumble": {},
        "answer": {
            "params": {"type": "object", "properties": {"value": {}}},
            "returns": {
                "type": "object",
                "required": ["value"],
                "properties": {"value": {"type": "number"}},
            },
        },
        "odd": {"params": {"type": "object", "properties": {"kind": {"type": "string"}}}},
        "copy": {
            "params": {
                "type": "object",
                "required": ["source", "file"],
                "properties": {
                    "source": {"type": "string", "format": "path"},
                    "file": {"type": "string", "format": "path"},
                },
            },
            "returns": {
                "type": "object",
                "required": ["file"],
                "properties": {"file": {"type": "string", "format": "path"}},
            },
        },
        "halt": {},
    },
}


class Scripted(Driver):
    """Every action appends a line to `deeds.txt` in the world folder before it does anything."""

    contract = "scripted@1"
    versions = {"firmware": "1.0"}  # noqa: RUF012 - declared ClassVar by Driver

    def __init__(self, place: Place) -> None:
        super().__init__(place)
        self.alone = place.config.get("alone", "")

    def _did(self, deed: str) -> None:
        with (self.place.world / "deeds.txt").open("a", encoding="utf-8") as deeds:
            deeds.write(f"{self.place.device} {deed}\n")

    async def open(self) -> None:
        if self.place.config.get("missing") and not (self.place.world / "plugged").exists():
            raise OSError("nothing answers on /dev/nowhere")
        self._did("open")
        if self.place.config.get("prints"):
            print("a library that talks " * 10_000)
        if self.place.config.get("helper"):
            self.helper = await asyncio.create_subprocess_exec("sleep", "600")
            (self.place.world / "helper").write_text(str(self.helper.pid))
        here = self.place.world / "deeds.txt"
        opened = here.read_text(encoding="utf-8").count(f"{self.place.device} open")
        if opened in self.place.config.get("silent_at", []):
            raise OSError("it does not answer yet")
        await asyncio.sleep(self.place.config.get("open_s", 0))

    async def close(self) -> None:
        self._did("close")

    async def status(self) -> dict[str, Any]:
        door = self.place.world / "door"
        told = door.read_text() if door.exists() else "away"
        if told == "dead":
            raise OSError("the door does not answer")
        return {"state": "idle"} if told == "away" else {"state": "idle", "door": told}

    async def safe(self) -> None:
        self._did("safe")
        await asyncio.sleep(self.place.config.get("safe_s", 0))
        if self.place.config.get("safe_fails"):
            raise RuntimeError("the brake is worn")

    async def hold(self, goal: GoalContext, *, seconds: float = 0) -> dict[str, Any]:
        self._did(f"hold {goal.id}")
        goal.feedback(0.5, "half way")
        try:
            async with asyncio.timeout(seconds):
                await goal.cancelled.wait()
        except TimeoutError:
            return {"held": seconds}
        raise ActionCanceled

    async def held(self, goal: GoalContext, *, seconds: float = 0) -> dict[str, Any]:
        """Goes on as long as its goal is sent again within so many seconds."""
        self._did(f"held {goal.id}")
        while time.monotonic() - goal.wanted_at < seconds:  # noqa: ASYNC110 - nobody tells
            await asyncio.sleep(0.01)
        return {}

    async def nudge(self, goal: GoalContext) -> dict[str, Any]:
        self._did(f"nudge {goal.id}")
        return {}

    async def press(self, goal: GoalContext, *, seconds: float = 0) -> dict[str, Any]:
        self._did(f"press {goal.id}")
        await asyncio.sleep(seconds)
        return {}

    async def sleep_through(self, goal: GoalContext, *, seconds: float = 0) -> dict[str, Any]:
        self._did(f"sleep_through {goal.id}")
        await asyncio.sleep(seconds)
        return {}

    async def go(self, goal: GoalContext, *, x: float) -> dict[str, Any]:
        self._did(f"go {goal.id}")
        return {"x": x}

    async def fail(
        self, goal: GoalContext, *, error: str = "Jammed", happened: Any = None
    ) -> dict[str, Any]:
        raise ActionFailed(error, "the drawer is stuck", happened) from LookupError("no rail 7")

    async def crash(self, goal: GoalContext) -> dict[str, Any]:
        raise ZeroDivisionError("division by zero")

    async def mumble(self, goal: GoalContext) -> dict[str, Any]:
        name: Any = 7
        message: Any = ["a", "list"]
        raise ActionFailed(name, message)

    async def answer(self, goal: GoalContext, *, value: Any = None) -> dict[str, Any]:
        return {"value": float("nan") if value == "nan" else value}

    async def odd(self, goal: GoalContext, *, kind: str = "feedback") -> dict[str, Any]:
        """Ends in a way that no JSON, no disk and no event loop expects."""
        self._did(f"odd {goal.id}")
        match kind:
            case "tuple as key":
                return {"peaks": {(1, 2): 3}}
            case "number as key":
                return {7: 1}  # pyright: ignore[reportReturnType]
            case "half a character":
                return {"path": "\udcff"}
            case "half a character as error":
                raise ActionFailed("Jammed", "\udcff")
            case "endless":
                ring: dict[str, Any] = {}
                ring["ring"] = ring
                return ring
            case "exit":
                sys.exit(3)
            case "many digits":
                return {"n": 10**5000}
            case _:
                goal.feedback(float("nan"), "\udcff")
                goal.feedback("half", "")  # pyright: ignore[reportArgumentType]
                return {}

    async def copy(self, goal: GoalContext, *, source: str, file: str) -> dict[str, Any]:
        data = goal.files["source"].data[::-1]
        goal.files["file"] = FileContent(path=file, sha256=sha256(data).hexdigest(), data=data)
        return {"file": file}

    async def halt(self, goal: GoalContext) -> dict[str, Any]:
        return {}
