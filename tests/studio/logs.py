"""Logs of the samples, read by the MCAP library for Python."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory

SAMPLES = Path(__file__).parents[2] / "sample_scenes"
NAMES = sorted(path.parent.name for path in SAMPLES.glob("*/scene.yaml"))


class Told(NamedTuple):
    """A message of a log: when, ns, and what."""

    time: int
    message: Any


@dataclass(frozen=True)
class Log:
    """A log in a file."""

    path: Path

    @cached_property
    def attachments(self) -> dict[str, bytes]:
        with self.path.open("rb") as stream:
            return {attachment.name: attachment.data for attachment in make_reader(stream).iter_attachments()}

    @cached_property
    def layout(self) -> dict[str, Any]:
        return json.loads(self.attachments["layout.json"])

    @cached_property
    def summary(self) -> dict[str, Any]:
        return json.loads(self.attachments["summary.json"])

    @cached_property
    def contacts(self) -> list[tuple[str, float, float]]:
        """Every contact's pair, begin and end, s."""
        return [
            (pair["pair"], contact["begin"][1], contact["end"][0] if contact["end"] else self.summary["time"][1])
            for pair in self.summary["pairs"]
            for contact in pair["contacts"]
        ]

    def share(self, time: float) -> float:
        """Return which share of the run has gone by at a time, s."""
        start, end = self.summary["time"]
        return (time - start) / (end - start)

    def time(self, share: float) -> float:
        """Return the time, s, at which a share of the run has gone by."""
        start, end = self.summary["time"]
        return start + share * (end - start)

    def messages(self, topic: str) -> list[Told]:
        with self.path.open("rb") as stream:
            reader = make_reader(stream, decoder_factories=[DecoderFactory()])
            return [Told(found[2].log_time, found[3]) for found in reader.iter_decoded_messages(topics=[topic])]

    def latest(self, topic: str, shown: str) -> list[Any]:
        """Return the messages that may be a topic's latest at a time of day, which Studio cuts to whole ms."""
        time = round(seconds(shown) * 1e9)
        messages = self.messages(topic)
        known = [told for told in messages if told.time <= time]
        latest = [told.message for told in known if told.time == known[-1].time]
        return latest + [told.message for told in messages if time < told.time < time + 1_000_000]


def seconds(time_of_day: str) -> float:
    """Return the time of day, as in 12:00:01.500 AM UTC, in s."""
    parts = re.fullmatch(r"(\d+):(\d+):([\d.]+) AM UTC", time_of_day)
    assert parts, time_of_day
    return (int(parts[1]) % 12 * 60 + int(parts[2])) * 60 + float(parts[3])


def logs_of_samples(folder: Path, names: Sequence[str] = NAMES) -> dict[str, Log]:
    """Run the tool on samples; their logs, by name, go to the folder."""
    found = {}
    for name in names:
        found[name] = Log(folder / f"{name}.mcap")
        command = [sys.executable, "-m", "closecall", "run", SAMPLES / name / "scene.yaml", "-o", found[name].path]
        subprocess.run(list(map(str, command)), check=True, capture_output=True, timeout=120)
    return found
