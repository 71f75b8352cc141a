"""`closecall check` tells of a recorded path how many poses it has, over what time, how often and with what gap."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from click.testing import CliRunner
from scene_files import HEAD

from closecall.cli.commands.check import command


def checked(folder: Path, motion: str, *options: str) -> str:
    path = folder / "s.yaml"
    path.write_text(f"{HEAD}bodies:\n  drone: {{motion: {motion}}}\n  post: {{shapes: [{{sphere: 1}}]}}\n")
    done = CliRunner().invoke(command, [str(path), *options])
    assert done.exit_code == 0, done.output
    return done.stdout


def recorded(folder: Path, motion: str) -> dict[str, object] | None:
    bodies = {body["name"]: body for body in json.loads(checked(folder, motion, "--json"))["bodies"]}
    assert bodies["post"]["recorded"] is None
    found: dict[str, object] | None = bodies["drone"]["recorded"]
    return found


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    times = [0.0, 0.1, 0.2, 0.3, 1.2, 1.3, 1.4]
    (tmp_path / "path.csv").write_text("t,x,y,z\n" + "".join(f"{time + 50},0,0,0\n" for time in times))
    (tmp_path / "one.tum").write_text("7 0 0 0 0 0 0 1\n")
    return tmp_path


@pytest.mark.parametrize("after", ["hold", "loop"])
def test_a_recorded_path_tells_its_rate_its_time_and_its_largest_gap(folder: Path, after: str) -> None:
    motion = f"{{type: file, file: path.csv, layout: csv, t0: -0.5, after: {after}}}"
    assert recorded(folder, motion) == {
        "poses": 7,
        "time": [-0.5, 0.9],
        "rate": pytest.approx(10.0),
        "largest_gap": pytest.approx(0.9),
        "largest_gap_from": pytest.approx(-0.2),
    }
    line = "drone: 7 recorded poses from -0.5 to 0.9 s (1.4 s), 10 Hz, largest gap 0.9 s, after -0.2 s"
    assert line in " ".join(checked(folder, motion).split())


def test_a_single_pose_has_neither_rate_nor_gap(folder: Path) -> None:
    motion = "{type: file, file: one.tum, layout: tum, after: hold}"
    assert recorded(folder, motion) == {
        "poses": 1,
        "time": [0.0, 0.0],
        "rate": None,
        "largest_gap": None,
        "largest_gap_from": None,
    }
    assert "drone: 1 recorded pose from 0 to 0 s\n" in checked(folder, motion)


def test_keys_in_the_scene_are_not_recorded(folder: Path) -> None:
    assert recorded(folder, "{type: keyframes, keys: [{t: 0}, {t: 1}]}") is None
