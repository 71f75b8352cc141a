"""Named keys: between which of them a body is at a time, when its keys are delayed, repeated or its ancestor's."""

from __future__ import annotations

from dataclasses import replace
from math import nextafter
from pathlib import Path

import pytest
from scene_files import HEAD, load

from closecall.formats.scene.loaded import KeyNames

KEYS = "keys: [{t: 0, name: home}, {t: 0.25}, {t: 0.5, name: reach}, {t: 0.75, name: grip}, {t: 1}]"
NAMED = KeyNames((0.0, 0.5, 0.75), ("home", "reach", "grip"), 0.0, 1.0, before=False, after=False)


def key_names(folder: Path, bodies: str) -> dict[int, KeyNames]:
    return dict(load(folder, f"{HEAD}bodies:\n{bodies}").key_names)


def path(options: str = "") -> str:
    return f"motion: {{type: keyframes, {options}{KEYS}}}"


def test_names_of_keys_are_kept_with_their_times(tmp_path: Path) -> None:
    assert key_names(tmp_path, f"  a: {{{path()}}}\n") == {0: NAMED}


def test_keys_without_names_are_not_kept(tmp_path: Path) -> None:
    assert key_names(tmp_path, "  a: {motion: {type: keyframes, keys: [{t: 0}, {t: 1}]}}\n") == {}


def test_t0_delays_the_names_with_the_keys(tmp_path: Path) -> None:
    found = key_names(tmp_path, f"  a: {{{path('t0: 0.125, before: hold, after: hold, ')}}}\n")
    assert found == {0: KeyNames((0.125, 0.625, 0.875), NAMED.names, 0.125, 1.125, before=False, after=False)}


def test_repeated_keys_are_known_as_such(tmp_path: Path) -> None:
    found = key_names(tmp_path, f"  a: {{{path('before: loop, after: loop, ')}}}\n")[0]
    assert (found.before, found.after) == (True, True)
    found = key_names(tmp_path, f"  a: {{{path('before: hold, after: loop, ')}}}\n")[0]
    assert (found.before, found.after) == (False, True)


def test_names_are_kept_in_normal_form(tmp_path: Path) -> None:
    keys = 'keys: [{t: 0, name: "e\\u0301"}, {t: 1}]'
    assert key_names(tmp_path, f"  a: {{motion: {{type: keyframes, {keys}}}}}\n")[0].names == ("\u00e9",)


def test_a_body_has_the_names_of_the_nearest_ancestor_with_any_or_its_own(tmp_path: Path) -> None:
    other = path().replace("home", "start")
    found = key_names(
        tmp_path,
        f"  tip: {{parent: wrist}}\n  wrist: {{parent: arm, motion: {{type: constant}}}}\n  arm: {{{path()}}}\n"
        f"  tool: {{parent: wrist, {other}}}\n  floor: {{}}\n",
    )
    assert {index: names.names[0] for index, names in found.items()} == {0: "home", 1: "home", 2: "home", 3: "start"}


@pytest.mark.parametrize(
    ("time", "around"),
    [
        (-1.0, ("", "home")),
        (0.0, ("home", "reach")),
        (0.3, ("home", "reach")),
        (0.5, ("reach", "grip")),
        (0.8, ("grip", "")),
        (1.0, ("grip", "")),
        (5.0, ("grip", "")),
    ],
)
def test_a_moment_lies_between_the_names_around_it(time: float, around: tuple[str, str]) -> None:
    assert NAMED.around(time) == around


@pytest.mark.parametrize(
    ("time", "around"),
    [
        (1.0, ("home", "reach")),
        (2.3, ("home", "reach")),
        (2.6, ("reach", "grip")),
        (1.8, ("grip", "home")),
    ],
)
def test_a_moment_of_a_repeated_motion_lies_between_the_names_of_its_loop(time: float, around: tuple[str, str]) -> None:
    looped = replace(NAMED, before=True, after=True)
    assert looped.around(time) == around
    assert looped.around(time - 4.0) == around


def test_a_float_before_a_loop_begins_anew_its_last_key_is_still_ahead() -> None:
    keys = KeyNames((0.1875, 0.75), ("first", "last"), 0.1875, 0.75, before=True, after=True)
    assert keys.around(nextafter(0.1875, 0.0)) == keys.around(nextafter(0.75, 0.0)) == ("first", "last")


def test_names_follow_one_another_only_where_the_keys_repeat() -> None:
    late = KeyNames((0.5, 0.75), ("reach", "grip"), 0.0, 1.0, before=False, after=True)
    assert late.around(-3.0) == late.around(0.2) == ("", "reach")
    assert late.around(0.8) == ("grip", "reach")
    assert late.around(1.2) == ("grip", "reach")
    early = replace(late, before=True, after=False)
    assert early.around(-0.8) == early.around(0.2) == ("grip", "reach")
    assert early.around(-0.1) == ("grip", "reach")
    assert early.around(0.8) == early.around(1.8) == ("grip", "")
