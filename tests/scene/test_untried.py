"""Nothing can be certified that is not tried: what a scene can say, random scenes say, and the oracle knows it.

Lists of what there is come from the grammar and from the scheduler itself, so that what is new is missed here until
somebody draws it.
"""

from __future__ import annotations

import csv
from collections.abc import Iterable, Iterator, Mapping
from itertools import combinations, combinations_with_replacement, product
from pathlib import Path
from types import GenericAlias
from typing import Any, Literal, NamedTuple

import numpy as np
import pytest
from grammar_places import leaves, own_places, parts, possible, taken, within
from pydantic import BaseModel, TypeAdapter, create_model

from closecall.formats.scene.build import meshes
from closecall.formats.scene.grammar.motions import MOTIONS, MotionChoice, MotionPart
from closecall.formats.scene.grammar.scene import BodyPart, SceneFile
from closecall.formats.scene.grammar.shapes import SHAPES
from closecall.formats.scene.trajectory_files import csv_layout as trajectory_csv
from oracle import truth
from oracle.draw_motions import random_motion
from oracle.pair_scenes import FIRST_SEED, scene_of_pairs
from oracle.poses import read_scene
from oracle.scenes import begun, random_scene, write_document

SCENES, SCENES_OF_PAIRS = 300, 75
"""As many as one deep run tries, and a few of those of many pairs."""

DRAWS = 500
"""Of each motion, for words that stand beside each other in one."""

REMEDY = "let tests/oracle/draw*.py draw it and tests/oracle know it, see docs/testing.md"


class Drawn(NamedTuple):
    """A drawn scene: the document, the places of the grammar that it takes, and its folder."""

    document: dict[str, Any]
    places: set[str]
    folder: Path


@pytest.fixture(scope="module")
def drawn(tmp_path_factory: pytest.TempPathFactory) -> list[Drawn]:
    """The draws of the first seeds; their meshes and trajectories are written."""
    folder = tmp_path_factory.mktemp("drawn")
    draws = [(random_scene, seed) for seed in range(SCENES)]
    draws += [(scene_of_pairs, FIRST_SEED + number) for number in range(SCENES_OF_PAIRS)]
    found = []
    for scene_of, seed in draws:
        place = folder / str(seed)
        place.mkdir()
        document = scene_of(begun(seed, place))
        found.append(Drawn(document, places_of(SceneFile.model_validate(document, strict=False)), place))
    return found


def places_of(part: BaseModel) -> set[str]:
    """Return the places of the grammar that a mapping takes with all that stands in it."""
    return {place for one in within(part) for place in taken(one)}


def never_drawn(model: type[BaseModel], drawn: Iterable[Drawn]) -> list[str]:
    """Return the places of a scene file that no drawn scene takes."""
    return sorted(possible(model).difference(*(one.places for one in drawn)))


def test_random_scenes_say_all_that_a_scene_can_say(drawn: list[Drawn]) -> None:
    missing = never_drawn(SceneFile, drawn)
    assert not missing, f"never drawn, {REMEDY}: {'; '.join(missing)}"


class SpringMotion(MotionPart):
    """A made-up motion."""

    type: Literal["spring"]
    damping: Literal["weak", "strong"] = "weak"


def test_a_motion_that_nobody_draws_is_missed(drawn: list[Drawn]) -> None:
    body = create_model("BodyPart", __base__=BodyPart, motion=(MotionChoice | SpringMotion | None, None))
    bodies: Any = GenericAlias(dict, (str, body))  # a type that is made here, which no type checker can know
    scene = create_model("SceneFile", __base__=SceneFile, bodies=(bodies, ...))
    assert never_drawn(scene, drawn) == [
        "BodyPart.motion: SpringMotion",
        "SpringMotion.damping",
        "SpringMotion.damping = strong",
        "SpringMotion.damping = weak",
        "SpringMotion.damping left out",
        "SpringMotion.t0",
        "SpringMotion.t0 left out",
        "SpringMotion.type",
        "SpringMotion.type = spring",
    ]


def refused() -> Iterator[tuple[str, ...]]:
    """Yield the pairs of places that may not stand beside each other in a motion."""
    yield "LimitsMotion.max_acceleration left out", "LimitsMotion.max_speed left out"
    yield "ProfileMotion.kind = slide", "ProfileMotion.point"
    times = ("FileMotion.times", "FileMotion.period")
    yield from ((f"FileMotion.layout = {layout}", "FileMotion.units") for layout in ("tum", "euroc", "kitti"))
    yield from product([f"FileMotion.layout = {layout}" for layout in ("tum", "euroc", "csv")], times)
    yield from product(times, ["FileMotion.units"])
    yield times
    yield "FileMotion.period", "FileMotion.duplicates"  # even times are never equal
    yield from (("FileMotion.period", f"FileMotion.duplicates = {which}") for which in ("error", "first", "last"))


def choices(places: Iterable[str]) -> set[str]:
    """Return those places where something else could have stood; one unit of length is as good as another."""
    there = {place for place in places if ".units = " not in place}
    optional = {place.removesuffix(" left out") for place in there if place.endswith(" left out")}
    return {place for place in there if place.endswith(" left out") or " = " in place or place in optional}


def beside(motion: type[BaseModel]) -> set[frozenset[str]]:
    """Return the pairs of places that may stand beside each other in a motion, poses of keys apart."""
    below = {part for part in parts(motion) if part.__name__ not in ("Key", "AxisAngle")}
    found = set()
    for one, other in combinations(sorted(choices(place for part in below for place in own_places(part))), 2):
        keys = {place.split(" ")[0] for place in (one, other)}
        if len(keys) == 2 and not any(inside(a, b, below) for a, b in ((one, other), (other, one))):
            found.add(frozenset({one, other}))
    return found - set(map(frozenset[str], refused()))


def inside(one: str, other: str, models: set[type[BaseModel]]) -> bool:
    """Tell whether a place is that of a mapping, left out or not, in which the other one stands."""
    for model in models:
        for field, info in model.model_fields.items():
            if one.startswith(f"{model.__name__}.{field}"):
                return any(other.startswith(f"{leaf.__name__}.") for leaf in leaves(info.annotation) if leaf in models)
    return False


@pytest.mark.parametrize("kind", MOTIONS)
def test_random_motions_say_together_all_that_may_be_said_together(kind: str, tmp_path: Path) -> None:
    draw = begun(1, tmp_path)
    reader: TypeAdapter[MotionPart] = TypeAdapter(MotionChoice)
    found = [reader.validate_python(random_motion(draw, kind), strict=False) for _ in range(DRAWS)]
    seen: set[frozenset[str]] = set()
    for motion in found:
        seen |= {frozenset(pair) for pair in combinations(sorted(places_of(motion)), 2)}
    missing = sorted(" with ".join(sorted(pair)) for pair in beside(type(found[0])) - seen)
    assert not missing, f"never drawn together, {REMEDY}: {'; '.join(missing)}"


def test_any_two_shapes_and_any_two_motions_meet_in_random_scenes(drawn: list[Drawn]) -> None:
    shapes: set[frozenset[str]] = set()
    laws: set[frozenset[str]] = set()
    moved: set[tuple[str, str]] = set()
    for one in drawn:
        kinds = [(shapes_of(body), motion_of(body)) for body in one.document["bodies"].values()]
        moved |= {pair for own, motion in kinds for pair in product(own, motion)}
        for a, b in combinations([kind for kind in kinds if kind[0]], 2):
            shapes |= {frozenset(pair) for pair in product(a[0], b[0])}
            laws |= {frozenset(pair) for pair in product(a[1], b[1])}
    for there, met in ((SHAPES, shapes), (MOTIONS, laws)):
        wanted = {frozenset(pair) for pair in combinations_with_replacement(there, 2)}
        assert not wanted - met, f"never in one scene, {REMEDY}: {wanted - met}"
    never = set(product(SHAPES, MOTIONS)) - moved
    assert not never, f"never moved so, {REMEDY}: {never}"


def test_each_motion_carries_and_is_carried_in_random_scenes(drawn: list[Drawn]) -> None:
    carrying: set[str] = set()
    carried: set[str] = set()
    for one in drawn:
        bodies = one.document["bodies"]
        for body in bodies.values():
            for above in lineage(bodies, body):
                carrying |= motion_of(above) if motion_of(body) else set()
                carried |= motion_of(body) if motion_of(above) else set()
    assert carrying == carried == set(MOTIONS), REMEDY


def shapes_of(body: Mapping[str, Any]) -> set[str]:
    return {kind for shape in body.get("shapes", ()) for kind in SHAPES if kind in shape}


def motion_of(body: Mapping[str, Any]) -> set[str]:
    return {body["motion"]["type"]} if "motion" in body else set()


def lineage(bodies: Mapping[str, Any], body: Mapping[str, Any]) -> Iterator[Mapping[str, Any]]:
    """Yield what carries a body, nearest first."""
    while "parent" in body:
        body = bodies[body["parent"]]
        yield body


def test_random_scenes_have_every_kind_of_mesh_file(drawn: list[Drawn]) -> None:
    files = {Path(mesh["file"]).suffix for one in drawn for mesh in one.document.get("meshes", {}).values()}
    assert files == set(meshes._READERS), REMEDY


def test_random_scenes_have_every_column_of_a_trajectory(drawn: list[Drawn]) -> None:
    columns: set[str] = set()
    for one in drawn:
        for path in one.folder.glob("*.csv"):
            columns |= set(next(csv.reader(path.read_text(encoding="utf-8").splitlines())))
    assert columns >= set(trajectory_csv._MEANINGS), REMEDY


class Read(dict):
    """A mapping of a scene that notes which of its keys the oracle takes."""

    def __init__(self, values: Mapping[str, Any], place: str, there: set[str], read: set[str]) -> None:
        super().__init__({key: noted(value, f"{place}.{key}", there, read) for key, value in values.items()})
        self.place, self.read = place, read
        there.update(f"{place}.{key}" for key in self)

    def __getitem__(self, key: str) -> Any:
        self.read.add(f"{self.place}.{key}")
        return super().__getitem__(key)

    def get(self, key: str, default: Any = None) -> Any:
        try:
            return self[key]
        except KeyError:
            return default


def noted(value: Any, place: str, there: set[str], read: set[str]) -> Any:
    """Return a value of a scene that notes which keys are taken, by places without names of bodies and meshes."""
    if isinstance(value, Mapping) and place in (".bodies", ".meshes"):
        return {name: noted(one, f"{place}.*", there, read) for name, one in value.items()}
    if isinstance(value, Mapping):
        return Read(value, f"{value.get('type', '')}{place}", there, read)
    if isinstance(value, list):
        return [noted(one, place, there, read) for one in value]
    return value


def asked(path: Path) -> None:
    """Ask the oracle all that it can say of a scene but distances."""
    known = truth.Truth(path)
    times = np.linspace(known.start, known.end, 5)
    for name in known.names:
        known.kinematics.world_from_body(name, times)
        known.kinematics.exists(name)
    for a, b in known.pairs():
        known.margin(a, b)
    assert known.time_resolution > 0.0 < known.contact_tolerance


MERELY_TOLD = {"$schema", "closecall", "reason", "max_gap", "distance_tolerance"}
"""Keys that the oracle need not know: for the reader, for a refusal, or told again in the log."""


def test_the_oracle_reads_every_key_that_is_drawn(drawn: list[Drawn], monkeypatch: pytest.MonkeyPatch) -> None:
    there: set[str] = set()
    read: set[str] = set()
    monkeypatch.setattr(truth, "read_scene", lambda path: noted(read_scene(path), "", there, read))
    for one in covering(drawn):
        asked(written(one))
    unread = sorted(place for place in there - read if place.rsplit(".", 1)[1] not in MERELY_TOLD)
    assert not unread, f"drawn, and unknown to tests/oracle: {unread}"


def covering(drawn: list[Drawn]) -> Iterator[Drawn]:
    """Yield the scenes that take places which none before them takes."""
    seen: set[str] = set()
    for one in drawn:
        if one.places - seen:
            yield one
        seen |= one.places


def written(one: Drawn) -> Path:
    """Write a drawn scene as JSON."""
    draw = begun(0, one.folder)
    draw.rng = np.random.default_rng(2)  # of which the first chance is JSON's
    return write_document(one.document, draw)


def test_the_oracle_stops_at_words_that_it_does_not_know(drawn: list[Drawn]) -> None:
    """Else a new word would be taken for one of the old ones."""
    untried = {place for place in possible(SceneFile) if " = " in place and place.rsplit(" ", 1)[1] not in NO_WORDS}
    for one in drawn:
        for owner, key, word in list(words(one.document)) if one.places & untried else ():
            places = {place for place in one.places & untried if place.endswith(f".{key} = {word}")}
            if places:
                owner[key] = "untried"
                untried -= places if stops_at(written(one), "untried") else set()
                owner[key] = word
    assert not untried, f"taken for something else by tests/oracle: {untried}"


def stops_at(path: Path, word: str) -> bool:
    """Tell whether the oracle refuses a scene for a word in it."""
    try:
        asked(path)
    except (NotImplementedError, KeyError) as error:
        return word in str(error)
    return False


NO_WORDS = {"1", "True", "False", "none"}


def words(value: Any) -> Iterator[tuple[dict[str, Any], str, str]]:
    """Yield every text that stands at a key of a document: the mapping, its key, the text."""
    for key, inner in value.items() if isinstance(value, dict) else ():
        if isinstance(inner, str):
            yield value, key, inner
        yield from words(inner)
    for inner in value if isinstance(value, list | tuple) else ():
        yield from words(inner)
