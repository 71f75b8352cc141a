"""Runs whose pairs are shared by processes: the same bytes, and one line and nothing else where a process is lost."""

import operator
import os
import signal
import subprocess
import time
from io import BytesIO
from pathlib import Path

import numpy as np
import psutil
import pytest
from cli_process import closecall, command, long_scene
from sample_runs import FOLDER, NAMES

from closecall.cli.application.sharing import told_by_workers
from closecall.formats.scene.reader import read_scene
from closecall.scheduler.broad.active_pairs import ActivePairs
from closecall.scheduler.broad.broad_phase import BroadPhase
from closecall.scheduler.broad.windows import Sweeps
from closecall.scheduler.model.events import Collision
from closecall.scheduler.model.scene import Settings
from closecall.scheduler.model.share import Share, shares_of
from closecall.scheduler.narrow.narrow_phase import NarrowPhase
from closecall.scheduler.pairs.pair_factory import PairFactory
from closecall.scheduler.parallel.merge import merged, packed_ticks, stream, told_in_order, windows_of
from closecall.scheduler.parallel.transport import Work, packed
from closecall.scheduler.run import run


class Unpacked:
    """Stands for a scene: where it is unpacked, a function is called."""

    def __init__(self, function, *arguments):
        self._call = (function, arguments)

    def __reduce__(self):
        return self._call


def told_by_one(scene: Path, crowded: bool) -> list[str]:
    """Return the events of one run of all pairs."""
    loaded = read_scene(scene)
    factory = PairFactory(loaded.scene, NarrowPhase(loaded.scene.bodies), loaded.settings.margin)
    crowd = ActivePairs(factory, loaded.settings, BroadPhase(loaded.scene, Sweeps(factory))) if crowded else None
    return [repr(event) for event in run(() if crowded else factory.all(), loaded.settings, crowd)]


def told_by_shares(scene: Path, crowded: bool, shares: int) -> list[str]:
    """Return the events of the shares, merged, whichever was done first."""
    loaded = read_scene(scene)
    work = Work(loaded.scene, loaded.settings, crowded)
    sent = packed(work)
    ticks = packed_ticks(work, [windows_of(sent, share) for share in shares_of(2)]) if crowded else None
    streams = [stream(sent, share, ticks) for share in shares_of(shares)]
    turns = [told.turns for told in streams]
    told, also = ([repr(event) for event in merged(map(BytesIO, order))] for order in (turns, reversed(turns)))
    assert told == also, "the order in which shares are done counts"
    collisions = [event for event in merged(map(BytesIO, turns)) if isinstance(event, Collision)]
    assert told_in_order(streams) == collisions
    return told


def workers_of(process: subprocess.Popen[str]) -> list[psutil.Process]:
    """Return the processes that a run has started for its shares, once there are two."""
    for _ in range(3000):
        children = psutil.Process(process.pid).children()
        workers = [child for child in children if "loky.backend.popen" in " ".join(child.cmdline())]
        if len(workers) == 2:
            return workers
        time.sleep(0.01)
    raise AssertionError("no workers within half a minute")


def started_with_workers(folder: Path) -> subprocess.Popen[str]:
    """Start a run that takes minutes, on two processes, as the leader of its own group."""
    (folder / "scene.yaml").write_text(long_scene())
    return subprocess.Popen(
        command("run", "scene.yaml", "-o", "out.mcap", "--jobs", "2"),
        cwd=folder,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )


def assert_gone(processes: list[psutil.Process]) -> None:
    _, alive = psutil.wait_procs(processes, timeout=20)
    assert not alive


def test_every_pair_belongs_to_one_share_and_shares_are_even_for_neighbours_and_rows():
    for of in (2, 3, 16):
        shares = [Share(number, of) for number in range(of)]
        for pairs in (range(4096), range(0, 4096 * 16, 16), [k * (2 * 4096 - k - 1) // 2 for k in range(4096)]):
            counts = [sum(share.has(pair) for pair in pairs) for share in shares]
            assert sum(counts) == 4096
            assert max(counts) < 1.25 * 4096 / of


@pytest.mark.parametrize(
    ("sample", "crowded", "shares"),
    [
        ("person_at_cell", False, 3),
        ("person_at_cell", True, 2),
        ("conveyor_gate", True, 3),
        ("compound_gripper", True, 2),
        ("asteroids", True, 2),
    ],
)
def test_shares_merged_tell_what_one_run_tells_in_its_order(sample, crowded, shares):
    scene = FOLDER / sample / "scene.yaml"
    assert told_by_shares(scene, crowded, shares) == told_by_one(scene, crowded)


@pytest.mark.parametrize("crowded", [False, True])
def test_contacts_that_begin_at_nearly_the_same_time_are_told_in_the_order_of_one_run(tmp_path, crowded):
    """Boxes that spin fall onto a plate within some milliseconds: the one goes back in time while the other waits."""
    rng = np.random.default_rng(1)
    bodies = ["  plate: {pose: {xyz: [0, 0, -0.5]}, shapes: [{box: [99, 99, 1]}]}"]
    for index in range(30):
        place = f"xyz: [{2 * (index % 6) - 5}, {2 * (index // 6) - 5}, {1.5 + rng.uniform(0, 0.01):.4f}]"
        x, y = rng.normal(0, 5, 2)
        motion = f"{{type: constant, velocity: [0, 0, -2], angular_velocity: [{x:.2f}, {y:.2f}, 3]}}"
        bodies.append(f"  b{index}: {{pose: {{{place}}}, shapes: [{{box: [0.5, 0.5, 0.5]}}], motion: {motion}}}")
    scene = tmp_path / "scene.yaml"
    scene.write_text(
        "closecall: 1\nunits: {length: m, angle: rad}\ntime: {start: 0, end: 1}\nbodies:\n" + "\n".join(bodies)
    )
    assert told_by_shares(scene, crowded, 3) == told_by_one(scene, crowded)


@pytest.mark.deep
@pytest.mark.parametrize("sample", NAMES)
@pytest.mark.parametrize("crowded", [False, True])
@pytest.mark.parametrize("shares", [1, 2, 7, 64])
def test_shares_of_every_sample_merged_tell_what_one_run_tells(sample, crowded, shares):
    scene = FOLDER / sample / "scene.yaml"
    assert told_by_shares(scene, crowded, shares) == told_by_one(scene, crowded)


@pytest.mark.parametrize(
    ("sample", "broad_phase", "numbers"),
    [
        ("conveyor_gate", "off", ["1", "2", "3"]),
        ("conveyor_gate", "on", ["1", "auto"]),
        ("satellites", "auto", ["1", "2"]),  # where bodies come and go
    ],
)
def test_the_log_has_the_same_bytes_for_every_number_of_jobs(tmp_path, sample, broad_phase, numbers):
    logs = set()
    for seed, jobs in enumerate(numbers):
        output = tmp_path / f"{jobs}.mcap"
        options = ["-q", "--broad-phase", broad_phase, "--jobs", jobs]
        scene = FOLDER / sample / "scene.yaml"
        done = closecall("run", scene, "-o", output, *options, cwd=tmp_path, PYTHONHASHSEED=str(seed))
        assert (done.returncode, done.stderr) == (0, "")
        logs.add(output.read_bytes())
    assert len(logs) == 1


def test_a_worker_that_dies_is_one_line_and_nothing_is_written(tmp_path):
    process = started_with_workers(tmp_path)
    workers = workers_of(process)
    time.sleep(0.5)
    workers[0].kill()
    _, told = process.communicate(timeout=60)
    assert process.returncode == 2
    assert told.count("\n") == 1
    assert told.startswith("a worker process died")
    assert [path.name for path in tmp_path.iterdir()] == ["scene.yaml"]
    assert_gone(workers)


@pytest.mark.parametrize("delay", [0.0, 1.0])
def test_ctrl_c_ends_all_processes_in_one_line(tmp_path, delay):
    process = started_with_workers(tmp_path)
    workers = workers_of(process)
    time.sleep(delay)
    os.killpg(process.pid, signal.SIGINT)
    _, told = process.communicate(timeout=60)
    assert (process.returncode, told) == (130, "interrupted\n")
    assert [path.name for path in tmp_path.iterdir()] == ["scene.yaml"]
    assert_gone(workers)


def test_workers_end_when_the_run_is_killed(tmp_path):
    process = started_with_workers(tmp_path)
    workers = workers_of(process)
    time.sleep(1.0)
    process.kill()
    process.communicate()
    assert not (tmp_path / "out.mcap").exists()
    assert_gone(workers)


@pytest.mark.parametrize(
    ("error", "call"), [(MemoryError, (bytes, 2**62)), (ZeroDivisionError, (operator.truediv, 1.0, 0.0))]
)
def test_an_error_in_a_worker_is_raised_as_it_would_be_here(error, call):
    work = Work(Unpacked(*call), Settings(), crowded=False)  # type: ignore[arg-type]
    with pytest.raises(error):
        told_by_workers(work, 5, 2, None, None, lambda step, done, of: None)


@pytest.mark.parametrize("jobs", ["0", "many", "100000"])
def test_a_number_of_jobs_that_cannot_be_is_refused(tmp_path, jobs):
    done = closecall("run", FOLDER / "spinning_bar" / "scene.yaml", "-o", "out.mcap", f"--jobs={jobs}", cwd=tmp_path)
    assert done.returncode == 2
    assert "expected auto, or 1 to 1024" in done.stderr
    assert not list(tmp_path.iterdir())
