"""The questions of `labrun setup gantry`, one after the other."""

import asyncio
import tempfile
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

import typer

from ...drivers.driver import ActionFailed, GoalContext, Place
from ...drivers.grbl.advice import advice
from ...drivers.grbl.gantry import Grbl
from ...drivers.motion.bench import LETTERS, Bench, read_bench
from ...drivers.motion.faults import MotionFault
from ...schemas.contracts import shipped_contracts
from ..lab.lab import load_lab
from ..problems.print import print_problems

STEP_MM, FEED = 5.0, 300.0
WAYS = {
    "r": ("x", ""), "l": ("x", "-"), "b": ("y", ""), "f": ("y", "-"), "u": ("z", ""), "d": ("z", "-"),
}  # fmt: skip
"""Seen from the front: x to the right, y to the back, z up."""


class GaveUp(Exception):
    """It cannot go on, or was told not to; the text says why."""


async def set_up(port: str | None, baud: int, output: Path) -> None:
    """Ask, look, move a little, and write the lab; raises GaveUp."""
    with tempfile.TemporaryDirectory(prefix="labrun-setup-") as folder:
        driver = await _reached([port] if port else _ports(), baud, Path(folder))
        try:
            await _settings(driver, output.with_suffix(".settings.txt"))
            axes = await _axes(driver)
            await _home(driver)
            bench = read_bench(
                {"axes": axes} if axes else {}, {}, driver.controller.settings.ranges
            )
            origin = await _origin(driver, bench) if driver.homed else None
        except (ActionFailed, MotionFault) as fault:
            raise GaveUp(f"{fault}. Nothing was written") from fault
        finally:
            await driver.close()
    config: dict[str, Any] = {"port": driver.controller.port.name}
    config |= {"baud": baud} if baud != 115200 else {}
    config |= {"home_first": True} if driver.controller.settings.homing else {}
    config |= {"axes": axes} if axes else {}
    config |= {"origin": origin} if origin else {}
    bench = read_bench(config, {}, driver.controller.settings.ranges)
    output.write_text(_lab(config, bench, driver.controller.firmware), encoding="utf-8")
    _, problems = load_lab(output)
    print_problems(problems, format="text")
    typer.echo(
        f"\nWrote {output}. Next, with a hand on the emergency stop:\n"
        f"  labrun serve {output} gantry          # in a terminal of its own\n"
        f"  labrun devices --lab {output}         # where it is\n"
        f"  labrun call --lab {output} gantry.home --yes"
    )


def _ports() -> list[str]:
    """The ports of this machine, by the names that stay where there are such."""
    from serial.tools.list_ports import comports

    stays = {p.resolve(): str(p) for p in Path("/dev/serial/by-id").glob("*")}
    found = [stays.get(Path(port.device).resolve(), port.device) for port in comports()]
    if not found:
        raise GaveUp(
            "this computer has no serial port: is the cable plugged in? `--port` names one"
        )
    return found


async def _reached(ports: list[str], baud: int, folder: Path) -> Grbl:
    """The gantry on the port that has one; a person chooses among several."""
    there: dict[str, Grbl] = {}
    for port in ports:
        contract = shipped_contracts()["gantry@2"]
        place = Place("gantry", {"port": port, "baud": baud}, {}, folder, folder, contract)
        driver = Grbl(place)
        try:
            await driver.open()
        except OSError as fault:
            typer.echo(f"- {fault}")
        else:
            there[port] = driver
            typer.echo(f"+ {port}: {driver.controller.firmware}")
    if not there:
        raise GaveUp("no controller was found; docs/how-to/gantry.md has a table of these messages")
    chosen = next(iter(there))
    while len(there) > 1 and (chosen := await _asked("Which port?", chosen)) not in there:
        typer.echo(f"one of {', '.join(there)}")
    for port, driver in there.items():
        if port != chosen:
            await driver.close()
    return there[chosen]


async def _settings(driver: Grbl, path: Path) -> None:
    """Keep a copy of `$$`, and say what to change; each is changed only where a person says so."""
    controller = driver.controller
    lines = await controller.ask("$$")
    path.write_text("".join(f"${line}\n" for line in lines), encoding="utf-8")
    typer.echo(f"\nIts settings are kept in {path}.")
    for one in advice(controller.settings):
        typer.echo(f"\n{one.line or 'Look'}: {one.why}.")
        if one.line and await _yes("Set it now?"):
            await controller.ask(one.line)
    now = type(controller.settings).read(await controller.ask("$$"))
    controller.configure(replace(controller.settings, values=now.values))


async def _axes(driver: Grbl) -> dict[str, str]:
    """Which machine axis is which of the bench; empty if each is its own."""
    typer.echo(
        f"\nEach axis is now moved by {STEP_MM:g} mm and back, slowly. Stand in front of the bench, the "
        f"tool clear on all sides, a hand on the emergency stop."
    )
    if not await _yes("Move?"):
        return {}
    await driver.unlock(GoalContext("setup-unlock"))
    found: dict[str, str] = {}
    for letter in LETTERS[: min(3, driver.controller.settings.axes)]:
        while True:
            distance = await _jogged(driver, letter.lower())
            way = await _asked(
                f"{letter}: which way did the tool go? right, left, back, front, up, down; again; none",
                "",
            )
            with suppress(ActionFailed):  # at its end: it stays
                await _jog(driver, letter.lower(), -distance)
            if way[:1] == "n":
                raise GaveUp(
                    f"{letter} did not move: look at its motor's cable and power, and at "
                    f"$10{LETTERS.index(letter)}. Nothing was written"
                )
            if way[:1] in WAYS:
                break
        name, sign = WAYS[way[:1]]
        if distance < 0:
            sign = "" if sign else "-"
        if name in found:
            raise GaveUp(f"{found[name]} and {letter} both move along {name}. Nothing was written")
        found[name] = f"{sign}{letter}"
    straight = {name: name.upper() for name in found}
    return {} if found == straight else {name: found[name] for name in sorted(found)}


async def _jogged(driver: Grbl, axis: str) -> float:
    """Move an axis a little, the other way where soft limits refuse the first one; how far."""
    try:
        await _jog(driver, axis, STEP_MM)
    except ActionFailed as failure:
        if failure.name != "SoftLimit":
            raise
        await _jog(driver, axis, -STEP_MM)
        return -STEP_MM
    return STEP_MM


async def _jog(driver: Grbl, axis: str, distance: float) -> None:
    await driver.jog(GoalContext(f"setup-{axis}"), axis=axis, distance=distance, feed=FEED)


async def _home(driver: Grbl) -> None:
    if not driver.controller.settings.homing:
        typer.echo(
            "\nHoming is off, so the lab cannot know where zero is: set $22=1 and run this again."
        )
    elif await _yes("\nHome it now? It goes to its switches, the tool up first."):
        await driver.home(GoalContext("setup-home"))


async def _origin(driver: Grbl, bench: Bench) -> dict[str, float] | None:
    """Zero where the tool stands, or the corner that the bench begins at."""
    machine = await driver._machine()
    typer.echo(
        f"\nIt stands at {_words(machine)} (machine). Bench zero is the corner at {_words(bench.origin)}."
    )
    typed = await _asked("Another zero? machine positions of x, y, z (Enter: that corner)", "")
    numbers = typed.replace(",", " ").split()
    if not numbers:
        return None
    try:
        x, y, z = (float(number) for number in numbers)
    except ValueError:
        typer.echo(f"{typed!r} is not three numbers: the corner is kept")
        return None
    return {"x": x, "y": y, "z": z}


def _words(place: tuple[float, ...]) -> str:
    return ", ".join(f"{letter} {value:g}" for letter, value in zip(LETTERS, place, strict=False))


def _lab(config: dict[str, Any], bench: Bench, firmware: str) -> str:
    """The lab file."""
    lines = [f"      {name}: {_yaml(value)}" for name, value in config.items()]
    ranges = zip(bench.axes, bench.low, bench.high, strict=True)
    limits = ", ".join(
        f"{axis}: {{minimum: {low + 0.0:g}, maximum: {high + 0.0:g}}}" for axis, low, high in ranges
    )
    return "\n".join(
        [
            f"# A gantry ({firmware}), as `labrun setup gantry` found it.",
            "# docs/how-to/gantry.md explains each key.",
            "name: bench",
            "devices:",
            "  gantry:",
            "    contract: gantry@2                  # plays roles of gantry@1, too",
            "    driver: grbl",
            "    port: 4101                          # of `labrun serve`, not of the controller",
            "    config:",
            *lines,
            f"    limits: {{{limits}}}",
            "",
        ]
    )


def _yaml(value: Any) -> str:
    if isinstance(value, dict):
        return "{" + ", ".join(f"{name}: {_yaml(one)}" for name, one in value.items()) + "}"
    return str(value).lower() if isinstance(value, bool) else str(value)


async def _asked(question: str, default: str) -> str:
    """A line from the terminal; the port goes on being read meanwhile."""
    try:
        typed = await asyncio.to_thread(typer.prompt, question, default, show_default=bool(default))
    except typer.Abort:
        raise GaveUp("ended; nothing was written") from None
    return str(typed).strip().lower()


async def _yes(question: str) -> bool:
    return (await _asked(f"{question} [y/N]", "")).startswith("y")
