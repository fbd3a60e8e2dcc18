"""Builds the page (web/src -> web/app-dist) before setuptools collects the package's data.

Without npm nothing is lost but the page: `labrun web` then says how to build it. In an sdist the
built page is there and its sources are not. LABRUN_SKIP_PAGE leaves it as it is, LABRUN_REQUIRE_PAGE
lets an installation fail that could not build it.
"""

import os
import shutil
import subprocess
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


def is_stale(web: Path) -> bool:
    """True where the page was not built, or is older than what it is made of."""
    built = web / "app-dist" / "index.html"
    if not built.exists():
        return True
    sources = (p for name in INPUTS for p in (web / name, *(web / name).rglob("*")) if p.is_file())
    return max((p.stat().st_mtime for p in sources), default=0.0) > built.stat().st_mtime


def build_page(web: Path, say: Callable[[str], None]) -> None:
    """Build it where that is needed and possible; otherwise say why not, and go on."""
    there = (web / "package-lock.json").exists()
    if os.environ.get("LABRUN_SKIP_PAGE") or not there or not is_stale(web):
        return
    npm = shutil.which("npm")
    try:
        if npm is None:
            raise OSError("npm was not found; Node 20 or newer brings it")
        for step in STEPS:
            subprocess.run(
                [npm, *step], cwd=web, check=True, stdin=subprocess.DEVNULL, timeout=STEP_S
            )
    except (OSError, subprocess.SubprocessError) as fault:
        if os.environ.get("LABRUN_REQUIRE_PAGE"):
            raise
        say(
            f"labrun: the page is not built: {fault}. Everything else works; see docs/how-to/web.md"
        )


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
    )
