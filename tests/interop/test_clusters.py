"""Recordings on a local Dask and a local Ray of two workers each, one of which is killed: every message once."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from rosproto.bag import BagWriter, partitions
from rosproto.codec import message_class

pytest.importorskip("pyarrow", reason="pyarrow is not installed (extra arrow)")

pytestmark = [pytest.mark.slow, pytest.mark.timeout(300)]
ROOT = Path(__file__).parents[2]
Odometry = message_class("nav_msgs/Odometry")
FIELDS = ["pose.pose.position.x", "header.frame_id"]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Four bags of 2000 messages, each with a number of its own."""
    folder = tmp_path_factory.mktemp("runs")
    for number in range(4):
        with BagWriter(folder / f"{number}.bag", "lz4", 100_000) as bag:
            for i in range(2000):
                message = Odometry()
                message.pose.pose.position.x = float(number * 2000 + i)
                message.header.frame_id = f"robot{number}"
                bag.write("/odom", message, 1000.0 + i)
    return folder


def test_one_process_has_them_all(folder: Path) -> None:
    """What the clusters are held to."""
    pieces = partitions(folder, "/odom", size=20_000, fields=FIELDS)
    assert len(pieces) > 8
    found = [x for piece in pieces for x in piece.table()["pose.pose.position.x"].to_pylist()]
    assert sorted(found) == [float(i) for i in range(8000)]


def test_dask_with_a_worker_killed(folder: Path) -> None:
    """In the middle of the work."""
    pytest.importorskip("dask.dataframe", reason="dask is not installed")
    distributed = pytest.importorskip("distributed", reason="dask's distributed is not installed")
    from rosproto.bag.dask import read_bags

    with (
        distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, dashboard_address=None, host="127.0.0.1"
        ) as cluster,
        distributed.Client(cluster, timeout=60) as client,
    ):
        frame = read_bags(folder, "/odom", fields=FIELDS, size=20_000)
        client.wait_for_workers(2, timeout=60)
        future = client.compute(frame)
        victim = next(iter(cluster.workers.values()))
        os.kill(victim.pid, signal.SIGKILL)
        found = future.result(timeout=120)
    assert sorted(found["pose.pose.position.x"].tolist()) == [float(i) for i in range(8000)]
    assert set(found["header.frame_id"]) == {f"robot{i}" for i in range(4)}


def test_ray_with_a_worker_killed(folder: Path) -> None:
    """Where there is no network but loopback: a cluster that is started asks the metadata services of clouds who it is."""
    pytest.importorskip("ray.data", reason="ray[data] is not installed")
    alone = ["unshare", "--map-root-user", "--net", "sh", "-c", 'ip link set lo up && exec "$@"', "sh"]
    try:
        subprocess.run([*alone, "true"], check=True, timeout=30, capture_output=True)
    except (OSError, subprocess.SubprocessError) as error:
        pytest.skip(f"no network namespace can be made here: {error}")
    environment = {name: value for name, value in os.environ.items() if name != "TESTS_WATCH"}
    environment |= {"PYTHONPATH": str(ROOT), "RAY_USAGE_STATS_ENABLED": "0"}
    program = ROOT / "tests" / "interop" / "programs" / "ray_cluster.py"
    done = subprocess.run(
        [*alone, sys.executable, str(program), str(folder)],
        env=environment,
        timeout=240,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr[-3000:]
    found = json.loads(done.stdout.splitlines()[-1])
    assert found["killed"] == 1
    assert sorted(found["numbers"]) == [float(i) for i in range(8000)]


def test_rays_read_tasks_have_them_all(folder: Path) -> None:
    """Without a cluster."""
    pytest.importorskip("ray.data", reason="ray[data] is not installed")
    from rosproto.bag.ray import _source

    pieces = partitions(folder, "/odom", size=20_000, fields=FIELDS)
    tasks = _source(pieces).get_read_tasks(2)
    assert len(tasks) == len(pieces)
    found = [x for task in tasks for table in task() for x in table["pose.pose.position.x"].to_pylist()]
    assert sorted(found) == [float(i) for i in range(8000)]
