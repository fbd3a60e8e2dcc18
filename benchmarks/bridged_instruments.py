"""Count the instruments that bridges to Python libraries reach: `python bridged_instruments.py qcodes`.

Needs an environment with labrun and the library (`pip install labrun[qcodes] pyvisa-sim`). Two counts,
apart: classes whose generated lab entry checks without a problem, and instruments that the driver
really called through a simulator that the library ships. Through VISA only what is answered counts,
and what is set and then read back. PyMeasure has no simulator, but recorded conversations in its
tests: `python bridged_instruments.py pymeasure FOLDER/tests/instruments` runs those of a checkout,
with every property and method that the contract has going through the driver.
"""

import asyncio
import importlib
import io
import logging
import pkgutil
import sys
import tempfile
import warnings
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, redirect_stdout, suppress
from pathlib import Path

from labrun.drivers.driver import ActionFailed, GoalContext, Place
from labrun.drivers.find import find_driver
from labrun.engine.lab.lab import load_lab
from labrun.engine.new.device.entry import entry_text
from labrun.engine.new.device.sources import described
from labrun.engine.new.protocol import CannotMake
from labrun.schemas.good_calls import good_call

QCODES_SIMS = {
    "american_magnetics.AMIModel430": ("AMI430.yaml", "GPIB::1::INSTR"),
    "AimTTi.AimTTiPL601": ("AimTTi_PL601P.yaml", "GPIB::1::INSTR"),
    "CopperMountain.CopperMountainM5065": ("CopperMountain_M5065.yaml", "TCPIP0::localhost::hislip0::INSTR"),
    "CopperMountain.CopperMountainM5180": ("CopperMountain_M5180.yaml", "TCPIP0::localhost::hislip0::INSTR"),
    "Keithley.Keithley2450": ("Keithley_2450.yaml", "GPIB::2::INSTR"),
    "Keithley.Keithley2614B": ("Keithley_2600.yaml", "GPIB::1::INSTR"),
    "Keithley.Keithley3706A": ("Keithley_3706A.yaml", "GPIB::11::INSTR"),
    "Keithley.KeithleyS46": ("Keithley_s46.yaml", "GPIB::2::INSTR"),
    "Keithley.Keithley7510": ("keithley_7510.yaml", "GPIB::1::INSTR"),
    "Keysight.Keysight33511B": ("Keysight_33xxx.yaml", "GPIB::1::INSTR"),
    "Keysight.Keysight33512B": ("Keysight_33xxx.yaml", "GPIB::1::INSTR"),
    "Keysight.Keysight34465A": ("Keysight_34465A.yaml", "GPIB::1::INSTR"),
    "Keysight.Keysight34980A": ("keysight_34980A.yaml", "GPIB::1::INSTR"),
    "Keysight.KeysightB1500": ("keysight_b1500.yaml", "GPIB::1::INSTR"),
    "Keysight.KeysightB220X": ("keysight_b220x.yaml", "GPIB::1::INSTR"),
    "Keysight.KeysightE4980A": ("Keysight_E4980A.yaml", "GPIB::1::INSTR"),
    "Keysight.KeysightN6705B": ("Keysight_N6705B.yaml", "GPIB::1::INSTR"),
    "Keysight.KeysightN9030B": ("Keysight_N9030B.yaml", "GPIB::1::INSTR"),
    "Lakeshore.LakeshoreModel335": ("lakeshore_model335.yaml", "GPIB::2::INSTR"),
    "Lakeshore.LakeshoreModel336": ("lakeshore_model336.yaml", "GPIB::2::INSTR"),
    "Lakeshore.LakeshoreModel372": ("lakeshore_model372.yaml", "GPIB::3::INSTR"),
    "cryomagnetics.CryomagneticsModelTM620": ("cryo_tm620.yaml", "GPIB0::1::INSTR"),
    "oxford.OxfordMercuryiPS": ("MercuryiPS.yaml", "GPIB::1::INSTR"),
    "rigol.RigolDS1074Z": ("Rigol_DS1074Z.yaml", "GPIB::1::INSTR"),
    "rohde_schwarz.RohdeSchwarzSGS100A": ("RSSGS100A.yaml", "GPIB::1::INSTR"),
    "rohde_schwarz.RohdeSchwarzRTO1000": ("RTO_1000.yaml", "GPIB::1::INSTR"),
    "tektronix.TektronixAWG5014": ("Tektronix_AWG5014C.yaml", "GPIB::1::INSTR"),
    "tektronix.TektronixAWG5208": ("Tektronix_AWG5208.yaml", "GPIB::1::INSTR"),
    "tektronix.TektronixAWG70002A": ("Tektronix_AWG70000A.yaml", "GPIB::2::INSTR"),
    "weinschel.Weinschel8320": ("Weinschel_8320.yaml", "GPIB::1::INSTR"),
    "yokogawa.YokogawaGS200": ("Yokogawa_GS200.yaml", "GPIB::1::INSTR"),
    "stahl.Stahl": ("stahl.yaml", "ASRL3"),
}  # fmt: skip
"""Class -> the PyVISA-sim definition in `qcodes.instrument.sims` and its resource."""
NOT_INSTRUMENTS = (
    "Base",
    "Cam",
    "Plugin",
    "IO",
    "Signal",
    "Namespace",
    "Plugins",
    "Block",
    "Channel",
)
"""How parts of instruments are named."""
SETTINGS, EACH = 12, 25
"""Settings of an instrument, and about how many tests of a file are tried."""


def classes(package, kind, *, deep=False, whole=False):
    """Name -> class of every module of a package that can be imported here."""
    found = {}
    walk = pkgutil.walk_packages if deep else pkgutil.iter_modules
    prefix = f"{package.__name__}."
    for module in walk(package.__path__, *([prefix] if deep else [])):
        name = module.name.removeprefix(prefix)
        try:
            there = importlib.import_module(f"{prefix}{name}")
        except (Exception, SystemExit):  # a module that needs more than this environment has
            continue
        for word, one in sorted(vars(there).items()):
            public = not word.startswith("_") and isinstance(one, type) and issubclass(one, kind)
            inside = one.__module__.startswith(package.__name__) if public else False
            if inside and not any(part.startswith("_") for part in name.split(".")):
                found.setdefault(one, f"{prefix if whole else ''}{name}.{word}")
    return {name: one for one, name in found.items()}


def pymeasure_names():
    """Every class of instruments."""
    import pymeasure.instruments as package

    found = classes(package, package.Instrument)
    return sorted(
        n for n, one in found.items() if one.__module__ != f"{package.__name__}.instrument"
    )


def qcodes_names():
    """Every class of instruments, without those that QCoDeS has for its own tests."""
    import qcodes.instrument_drivers as package
    from qcodes.instrument import Instrument

    return sorted(n for n in classes(package, Instrument) if not n.startswith("mock_instruments"))


def ophyd_names():
    """Devices of ophyd and ophyd-async, without their parts, base classes and simulations."""
    import ophyd
    import ophyd_async

    here = [
        n
        for n, one in vars(ophyd).items()
        if isinstance(one, type) and issubclass(one, ophyd.Device)
    ]
    there = classes(ophyd_async, ophyd_async.core.Device, deep=True, whole=True)
    ours = [f"ophyd.{name}" for name in here]
    ours += [n for n in there if ".epics." in n or ".fastcs." in n]
    return sorted(n for n in ours if not n.endswith(NOT_INSTRUMENTS) and ".testing" not in n)


def pylabrobot_names():
    """Every kind of machine; each has backends for several makes."""
    import pylabrobot
    from pylabrobot.machines import Machine

    return sorted(n for n in classes(pylabrobot, Machine) if not n.startswith("machines."))


def written(library, names):
    """Print what does not generate a contract that checks; the names of what does."""
    good, actions, long = [], 0, 0
    with tempfile.TemporaryDirectory() as folder:
        for name in names:
            try:
                lab, problems, text = lab_of(f"{library}:{name}", Path(folder))
            except CannotMake as fault:
                print(f"  {name}: {str(fault)[:150]}")
                continue
            if problems or lab is None:
                print(f"  {name}: {problems[0].message}")
                continue
            good.append(name)
            actions += len(lab.contracts["device@1"].actions)
            long += len(text.splitlines()) > 110
    print(
        f"{library}: {len(good)} of {len(names)} make a contract that checks, with {actions} actions; "
        f"{len(good) - long} of them in at most 120 lines with their test"
    )
    return good


def lab_of(source, folder):
    """The lab that is written for a source."""
    with redirect_stdout(io.StringIO()):
        text = f"devices:\n{entry_text('device', described(source))}"
    path = folder / "lab.yaml"
    path.write_text(text, "utf-8")
    return *load_lab(path), text


def called(source, also=(), **more):
    """What the driver did through a simulator: Counter of `read`, `done`, `back` and `failed`."""
    seen = Counter()
    with tempfile.TemporaryDirectory() as folder:
        lab, _, _ = lab_of(source, Path(folder))
        config = {**lab.lab.devices["device"].config, **more, "timeout": 3}
        contract = lab.contracts["device@1"]

        def with_driver(story):
            place = Place("device", config, {}, Path(folder), Path(folder), contract)
            driver = find_driver(lab.lab.devices["device"].driver, Path())(place)

            async def all_of_it():
                await driver.open()
                try:
                    await story(driver)
                finally:
                    await driver.close()

            asyncio.run(all_of_it())

        async def do(driver, name):
            params = good_call(contract.actions[name])
            return params, await driver.method(name)(GoalContext(f"run/{name}"), **params)

        async def readings(driver):
            for name, action in contract.actions.items():
                if (action.effect != "pure" and name not in also) or name == "last_once":
                    continue
                try:
                    _, result = await do(driver, name)
                    if "ERROR" in result.values():  # what PyVISA-sim says to what it does not know
                        seen["failed"] += 1
                    else:
                        seen["read" if result else "done"] += 1
                except ActionFailed:
                    seen["failed"] += 1

        with_driver(readings)
        pairs = [
            n[4:]
            for n in contract.actions
            if n.startswith("set_") and f"read_{n[4:]}" in contract.actions
        ]
        for name in pairs[:SETTINGS]:

            async def set_and_read(driver, name=name):
                with suppress(ActionFailed):
                    params, _ = await do(driver, f"set_{name}")
                    _, result = await do(driver, f"read_{name}")
                    seen["back"] += list(params.values()) == list(result.values())

            with_driver(set_and_read)
    return seen


def simulated(name, runs):
    """Print what each simulator answered, and how many instruments did."""
    total, counted, told = Counter(), 0, 0
    for source, also, more in runs:
        try:
            with redirect_stdout(io.StringIO()):
                seen = called(source, also, **more)
        except (CannotMake, OSError, ValueError, AttributeError) as fault:
            print(f"  {source}: {str(fault)[:150]}")
            continue
        print(f"  {source}: {dict(seen)}")
        counted += bool(seen["read"] + seen["back"])
        told += bool(seen["done"]) and not seen["read"] + seen["back"]
        total += seen
    print(
        f"{name}: of {len(runs)} simulators {counted} answered the driver, {told} took what it was told: "
        f"{total['read']} readings, {total['back']} settings that were read back, {total['done']} other "
        f"actions, {total['failed']} failures"
    )


def qcodes_runs():
    """Instruments of which QCoDeS ships a PyVISA-sim definition."""
    for name, (sim, resource) in QCODES_SIMS.items():
        yield f"qcodes:{name}", (), {"resource": resource, "options": {"pyvisa_sim_file": sim}}


def ophyd_runs():
    """The devices that `ophyd.sim` and `ophyd_async.sim` have."""
    from ophyd import sim

    for name in vars(sim.hw()):
        yield f"ophyd:sim.{name}", ("trigger", "stop"), {}
    for name in ("SimMotor", "HorizontalMirror", "VerticalMirror"):
        yield f"ophyd:ophyd_async.sim.{name}", ("stop", "move"), {}


def pylabrobot_runs():
    """Machines with the backends that print what they are told."""
    for name in pylabrobot_names():
        with suppress(CannotMake):
            known = described(f"pylabrobot:{name}")
            if "Chatterbox" in known.config.get("backend", "") and "deck" not in known.config:
                yield f"pylabrobot:{name}", tuple(known.actions), {}


class Conversations:
    """A plugin of pytest: PyMeasure's own tests, with the driver between them and the instrument."""

    def __init__(self):
        self.passed, self.failed, self.classes = 0, 0, Counter()
        self.now = Counter()
        import pymeasure.test as there

        original = there.expected_protocol

        @contextmanager
        def through_the_driver(kind, *given, **more):
            with original(kind, *given, **more) as instrument:
                yield Between(kind, instrument, self.now)

        there.expected_protocol = through_the_driver

    def pytest_collection_modifyitems(self, items):
        """Some of each file: it repeats one test with thousands of values."""
        by_file = {}
        for item in items:
            by_file.setdefault(item.path, []).append(item)
        items[:] = [one for some in by_file.values() for one in some[:: max(1, len(some) // EACH)]]

    def pytest_runtest_setup(self):
        """Count the calls of this test alone."""
        self.now.clear()

    def pytest_runtest_logreport(self, report):
        """Count a test that called the driver."""
        if report.when == "call" and self.now:
            self.passed += report.passed
            self.failed += report.failed
            if report.passed:
                self.classes.update(self.now.keys())


ENTRIES = {}
"""Class -> its lab, or None."""


class Between:
    """Stands for an instrument of PyMeasure: what the contract has goes through the driver."""

    def __init__(self, kind, instrument, counted):
        self.__dict__.update(_instrument=instrument, _kind=kind, _counted=counted, _driver=None)
        if kind not in ENTRIES:
            ENTRIES[kind] = None
            name = f"{kind.__module__.removeprefix('pymeasure.instruments.')}.{kind.__name__}"
            with suppress(CannotMake), tempfile.TemporaryDirectory() as folder:
                ENTRIES[kind] = lab_of(f"pymeasure:{name}", Path(folder))[0]
        lab = ENTRIES[kind]
        if lab is not None:
            folder = Path(tempfile.mkdtemp())
            device = lab.lab.devices["device"]
            place = Place("device", device.config, {}, folder, folder, lab.contracts["device@1"])
            driver = find_driver("pymeasure", Path())(place)
            driver.record.open()
            driver._instrument, driver._thread = instrument, ThreadPoolExecutor(1)
            self.__dict__["_driver"] = driver

    def _through(self, action, **values):
        try:
            result = asyncio.run(self._driver.method(action)(GoalContext("run/1"), **values))
        except ActionFailed as failure:
            fault = failure
            while fault.__cause__ is not None:  # what the library itself raised
                fault = fault.__cause__
            raise fault from None
        self._counted[f"{self._kind.__module__}.{self._kind.__name__}"] += 1
        return next(iter(result.values()), None)

    def _has(self, action):
        return self._driver is not None and action in self._driver.contract_kept.actions

    def __getattr__(self, name):
        if self._has(f"read_{name}"):
            return self._through(f"read_{name}")
        if self._has(name):
            return lambda *given, **more: (
                self._through(name, **more)
                if not given
                else getattr(self._instrument, name)(*given, **more)
            )
        return getattr(self._instrument, name)

    def __setattr__(self, name, value):
        plain = type(value) in (bool, int, float, str, list)
        if plain and self._has(f"set_{name}"):
            self._through(f"set_{name}", **{name: value})
        else:
            setattr(self._instrument, name, value)


def conversations(folder):
    """Run PyMeasure's recorded conversations through the driver."""
    import pytest

    plugin = Conversations()
    pytest.main(
        [
            "-q",
            "--no-header",
            "-p",
            "no:cacheprovider",
            "--tb=line",
            "--continue-on-collection-errors",
            "--ignore-glob=*with_device*",
            folder,
        ],
        plugins=[plugin],
    )
    print(
        f"pymeasure: {len(plugin.classes)} classes were really called, by {plugin.passed} of its own "
        f"tests; {plugin.failed} failed through the driver"
    )


def main():
    """Both counts of one library."""
    warnings.simplefilter("ignore")
    logging.disable(logging.CRITICAL)
    library, *folder = sys.argv[1:]
    written(library, globals()[f"{library}_names"]())
    if folder:
        conversations(folder[0])
    elif library != "pymeasure":
        simulated(library, list(globals()[f"{library}_runs"]()))


if __name__ == "__main__":
    main()
