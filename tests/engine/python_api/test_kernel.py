"""In a real Jupyter kernel: what a scientist sees of refusals, and that an interrupt aborts a run."""

import threading
import time

import pytest

# Warnings are Jupyter's own.
pytestmark = [pytest.mark.slow, pytest.mark.needs("kernel"), pytest.mark.filterwarnings("ignore")]
LONG = """labrun: 1
name: long
devices: {gantry: gantry@1}
steps:
  - foreach: {n: "${{ range(100000) }}"}
    steps: [{wait: 50 ms}]
finally: [{do: gantry.home}]
"""


@pytest.fixture
def notebook(tmp_path):
    """Executes a cell, and returns its outputs and its error."""
    import nbclient
    import nbformat

    (tmp_path / "long.yaml").write_text(LONG)
    (tmp_path / "bad.yaml").write_text(LONG.replace("home", "hoem"))
    book = nbformat.v4.new_notebook()
    resources = {"metadata": {"path": str(tmp_path)}}
    client = nbclient.NotebookClient(book, timeout=120, allow_errors=True, resources=resources)

    def execute(source):
        book.cells.append(nbformat.v4.new_code_cell(source))
        client.execute_cell(book.cells[-1], len(book.cells) - 1)
        outputs = book.cells[-1].outputs
        return str(outputs), next((o for o in outputs if o.output_type == "error"), None)

    with client.setup_kernel():
        execute.client, execute.folder = client, tmp_path
        execute("import labrun")
        yield execute


def interrupted(notebook, source):
    """Execute a cell that begins a run, and interrupt the kernel once the run is under way."""
    before = len(list(notebook.folder.glob("runs/*/control.json")))

    def interrupt():
        while len(list(notebook.folder.glob("runs/*/control.json"))) == before:
            time.sleep(0.05)
        notebook.client.km.provisioner.process.send_signal(2)

    interrupting = threading.Thread(target=interrupt)
    interrupting.start()
    try:
        return notebook(source)
    finally:
        interrupting.join()


def test_a_refusal_is_its_sentence_and_no_traceback(notebook):
    _, fault = notebook("labrun.run('bad.yaml')")

    assert fault.ename == "ProtocolFault"
    assert "bad.yaml:7:16: error[E202]" in fault.traceback[0] and "File" not in str(fault.traceback)
    assert "did you mean home?" in str(fault.traceback)


@pytest.mark.posix("signals of POSIX")
def test_interrupting_a_cell_aborts_its_run_and_the_kernel_goes_on(notebook):
    shown, fault = interrupted(notebook, "run = labrun.run('long.yaml'); run")
    _, cancelled = interrupted(notebook, "await labrun.arun('long.yaml')")
    later, none = notebook("[run.fate for run in labrun.runs()]")

    assert fault is None and "aborted by Ctrl-C" in shown
    assert cancelled.ename == "CancelledError"
    assert none is None and "['aborted', 'aborted']" in later
