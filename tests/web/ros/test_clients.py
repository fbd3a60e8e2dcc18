"""Stock roslibpy, roslib 2 and roslib 1.4 use the lab as they would use any ROS 2."""

import pytest

pytestmark = pytest.mark.slow

GLOW = {"do": "goal", "name": "/Lamp_9/glow", "type": "labrun_interfaces/action/LampGlow"}
MOVE = {"do": "goal", "name": "/gantry/move_to", "type": "labrun_interfaces/action/GantryMoveTo"}


def test_a_goal_succeeds_and_every_field_of_its_result_is_there(talk, endpoint):
    (told,) = talk(endpoint.url, {**GLOW, "args": {"seconds": 0.2, "pattern": [1, 2]}})

    assert told["status"] == "SUCCEEDED"
    assert told["values"] == {
        "seconds": 0.2, "pattern": [1, 2], "extra_json": "",
        "error_name": "", "error_message": "", "error_happened": "",
    }  # fmt: skip


def test_feedback_comes_before_the_result(talk, endpoint):
    (told,) = talk(endpoint.url, {**GLOW, "args": {"seconds": 0.2, "colour": "warm white"}})

    assert told["feedback"][0] == {"progress": 0.0, "message": "glowing warm white"}
    assert told["status"] == "SUCCEEDED"


def test_a_goal_is_cancelled_by_its_client(talk, endpoint):
    (told,) = talk(endpoint.url, {**GLOW, "args": {"seconds": 60}, "cancel": True})

    assert told.get("status") == "CANCELED" or "Action was canceled" in told["error"]


def test_a_goal_that_fails_is_aborted_with_the_contracts_own_error(talk, endpoint):
    (told,) = talk(endpoint.url, {**GLOW, "args": {"seconds": 1, "colour": "#fff"}})

    said = told["values"] if "values" in told else told["error"]
    assert told.get("status") == "ABORTED" or "Action was aborted" in said
    assert "Burnt" in str(said) and "too bright for this bulb" in str(said) and "yes" in str(said)


@pytest.mark.parametrize(
    ("step", "words"),
    [
        ({**MOVE, "args": {"x": 500.5}}, "500"),
        ({**MOVE, "args": {}}, "needs at least 1"),
        ({**MOVE, "args": {"x": "far"}}, "x is a string but must be a float64"),
        ({**MOVE, "args": {"xx": 1}}, "xx is not a field of GantryMoveToGoal"),
    ],
)
def test_a_goal_that_breaks_the_contract_is_refused_with_the_reason(talk, endpoint, step, words):
    (told,) = talk(endpoint.url, step)

    assert words in str(told["error"])


def test_an_unknown_action_is_answered(roslibpy, roslib2, endpoint):
    step = {**MOVE, "name": "/gantry/move_too", "args": {"x": 1}}
    for talk in (roslibpy, roslib2):
        (told,) = talk(endpoint.url, step)

        assert "there is no action /gantry/move_too; did you mean /gantry/move_to?" in str(
            told["error"]
        )


def test_an_action_of_another_type_is_refused(roslibpy, roslib2, endpoint):
    step = {**MOVE, "type": "example_interfaces/action/Fibonacci", "args": {"x": 1}}
    for talk in (roslibpy, roslib2):
        (told,) = talk(endpoint.url, step)

        assert "is a labrun_interfaces/action/GantryMoveTo, not a example_interfaces" in str(
            told["error"]
        )


def test_all_goals_of_an_action_are_cancelled_at_once(roslib2, endpoint):
    (told,) = roslib2(endpoint.url, {**GLOW, "args": {"seconds": 60}, "cancelAll": True})

    assert "Action was canceled" in told["error"]


def test_a_pure_action_is_a_service_too(talk, endpoint):
    step = {"do": "service", "name": "/Lamp_9/age", "type": "labrun_interfaces/srv/LampAge"}
    some, none, failed, bad = talk(
        endpoint.url, {**step, "args": {"of": "tube"}}, {**step, "args": {}},
        {**step, "args": {"of": "nothing"}}, {**step, "args": {"of": 3}},
    )  # fmt: skip

    assert some["values"]["hours"] == [12.5] and some["values"]["of"] == "tube"
    assert none["values"]["hours"] == []
    assert failed["values"]["error_name"] == "Unknown"
    assert "of is a number but must be a string" in bad["error"]


def test_an_unknown_service_is_answered(talk, endpoint):
    (told,) = talk(endpoint.url, {"do": "service", "name": "/lamp/age", "type": "x/Y", "args": {}})

    assert "there is no service /lamp/age" in told["error"]


def test_the_status_of_a_device_is_a_topic_with_every_field(talk, endpoint):
    step = {"do": "topic", "name": "/Lamp_9/status", "type": "labrun_interfaces/msg/LampStatus"}
    (told,) = talk(endpoint.url, {**step, "count": 2})

    # Another test's goal on this endpoint may have left it lit.
    assert isinstance(told["messages"][0].pop("lit"), bool)
    assert told["messages"][0] == {
        "colour": "warm white", "levels": [1.5, 2.25], "counts": [1, 2**40],
        "place": {"x": 3.5, "value_class": "A"}, "note": [], "more_json": '{"a": [1, null]}',
    }  # fmt: skip


def test_a_topic_comes_as_cbor_with_packed_arrays(roslib1, roslib2, endpoint):
    step = {"do": "topic", "name": "/Lamp_9/status", "type": "labrun_interfaces/LampStatus"}
    for talk in (roslib1, roslib2):
        (told,) = talk(endpoint.url, {**step, "count": 1, "compression": "cbor"})

        message = told["messages"][0]
        levels = message["levels"]  # a Float64Array, which JSON has as {"0": 1.5, ...}
        assert list(levels.values()) == [1.5, 2.25]
        assert message["place"] == {"x": 3.5, "value_class": "A"}


def test_rosapi_says_what_there_is(talk, endpoint):
    (told,) = talk(
        endpoint.url,
        {"do": "look", "topic": "/gantry/status", "message": "labrun_interfaces/LampStatus"},
    )

    assert "/gantry/status" in told["topics"]
    assert "/Lamp_9/age" in told["services"] and "/rosapi/topics" in told["services"]
    assert {"/gantry/move_to", "/labrun/run_protocol"} <= set(told["actions"])
    assert told["type"] == "labrun_interfaces/msg/GantryStatus"
    assert told["nodes"] == ["/labrun"]
    if "details" in told:
        assert told["details"]["place"] == {"x": "float64", "value_class": "string"}


def test_a_protocol_runs_as_an_action(talk, endpoint):
    step = {
        "do": "goal",
        "name": "/labrun/run_protocol",
        "type": "labrun_interfaces/action/RunProtocol",
    }
    (told,) = talk(
        endpoint.url, {**step, "args": {"protocol": "hello", "params_json": '{"there": "30 mm"}'}}
    )

    assert told["status"] == "SUCCEEDED", told
    values = told["values"]
    assert values["fate"] == "succeeded" and "_hello_" in values["run"]
    assert '"x": {"$quantity": [30' in values["outputs_json"]
    assert (endpoint.folder / "runs" / values["run"] / "report.html").is_file()
    assert {feedback["run"] for feedback in told["feedback"]} == {values["run"]}
