"""A device server of somebody else: one stage that jogs by itself while its goal is sent again."""

import asyncio
import threading
import time

import socketio
import uvicorn

CONTRACT = {
    "type": "stage@1",
    "summary": "Axes that a hand moves",
    "safe_state": ["halt"],
    "status": {
        "type": "object",
        "properties": {
            "state": {"enum": ["idle", "moving"]},
            "homed": {"type": "boolean"},
            **{axis: {"type": "number", "unit": "mm"} for axis in "xyz"},
        },
    },
    "actions": {
        "move_to": {
            "effect": "idempotent", "danger": "motion", "cancel": True, "duration": "2 s",
            "params": {"type": "object", "additionalProperties": False, "properties": {
                axis: {"type": "number", "unit": "mm", "minimum": 0, "maximum": 200}
                for axis in "xyz"
            }},
        },
        "jog": {
            "effect": "once", "danger": "motion", "cancel": True, "duration": "2 s",
            "params": {
                "type": "object", "additionalProperties": False,
                "oneOf": [
                    {"required": ["axis", "distance"]}, {"required": ["axis", "direction"]},
                    {"required": ["way"]},
                ],
                "properties": {
                    "axis": {"enum": ["x", "y", "z"]},
                    "distance": {"type": "number", "unit": "mm", "minimum": -810, "maximum": 810},
                    "direction": {"enum": ["+", "-"]},
                    "feed": {"type": "number", "unit": "mm/min", "exclusiveMinimum": 0,
                             "maximum": 2500, "default": 600},
                    "way": {"type": "string"},
                    "lease": {"type": "number", "unit": "s", "minimum": 0.1, "maximum": 2,
                              "default": 0.3},
                },
            },
            "returns": {"type": "object", "properties": {
                axis: {"type": "number", "unit": "mm"} for axis in "xyz"
            }},
        },
        "halt": {"effect": "idempotent", "duration": "1 s"},
    },
}  # fmt: skip
TICK_S = 0.01


class Stage:
    """The wire of a device server, and one axis after the other that moves."""

    def __init__(self):
        self.begin()
        self.sio = socketio.AsyncServer(async_mode="asgi", transports=["websocket"])
        for event in ("describe", "lease", "release", "goal", "cancel", "query", "stop"):
            self.sio.on(event, getattr(self, f"_{event}"), namespace="/action")
        self.sio.on("connect", self._connect, namespace="/action")
        config = uvicorn.Config(
            socketio.ASGIApp(self.sio), port=0, log_level="error", lifespan="off"
        )
        self.server = uvicorn.Server(config)
        self.thread = threading.Thread(target=self.server.run)

    def begin(self):
        """As it was when it was switched on."""
        self.place = {"x": 50.0, "y": 50.0, "z": 50.0}
        self.homed = True
        self.deaf = False
        """While true it takes no goal that it knows already: its network is down one way."""
        self.goals = []
        self.sent_again = 0
        self.ended = {}
        self.running = {}
        self.cancelled = set()

    def open(self):
        self.thread.start()
        until = time.monotonic() + 500
        while not self.server.started:
            assert time.monotonic() < until
            time.sleep(0.02)
        port = self.server.servers[0].sockets[0].getsockname()[1]
        return f"http://127.0.0.1:{port}"

    def close(self):
        self.server.should_exit = True
        self.thread.join(timeout=500)

    async def _connect(self, session, environ, auth=None):
        self.sio.start_background_task(self._beat, session)

    async def _beat(self, session):
        while session in self.sio.manager.rooms.get("/action", {}).get(None, {}):
            await self.sio.emit("status", self._status(), namespace="/action", to=session)
            await asyncio.sleep(0.3)

    def _status(self):
        state = "moving" if self.running else "idle"
        return {"device": "stage", "state": state, "homed": self.homed, **self.place}

    async def _describe(self, session, data=None):
        status = self._status()
        del status["device"]
        stage = {"contract": CONTRACT, "driver": "peer", "status": status}
        return {"ok": True, "boot": "b1", "ledger": "l1", "devices": {"stage": stage}}

    async def _lease(self, session, data):
        return {"ok": True, "epoch": 1, "boot": "b1", "device": "stage"}

    async def _release(self, session, data):
        return {"ok": True, "released": True}

    async def _goal(self, session, data):
        id = data["id"]
        if id in self.ended:
            return {"ok": True, "dup": True, **self.ended[id]}
        if id in self.running:
            self.sent_again += 1
            if not self.deaf:
                self.running[id] = time.monotonic()
        else:
            self.goals.append((data["action"], data["params"]))
            self.running[id] = time.monotonic()
            self.sio.start_background_task(self._move, id, data["params"])
        return {"ok": True, "id": id, "state": "EXECUTING", "seq": 1, "boot": "b1"}

    async def _move(self, id, params):
        way = params.get("way") or f"{params.get('direction', '+')}{params['axis']}"
        signs = {way[i + 1]: -1 if way[i] == "-" else 1 for i in range(0, len(way), 2)}
        left = params.get("distance")
        if left is not None:
            for axis, sign in signs.items():
                self.place[axis] += sign * left
            await asyncio.sleep(0.05)
        while left is None and id not in self.cancelled:
            if time.monotonic() - self.running[id] > params["lease"]:
                break
            for axis, sign in signs.items():
                step = sign * params["feed"] / 60 * TICK_S
                self.place[axis] = min(200.0, max(0.0, self.place[axis] + step))
            if {self.place[axis] for axis in signs} & {0.0, 200.0}:
                break
            await asyncio.sleep(TICK_S)
        state = "CANCELED" if id in self.cancelled else "SUCCEEDED"
        told = {"id": id, "state": state, "seq": 2, "boot": "b1", "result": dict(self.place)}
        self.ended[id] = told
        del self.running[id]
        await self.sio.emit("update", told, namespace="/action")

    async def _cancel(self, session, data):
        self.cancelled.add(data["id"])
        return {"ok": True, "state": "CANCELING"}

    async def _query(self, session, data):
        known = {
            id: self.ended.get(id)
            or ({"id": id, "state": "EXECUTING", "seq": 1} if id in self.running else None)
            for id in data["ids"]
        }
        return {"ok": True, "boot": "b1", "ledger": "l1", "goals": known}

    async def _stop(self, session, data):
        self.cancelled |= set(self.running)
        return {"ok": True, "safe": True, "devices": {"stage": {"safe": True, "message": "still"}}}
