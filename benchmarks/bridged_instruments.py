"""Count the instruments of PyMeasure whose generated lab entry checks: `python bridged_instruments.py`.

Needs an environment with labrun and PyMeasure. It counts what generates a contract without a
problem, by class; it calls none of them.
"""

import importlib
import pkgutil
import tempfile
import warnings
from pathlib import Path

from labrun.engine.lab.lab import load_lab
from labrun.engine.new.device.entry import entry_text
from labrun.engine.new.device.sources import described


def classes():
    """`keithley.Keithley2000`, ... of every module that can be imported here."""
    import pymeasure.instruments as package

    for module in pkgutil.iter_modules(package.__path__):
        try:
            there = importlib.import_module(f"{package.__name__}.{module.name}")
        except Exception as fault:  # a module that needs more than this environment has
            print(f"{module.name}: not imported: {fault}")
            continue
        for name, one in sorted(vars(there).items()):
            if (
                isinstance(one, type)
                and issubclass(one, package.Instrument)
                and one.__module__ != (f"{package.__name__}.instrument")
            ):
                yield f"{module.name}.{name}"


def main():
    """Print one line for each class that does not, and the count."""
    warnings.simplefilter("ignore")
    good = actions = 0
    names = sorted(set(classes()))
    with tempfile.TemporaryDirectory() as folder:
        for name in names:
            path = Path(folder) / "lab.yaml"
            try:
                path.write_text(
                    f"devices:\n{entry_text('device', described(f'pymeasure:{name}'))}", "utf-8"
                )
                lab, problems = load_lab(path)
            except Exception as fault:
                print(f"{name}: {type(fault).__name__}: {fault}")
                continue
            if problems or lab is None:
                print(f"{name}: {problems[0].message}")
                continue
            good += 1
            actions += len(lab.contracts["device@1"].actions)
    print(f"{good} of {len(names)} classes make a contract that checks, with {actions} actions")


main()
