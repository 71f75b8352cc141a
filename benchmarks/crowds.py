"""Crowds in a box off whose walls they bounce, for 10 s: convex polytopes, and polygon soups that come and go.

`python -m benchmarks.crowds [SHARE]` runs 1,000 polytopes of 50 faces (as in I-COLLIDE) and 200 soups of 5,120
triangles (as in V-COLLIDE), and says what they took. Then python-fcl steps the same bodies at 10 ms, each pair whose
balls overlap: whatever touches at a sample must lie in a contact of the log, and what lies in one may be apart for less
than the time resolution only. With SHARE below 1 so large a share of the bodies is taken, at the same density.

A polytope is 1 m wide and has a cube of 4 m to itself, a soup is 2 m wide and has one of 4 m; they move at some 1 m/s
along each axis and turn at 1 rad/s.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import fcl
import numpy as np
import trimesh
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory
from scipy.spatial import ConvexHull, cKDTree
from scipy.spatial.transform import Rotation, Slerp

from .command import Ran, run_command
from .scene_file import write_scene_file
from .table import Row

SECONDS = 10.0
SAMPLE = 0.01
"""s: the step of the independent run."""

ROOM = 4.0
"""m: the edge of the cube that each body has to itself, on the average."""

BRACKET = 1e-6
"""s: a contact's span reaches so far at most beyond the instants at which the bodies certainly touch."""

RESOLUTION = 1e-3
"""s: the command's time resolution. A contact may hide gaps that are shorter."""

CONTACTS_ALONE = ("--rate", "0", "--distance-tolerance", "none")

Contacts = dict[tuple[int, int], list[tuple[float, float]]]


@dataclass(frozen=True, slots=True, eq=False)
class Crowd:
    """Bodies of one mesh on paths of straight stretches, turning evenly.

    Attributes:
        radius: m, of the ball about the origin that holds the mesh.
        times, places: of each body, when and where it starts, bounces and ends: (k,) s and (k, 3) m.
        turns: of each body, at those times, as rotations.
        exists: (n, 2) s, from when to when it is there.
    """

    name: str
    mesh: trimesh.Trimesh
    radius: float
    times: list[np.ndarray]
    places: list[np.ndarray]
    turns: list[Rotation]
    exists: np.ndarray

    def write(self, folder: Path) -> Path:
        """Write the scene file."""
        self.mesh.export(folder / "body.ply")
        bodies = {}
        for index, (times, places, turns) in enumerate(zip(self.times, self.places, self.turns, strict=True)):
            quaternions = np.roll(turns.as_quat(), 1, axis=1)
            keys = [
                {"t": t, "xyz": place, "quat_wxyz": turn}
                for t, place, turn in zip(times.tolist(), places.tolist(), quaternions.tolist(), strict=True)
            ]
            motion = {"type": "keyframes", "keys": keys, "before": "hold", "after": "hold"}
            exists = self.exists[index].tolist()
            bodies[f"body_{index}"] = {"shapes": [{"mesh": "body"}], "motion": motion, "exists": exists}
        return write_scene_file(folder / "scene.json", SECONDS, {"body": {"file": "body.ply"}}, bodies)


def polytopes(count: int) -> Crowd:
    """Return polytopes of 27 corners and 50 triangles, there throughout."""
    rng = np.random.default_rng(0)
    points = rng.normal(size=(27, 3))
    points *= 0.5 / np.linalg.norm(points, axis=1, keepdims=True)
    hull = ConvexHull(points)
    a, b, c = points[hull.simplices].transpose(1, 0, 2)
    inward = np.einsum("ij,ij->i", np.cross(b - a, c - a), hull.equations[:, :3]) < 0.0
    mesh = trimesh.Trimesh(points, np.where(inward[:, None], hull.simplices[:, ::-1], hull.simplices), process=False)
    return _crowd("polytopes of 50 faces", mesh, 0.5, count, rng, np.tile((0.0, SECONDS), (count, 1)))


def soups(count: int) -> Crowd:
    """Return soups of loose triangles, a third of them there throughout, the others for some seconds."""
    rng = np.random.default_rng(1)
    ball = trimesh.creation.icosphere(subdivisions=4)
    corners = ball.triangles * rng.uniform(0.8, 1.0, (len(ball.triangles), 1, 1))
    middles = corners.mean(axis=1, keepdims=True)
    corners = middles + 0.9 * (corners - middles)
    mesh = trimesh.Trimesh(corners.reshape(-1, 3), np.arange(3 * len(corners)).reshape(-1, 3), process=False)
    exists = np.sort(rng.uniform(0.0, SECONDS, (count, 2)).round(3), axis=1)
    exists[::3] = 0.0, SECONDS
    return _crowd("soups of 5,120 triangles", mesh, 1.0, count, rng, exists)


def _crowd(
    name: str, mesh: trimesh.Trimesh, radius: float, count: int, rng: np.random.Generator, exists: np.ndarray
) -> Crowd:
    half = 0.5 * ROOM * count ** (1.0 / 3.0) - radius
    paths = [_bouncing(rng.uniform(-half, half, 3), rng.normal(0.0, 1.0, 3), half) for _ in range(count)]
    turns = []
    for times, _ in paths:
        first, rate = Rotation.from_quat(rng.normal(size=4)), rng.normal(0.0, 0.6, 3)
        turns.append(Rotation.from_rotvec(times[:, None] * rate) * first)
    return Crowd(name, mesh, radius, [times for times, _ in paths], [places for _, places in paths], turns, exists)


def _bouncing(place: np.ndarray, velocity: np.ndarray, half: float) -> tuple[np.ndarray, np.ndarray]:
    """Return when and where a point that starts at `place` bounces in a cube of half edges `half`, each second too."""
    times = {*np.arange(SECONDS + 1.0).tolist()}
    for start, speed in zip(place, velocity, strict=True):
        walls = np.arange(-50, 51) * 2.0 * half + half
        times |= {t for t in ((walls - start) / speed).tolist() if 0.0 < t < SECONDS}
    ordered = np.array(sorted(times))
    straight = place + ordered[:, None] * velocity + half
    folded = np.abs((straight + 2.0 * half) % (4.0 * half) - 2.0 * half) - half
    return ordered, folded


def contacts_of(log: Path) -> Contacts:
    """Return the times (s) of each pair's contacts, as the log's spans have them."""
    found: Contacts = {}
    with log.open("rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        for _, _, _, span in reader.iter_decoded_messages(topics=["/spans"]):
            if span.Verdict.Name(span.verdict) == "CONTACT":
                a, b = (int(body.removeprefix("body_")) for body in (span.body_a, span.body_b))
                found.setdefault((a, b), []).append((span.start, span.end))
    return found


class Stepped:
    """The crowd as python-fcl sees it, by poses of its own."""

    def __init__(self, crowd: Crowd) -> None:
        """Build one tree for all."""
        model = fcl.BVHModel()
        model.beginModel(len(crowd.mesh.vertices), len(crowd.mesh.faces))
        model.addSubModel(crowd.mesh.vertices, crowd.mesh.faces)
        model.endModel()
        self._crowd = crowd
        self._objects = [fcl.CollisionObject(model, fcl.Transform()) for _ in crowd.times]
        self._turns = [Slerp(times, turns) for times, turns in zip(crowd.times, crowd.turns, strict=True)]

    def touching(self, time: float) -> set[tuple[int, int]]:
        """Return the pairs of bodies that are there and touch."""
        exists = self._crowd.exists
        there = np.flatnonzero((exists[:, 0] < time) & (time < exists[:, 1]))
        if len(there) < 2:
            return set()
        places = np.array([self._place(index, time) for index in there.tolist()])
        near = cKDTree(places).query_pairs(2.0 * self._crowd.radius + 1e-6, output_type="ndarray")
        for row in np.unique(near).tolist():
            index = int(there[row])
            self._objects[index].setTransform(fcl.Transform(self._turns[index](time).as_matrix(), places[row]))
        pairs = np.sort(there[near], axis=1).tolist()
        return {(a, b) for a, b in pairs if fcl.collide(self._objects[a], self._objects[b])}

    def touch(self, a: int, b: int, time: float) -> bool:
        """Tell whether two bodies touch."""
        for index in (a, b):
            turn = self._turns[index](time).as_matrix()
            self._objects[index].setTransform(fcl.Transform(turn, self._place(index, time)))
        return bool(fcl.collide(self._objects[a], self._objects[b]))

    def _place(self, index: int, time: float) -> np.ndarray:
        times = self._crowd.times[index]
        return np.array([np.interp(time, times, column) for column in self._crowd.places[index].T])


@dataclass(slots=True)
class Tally:
    """Samples at which pairs touch, those of them outside the log's contacts, and those in contacts that are apart.

    Attributes:
        hidden: apart in a contact for less than the time resolution, as a contact may be.
        invented: for longer.
    """

    touching: int = 0
    missed: int = 0
    hidden: int = 0
    invented: int = 0


def compared(crowd: Crowd, contacts: Contacts) -> Tally:
    """Step the crowd by itself and hold every sample against the contacts."""
    stepped, tally = Stepped(crowd), Tally()
    spans = [(start, end, pair) for pair, own in contacts.items() for start, end in own]
    for time in np.arange(SAMPLE, SECONDS, SAMPLE).tolist():
        touching = stepped.touching(time)
        told = {pair for start, end, pair in spans if start < time < end}
        tally.touching += len(touching)
        tally.missed += len(touching - told)
        certain = {pair for start, end, pair in spans if start + BRACKET < time < end - BRACKET}
        for a, b in certain - touching:
            if _gap(stepped, a, b, time) <= RESOLUTION:
                tally.hidden += 1
            else:
                tally.invented += 1
    return tally


def _gap(stepped: Stepped, a: int, b: int, time: float) -> float:
    """Return for how long (s) two bodies are apart around a time, to a tenth of the resolution; inf for very long."""
    tenths = RESOLUTION / 10.0 * np.arange(1, 12)
    sides = (next((t for t in tenths.tolist() if stepped.touch(a, b, time + side * t)), np.inf) for side in (-1, 1))
    return float(sum(sides)) - RESOLUTION / 5.0


def rows(share: float) -> Iterator[Row]:
    """Yield the rows of the table: what each crowd takes, and how its contacts compare."""
    for crowd in (polytopes(round(1000 * share)), soups(round(200 * share))):
        case = f"{len(crowd.times)} {crowd.name}, {SECONDS:g} s"
        with TemporaryDirectory() as name:
            scene = crowd.write(Path(name))
            log = scene.with_suffix(".mcap")
            yield Row(f"{case}, with least distances", took(run_command(scene, log, "--rate", "0")))
            ran = run_command(scene, log, *CONTACTS_ALONE)
            contacts = contacts_of(log)
        yield Row(f"{case}, contacts alone", took(ran), f"within {SECONDS:g} s", ran.wall < SECONDS)
        tally = compared(crowd, contacts)
        told = sum(map(len, contacts.values()))
        agreement = f"{told} contacts; {tally.touching} samples touch, {tally.missed} of them outside; apart inside: "
        agreement += f"{tally.hidden} for less than the time resolution, {tally.invented} for longer"
        agree = tally.missed == tally.invented == 0
        yield Row(f"{case}: python-fcl at {1e3 * SAMPLE:g} ms", agreement, "none outside, none for longer", agree)


def took(ran: Ran) -> str:
    """Return a run's cost in words."""
    parts = ", ".join(f"{part} {seconds:.1f}" for part, seconds in ran.told["seconds"].items() if part != "total")
    return f"{ran.wall:.1f} s ({parts}), {ran.cpu:.1f} CPU s, {ran.memory:.0f} MB"


if __name__ == "__main__":
    for row in rows(float(sys.argv[1]) if len(sys.argv) > 1 else 1.0):
        print(row.markdown(), flush=True)
