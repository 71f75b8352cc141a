"""How many snapshots a run takes: enough to show curves, and never so many that a long run does not end."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from closecall.cli.application.errors import OptionError
from closecall.cli.application.rate import snapshot_rate, thinned
from closecall.cli.commands.run import command
from closecall.scheduler.model.scene import Body, PairRules, Scene
from closecall.scheduler.motions import Fixed
from closecall.scheduler.snapshots.schedule import snapshot_times


@pytest.mark.parametrize(
    ("seconds", "snapshots"), [(1e-6, 121), (1.0, 121), (4.0, 121), (100.0, 3001), (1200.0, 36001), (1e6, 36001)]
)
def test_a_run_of_any_length_takes_enough_snapshots_and_not_too_many(seconds: float, snapshots: int) -> None:
    scene = Scene((Body("post", None, np.eye(4), Fixed(), ()),), 0.0, seconds, PairRules())
    times = list(snapshot_times(scene, snapshot_rate(seconds, None)))
    assert len(times) == snapshots
    assert (times[0], times[-1]) == (0.0, seconds)


def test_only_a_run_that_takes_them_less_often_than_usual_says_so() -> None:
    assert thinned(1200.0, None) is None
    assert thinned(1e6, 1.0) is None
    assert thinned(1e6, None) == "the run of 1e+06 s takes a snapshot every 27.8 s, 36,000 in all; see --rate"


def test_a_rate_that_is_asked_for_is_kept_up_to_a_million_snapshots() -> None:
    assert snapshot_rate(1e6, 1.0) == 1.0
    assert snapshot_rate(1.0, 0.0) == 0.0
    with pytest.raises(OptionError, match="would take 30,000,000 snapshots"):
        snapshot_rate(1e6, 30.0)


def test_too_many_snapshots_are_refused_before_anything_is_written(tmp_path: Path) -> None:
    ball = {"shapes": [{"sphere": 1}], "motion": {"type": "constant", "velocity": [1, 0, 0]}}
    post = {"pose": {"xyz": [0, 9, 0]}, "shapes": [{"sphere": 1}]}
    scene = {"closecall": 1, "units": {"length": "m", "angle": "deg"}, "time": {"start": 0, "end": 1e6}}
    (tmp_path / "scene.json").write_text(json.dumps({**scene, "bodies": {"ball": ball, "post": post}}))
    words = [str(tmp_path / "scene.json"), "-o", str(tmp_path / "out.mcap"), "--rate", "30"]
    refused = CliRunner().invoke(command, words)
    assert refused.exit_code == 2
    assert "the limit is 1,000,000, which is 1 Hz" in " ".join(refused.output.split())
    assert sorted(path.name for path in tmp_path.iterdir()) == ["scene.json"]
    certified = CliRunner().invoke(command, [*words, "--log", "certificate", "-q"], standalone_mode=False)
    assert certified.return_value == 0
