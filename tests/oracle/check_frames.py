"""Checks of what viewers are told: transforms."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from .logs import Log
from .sampling import Effort
from .truth import Truth, point, seconds

Values = dict[str, Any]


def check_transforms(truth: Truth, log: Log, effort: Effort, epoch: int) -> Iterable[str]:
    """Logged transforms are the bodies' poses in the world."""
    rng = np.random.default_rng(effort.seed)
    messages = log.of("tf")
    order = rng.permutation(len(messages))[: effort.messages]
    for message in (messages[i] for i in order):
        time = seconds({"timestamp": message["log_time"]}, epoch)
        for transform in message["transforms"]:
            yield from check_transform(truth, transform, time)


def check_transform(truth: Truth, transform: Values, time: float) -> Iterable[str]:
    """One transform at one time (s); its timestamp is in ns. Where a path is unknown, it is a picture and no claim."""
    name = transform["child_frame_id"]
    if name not in truth.names:
        yield f"/tf at {time} s: no body {name}"
        return
    if transform["parent_frame_id"] != "world":
        yield f"/tf at {time} s: {name} has parent {transform['parent_frame_id']}"
    if truth.unplaced(name):
        return
    times = np.array([time])
    true = truth.kinematics.world_from_body(name, times)[0]
    blur = float(truth.blur(name, times)[0])
    moved = np.linalg.norm(true[:3, 3] - np.array(point(transform["translation"])))
    turn = transform["rotation"]
    turned = Rotation.from_quat([turn[key] for key in "xyzw"]).as_matrix() - true[:3, :3]
    off = moved + np.linalg.norm(turned) * truth.surfaces[name].extent
    if not off <= truth.tolerance + blur:
        yield f"/tf at {time} s: {name} is {off:.3g} m off"
