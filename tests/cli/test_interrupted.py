"""Runs that do not come to their end: killed, interrupted, cut off from their reader."""

import json
import os
import random
import re
import signal
import subprocess
import time
from pathlib import Path

import pytest
from cli_process import SPHERES, closecall, command, long_scene, messages_before_the_cut, started
from mcap.reader import make_reader
from places import SAMPLES


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    path = tmp_path / "scene.yaml"
    path.write_text(SPHERES)
    return path


def test_sigkill_leaves_no_output_and_a_partial_that_the_stream_reader_reads(scene, tmp_path):
    process = started(scene, tmp_path / "out.mcap")
    process.kill()
    process.communicate()
    assert not (tmp_path / "out.mcap").exists()
    assert messages_before_the_cut(tmp_path / "out.mcap.partial") > 1000


@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_a_signal_ends_the_run_in_a_line_that_says_where_the_partial_is(scene, tmp_path, number, code):
    process = started(scene, tmp_path / "out.mcap")
    process.send_signal(number)
    _, told = process.communicate(timeout=60)
    assert process.returncode == code
    assert told.count("\n") == 1
    assert "out.mcap.partial" in told
    assert not (tmp_path / "out.mcap").exists()
    (hint,) = re.findall(r"closecall (summary \S+);", told)
    done = closecall(*hint.split(), cwd=tmp_path)
    assert done.returncode == 3
    assert "28 pairs" in done.stdout
    assert messages_before_the_cut(tmp_path / "out.mcap.partial") > 1000


def test_an_existing_output_survives_an_interrupted_run(scene, tmp_path):
    output = tmp_path / "out.mcap"
    closecall("run", scene, "-o", output, cwd=tmp_path)
    whole = output.read_bytes()
    process = started(scene, output)
    process.send_signal(signal.SIGINT)
    process.communicate(timeout=60)
    assert output.read_bytes() == whole


def test_an_unfinished_log_is_summarised_as_far_as_it_goes_and_a_line_says_so(scene, tmp_path):
    process = started(scene, tmp_path / "out.mcap")
    process.kill()
    process.communicate()
    done = closecall("summary", "out.mcap.partial", "--json", cwd=tmp_path)
    assert done.returncode == 3
    (line,) = done.stderr.splitlines()
    assert re.fullmatch(r"out\.mcap\.partial: unfinished at byte [0-9]+: .*; read up to [0-9.]+ s", line)
    summary = json.loads(done.stdout)
    assert sum(summary["totals"]["pairs"].values()) == summary["pairs_total"] == 28
    assert summary["totals"]["wakeups"] > 1000
    assert summary["totals"]["pairs"]["clear"] == 0, "of no pair is all known yet"


def killed_at_random(folder: Path, seed: int) -> None:
    """Kill a run at a random instant and check what it leaves."""
    instant = random.Random(seed).uniform(0.2, 3.0)
    scene, output = folder / f"{seed}.yaml", folder / f"{seed}.mcap"
    scene.write_text(long_scene())
    process = subprocess.Popen(command("run", scene, "-o", output), stderr=subprocess.PIPE, stdout=subprocess.PIPE)
    time.sleep(instant)
    process.kill()
    process.communicate()
    partial = Path(f"{output}.partial")
    assert not output.exists(), seed
    if partial.exists() and partial.stat().st_size > 1_000_000:
        assert messages_before_the_cut(partial) > 1000, seed


@pytest.mark.parametrize("seed", range(5))
def test_kill_at_a_random_instant_never_leaves_an_output(tmp_path, seed):
    killed_at_random(tmp_path, seed)


@pytest.mark.deep
def test_kill_at_fifty_random_instants_never_leaves_an_output(tmp_path):
    for seed in range(100, 150):
        killed_at_random(tmp_path, seed)


def test_a_log_down_a_pipe_is_the_log_of_the_file(scene, tmp_path):
    closecall("run", scene, "-o", "file.mcap", cwd=tmp_path)
    piped = subprocess.run(command("run", scene, "-o", "-"), capture_output=True, timeout=60)
    assert piped.returncode == 0
    assert piped.stdout == (tmp_path / "file.mcap").read_bytes()
    assert b"left | right" in piped.stderr
    path = tmp_path / "piped.mcap"
    path.write_bytes(piped.stdout)
    with path.open("rb") as file:
        assert make_reader(file, validate_crcs=True).get_summary() is not None


def test_a_pipe_closed_by_its_reader_ends_the_run_quietly(scene):
    scene.write_text(long_scene())
    process = subprocess.Popen(command("run", scene, "-o", "-"), stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    assert process.stdout is not None
    assert process.stderr is not None
    process.stdout.read(1000)
    process.stdout.close()
    assert process.wait(timeout=60) == 141
    assert process.stderr.read() == b""
    process.stderr.close()


@pytest.mark.parametrize("seconds", [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.8])
def test_an_interrupt_while_it_starts_ends_it(tmp_path, seconds):
    """While libraries are loaded that would take it for a module that is missing."""
    sample = SAMPLES / "asteroids" / "scene.yaml"
    process = subprocess.Popen(command("run", sample, "-o", "out.mcap"), cwd=tmp_path, stderr=subprocess.PIPE)
    assert process.stderr is not None
    time.sleep(seconds)
    process.send_signal(signal.SIGINT)
    told = process.stderr.read().decode()
    process.stderr.close()
    before_closecall = re.search(r"Fatal Python error: init_import_site|<frozen runpy>", told)
    assert process.wait(timeout=60) in (130, -signal.SIGINT) or before_closecall
    assert not re.search(r"TypeError|RuntimeError", told)
    assert not (tmp_path / "out.mcap").exists()


def test_json_and_a_log_down_the_same_pipe_is_a_usage_error(scene, tmp_path):
    done = closecall("run", scene, "-o", "-", "--json", cwd=tmp_path)
    assert (done.returncode, done.stdout) == (2, "")
    assert "--json" in done.stderr


def test_a_full_disk_is_one_line_and_leaves_no_output(scene, tmp_path):
    """A limit on the file's size stands for the full disk."""
    scene.write_text(long_scene())
    limited = ["bash", "-c", 'ulimit -f 300; trap "" XFSZ; exec "$@"', "bash", *command("run", scene, "-o", "out.mcap")]
    done = subprocess.run(limited, cwd=tmp_path, capture_output=True, text=True, timeout=120, env=dict(os.environ))
    assert done.returncode == 2
    assert done.stderr.count("\n") == 1
    assert "cannot write" in done.stderr
    assert "mcap recover out.mcap.partial" in done.stderr
    assert not (tmp_path / "out.mcap").exists()
