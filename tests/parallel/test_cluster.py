"""Runs whose pairs are shared by the workers of a Dask cluster."""

import os
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from cli_process import closecall, command
from distributed import Client, LocalCluster
from sample_runs import FOLDER

from closecall.cli.application import workers
from closecall.cli.application.errors import WorkerError
from closecall.cli.application.sharing import told_by_workers
from closecall.formats.scene.reader import read_scene
from closecall.scheduler.parallel.transport import Work

SCENE = FOLDER / "asteroids" / "scene.yaml"
OPTIONS = ["-q", "--log", "certificate"]


def made(kind: Any, *arguments: object, **options: object) -> Any:
    """Return what Dask makes: either waits for itself or is to be awaited, which its types leave open."""
    return kind(*arguments, **options)


@pytest.fixture(scope="module")
def cluster() -> Iterator[Any]:
    """Two workers of two threads, each of which builds models of its own."""
    with made(LocalCluster, n_workers=2, threads_per_worker=2, processes=True, dashboard_address=":0") as cluster:
        yield cluster


@pytest.fixture(scope="module")
def alone(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """The log of one process."""
    folder = tmp_path_factory.mktemp("alone")
    closecall("run", SCENE, "-o", "out.mcap", *OPTIONS, cwd=folder)
    return (folder / "out.mcap").read_bytes()


def run_shares(address: str) -> None:
    loaded = read_scene(FOLDER / "spinning_bar" / "scene.yaml")
    work = Work(loaded.scene, loaded.settings, crowded=False)
    told_by_workers(work, 1, 1, address, None, lambda step, done, of: None)


def test_a_cluster_gives_the_bytes_of_one_process(cluster, alone, tmp_path):
    done = closecall("run", SCENE, "-o", "out.mcap", *OPTIONS, "--cluster", cluster.scheduler_address, cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    assert (tmp_path / "out.mcap").read_bytes() == alone


def test_a_cluster_gives_the_bytes_of_one_process_when_a_worker_dies(cluster, alone, tmp_path):
    with made(Client, cluster.scheduler_address, set_as_default=False) as client:
        pid = next(iter(client.run(os.getpid).values()))
        options = [*OPTIONS, "--cluster", cluster.scheduler_address]
        process = subprocess.Popen(command("run", SCENE, "-o", tmp_path / "out.mcap", *options))
        while not any(client.processing().values()):
            assert process.poll() is None
            time.sleep(0.01)
        os.kill(pid, 9)
        assert process.wait(timeout=60) == 0
    assert (tmp_path / "out.mcap").read_bytes() == alone


@pytest.mark.parametrize("address", ["tcp://127.0.0.1:9", "ftp://127.0.0.1:9", "nowhere"])
def test_an_address_where_no_scheduler_answers_is_told_with_a_remedy(monkeypatch, address):
    monkeypatch.setattr(workers, "PATIENCE", 0.2)
    with pytest.raises(WorkerError, match=f"--cluster {address}: no Dask scheduler .* start one with `dask scheduler`"):
        run_shares(address)


def test_a_cluster_without_workers_is_told_with_a_remedy(monkeypatch):
    monkeypatch.setattr(workers, "PATIENCE", 0.5)
    with (
        made(LocalCluster, n_workers=0, dashboard_address=":0") as cluster,
        pytest.raises(WorkerError, match="the scheduler has no workers; start workers with `dask worker ADDRESS`"),
    ):
        run_shares(cluster.scheduler_address)


def test_workers_of_another_version_are_refused(cluster, monkeypatch):
    monkeypatch.setattr(workers, "__version__", "0.0.1")
    with pytest.raises(WorkerError, match=r"has closecall .*; install closecall 0\.0\.1, Python .* there"):
        run_shares(cluster.scheduler_address)


def test_without_dask_the_extra_is_named(tmp_path):
    script = (
        "import sys; sys.modules['distributed'] = None\n"
        "sys.argv = ['closecall', *sys.argv[1:]]\n"
        "from closecall.cli.main import main\nmain()\n"
    )
    arguments = ["run", str(SCENE), "-o", "out.mcap", "--cluster", "tcp://127.0.0.1:8786"]
    done = subprocess.run([sys.executable, "-c", script, *arguments], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 2
    assert "pip install 'closecall[cluster]'" in done.stderr
    assert not list(Path(tmp_path).iterdir())


def test_jobs_and_a_cluster_at_once_are_a_usage_error(tmp_path):
    done = closecall("run", SCENE, "-o", "out.mcap", "--cluster", "tcp://127.0.0.1:9", "--jobs", "2", cwd=tmp_path)
    assert done.returncode == 2
    assert "either jobs or a cluster, not both" in done.stderr
