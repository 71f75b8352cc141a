"""What is left of a log where a run does not end well, and what is refused before it starts."""

from __future__ import annotations

import errno
import os
import signal
import struct
import subprocess
import sys
from pathlib import Path

import pytest
from bare_scenes import loaded
from mcap.exceptions import McapError
from mcap.reader import make_reader
from mcap.records import Message
from mcap.stream_reader import StreamReader
from places import HELPERS

from closecall.formats.log.container.chunks import CHUNK_BYTES, ChunkWriter
from closecall.formats.log.container.output import LOG, Output, published
from closecall.formats.log.errors import LogError
from closecall.formats.log.writer import LogOptions, LogWriter
from closecall.formats.scene.loaded import LoadedScene
from closecall.scheduler.model.events import Bound, Level, PairKey, Reason, Wakeup

OLDER = b"\x89MCAP0\r\nan older log"


def log_writer(path: Path, scene: LoadedScene, epoch: int = 0) -> LogWriter:
    return LogWriter(path, scene, scene.settings, 1, LogOptions(epoch=epoch))


def wakeup(time: float) -> Wakeup:
    return Wakeup(time, PairKey(0, 0, 1), Reason.KNOT, Level.SPHERE, Bound.DISPLACEMENT, 0.25, 0.5)


def salvaged(path: Path) -> list[int]:
    """Return the log times in an unfinished file, up to its last whole chunk."""
    found: list[int] = []
    with path.open("rb") as file:
        records = StreamReader(file, validate_crcs=True).records
        while True:
            try:
                record = next(records)
            except (McapError, ValueError, OSError, struct.error):
                return found
            if isinstance(record, Message):
                found.append(record.log_time)


def message_count(path: Path) -> int:
    with path.open("rb") as file:
        return sum(1 for _ in make_reader(file, validate_crcs=True).iter_messages())


def test_fault_keeps_the_partial_and_the_old_output(tmp_path):
    scene = loaded(tmp_path)
    (tmp_path / "out.mcap").write_bytes(OLDER)
    log = log_writer(tmp_path / "out.mcap", scene)

    def failing_run() -> None:
        with log:
            log.write(wakeup(0.0))
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        failing_run()
    assert (tmp_path / "out.mcap").read_bytes() == OLDER
    assert log.partial == tmp_path / "out.mcap.partial"
    assert len(salvaged(log.partial)) == 2, "the opening and the one fact"


def test_output_is_replaced_only_after_a_clean_end(tmp_path):
    scene = loaded(tmp_path)
    target = tmp_path / "out.mcap"
    target.write_bytes(OLDER)
    with log_writer(target, scene) as log:
        log.write(wakeup(0.0))
        assert target.read_bytes() == OLDER
    assert message_count(target) == 3
    assert not log.partial.exists()


def test_killed_run_leaves_all_whole_chunks_readable(tmp_path):
    script = (
        "import sys; sys.path[:0] = sys.argv[1:3]; import test_faults as t; from pathlib import Path\n"
        "f = Path(sys.argv[3]); s = t.loaded(f)\n"
        "with t.log_writer(f / 'out.mcap', s) as log:\n"
        "    for k in range(10_000_000):\n"
        "        log.write(t.wakeup(k / 1024))\n"
        "        if k % 10_000 == 0:\n"
        "            print(k, flush=True)\n"
    )
    command = [sys.executable, "-c", script, str(Path(__file__).parent), str(HELPERS), str(tmp_path)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as run:
        assert run.stdout is not None
        for line in run.stdout:
            if int(line) >= 50_000:
                run.send_signal(signal.SIGKILL)
                break
    assert run.returncode == -signal.SIGKILL
    assert not (tmp_path / "out.mcap").exists()
    found = salvaged(tmp_path / "out.mcap.partial")
    assert len(found) > 50_000 - CHUNK_BYTES // 100, "at most the last chunk is lost"
    assert found == sorted(found)


def test_interrupt_in_the_middle_of_a_chunk_leaves_no_garbled_one(tmp_path, monkeypatch):
    log = log_writer(tmp_path / "out.mcap", loaded(tmp_path))
    whole: list[int] = []

    def interrupted_run() -> None:
        with log:
            for k in range(10_000):
                log.write(wakeup(float(k)))
            whole.extend(salvaged(log.partial))
            monkeypatch.setattr("mcap._chunk_builder.ChunkBuilder.add_message", _interrupt)
            for k in range(10_000):
                log.write(wakeup(float(k)))

    with pytest.raises(KeyboardInterrupt):
        interrupted_run()
    assert whole
    assert salvaged(log.partial) == whole


def _interrupt(*_: object) -> None:
    raise KeyboardInterrupt


def test_full_disk_is_one_line_that_names_the_file(tmp_path, monkeypatch):
    def full(_: object) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    log = log_writer(tmp_path / "o.mcap", loaded(tmp_path))

    def run_out_of_space() -> None:
        with log:
            monkeypatch.setattr(ChunkWriter, "flush", full)
            log.write(wakeup(0.0))

    with pytest.raises(LogError) as caught:
        run_out_of_space()
    assert str(caught.value).startswith(f"{log.partial}: cannot write: No space left on device; ")
    assert log.partial.exists()
    assert not (tmp_path / "o.mcap").exists()


@pytest.mark.parametrize("name", ["nowhere/out.mcap", ".", "scene.yaml", "link.mcap", "0.stl", "hard.mcap", "pipe"])
def test_impossible_output_is_refused_in_one_line_and_nothing_is_touched(tmp_path, name):
    scene = loaded(tmp_path, meshes=(b"solid",))
    (tmp_path / "link.mcap").symlink_to(tmp_path / "scene.yaml")
    (tmp_path / "hard.mcap").hardlink_to(tmp_path / "0.stl")
    os.mkfifo(tmp_path / "pipe")
    before = sorted(tmp_path.iterdir())
    with pytest.raises(LogError) as caught:
        log_writer(tmp_path / name, scene)
    assert str(caught.value).startswith(str(tmp_path / name))
    assert "\n" not in str(caught.value)
    assert sorted(tmp_path.iterdir()) == before
    assert scene.path.read_bytes() == scene.source


def test_a_partial_that_leads_to_an_input_is_refused(tmp_path):
    scene = loaded(tmp_path)
    (tmp_path / "out.mcap.partial").symlink_to(scene.path)
    with pytest.raises(LogError, match="would overwrite the input"):
        log_writer(tmp_path / "out.mcap", scene)


def test_a_file_that_is_no_log_is_not_replaced(tmp_path):
    target = tmp_path / "scene.yaml"
    target.write_text("closecall: 1\n")
    with pytest.raises(LogError, match=r"scene.yaml: exists and is not a log; remove it, or choose another output"):
        Output(target, [], LOG)
    assert target.read_text() == "closecall: 1\n"
    target.write_bytes(b"")  # as mktemp makes it
    Output(target, [], LOG)


def test_unwritable_folder_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(os, "access", lambda *_: False)
    with pytest.raises(LogError, match="is not writable"):
        Output(tmp_path / "out.mcap", [], LOG)


def test_a_name_too_long_for_the_file_system_is_one_line(tmp_path):
    with pytest.raises(LogError, match=r"at most 247 fit.*choose a shorter name"):
        Output(tmp_path / ("x" * 250), [], LOG)


def test_what_cannot_be_put_in_its_place_is_not_left_beside_it(tmp_path, monkeypatch):
    def refuse(*_: object) -> None:
        raise OSError(5, "Input/output error")

    monkeypatch.setattr(Path, "replace", refuse)
    with (
        pytest.raises(LogError, match="cannot write: Input/output error"),
        published(Output(tmp_path / "out.mcap", [], LOG)) as stream,
    ):
        stream.write(b"all of it")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(("start", "epoch", "remedy"), [(-1.5, 0, "at least 1500000000"), (0.0, 2**63, "at most")])
def test_times_outside_the_logs_range_are_refused(tmp_path, start, epoch, remedy):
    with pytest.raises(LogError, match=remedy):
        log_writer(tmp_path / "out.mcap", loaded(tmp_path, start=start), epoch)


def test_a_mesh_that_changed_or_went_since_it_was_loaded_is_refused(tmp_path):
    scene = loaded(tmp_path, meshes=(b"solid",))
    scene.mesh_files[0].path.write_bytes(b"other")
    with pytest.raises(LogError, match="changed"):
        log_writer(tmp_path / "out.mcap", scene).__enter__()
    scene.mesh_files[0].path.unlink()
    with pytest.raises(LogError, match="--no-attach-meshes"):
        log_writer(tmp_path / "out.mcap", scene).__enter__()
    assert not (tmp_path / "out.mcap.partial").exists()


def test_two_runs_at_one_output_never_publish_a_mixture(tmp_path):
    scene = loaded(tmp_path)
    first = log_writer(tmp_path / "out.mcap", scene).__enter__()
    second = log_writer(tmp_path / "out.mcap", scene).__enter__()
    second.write(wakeup(0.0))
    with pytest.raises(LogError, match="another run took"):
        first.__exit__(None, None, None)
    second.__exit__(None, None, None)
    assert message_count(tmp_path / "out.mcap") == 3


def test_a_stale_partial_is_written_over(tmp_path):
    (tmp_path / "out.mcap.partial").write_bytes(b"x" * 100_000)
    with log_writer(tmp_path / "out.mcap", loaded(tmp_path)) as log:
        log.write(wakeup(0.0))
    assert message_count(tmp_path / "out.mcap") == 3
