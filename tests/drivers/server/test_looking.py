"""People look through a camera between its goals: nothing is held, kept or disturbed by it."""

import asyncio

import pytest

from labrun.drivers.driver import ActionFailed
from labrun.drivers.server.lease import Refused
from labrun.schemas.contract import Contract
from labrun.schemas.contracts import shipped_contracts
from labrun.schemas.messages import FileContent

from .lamp import Lamp, Story

FILE = {"type": "string", "format": "path"}
PICTURE = {
    "effect": "pure",
    "params": {
        "type": "object", "required": ["image"],
        "properties": {"image": {**FILE, "contentMediaType": "image/png"}},
    },
    "returns": {"type": "object", "properties": {"image": FILE}},
}  # fmt: skip
ACTIONS = {"shine": {"cancel": True}, "capture": PICTURE}


class Camera(Lamp):
    """A lamp with an eye, which takes two seconds to see."""

    takes_s = 2.0
    fault: Exception | None = None

    async def capture(self, goal, *, image):
        self.acts.append(("looks", image))
        await asyncio.sleep(self.takes_s)
        if self.fault is not None:
            raise self.fault
        goal.files["image"] = FileContent.of(image, b"\xff\xd8\xff")
        self.acts.append(("seen", image))
        return {"image": image}


def told_with(told, driver=Camera, **more):
    return Story.tell(told, driver=driver, **{"actions": ACTIONS, **more})


def test_a_look_needs_no_lease_and_leaves_no_goal_and_no_file():
    async def told(story):
        first, second = await asyncio.gather(story.device.look(), story.device.look())
        return (
            first.file.data,
            second.file.data,
            list(story.lamp.acts),
            list(story.ledger.reports_since(0)),
        )

    first, second, acts, goals = told_with(told)

    assert first == second == b"\xff\xd8\xff"
    assert acts == [("looks", "picture.jpg"), ("seen", "picture.jpg")]
    assert goals == []


def test_whoever_holds_the_camera_is_not_disturbed_and_is_named():
    async def told(story):
        await story.take("run-1")
        with pytest.raises(Refused) as held:
            await story.device.look()
        await story.device.release("run-1", None)
        await story.device.look()
        return held.value

    held = told_with(told)

    assert (held.code, held.message) == ("HELD", "lamp is held by run-1")


def test_a_goal_that_comes_during_a_look_begins_after_it():
    async def told(story):
        look = asyncio.ensure_future(story.device.look())
        await asyncio.sleep(0.5)
        await story.take()
        goal = await story.goal()
        await story.until("begins", goal)
        await look
        return list(story.lamp.acts)

    acts = told_with(told)

    assert acts == [("looks", "picture.jpg"), ("seen", "picture.jpg"), ("begins", "g1")]


@pytest.mark.parametrize(("more", "limit_s"), [({}, 10), ({"look_timeout": "4 s"}, 4)])
def test_a_camera_that_hangs_keeps_no_goal_waiting_for_ever(monkeypatch, more, limit_s):
    monkeypatch.setattr(Camera, "takes_s", 1000.0)

    async def told(story):
        with pytest.raises(Refused, match=f"gave no picture within {limit_s} s"):
            await story.device.look()
        began = asyncio.get_running_loop().time()
        await story.take()
        await story.until("begins", await story.goal())
        return asyncio.get_running_loop().time() - began

    assert told_with(told, **more) == pytest.approx(limit_s, abs=1)


@pytest.mark.parametrize(
    ("fault", "words"),
    [
        (ActionFailed("CameraLost", "it is not plugged in"), "it is not plugged in"),
        (OSError("the cable"), "the cable"),
    ],
)
def test_a_camera_that_sees_nothing_says_why(monkeypatch, fault, words):
    monkeypatch.setattr(Camera, "fault", fault)

    async def told(story):
        with pytest.raises(Refused) as refused:
            await story.device.look()
        return refused.value.message

    assert told_with(told) == f"lamp gives no picture: {words}"


class HighCamera(Camera):
    """A camera that also shows the bench from above."""

    async def capture(self, goal, *, image, above=False):
        told = await super().capture(goal, image=image)
        return {**told, "left": -5.0, "right": 20, "front": 0, "back": 7.5} if above else told


def test_a_picture_from_above_says_where_on_the_bench_it_is():
    params = PICTURE["params"]
    high = {**params, "properties": {**params["properties"], "above": {"type": "boolean"}}}

    async def told(story):
        return await asyncio.gather(story.device.look(), story.device.look(above=True))

    actions = {**ACTIONS, "capture": {**PICTURE, "params": high}}
    plain, above = Story.tell(told, driver=HighCamera, actions=actions)

    assert plain.place is None
    assert above.place.model_dump() == {"left": -5, "right": 20, "front": 0, "back": 7.5}
    assert (plain.file.path, above.file.path) == ("picture.jpg", "picture.png")


def test_a_look_from_above_that_comes_after_a_plain_one_ends_in_the_time_of_one(monkeypatch):
    monkeypatch.setattr(HighCamera, "takes_s", 1000.0)
    params = PICTURE["params"]
    high = {**params, "properties": {**params["properties"], "above": {"type": "boolean"}}}
    slow = {**PICTURE, "params": high, "duration": "8 s"}

    async def told(story):
        clock = asyncio.get_running_loop().time
        began = clock()
        looks = (story.device.look(above=above) for above in (False, True))
        ends = await asyncio.gather(*looks, return_exceptions=True)
        return [str(end) for end in ends], clock() - began

    ends, took_s = Story.tell(told, driver=HighCamera, actions={**ACTIONS, "capture": slow})

    assert ends == ["lamp gave no picture within 24 s"] * 2  # three times what the contract says
    assert took_s == pytest.approx(24, abs=1)


def test_what_is_no_camera_says_so():
    async def told(story):
        with pytest.raises(Refused, match="lamp takes no pictures"):
            await story.device.look()

    async def told_above(story):
        with pytest.raises(Refused, match="lamp takes no pictures from above"):
            await story.device.look(above=True)

    Story.tell(told)
    told_with(told_above)


@pytest.mark.parametrize(
    "changed",
    [
        {"effect": "once"},
        {"danger": "laser"},
        {"interlock": {"door": "closed"}},
        {"returns": {}},
        {"params": {**PICTURE["params"], "required": ["image", "exposure"]}},
    ],
)
def test_only_what_changes_nothing_and_needs_nothing_is_a_look(changed):
    def camera(action):
        return Contract.model_validate({"type": "eye@1", "actions": {"capture": action}})

    assert camera(PICTURE).look() == ("capture", "image")
    assert camera({**PICTURE, **changed}).look() is None


def test_the_cameras_that_ship_can_be_looked_through():
    seen = {name for name, one in shipped_contracts().items() if one.look() is not None}

    assert seen == {"depth_camera@1"}
