"""No class of motions can be certified that is not tried: by rounding tests, by tests of bounds, by the oracle."""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Iterator
from enum import Enum
from types import ModuleType
from typing import Any, get_type_hints

import numpy as np
import pytest
from drawn_motions import KINDS
from rounding_cases import ROUNDING_CASES

from closecall.formats.scene.grammar.motions import MOTIONS
from closecall.scheduler import motions
from oracle.motions import MOTIONS as ORACLE_MOTIONS
from oracle.paths import PATHS


def motion_classes(package: ModuleType) -> set[type]:
    """Return the classes of a package's modules that are motions, wherever they stand; Fixed and Limits apart.

    Nothing of the one is rounded, of the other no pose is known: test_unknown_path.py tries what is said of it.
    """
    found: set[type] = set()
    for module in pkgutil.iter_modules(package.__path__, f"{package.__name__}."):
        for value in vars(importlib.import_module(module.name)).values():
            if isinstance(value, type) and hasattr(value, "pose") and hasattr(value, "rounding_scale"):
                found.add(value)
    return found - {motions.Motion, motions.Fixed, motions.Limits}


def test_the_rounding_of_each_class_of_motions_is_tried() -> None:
    tried = {kind for kind, _ in ROUNDING_CASES.values()}
    assert motion_classes(motions) == tried, "let tests/motions/test_rounding_of_poses.py have a case of each"


def test_bounds_are_tried_with_each_class_of_motions_and_all_that_it_can_be() -> None:
    """By helpers/drawn_motions.py, which the tests of displacements, lengths, rates, slabs and so on draw from."""
    rng = np.random.default_rng(1)
    drawn = [kind(rng) for kind in KINDS for _ in range(10)]
    assert motion_classes(motions) == {type(motion) for motion in drawn}, "let tests/helpers/drawn_motions.py draw each"
    for kind, name, values in choices():
        assert values == {getattr(motion, name) for motion in drawn if type(motion) is kind}, f"{kind.__name__}.{name}"


def choices() -> Iterator[tuple[type, str, set[Any]]]:
    """Yield what a motion may be made with that has few values: the class, the argument, the values."""
    for kind in motion_classes(motions):
        for name, annotation in get_type_hints(kind.__init__).items():
            if annotation is bool:
                yield kind, name, {False, True}
            elif isinstance(annotation, type) and issubclass(annotation, Enum):
                yield kind, name, set(annotation)


@pytest.mark.parametrize("kind", sorted(set(MOTIONS) - set(PATHS)))
def test_the_oracle_knows_where_each_motion_goes(kind: str) -> None:
    assert kind in ORACLE_MOTIONS


def test_a_class_of_motions_that_nobody_tries_is_missed(monkeypatch: pytest.MonkeyPatch) -> None:
    class Spring(motions.Fixed):
        """A made-up motion."""

    monkeypatch.setattr(importlib.import_module("closecall.scheduler.motions.screw"), "Spring", Spring, raising=False)
    missed = motion_classes(motions) - {kind for kind, _ in ROUNDING_CASES.values()}
    assert missed == {Spring}
