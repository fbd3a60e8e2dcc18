"""What is installed on request: the extra that brings a library, and the one line that adds it.

A library may also be there and lack another one of the system's, which pip does not bring.
"""

import sys
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any

EXTRAS = {
    "spectra": ("numpy", "scipy", "numba", "matplotlib", "pyarrow"),
    "numpy": ("numpy",),
    "vision": ("cv2", "numpy"),
    "realsense": ("pyrealsense2", "cv2", "numpy"),
    "oak": ("depthai", "cv2", "numpy"),
    "web": ("fastapi", "starlette", "numpy"),
    "mcp": ("mcp",),
    "gui": ("pyautogui", "PIL", "cv2", "numpy"),
    "ros": ("roslibpy",),
    "dask": ("distributed", "dask"),
    "formats": ("avaread", "h5py", "python_calamine", "sif_parser", "spc_io"),
    "export": ("h5py", "mcap", "tifffile", "numpy"),
    "notebook": ("pandas", "tqdm", "xarray"),
    "optimize": ("sklearn", "scipy", "threadpoolctl", "numpy"),
    "quant": ("sklearn", "scipy", "numpy"),
    "optuna": ("optuna", "numpy"),
    "gpcam": ("gpcam", "numpy"),
    "baybe": ("baybe", "numpy"),
    "notify": ("apprise",),
    "visa": ("pyvisa",),
    "modbus": ("pymodbus",),
    "pymeasure": ("pymeasure",),
    "qcodes": ("qcodes",),
    "pylabrobot": ("pylabrobot",),
    "sila2": ("sila2",),
    "opcua": ("asyncua",),
    "ophyd": ("ophyd", "ophyd_async"),
    "zaber": ("zaber_motion",),
}
"""Extra -> the libraries that labrun imports from it, as pyproject.toml has them."""
OF_DRIVERS = {
    "sim_depth_camera": "vision", "stereo_camera": "vision", "realsense": "realsense", "oak": "oak",
    "reducer": "spectra", "apprise": "notify", "zaber": "zaber",
    "gp": "optimize", "optuna": "optuna", "gpcam": "gpcam", "baybe": "baybe",
    "sciaps_gui": "gui", "window_program": "gui",
    "modbus": "modbus", "pymeasure": "pymeasure", "qcodes": "qcodes", "ophyd": "ophyd",
    "pylabrobot": "pylabrobot", "sila2": "sila2", "opcua": "opcua",
}  # fmt: skip
"""Driver of a lab -> the extra without which it cannot work, so that nothing is loaded to find out."""
OF_THE_SYSTEM = {
    "libusb": "apt-get install libusb-1.0-0",
    "libGL.so": "apt-get install libgl1",
    "libgthread": "apt-get install libglib2.0-0",
    "DLL load failed": "Microsoft's Visual C++ Redistributable",
}
"""What a loader says -> what adds it: pyrealsense2's wheel for Linux wants libusb, OpenCV with windows the
next two, and most compiled wheels for Windows the last."""


def line(extra: str) -> str:
    """What adds an extra to the Python that is running."""
    return f'{_python()} -m pip install "labrun[{extra}]"'


def not_installed(fault: ImportError, extra: str | None = None) -> str | None:
    """`matplotlib is not installed; add it with ...`; None where the library is in no extra.

    `extra` is the one to name where several bring the library. Of a library that is there and that
    the system does not load, what the system says, and what it lacks where that is known.
    """
    library = (fault.name or "").partition(".")[0]
    if extra is None or library not in EXTRAS[extra]:
        extra = next((name for name, brought in EXTRAS.items() if library in brought), None)
    if extra is None:
        return None
    if not isinstance(fault, ModuleNotFoundError):
        return f"{library} is installed, but cannot be loaded: {_why(fault)}"
    return f"{library} is not installed; add it with: {line(extra)}"


def needed(module: str) -> Any:
    """The module of an extra; raises OSError with the line that adds it."""
    try:
        return import_module(module)
    except ImportError as fault:
        raise OSError(not_installed(fault) or str(fault)) from fault


def in_words(fault: BaseException) -> str:
    """A fault that nobody foresaw: `ValueError: ...`, or what a library of an extra lacks."""
    why = not_installed(fault) if isinstance(fault, ImportError) else None
    return why or f"{type(fault).__name__}: {fault}"


def _why(fault: ImportError) -> str:
    said = " ".join(str(fault).split())
    adds = next((adds for part, adds in OF_THE_SYSTEM.items() if part in said), None)
    return f"{said}; add it with: {adds}" if adds else said


def missing(extra: str) -> str | None:
    """The same for the first library of an extra that is not there; None if all of them are."""
    return next(filter(None, (absent(library, extra) for library in EXTRAS[extra])), None)


def absent(library: str, extra: str | None = None) -> str | None:
    """The same for one library, which is not loaded to find out."""
    try:
        there = sys.modules.get(library) or find_spec(library)
    except (ImportError, ValueError):
        there = None
    return not_installed(ModuleNotFoundError(name=library), extra) if there is None else None


def _python() -> str:
    """This Python as a shell takes it: from the current folder where it lies below that."""
    python = Path(sys.executable or "python")
    if python.is_relative_to(Path.cwd()):
        python = python.relative_to(Path.cwd())
    return f'"{python}"' if " " in str(python) else str(python)
