"""What a goal costs on its way through ROS: over the rosbridge endpoint, and by a real node.

A device that does nothing is asked N times by one client. Beside it, in the same run: a bare WebSocket
echo of the same frames, and the device's own server asked directly, ledger on disk as always. With
`--node` (in a Python with rclpy and the lab's interfaces built, see docs/how-to/ros.md) the same goals
go through the node, beside a bare rclpy action server that does nothing.
Run: python benchmarks/ros.py [--goals N] [--node] [--write DIR]
"""

import argparse
import asyncio
import json
import statistics
import sys
import tempfile
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
from dispatch import CONTRACT, DRIVER, LAB

GOAL = {
    "op": "send_action_goal", "action": "/nothing/nothing", "feedback": True, "args": {"i": 1},
    "action_type": "labrun_interfaces/action/NothingNothing",
}  # fmt: skip


def median_ms(times: list[float]) -> float:
    """The middle one."""
    return 1e3 * statistics.median(times)


async def ask(url: str, count: int, *, id: bool, action: str = "/nothing/nothing") -> list[float]:
    """Seconds from a frame to its answer."""
    from websockets.asyncio.client import connect

    times = []
    async with connect(url, compression=None) as socket:
        for number in range(count):
            frame = json.dumps({**GOAL, "action": action, "id": f"g{number}"} if id else GOAL)
            began = time.perf_counter()
            await socket.send(frame)
            answer = json.loads(await socket.recv())
            times.append(time.perf_counter() - began)
            assert not id or answer["status"] == 4, answer
    return times


async def echo(count: int) -> list[float]:
    """The same frames to a server that sends them back, in this process as the endpoint is."""
    from websockets.asyncio.server import serve

    async def back(socket):
        async for frame in socket:
            await socket.send(json.dumps(json.loads(frame)))

    async with serve(back, "127.0.0.1", 0, compression=None) as server:
        port = next(iter(server.sockets)).getsockname()[1]
        return await ask(f"ws://127.0.0.1:{port}", count, id=False)


async def direct(site, count: int) -> list[float]:
    """The device server asked without ROS: lease held, ledger on disk."""
    from labrun.schemas.messages import Goal

    device, times = site.devices["nothing"], []
    async with device.borrowed() as client:
        for number in range(count):
            goal = Goal(
                id=f"{site.owner}/direct/{number}", device="nothing", boot=client.boot,
                epoch=client.epoch("nothing"), action="nothing", params={"i": 1},
            )  # fmt: skip
            began = time.perf_counter()
            outcome = await client.follow(goal)
            times.append(time.perf_counter() - began)
            assert outcome.state == "SUCCEEDED", outcome
    return times


async def endpoint(folder: Path, count: int) -> None:
    """Print the figures of the endpoint."""
    async with _site(folder) as site:
        add_here(site)
        await _figures(site, count)


async def _figures(site, count: int) -> None:
    from labrun.drivers.server.gate import Brake
    from labrun.web.ros.bridge.gate import Gate
    from labrun.web.ros.bridge.serve import bridge

    async with bridge(site.offers, site.goals, Gate("127.0.0.1", Brake(None)), 0) as url:
        await ask(url, 50, id=True)
        bare = await echo(count)
        own = await direct(site, count)
        ours = await ask(url, count, id=True)
        spent = time.process_time()
        alone = await ask(url, count, id=True, action="/here")
        spent_ms = 1e3 * (time.process_time() - spent) / count
    print(f"bare WebSocket echo              {median_ms(bare):8.2f} ms median")
    print(f"goal over the endpoint           {median_ms(alone):8.2f} ms   (wanted: under 2)")
    print(f"  processor time, both ends      {spent_ms:8.2f} ms")
    print(f"  beside the echo                {median_ms(alone) / median_ms(bare):8.1f} times")
    print(f"device server asked directly     {median_ms(own):8.2f} ms   (ledger on disk)")
    print(f"goal of that device              {median_ms(ours):8.2f} ms")


def add_here(site) -> None:
    """An action that is over at once, in this process: what is left is the endpoint's own part."""
    from labrun.web.ros.offers.goals import result_of
    from labrun.web.ros.offers.offer import Action, End

    class Here(Action):
        name = "/here"
        kind = site.offers.actions["/nothing/nothing"].kind

        async def carry(self, work):
            work.begun.set()
            return End("SUCCEEDED", result_of(self, {}))

    site.offers.actions["/here"] = Here()


def _site(folder: Path):
    from labrun.engine.lab.lab import load_lab
    from labrun.web.ros.offers.offered_lab import Folders
    from labrun.web.ros.open_lab import opened

    lab, problems = load_lab(folder / "lab.yaml")
    assert lab is not None, problems
    folders = Folders(folder, folder / "runs", folder / "files", folder / "state")
    return opened(lab, "labrun_interfaces", folders)


def ask_node(name: str, count: int) -> list[float]:
    """Seconds from a goal to its result, by a client of rclpy in a process of its own."""
    import subprocess

    done = subprocess.run(
        [sys.executable, __file__, "--client", name, "--goals", str(count)],
        capture_output=True, text=True, timeout=600,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout.splitlines()[-1])


def node_client(name: str, count: int) -> list[float]:
    """What `ask_node` runs."""
    import rclpy
    from labrun_interfaces.action import NothingNothing
    from rclpy.action import ActionClient
    from rclpy.executors import SingleThreadedExecutor

    rclpy.init()
    node = rclpy.create_node("bench_client")
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    client = ActionClient(node, NothingNothing, name)
    assert client.wait_for_server(30)
    time.sleep(1.5)

    def wait(future):
        executor.spin_until_future_complete(future, timeout_sec=30)
        return future.result()

    times = []
    for _ in range(count):
        began = time.perf_counter()
        handle = wait(client.send_goal_async(NothingNothing.Goal()))
        assert wait(handle.get_result_async()).status == 4
        times.append(time.perf_counter() - began)
    return times


async def through_node(folder: Path, count: int) -> None:
    """Print the figures of the node."""
    from labrun_interfaces.action import NothingNothing
    from rclpy.action import ActionServer

    from labrun.web.ros.as_node import types_of
    from labrun.web.ros.node.face import node

    def nothing(handle):
        handle.succeed()
        return NothingNothing.Result()

    async with _site(folder) as site, node(site.offers, site.goals, types_of(site.offers)) as made:
        server = ActionServer(made, NothingNothing, "/bare", nothing)
        bare = await asyncio.to_thread(ask_node, "/bare", count)
        spent = time.process_time()
        ours = await asyncio.to_thread(ask_node, "/nothing/nothing", count)
        spent_ms = 1e3 * (time.process_time() - spent) / count
        own = await direct(site, count)
        server.destroy()
    print(f"bare action server of rclpy      {median_ms(bare):8.2f} ms median")
    print(f"device server asked directly     {median_ms(own):8.2f} ms   (ledger on disk)")
    print(f"goal through the node            {median_ms(ours):8.2f} ms   (wanted: under 15)")
    print(
        f"  beyond the two above           {median_ms(ours) - median_ms(bare) - median_ms(own):8.2f} ms"
    )
    print(f"  processor time of the node     {spent_ms:8.2f} ms")


def write_lab(folder: Path) -> None:
    """The lab with the device that does nothing."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in (("nothing.yaml", CONTRACT), ("nothing.py", DRIVER), ("lab.yaml", LAB)):
        (folder / name).write_text(text, encoding="utf-8")


def main() -> None:
    """Measure, and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--goals", type=int, default=300)
    parser.add_argument("--node", action="store_true")
    parser.add_argument(
        "--write", type=Path, help="write the lab there, for its interfaces, and end"
    )
    parser.add_argument("--client", help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.write is not None:
        write_lab(given.write)
    elif given.client is not None:
        print(json.dumps(node_client(given.client, given.goals)))
    else:
        with tempfile.TemporaryDirectory() as name:
            write_lab(Path(name))
            asyncio.run((through_node if given.node else endpoint)(Path(name), given.goals))


if __name__ == "__main__":
    main()
