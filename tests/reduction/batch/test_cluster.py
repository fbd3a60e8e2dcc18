"""A real cluster: scheduler and workers are processes of their own, reached over TCP."""

import contextlib
import importlib.util
import socket
import subprocess
import sys
import time

import pytest

from labrun.reduction.batch.batch import Batch
from labrun.reduction.batch.executor import ExecutorFault, ExecutorUnreachable
from labrun.reduction.batch.gather import gather
from labrun.reduction.batch.job import job_in
from labrun.reduction.batch.pool import Pool
from labrun.reduction.batch.settings import Settings
from labrun.reduction.batch.summary import Circumstances
from labrun.reduction.batch.versions import versions

pytestmark = [
    pytest.mark.skipif(
        importlib.util.find_spec("distributed") is None, reason="the extra `dask` is not installed"
    ),
    # Dask leaves sockets of its event loop to the collector when a client is closed.
    pytest.mark.filterwarnings("ignore::ResourceWarning"),
    pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning"),
]
UP_S = 500


def free_port() -> int:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        return taken.getsockname()[1]


@pytest.fixture
def processes(tmp_path):
    """Starts dask's own command lines; everything is ended afterwards."""
    started = []

    def start(module, *arguments):
        log = (tmp_path / f"{len(started)}.log").open("wb")
        process = subprocess.Popen(
            [sys.executable, "-m", f"distributed.cli.{module}", *arguments, "--no-dashboard"],
            stdout=log, stderr=log, start_new_session=True,
        )  # fmt: skip
        log.close()
        started.append(process)
        return process

    yield start
    import psutil

    for process in started:
        with contextlib.suppress(psutil.NoSuchProcess):
            for child in psutil.Process(process.pid).children(
                recursive=True
            ):  # of a worker's nurse
                child.kill()
        process.kill()
        process.wait(10)


@pytest.fixture
def scheduler(processes):
    """The address of a scheduler without workers, and its process."""
    port = free_port()
    process = processes("dask_scheduler", "--host", "127.0.0.1", "--port", str(port))
    ends = time.monotonic() + UP_S
    while time.monotonic() < ends:
        with socket.socket() as door:
            if door.connect_ex(("127.0.0.1", port)) == 0:
                return f"tcp://127.0.0.1:{port}", process
        time.sleep(0.1)
    raise AssertionError("the scheduler did not come up")


@pytest.fixture
def address(scheduler, processes, tmp_path):
    """The address of a scheduler with two workers, each a process."""
    for n in range(2):
        new_worker(processes, scheduler[0], tmp_path / f"worker{n}")
    return scheduler[0]


def new_worker(processes, address, folder):
    return processes(
        "dask_worker", address, "--nthreads", "1", "--no-nanny", "--local-directory", str(folder)
    )


def reduce_into(out, folder, executor):
    found = gather([folder], out)
    about = Circumstances(Settings(), "", folder, found.left_aside)
    try:
        with job_in(out, about) as job:
            batch = Batch(executor, job.spool)
            batch.add(found.spectra)
            batch.run()
            return job.write()
    finally:
        executor.close()


@pytest.mark.soak
def test_a_cluster_writes_the_same_bytes_as_this_machine(spectra, tmp_path, address, tables_of):
    from labrun.reduction.batch.cluster import Cluster

    (spectra / "empty.csv").write_text("")
    (spectra / "link.csv").symlink_to("/nowhere")
    counts = reduce_into(tmp_path / "there", spectra, Cluster(address, Settings(), UP_S))
    reduce_into(tmp_path / "here", spectra, Pool(2, Settings(), lambda: None))

    assert counts.reduced == 6
    assert tables_of(tmp_path / "there") == tables_of(tmp_path / "here")


@pytest.mark.soak
def test_a_worker_that_dies_costs_nothing_but_time(many, tmp_path, address, scheduler, processes):
    from labrun.reduction.batch.cluster import Cluster

    mortal = new_worker(processes, scheduler[0], tmp_path / "mortal")
    executor = Cluster(address, Settings(), UP_S)
    executor.client.wait_for_workers(3, timeout=UP_S)
    for path in sorted(many.iterdir())[60:]:
        path.unlink()
    starts = []
    real = executor.start

    def start(number, chunk):
        real(number, chunk)
        starts.append(number)
        if len(starts) == 4:
            mortal.kill()

    executor.start = start
    counts = reduce_into(tmp_path / "out", many, executor)

    assert (counts.reduced, counts.failed) == (60, [])
    assert mortal.wait(10) != 0


def test_other_versions_on_a_worker_are_told():
    from labrun.reduction.batch.cluster import differing

    here = versions()

    assert differing({"tcp://a": here}) == ""
    assert differing({"tcp://a": {**here, "numpy": "1.0"}}).startswith("tcp://a has numpy 1.0 and")


@pytest.mark.slow
def test_a_scheduler_that_dies_ends_the_batch_with_a_sentence(
    many, tmp_path, address, scheduler, monkeypatch
):
    from labrun.reduction.batch import cluster

    monkeypatch.setattr(cluster, "LOST_S", 1.0)
    executor = cluster.Cluster(address, Settings(), UP_S)
    starts = []
    real = executor.start

    def start(number, chunk):
        real(number, chunk)
        starts.append(number)
        if len(starts) == 3:
            scheduler[1].kill()

    executor.start = start

    with pytest.raises(ExecutorFault, match="lost the dask scheduler"):
        reduce_into(tmp_path / "out", many, executor)
    assert not (tmp_path / "out").exists()


@pytest.mark.soak
def test_a_scheduler_that_dies_before_it_hands_over_a_result_ends_the_batch_with_a_sentence(
    address, scheduler
):
    from labrun.reduction.batch.cluster import Cluster

    executor = Cluster(address, Settings(), UP_S)
    finished = executor.client.submit(str, 1)
    finished.result()
    executor.ready.put((0, finished))
    scheduler[1].kill()
    scheduler[1].wait()

    with pytest.raises(ExecutorFault, match="lost the dask scheduler"):
        executor.answers(wait_s=1.0)
    executor.close()


def test_nobody_at_the_address_is_a_sentence():
    from labrun.reduction.batch.cluster import Cluster

    with pytest.raises(
        ExecutorUnreachable, match=r"no dask scheduler answers at tcp://127.* running"
    ):
        Cluster(f"tcp://127.0.0.1:{free_port()}", Settings(), reach_s=0.5)


def test_an_address_that_is_none_is_a_sentence():
    from labrun.reduction.batch.cluster import Cluster

    with pytest.raises(ExecutorUnreachable, match=r"at nonsense \(missing port"):
        Cluster("nonsense", Settings(), reach_s=0.5)


def test_something_else_at_the_address_is_a_sentence():
    from labrun.reduction.batch.cluster import Cluster

    with socket.socket() as server:
        server.bind(("127.0.0.1", 0))
        server.listen()
        with pytest.raises(ExecutorUnreachable, match="no dask scheduler answers"):
            Cluster(f"tcp://127.0.0.1:{server.getsockname()[1]}", Settings(), reach_s=0.5)


@pytest.mark.slow
def test_a_scheduler_without_workers_is_a_sentence(scheduler):
    from labrun.reduction.batch.cluster import Cluster

    with pytest.raises(ExecutorUnreachable, match="has no worker; start one with: dask worker tcp"):
        Cluster(scheduler[0], Settings(), reach_s=5.0)


def test_without_dask_the_way_to_install_it_is_said(monkeypatch):
    from labrun.reduction.batch.cluster import Cluster

    monkeypatch.setitem(sys.modules, "distributed", None)

    with pytest.raises(ExecutorFault, match=r'python -m pip install "labrun\[dask\]"'):
        Cluster("tcp://127.0.0.1:1", Settings())
