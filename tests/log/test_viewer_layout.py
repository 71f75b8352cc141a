"""The layout that travels with a log: what it shows, and that its camera has all in view."""

from __future__ import annotations

import json
from math import cos, radians, sin, tan

import numpy as np
import pytest
from viewer_logs import seen, seen_by, show, write_scene

from closecall.formats.log.viewer.camera import camera
from closecall.formats.log.viewer.layout import layout
from closecall.formats.log.viewer.view_extent import Reach, reach
from closecall.scheduler.model.scene import Body, Mesh, PairRules, Scene, Shape
from closecall.scheduler.motions import Constant, Fixed

RNG = np.random.default_rng(0)
CLOUDS = {
    "cube": RNG.uniform(-1.0, 1.0, (500, 3)),
    "plate far off": RNG.uniform(-1.0, 1.0, (500, 3)) * (50.0, 30.0, 0.1) + (1e4, -1e4, 10.0),
    "pole": RNG.uniform(-1.0, 1.0, (500, 3)) * (0.01, 0.01, 5.0),
    "speck": RNG.uniform(-1e-5, 1e-5, (500, 3)),
    "point": np.zeros((1, 3)),
}


@pytest.mark.parametrize("name", CLOUDS)
def test_the_camera_has_all_in_view_and_the_bodies_fill_it(name):
    points = CLOUDS[name]
    view = camera(Reach(points, points))
    slopes = seen(points, view.distance, view.phi, view.theta, view.target)
    high = tan(radians(22.5))
    assert (slopes[:, 2] > 0.0).all()
    assert np.abs(slopes[:, 1]).max() < high
    assert np.abs(slopes[:, 0]).max() < 1.05 * high
    if name != "point":
        fill = max(np.abs(slopes[:, 1]).max() / high, np.abs(slopes[:, 0]).max() / (1.05 * high))
        assert fill > 0.85


def test_motion_is_seen_across_from_the_side_where_it_takes_place():
    room = RNG.uniform(-10.0, 10.0, (500, 3))
    moving = RNG.uniform(-1.0, 1.0, (500, 3)) * (5.0, 0.2, 1.0) + (0.0, 6.0, 0.0)  # along x, at the far wall
    view = camera(Reach(np.vstack((room, moving)), moving))
    place = np.array((-sin(radians(view.theta)), -cos(radians(view.theta))))
    assert place @ (0.0, 1.0) > 0.9


def test_reach_covers_all_that_bodies_sweep():
    bar = Mesh("bar", np.array([[x, 0.0, 0.0] for x in (-1.0, 1.0)] + [[0.0, 0.1, 0.0]]), np.array([[0, 1, 2]]), False)
    turning = Body("bar", None, np.eye(4), Constant((0.0, 0.0, 0.0), (0.0, 0.0, 6.3)), (Shape(bar, 0.0, np.eye(4)),))
    still = Body("frame", None, np.eye(4), Fixed(), ())
    outlines = np.zeros((2, 2, 3))
    outlines[0] = bar.vertices[:2]
    found = reach(Scene((turning, still), 0.0, 1.0, PairRules()), outlines, [True, False])
    assert found.low == pytest.approx((-1.0, -1.0, 0.0), abs=1e-3)
    assert found.high == pytest.approx((1.0, 1.0, 0.0), abs=1e-3)
    assert len(found.moving) == len(found.points)


def test_scenes_without_shapes_or_extent_have_a_size():
    scene = Scene((Body("frame", None, np.eye(4), Fixed(), ()),), 0.0, 1.0, PairRules())
    nothing = reach(scene, np.zeros((1, 26, 3)), [False])
    assert nothing.size == 1.0
    document = json.loads(layout(nothing, camera(nothing), []))
    assert document["configById"]["3D!scene"]["cameraState"]["distance"] > 0.0


def panels_in(node) -> set[str]:
    return {node} if isinstance(node, str) else panels_in(node["first"]) | panels_in(node["second"])


def test_the_layout_shows_scene_plot_states_pairs_and_log(tmp_path):
    shown = show(write_scene(tmp_path), tmp_path / "out.mcap")
    document = json.loads(shown.attachment("layout.json") or b"")
    panels = document["configById"]
    assert panels_in(document["layout"]) == set(panels)
    assert {name.split("!")[0] for name in panels} == {"3D", "Plot", "StateTransitions", "Table", "RosOut"}
    assert [path["value"] for path in panels["Plot!distance"]["paths"]] == ["/world.min_distance"]
    states = [path["value"] for path in panels["StateTransitions!states"]["paths"]]
    assert states == ["/collisions.phase", "/wakeups.reason"]
    assert panels["Table!pairs"]["topicPath"] == "/world.pairs"
    assert panels["RosOut!log"]["topicToRender"] == "/log"
    scene = panels["3D!scene"]
    assert scene["followTf"] == "world"
    topics = {topic for topic, _, _ in shown.decoded()}
    assert all(settings["visible"] and name in topics for name, settings in scene["topics"].items())
    assert set(scene["topics"]) == {"/scene/meshes", "/viz/clearance", "/viz/contacts", "/viz/names"}


def test_camera_and_grid_are_on_the_bounds_of_all_bodies_over_the_run(tmp_path):
    shown = show(write_scene(tmp_path), tmp_path / "out.mcap")
    scene = json.loads(shown.attachment("layout.json") or b"")["configById"]["3D!scene"]
    view = scene["cameraState"]
    # The carriage starts at x = 1.5 and ends at 4.5; the floor's corners are the lowest points.
    points = np.array([(4.7, 0.0, 0.0), (4.5, 0.3, 0.3), (0.0, 0.0, 2.9), *floor_corners()])
    slopes = seen(points, view["distance"], view["phi"], view["thetaOffset"], np.array(view["targetOffset"]))
    assert (np.abs(slopes[:, :2]) < (1.05 * tan(radians(22.5)), tan(radians(22.5)))).all()
    assert view["near"] < slopes[:, 2].min() < slopes[:, 2].max() < view["far"]
    grid = scene["layers"]["grid"]
    assert grid["position"][2] == pytest.approx(-2.25)
    assert grid["size"] / grid["divisions"] == pytest.approx(1.0)


def floor_corners() -> list[tuple[float, float, float]]:
    turn = radians(30.0)
    corners = [(x, y) for x in (-3.0, 3.0) for y in (-3.0, 3.0)]
    return [
        (cos(turn) * x - sin(turn) * y, sin(turn) * x + cos(turn) * y, z) for x, y in corners for z in (-2.25, -1.75)
    ]


SPECKS = """\
closecall: 1
units: {length: m, angle: deg}
time: {start: 0, end: 2}
bodies:
  base: {shapes: [{box: [1, 1, 1]}]}
  one: {pose: {xyz: [0, 0, 1000]}, shapes: [{sphere: 0.5}], motion: {type: constant, velocity: [1, 0, 0]}}
  other: {pose: {xyz: [2, 2, 1000]}, shapes: [{sphere: 0.5}], motion: {type: constant, velocity: [-1, 0, 0]}}
"""


def test_bodies_too_small_to_be_seen_are_shown_close_up_as_well(tmp_path):
    """The balls pass each other at 1 s, their centres 2 m apart."""
    shown = show(write_scene(tmp_path, SPECKS), tmp_path / "out.mcap")
    document = json.loads(shown.attachment("layout.json") or b"")
    assert panels_in(document["layout"]) == set(document["configById"])
    panel = document["configById"]["3D!close-up"]
    assert (panel["followMode"], panel["followTf"]) == ("follow-position", "one")
    assert panel["topics"] == document["configById"]["3D!scene"]["topics"]
    view = panel["cameraState"]
    ball = 0.5 * np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    slopes = seen_by(view, np.vstack((ball, ball + np.array((0.0, 2.0, 0.0)))))
    assert np.abs(slopes[:, :2]).max() < tan(radians(22.5))
    assert np.ptp(slopes[:4, :2]) > 0.1 * tan(radians(22.5)), "a ball is seen"


def test_bodies_that_are_seen_need_no_close_up(tmp_path):
    shown = show(write_scene(tmp_path), tmp_path / "out.mcap")
    assert "3D!close-up" not in json.loads(shown.attachment("layout.json") or b"")["configById"]
