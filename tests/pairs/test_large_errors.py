"""Where distances may be wrong by much, certain overlaps are CONTACT, and all else that may touch is UNRESOLVED."""

from __future__ import annotations

import json
from math import hypot

import numpy as np
import pytest
from cli_process import closecall_inside
from small_scenes import HERE, box, events_of, round_shape

from closecall.formats.log.reader import LogReader
from closecall.scheduler.model.events import Collision, Distance, Phase, Span, Verdict
from closecall.scheduler.model.scene import Body, PairRules, Scene
from closecall.scheduler.motions import Constant, Fixed
from closecall.scheduler.narrow.narrow_phase import NarrowPhase
from closecall.scheduler.pairs.pair_factory import pairs_that_might_collide

SPIN = (0.0, 0.0, 1e12)
"""rad/s, by which the places of a body after some seconds are known to some mm."""


def scene(gap: float) -> str:
    """Return two balls that stay so far (m) apart, one of which spins about its own middle, in Unix time."""
    return (
        "closecall: 1\nunits: {length: m, angle: rad}\ntime: {start: 1700000000, end: 1700000001}\n"
        "settings: {contact_tolerance: 1e-4, time_resolution: 0.02}\nbodies:\n"
        "  a: {shapes: [{sphere: 0.4}], motion: {type: constant, angular_velocity: [0, 0, 1000]}}\n"
        f"  b: {{pose: {{xyz: [{0.8 + gap}, 0, 0]}}, shapes: [{{sphere: 0.4}}]}}\n"
    )


@pytest.mark.parametrize(
    ("gap", "verdict"), [(1e-3, "unresolved"), (-1e-4, "unresolved"), (-0.01, "contact"), (0.01, "clear")]
)
def test_what_the_error_hides_is_unresolved_and_what_it_does_not_is_told(tmp_path, gap, verdict):
    (tmp_path / "scene.yaml").write_text(scene(gap))
    done = closecall_inside("run", "scene.yaml", "-o", "out.mcap", "--log", "certificate", cwd=tmp_path)
    (pair,) = json.loads(closecall_inside("summary", "out.mcap", "--json", cwd=tmp_path).stdout)["pairs"]
    assert pair["verdict"] == verdict
    assert 1e-4 < pair["error"] < 5e-3
    assert f"warning: distances of a | b may be wrong by {pair['error']:.2g} m; " in done.stderr
    with LogReader(tmp_path / "out.mcap") as log:
        told = [message.message for _, _, message in log.facts("/log")]
    assert any(line.startswith(f"distances of a | b may be wrong by {pair['error']:.2g} m; ") for line in told)
    if verdict == "unresolved":
        assert (pair["distance"]["bracket"], pair["distance"]["why"]) == ("wide", "error")


def error_of(*bodies: Body, end: float) -> float:
    (pair,) = pairs_that_might_collide(Scene(bodies, 0.0, end, PairRules()), NarrowPhase(bodies), 0.0)
    assert pair.coarse
    return pair.error


def body(name: str, shape, place, motion) -> Body:
    pose = np.eye(4)
    pose[:3, 3] = place
    return Body(name, None, pose, motion, (shape,))


@pytest.mark.parametrize("aside", [0.0, 0.5])
def test_bodies_that_pass_through_each_other_touch_where_that_is_certain_and_may_on_both_sides_of_it(aside):
    """Balls of 0.5 m, one of which passes the other's middle at so many m: they truly meet while it is within 1 m."""
    runs = body("runs", round_shape(0.5), (-2.0, aside, 0.0), Constant((1.0, 0.0, 0.0), SPIN))
    still = body("still", round_shape(0.5), (0.0, 0.0, 0.0), Fixed())
    error = error_of(runs, still, end=4.0)
    events = events_of(runs, still, end=4.0)
    spans = [event for event in events if isinstance(event, Span)]
    assert [span.verdict for span in spans] == [
        Verdict.CLEAR,
        Verdict.UNRESOLVED,
        Verdict.CONTACT,
        Verdict.UNRESOLVED,
        Verdict.CLEAR,
    ]

    def depth(time: float) -> float:
        return 1.0 - hypot(time - 2.0, aside)

    for span in spans:
        depths = [depth(time) for time in np.linspace(span.start, span.end, 2001)]
        if span.verdict is Verdict.CLEAR:
            assert max(depths) <= 0.0
        elif span.verdict is Verdict.CONTACT:
            assert min(depths) >= 0.0
        else:
            assert max(map(abs, depths)) < 3.0 * error + 2e-3  # a step of the time resolution beside them
            assert max(depths) <= span.depth_limit
            assert min(depths) < 0.0 < max(depths)
    begin, finish = (event for event in events if isinstance(event, Collision))
    assert (begin.phase, finish.phase) == (Phase.BEGIN, Phase.END)
    for event in (begin, finish):
        assert 0.0 < abs(event.time_clear - event.time_touching) <= 1e-6
        assert depth(event.time_touching) >= 0.0
    assert {event.error for event in spans} == {error}


def test_boxes_that_are_certainly_in_each_other_touch_and_what_may_be_deep_says_so():
    """A corner 0.2 m deep tells; where nobody knows how deep, no depth is promised."""
    still = body("still", box(1.0, 1.0, 1.0), (0.0, 0.0, 0.0), Fixed())
    turns = body("turns", box(1.0, 1.0, 1.0), (0.8, 0.8, 0.8), Constant((0.0, 0.0, 0.0), (0.0, 0.0, 1e11)))
    assert error_of(still, turns, end=0.01) > 1e-6
    events = events_of(still, turns, end=0.01)
    assert {event.verdict for event in events if isinstance(event, Span)} <= {Verdict.CONTACT, Verdict.UNRESOLVED}
    for event in events:
        if isinstance(event, Span) and event.verdict is Verdict.UNRESOLVED:
            assert event.depth_limit >= 0.2


def test_what_a_large_error_hides_is_never_clear_while_it_stands_still():
    """Nothing moves but the spin, and the gap is half the error: no sleep proves anything."""
    spins = Constant((0.0, 0.0, 0.0), SPIN)
    error = error_of(
        body("a", round_shape(0.5), (0.0, 0.0, 0.0), spins), body("b", round_shape(0.5), (1.1, 0, 0), Fixed()), end=0.1
    )
    for shape in (round_shape(0.5), box(1.0, 1.0, 1.0)):
        wall = Body("wall", None, HERE, Fixed(), (box(0.2, 4.0, 4.0),))
        half = 0.5 * error if shape.radius else 0.4 * error
        near = body("near", shape, (0.6 + half, 0.0, 0.0), Constant((0.0, 0.0, 0.0), (1e12, 0.0, 0.0)))
        events = events_of(wall, near, end=0.1)
        assert {event.verdict for event in events if isinstance(event, Span)} == {Verdict.UNRESOLVED}
        assert min(event.distance for event in events if isinstance(event, Distance)) > 0.0


def test_errors_that_bodies_of_their_size_always_have_leave_what_rests_in_contact():
    for size in (1e-6, 1.0, 1e9):
        floor = body("floor", box(size, size, size), (0.0, 0.0, 0.0), Fixed())
        slides = Constant((0.1 * size, 0.0, 0.0), (0.0, 0.0, 0.0))
        rests = body("rests", box(size, size, size), (0.0, 0.0, size), slides)
        verdicts = {event.verdict for event in events_of(floor, rests, end=1.0) if isinstance(event, Span)}
        assert verdicts == {Verdict.CONTACT}
