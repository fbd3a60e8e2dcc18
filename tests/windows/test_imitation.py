"""What people do, under Windows' rules (`rules/sitecustomize.py`) and on a console of code page 1252.

Every process has them: the command, the engine, the device servers.
"""

import json
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

RULES = Path(__file__).parent / "rules"
PROTOCOLS = Path(__file__).parents[2] / "protocols"
MAP = str(PROTOCOLS / "pegmatite_map.yaml")
LONGEST = 259
CTRL_BREAK = getattr(signal, "SIGUSR1", None)
"""As the rules have it."""

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="the real one has them itself")


@pytest.fixture
def environment(tmp_path):
    return {
        **os.environ, "PYTHONPATH": str(RULES), "PYTHONUTF8": "0", "PYTHONIOENCODING": "cp1252",
        "XDG_STATE_HOME": str(tmp_path / "state"),
    }  # fmt: skip


@pytest.fixture
def labrun(tmp_path, environment):
    """Runs a command; gives its exit status and its output."""

    def run(*words):
        ran = subprocess.run(
            [sys.executable, "-m", "labrun.engine", *words],
            cwd=tmp_path, env=environment, capture_output=True, encoding="cp1252",
        )  # fmt: skip
        return ran.returncode, ran.stdout + ran.stderr

    return run


@pytest.fixture
def python(tmp_path, environment):
    """Runs a program of Python; gives what came of it."""

    def run(program):
        return subprocess.run(
            [sys.executable, "-c", program],
            cwd=tmp_path, env=environment, capture_output=True, text=True,
        )  # fmt: skip

    return run


@pytest.fixture
def started(tmp_path, environment):
    """Starts a command, and gives its process when a line of its output contains a word."""
    processes = []

    def start(word, *words):
        process = subprocess.Popen(
            [sys.executable, "-m", "labrun.engine", *words], cwd=tmp_path, env=environment,
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, encoding="cp1252",
        )  # fmt: skip
        processes.append(process)
        assert process.stdout is not None
        read = []
        for line in process.stdout:
            read.append(line)
            if word in line:
                process.said = "".join(read)
                return process
        raise AssertionError("".join(read))

    yield start
    for process in processes:
        process.kill()
        process.communicate()


def journal(tmp_path):
    (run,) = (tmp_path / "runs").iterdir()
    return (run / "journal.jsonl").read_bytes()


def test_the_rules_are_kept(python):
    broken = """
import os, subprocess, sys, time
from pathlib import Path
sys._getframe().f_globals["__name__"] = "labrun.x"
def tried(act):
    try: act()
    except (OSError, AttributeError, ImportError) as fault: return type(fault).__name__
def fsync_what_is_only_read():
    number = os.open("a", os.O_RDONLY | os.O_BINARY)
    try: os.fsync(number)
    finally: os.close(number)
def write_without_binary():
    number = os.open("b", os.O_WRONLY | os.O_CREAT)
    os.write(number, b"1\\n")
    os.close(number)
def import_fcntl():
    import fcntl
open("a", "w").close()
held = open("a")
write_without_binary()
Path("c").write_text("\u00fc\\n")
other = subprocess.Popen([sys.executable, "-c", "input()"], stdin=subprocess.PIPE, stdout=open("d", "w"))
print([tried(act) for act in (
    fsync_what_is_only_read, lambda: os.open(".", os.O_RDONLY), lambda: os.unlink("a"),
    lambda: os.replace("b", "a"), lambda: open("a:b", "w"), lambda: open("nul.csv", "w"),
    lambda: os.fdatasync(1), import_fcntl, *[lambda: os.unlink("d")] * 3,
)], open("b", "rb").read(), open("c", "rb").read(), time.time() * 64 % 1, time.monotonic() * 64 % 1)
other.communicate(b"\\n")
"""
    ran = python(broken)

    assert ran.stdout.strip() == str(
        [
            "OSError", "PermissionError", "PermissionError", "PermissionError", "OSError", "OSError",
            "AttributeError", "ModuleNotFoundError", *["PermissionError"] * 3,
        ]
    ) + r" b'1\r\n' b'\xfc\r\n' 0.0 0.0", ran.stderr  # fmt: skip


def test_a_file_that_a_virus_scanner_holds_is_replaced_when_it_lets_go(python):
    program = (
        "import os\nfrom pathlib import Path\nfrom labrun.system.files import replace_whole, write_whole\n"
        "write_whole(Path('a'), b'one')\nwrite_whole(Path('a'), b'two')\n"
        "with replace_whole(Path('b')) as file:\n    file.write(b'three')\n"
        "print(Path('a').read_text(), Path('b').read_text(), sorted(os.listdir()))\n"
    )
    ran = python(program)

    assert ran.stdout.strip() == "two three ['a', 'b']", ran.stderr


@pytest.mark.soak
def test_the_page_is_served_and_ends_on_ctrl_break(started, tmp_path):
    (tmp_path / "hello.yaml").write_bytes((PROTOCOLS / "hello.yaml").read_bytes())
    serving = started("labrun web at", "web", ".", "--no-browser", "--port", "0")
    serving.send_signal(CTRL_BREAK)
    status = serving.wait()

    assert status == 0, serving.stdout.read()


@pytest.mark.soak
def test_spectra_are_reduced_by_several_processes(labrun, tmp_path):
    folder = tmp_path / "Spektren ü"
    folder.mkdir()
    for number in range(3):
        rows = (f"{200 + n / 5:.1f},{100 + (n * 7 + number) % 13}" for n in range(600))
        (folder / f"shot {number}.csv").write_text("wavelength,intensity\n" + "\n".join(rows))
    status, said = labrun("reduce", str(folder), "--jobs", "2", "-o", "tables")

    assert status == 0, said
    assert (tmp_path / "tables" / "peaks.csv").exists()


def test_who_closes_the_window_lets_a_process_end_in_order_and_a_service_outlives_a_logoff(
    python,
):
    program = """
import asyncio, sitecustomize, threading
from labrun.system.signals import on_end
async def main():
    told = asyncio.get_running_loop().create_future()
    on_end(told.set_result)
    (hear,) = sitecustomize.console_handlers
    print(hear(1), hear(5), told.done())   # Ctrl-Break is `signal`'s; a logoff is another person's
    window = threading.Thread(target=hear, args=(2,), daemon=True)
    window.start()
    print(await told, window.is_alive())   # as long as it has not returned, Windows waits
asyncio.run(main())
"""
    ran = python(program)

    assert ran.stdout.splitlines() == ["0 1 False", "the window's end True"], ran.stderr


def test_devices_whose_folders_windows_cannot_make_are_told_by_a_check(labrun, tmp_path):
    devices = "".join(
        f"  {name}: {{contract: balance@1, driver: sim_balance}}\n" for name in ("com1", "A", "a")
    )
    (tmp_path / "lab.yaml").write_text(f"name: bench\nsimulated: true\ndevices:\n{devices}")
    status, said = labrun("check", str(PROTOCOLS / "hello.yaml"), "--lab", "lab.yaml")

    assert status == 2
    assert "on Windows no folder can be named com1" in said
    assert "A and a would share a folder on Windows and macOS" in said


def test_a_pipe_that_is_closed_is_no_fault_of_ours(python):
    program = (
        "import errno, sys\nfrom labrun.engine import cli\n"
        "class Closed(type(sys.stdout)):\n"
        "    def write(self, text): raise OSError(errno.EINVAL, 'Invalid argument')\n"
        "sys.stdout = Closed(sys.stdout.buffer)\nsys.argv = ['labrun', 'problem', 'E204']\ncli.main()\n"
    )
    ran = python(program)

    assert (ran.returncode, ran.stderr) == (0, "")


def test_torture_says_what_windows_lacks(labrun):
    status, said = labrun("torture", MAP)

    assert status == 2
    assert "torture needs SIGKILL" in said


@pytest.mark.slow
def test_a_run_succeeds_and_its_journal_is_that_of_other_systems(tmp_path, labrun):
    text = (PROTOCOLS / "hello.yaml").read_text(encoding="utf-8").replace("Hello", "Grüße → 日本,")
    (tmp_path / "hello.yaml").write_text(text, encoding="utf-8")
    status, said = labrun("run", "hello.yaml")

    assert status == 0, said
    assert "Grüße ? ??, from" in said
    assert b"\r" not in journal(tmp_path)


def test_a_run_whose_files_would_have_too_long_names_is_refused_before_it_begins(tmp_path, labrun):
    runs = "a" * 50 + "/" + "b" * (LONGEST - 150 - len(str(tmp_path)))
    (tmp_path / "hello.yaml").write_bytes((PROTOCOLS / "hello.yaml").read_bytes())
    status, said = labrun("run", "hello.yaml", "--runs", runs)

    assert status == 1
    assert "a path may have 259 characters" in said and "--runs" in said
    assert list(tmp_path.glob("a*/b*/*")) == []


@pytest.mark.soak
def test_a_run_whose_engine_is_killed_is_resumed(tmp_path, started, labrun):
    engine = started("run ", "run", MAP, "-p", "pitch=1 mm")
    while b'"kind":"ended"' not in journal(tmp_path):
        time.sleep(0.05)
    engine.kill()
    engine.wait()
    (run,) = (tmp_path / "runs").iterdir()
    status, said = labrun("resume", run.name)
    kinds = [json.loads(line)["kind"] for line in journal(tmp_path).splitlines()]

    assert status == 0, said
    assert kinds.count("resumed") == 1
    assert b"\r" not in journal(tmp_path)


@pytest.mark.soak
def test_device_servers_end_in_order_on_ctrl_break(started, tmp_path):
    serving = started("serving", "serve", "--port", "0")
    serving.send_signal(CTRL_BREAK)
    status = serving.wait()

    assert status == 0
    assert list(tmp_path.glob("**/server.json")) == []  # each has left in order


@pytest.mark.slow
def test_an_instruments_computer_serves_it_by_one_command_to_whoever_has_the_token(
    started, labrun, tmp_path
):
    token = "sixteen-characters-and-more"
    # As PowerShell writes it: `"..." > token.txt`.
    (tmp_path / "token.txt").write_text(f"{token}\n", encoding="utf-16", newline="\r\n")
    analyser = "analyser: {contract: libs_analyzer@1, driver: sim_libs, config: {clock: fast}}"
    (tmp_path / "lab.yaml").write_text(f"name: bench\nsimulated: true\ndevices:\n  {analyser}\n")
    words = (
        "lab.yaml",
        "analyser",
        "--host",
        "127.0.0.1",
        "--port",
        "0",
        "--token-file",
        "token.txt",
    )
    serving = started("serving", "serve", *words)
    url = re.search(r"http://[\d.:]+", serving.said)[0]
    for name, token_line in (("with", f", token: {token}"), ("without", "")):
        device = f'{{contract: libs_analyzer@1, url: "{url}"{token_line}}}'
        (tmp_path / f"{name}.yaml").write_text(f"name: {name}\ndevices:\n  analyser: {device}\n")
    status, said = labrun("call", "analyser.measure", "--yes", "--lab", "with.yaml")
    refused, why = labrun("call", "analyser.measure", "--yes", "--lab", "without.yaml")

    assert status == 0, said
    assert "shot" in said
    assert refused != 0 and "token" in why


@pytest.mark.slow
@pytest.mark.parametrize(
    "words",
    [
        ("check", MAP), ("explain", MAP), ("rehearse", str(PROTOCOLS / "hello.yaml")), ("new", "my_scan"),
        ("schema",), ("problem", "E204"), ("lines", "Li"), ("--help",),
    ],
    ids=lambda words: words[0],
)  # fmt: skip
def test_a_command_of_every_group_ends_well(labrun, words):
    status, said = labrun(*words)

    assert status == 0, said
