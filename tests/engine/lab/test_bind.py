"""A role is played by the requested device, the one of its name, or the only one that can."""

from labrun.engine.check import check_text

LAB = """\
name: bench
devices:
  left: {contract: gantry@1, driver: sim_gantry, limits: {x: {maximum: 100}}}
  right: {contract: gantry@1, driver: sim_gantry}
  laser: {contract: libs_analyzer@1, driver: sim_libs}
"""


def check(tmp_path, devices: str, bind: dict[str, str], step: str = "do: ROLE.home"):
    lab = tmp_path / "lab.yaml"
    lab.write_text(LAB)
    role = devices.partition(":")[0]
    text = f"labrun: 1\nname: t\ndevices: {{{devices}}}\nsteps:\n  - {step.replace('ROLE', role)}\n"
    return check_text(text, "p.yaml", lab=lab, bind=bind)


def test_a_role_goes_to_the_device_of_its_name_or_the_only_one_or_the_one_asked_for(tmp_path):
    locate = "do: ROLE.locate"

    assert check(tmp_path, "right: gantry@1", {}).roles["right"].device == "right"
    assert check(tmp_path, "libs: libs_analyzer@1", {}, locate).roles["libs"].device == "laser"
    assert check(tmp_path, "right: gantry@1", {"right": "left"}).roles["right"].device == "left"


def test_of_several_simulated_devices_the_first_free_one_plays_the_role(tmp_path):
    lab = tmp_path / "lab.yaml"
    lab.write_text(LAB + "simulated: true\n")
    text = (
        "labrun: 1\nname: t\ndevices: {one: gantry@1, left: gantry@1, two: gantry@1}\n"
        "steps: [{do: one.home}, {do: left.home}, {do: two.home}]\n"
    )
    roles = check_text(text, "p.yaml", lab=lab).roles

    assert {role: bound.device for role, bound in roles.items()} == {
        "one": "right", "left": "left", "two": "left",
    }  # fmt: skip


def test_two_candidates_are_listed(tmp_path):
    problem = check(tmp_path, "gantry: gantry@1", {}).problems[0]

    assert (problem.code, problem.line, problem.column) == ("E209", 3, 19)
    assert problem.hint == "choose one: --bind gantry=left (or right)"


def test_a_wrong_bind_is_told(tmp_path):
    def code_and_message(bind):
        return [
            (p.file, p.code, p.message) for p in check(tmp_path, "right: gantry@1", bind).problems
        ]

    assert code_and_message({"right": "rigt"}) == [
        ("--bind", "E210", "the lab 'bench' has no device rigt; did you mean right?")
    ]
    assert code_and_message({"right": "laser"}) == [
        ("--bind", "E210", "laser is a libs_analyzer@1, but the role right needs a gantry@1")
    ]
    assert code_and_message({"rihgt": "left"}) == [
        ("--bind", "E210", "the protocol has no role rihgt; did you mean right?")
    ]


def test_the_limits_of_the_device_hold_for_the_role(tmp_path):
    step = "{do: ROLE.move_to, with: {x: 10.1 cm}}"
    checked = check(tmp_path, "right: gantry@1", {"right": "left"}, step)

    assert [(p.code, p.hint) for p in checked.problems] == [("E207", "a limit of this lab")]
    assert check(tmp_path, "right: gantry@1", {}, step).ok
