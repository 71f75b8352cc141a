"""The `pairs` section: which pairs are checked and within which margins, and what it may not say."""

from __future__ import annotations

from pathlib import Path

import pytest
from scene_files import HEAD, fault, faults, load

from closecall.formats.scene.build import names
from closecall.scheduler.model.scene import PairRules, PairSet

BODIES = f"{HEAD}bodies:\n  a: {{groups: [g]}}\n  b: {{groups: [g]}}\n  c: {{groups: [h]}}\n"
"""What follows begins in line 8."""


def rules(folder: Path, pairs: str) -> PairRules:
    return load(folder, f"{BODIES}pairs: {{{pairs}}}\n").scene.rules


def test_without_rules_every_pair_is_checked(tmp_path: Path) -> None:
    assert load(tmp_path, BODIES).scene.rules == PairRules()


def test_rules_take_names_groups_and_patterns(tmp_path: Path) -> None:
    found = rules(tmp_path, "ignore: [{between: [g, '[bc]'], reason: r}], check: [{between: ['*', c]}]")
    assert found.ignored == (PairSet(frozenset({0, 1}), frozenset({1, 2})),)
    assert found.checked == (PairSet(frozenset({0, 1, 2}), frozenset({2})),)


def test_the_default_may_be_to_ignore(tmp_path: Path) -> None:
    found = rules(tmp_path, "default: ignore, check: [{between: [a, c]}]")
    assert [found.allow(*pair) for pair in ((0, 1), (0, 2), (1, 2))] == [False, True, False]
    found = rules(tmp_path, "default: check, ignore: [{between: [a, c]}]")
    assert [found.allow(*pair) for pair in ((0, 1), (0, 2), (1, 2))] == [True, False, True]


def test_a_check_overrides_an_ignore_in_either_order_of_its_sides(tmp_path: Path) -> None:
    found = rules(tmp_path, "ignore: [{between: ['*', '*']}], check: [{between: [c, g]}]")
    assert [found.allow(*pair) for pair in ((0, 1), (0, 2), (1, 2))] == [False, True, True]


def test_margins_are_in_the_files_unit_and_the_last_that_fits_counts(tmp_path: Path) -> None:
    found = rules(
        tmp_path,
        "margins: [{between: ['*', '*'], margin: 5}, {between: [h, a], margin: 0}, {between: [b, c], margin: 2}]",
    )
    assert [found.margin(*pair, 1.0) for pair in ((0, 1), (0, 2), (1, 2))] == [0.005, 0.0, 0.002]
    assert rules(tmp_path, "margins: [{between: [a, b], margin: 5}]").margin(0, 2, 1.0) == 1.0


@pytest.mark.parametrize("section", ["ignore", "check", "margins"])
@pytest.mark.parametrize(
    ("between", "begin", "phrase"),
    [
        ("[a, x]", "[0].between[1]: ", "unknown body or group 'x'"),
        ("[d, a]", "[0].between[0]: ", "unknown body or group 'd'"),
        ("['z*', a]", "[0].between[0]: ", "the pattern 'z*' matches no body"),
        ("[a, '[x-z]']", "[0].between[1]: ", "the pattern '[x-z]' matches no body"),
        ("[a, a]", "[0].between[1]: ", "expected two bodies, both sides are the body 'a' alone"),
        ("[h, 'c*']", "[0].between[1]: ", "expected two bodies, both sides are the body 'c' alone"),
        ("[world, a]", "[0].between[0]: ", "unknown body or group 'world'"),
        ("['', a]", "[0].between[0]: ", "unknown body or group ''"),
    ],
)
def test_a_side_that_names_nothing_is_refused_in_every_section(
    tmp_path: Path, section: str, between: str, begin: str, phrase: str
) -> None:
    margin = ", margin: 1" if section == "margins" else ""
    line = fault(tmp_path, f"{BODIES}pairs: {{{section}: [{{between: {between}{margin}}}]}}\n")
    assert line.split(": ")[1] == f"pairs.{section}{begin}".removesuffix(": ")
    assert line.startswith("8:")
    assert phrase in line


def test_a_misspelt_body_or_group_is_told_with_the_nearest(tmp_path: Path) -> None:
    bodies = f"{HEAD}bodies: {{gear: {{groups: [drive]}}, wheel: {{}}}}\n"
    told = faults(tmp_path, f"{bodies}pairs: {{ignore: [{{between: [geer, weel]}}, {{between: [drives, wheel]}}]}}")
    assert [line.split("unknown body or group ")[1] for line in told] == [
        "'geer' (did you mean 'gear'?)",
        "'weel' (did you mean 'wheel'?)",
        "'drives' (did you mean 'drive'?)",
    ]


def test_a_group_matches_before_a_pattern_and_a_name_before_a_group(tmp_path: Path) -> None:
    assert rules(tmp_path, "ignore: [{between: [h, a]}]").ignored[0] == PairSet(frozenset({2}), frozenset({0}))


def test_a_rule_within_one_group_is_about_its_pairs(tmp_path: Path) -> None:
    found = rules(tmp_path, "ignore: [{between: [g, g], reason: one assembly}]")
    assert [found.allow(*pair) for pair in ((0, 1), (0, 2), (1, 2))] == [False, True, True]


def test_existence_of_bodies_is_kept(tmp_path: Path) -> None:
    bodies = load(tmp_path, f"{HEAD}bodies: {{a: {{exists: [0.25, 0.5]}}, b: {{exists: [-9, 9]}}, c: {{}}}}").scene
    assert bodies.bodies[0].exists == (0.25, 0.5)
    assert bodies.shared_time(0, 1) == (0.25, 0.5)
    assert bodies.shared_time(1, 2) == (0.0, 1.0)


def test_a_small_file_cannot_ask_for_any_number_of_pattern_comparisons(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(names, "MOST_PATTERN_COMPARISONS", 3 * 3)
    again = ", ".join(["{between: ['*', 'a*']}, {between: [g, 'c?*']}, {between: [c, a]}"] * 20).replace("c?*", "[c]")
    assert len(rules(tmp_path, f"ignore: [{again}]").ignored) == 60
    told = faults(tmp_path, f"{BODIES}pairs: {{ignore: [{again}, {{between: ['?', '[a-z]']}}]}}\n")
    assert [line.split(": ")[1:] for line in told] == [
        [f"pairs.ignore[60].between[{side}]", "too many patterns for so many bodies, use groups instead"]
        for side in range(2)
    ]
