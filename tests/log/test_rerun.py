"""docs/rerun_convert.py: a log's collisions come back from its Rerun recording as they are in the log."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory
from places import ROOT

COUNTS = {"arm_pick": 2, "asteroids": 6, "ball_in_shell": 1, "near_gears": 0, "spinning_bar": 2}
"""How many begins and ends of contacts each sample has; the two of arm_pick are at one instant."""


def has_rerun() -> bool:
    """Tell whether all is installed that the script imports."""
    if any(find_spec(name) is None for name in ("rerun", "datafusion", "pyarrow")):
        return False
    return find_spec("rerun.chunk") is not None


def logged(log: Path) -> list[dict[str, Any]]:
    """Return the collisions of a log, in its order."""
    with log.open("rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        return [plain(found[3]) for found in reader.iter_decoded_messages(topics=["/collisions"])]


def plain(message: Any) -> dict[str, Any]:
    """Return a message as a dictionary with every field, enums by name."""
    values = {}
    for field in message.DESCRIPTOR.fields:
        value = getattr(message, field.name)
        if field.enum_type:
            values[field.name] = field.enum_type.values_by_number[value].name
        else:
            values[field.name] = plain(value) if field.message_type else value
    return values


def test_without_rerun_or_with_an_old_one_a_line_says_what_to_install(tmp_path: Path) -> None:
    (tmp_path / "datafusion.py").write_text("raise ModuleNotFoundError(\"No module named 'datafusion'\")\n")
    script = str(ROOT / "docs" / "rerun_convert.py")
    path = os.pathsep.join(filter(None, (str(tmp_path), os.environ.get("PYTHONPATH"))))
    arguments = [sys.executable, script, "a.mcap", "a.rrd"]
    done = subprocess.run(arguments, capture_output=True, text=True, env={**os.environ, "PYTHONPATH": path})
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (1, "", 1)
    assert done.stderr.startswith("No module named 'datafusion': this script needs closecall, and pip install")


@pytest.mark.skipif(not has_rerun(), reason="not installed: pip install 'rerun-sdk[catalog]>=0.41'")
@pytest.mark.parametrize("name", COUNTS)
def test_collisions_come_back_from_the_recording(name: str, tmp_path: Path) -> None:
    log, recording = tmp_path / f"{name}.mcap", tmp_path / f"{name}.rrd"
    scene = ROOT / "sample_scenes" / name / "scene.yaml"
    run = [sys.executable, "-m", "closecall", "run", str(scene), "-o", str(log)]
    subprocess.run(run, check=True, capture_output=True, timeout=120)
    script = str(ROOT / "docs" / "rerun_convert.py")
    done = subprocess.run([sys.executable, script, log, recording], capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    printed = [json.loads(line) for line in done.stdout.splitlines()]
    assert printed == logged(log)
    assert len(printed) == COUNTS[name]
    assert recording.stat().st_size > 0
