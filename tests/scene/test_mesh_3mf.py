"""3MF: all that a package builds, where it builds it, in its own unit, or the file is refused."""

from __future__ import annotations

import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from guarded import memory_limited, time_limited
from mesh_files import CORE, ITEM, MODEL_RELATION, OBJECT, TRIANGLE_MESH, model_xml, package

from closecall.formats.scene.build.meshes import MeshFolder
from closecall.formats.scene.grammar.scene import MeshReference
from closecall.formats.scene.mesh_files import threemf
from closecall.formats.scene.mesh_files.assembly import MOST_PLACEMENTS, MOST_TRIANGLES
from closecall.formats.scene.mesh_files.surface import MeshError
from closecall.formats.scene.mesh_files.threemf import read_3mf

PAIR = (
    '<object id="2"><components><component objectid="1" transform="1 0 0 0 1 0 0 0 1 10 20 30"/>'
    '<component objectid="1" transform="0 1 0 -1 0 0 0 0 1 0 0 0"/></components></object>'
)
SUB_MODEL = f'<model unit="millimeter" xmlns="{CORE}"><resources>{OBJECT}</resources><build/></model>'
OTHER_PART = (
    '<object id="5"><components><component p:path="/3D/other.model" objectid="1" '
    'transform="1 0 0 0 1 0 0 0 1 0 0 3"/></components></object>'
)


def built(resources: str = OBJECT, build: str = ITEM, **options: str) -> bytes:
    return package(model_xml(resources, build, **options))


def corners_of(data: bytes) -> list[list[list[float]]]:
    surface = read_3mf(data)
    return surface.vertices[surface.triangles].tolist()


def test_only_what_is_built_is_read() -> None:
    unbuilt = OBJECT.replace('id="1"', 'id="9"').replace('x="1"', 'x="99"')
    assert corners_of(built(OBJECT + unbuilt)) == [[[0, 0, 0], [1, 0, 0], [0, 1, 0]]]


def test_items_and_components_are_moved_and_turned() -> None:
    assert corners_of(built(OBJECT + PAIR, '<item objectid="2" transform="2 0 0 0 2 0 0 0 2 100 0 0"/>' + ITEM)) == [
        [[120, 40, 60], [122, 40, 60], [120, 42, 60]],
        [[100, 0, 0], [100, 2, 0], [98, 0, 0]],
        [[0, 0, 0], [1, 0, 0], [0, 1, 0]],
    ]


def test_objects_in_other_parts_of_the_package_are_read() -> None:
    required = model_xml(OTHER_PART, '<item objectid="5"/>', 'requiredextensions="p" unit="millimeter"')
    assert corners_of(package(required, {"3D/other.model": SUB_MODEL})) == [[[0, 0, 3], [1, 0, 3], [0, 1, 3]]]


def test_foreign_elements_and_attributes_are_passed_over() -> None:
    foreign = '<x:vertices><x:vertex x="nan"/><vertex x="nan"/></x:vertices>'
    mesh = TRIANGLE_MESH.replace("<mesh>", f"<mesh>{foreign}").replace("<vertex ", '<vertex x:weight="nan" ')
    metadata = '<basematerials id="7"><base name="red"/></basematerials>'
    assert len(corners_of(built(f'{metadata}<object id="1" pid="7">{mesh}</object>'))) == 1


@pytest.mark.parametrize(
    ("word", "unit", "metres"),
    [("millimeter", "mm", 1e-3), ("centimeter", "cm", 1e-2), ("inch", "in", 0.0254), ("foot", "ft", 0.3048)],
)
def test_the_unit_is_the_files_own_and_the_scene_must_say_the_same(
    tmp_path: Path, word: str, unit: str, metres: float
) -> None:
    (tmp_path / "t.3mf").write_bytes(built(attributes=f'unit="{word}"'))
    folder = MeshFolder(tmp_path, ())
    mesh = folder.load("part", MeshReference.model_validate({"file": "t.3mf", "units": unit})).mesh
    assert mesh.vertices[1].tolist() == [metres, 0, 0]
    with pytest.raises(MeshError, match=f"t.3mf: the file's own unit is '{unit}', the scene says 'm'$"):
        folder.load("part", MeshReference.model_validate({"file": "t.3mf", "units": "m"}))


def test_a_file_without_unit_is_in_millimetres_and_microns_fit_no_scene() -> None:
    assert read_3mf(built(attributes="")).unit == "mm"
    assert read_3mf(built(attributes='unit="meter"')).unit == "m"
    assert read_3mf(built(attributes='unit="micron"')).unit == "micron"


@pytest.mark.parametrize("method", [zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED])
def test_stored_and_deflated_parts_are_read(method: int) -> None:
    assert len(corners_of(package(method=method))) == 1


def test_what_trimesh_writes_is_read_as_it_was() -> None:
    pytest.importorskip("networkx")
    pytest.importorskip("lxml")
    box, ball = trimesh.creation.box((1, 2, 3)), trimesh.creation.icosphere(2)
    scene: Any = trimesh.Scene()
    scene.add_geometry(box, node_name="a")
    turn = trimesh.transformations.rotation_matrix(1, (1, 2, 3), (4, 5, 6))
    scene.add_geometry(ball, node_name="b", transform=turn)  # a child of `a` would be lost in its writing
    surface, expected = read_3mf(scene.export(file_type="3mf")), scene.to_geometry()
    np.testing.assert_allclose(
        np.sort(surface.vertices[surface.triangles].reshape(-1, 9), axis=0),
        np.sort(expected.vertices[expected.faces].reshape(-1, 9), axis=0),
        atol=1e-6,
    )


def relation(target: str) -> str:
    return MODEL_RELATION.replace("/3D/3dmodel.model", target)


ENTITIES = '<!DOCTYPE model [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;&a;&a;">]>\n'
LATTICE = f'<object id="1"><mesh xmlns:b="urn:b">{TRIANGLE_MESH[6:-7]}<b:beamlattice/></mesh></object>'


@pytest.mark.parametrize(
    ("data", "phrase"),
    [
        (b"", "expected a 3MF package, a ZIP archive"),
        (package()[:-30], "a ZIP archive"),
        (package().replace(b"PK\3\4", b"PK\3\5"), "cannot be unpacked"),
        (package(method=zipfile.ZIP_STORED).replace(b'x="1"', b'x="2"'), "cannot be unpacked: .*CRC"),
        (package(method=zipfile.ZIP_LZMA), "packed by a method that 3MF does not know"),
        (package(parts={"3d/3DModel.model": SUB_MODEL}), "two parts of the package have one name"),
        (package(parts={"_rels/.rels": "<Relationships/>"}), "names 0 models, expected one"),
        (package(parts={"_rels/.rels": relation("/3D/none.model")}), "no part '3D/none.model'"),
        (package("<model/>"), "'3D/3dmodel.model', line 1: expected a 3MF model, got 'model'"),
        (package(f'<model xmlns="{CORE}"/>x'), "line 1: not well-formed XML, "),
        (package(model_xml()[:-9]), "line 4: not well-formed XML, "),
        (built(prolog=ENTITIES), "line 2: expected no document type"),
        (built("<a>" * 100 + "</a>" * 100), "nested deeper than 64"),
        (built(attributes='unit="parsec"'), "expected a unit among micron, .* got 'parsec'"),
        (built(attributes='requiredextensions="p x"'), "requires the extension 'urn:other'"),
        (built(attributes='requiredextensions="slice"'), "requires the extension 'slice'"),
        (built(LATTICE), "beam lattices are not supported"),
        (built(build=""), "builds nothing"),
        (built(build='<item objectid="4"/>'), "'3D/3dmodel.model' has no object '4'"),
        (built(build="<item/>"), "has no object ''"),
        (built(OBJECT * 2), "an id of its own, got '1'"),
        (built('<object id="1"/>'), "places no triangles"),
        (built('<object id="1"><mesh/></object>'), "the mesh has no triangles"),
        (built(OBJECT.replace('v3="2"', 'v3="3"')), "line 3: a triangle refers to vertex 3, the mesh has 3"),
        (built(OBJECT.replace('v3="2"', 'v3="-1"')), "expected the index of a vertex, got '-1'"),
        (built(OBJECT.replace('v3="2"', 'v3="' + "9" * 30 + '"')), "expected the index of a vertex"),
        (built(OBJECT.replace('v3="2"', "")), "expected the index of a vertex, got ''"),
        (built(OBJECT.replace('x="1"', 'x="nan"')), "line 3: expected a finite number, got 'nan'"),
        (built(OBJECT.replace('x="1"', 'x="1e999"')), "expected a finite number"),
        (built(OBJECT.replace('x="1"', "")), "expected a finite number, got ''"),
        (built(build='<item objectid="1" transform="1 0 0"/>'), "12 numbers, got 3"),
        (built(build='<item objectid="1" transform="1 0 0 0 1 0 0 0 1 0 0 x"/>'), "finite number, got 'x'"),
        (
            built(
                OBJECT.replace('x="1"', 'x="1e200"'),
                '<item objectid="1" transform="1e200 0 0 0 1 0 0 0 1 0 0 0"/>',
            ),
            "a coordinate is not finite",
        ),
        (built('<object id="1"><components><component objectid="1"/></components></object>'), "component of itself"),
        (
            package(model_xml(OTHER_PART, '<item objectid="5"/>')),
            "no part '3D/other.model'",
        ),
        (
            package(
                model_xml(OTHER_PART, '<item objectid="5"/>'),
                {"3D/other.model": SUB_MODEL.replace("millimeter", "inch")},
            ),
            "the unit of '3D/other.model' is 'in', that of the model it belongs to 'mm'",
        ),
    ],
)  # fmt: skip
def test_bad_3mf_is_refused(data: bytes, phrase: str) -> None:
    with pytest.raises(MeshError, match=phrase) as caught:
        read_3mf(data)
    assert caught.value.line is None


def nested(depth: int, width: int, core: str = OBJECT) -> bytes:
    """Return a file whose objects each hold `width` of the one before it."""
    rows = "".join(
        f'<object id="{i}"><components>{f"<component objectid={str(i - 1)!r}/>" * width}</components></object>'
        for i in range(2, depth + 2)
    )
    return built(core + rows, f'<item objectid="{depth + 1}"/>')


def test_a_small_file_cannot_ask_for_any_number_of_triangles() -> None:
    assert len(read_3mf(nested(5, 3)).triangles) == 3**5
    for width in (10, 20):
        with pytest.raises(MeshError, match=f"expected ({MOST_TRIANGLES}|{MOST_PLACEMENTS}) at most"):
            read_3mf(nested(20, width))
    with pytest.raises(MeshError, match=f"expected {MOST_PLACEMENTS} at most"):
        read_3mf(nested(20, 10, '<object id="1"/>'))
    with pytest.raises(MeshError, match="components are nested deeper than 32"):
        read_3mf(nested(500, 1))


def test_a_small_file_cannot_unpack_to_any_size(monkeypatch: pytest.MonkeyPatch) -> None:
    data = built(OBJECT + " " * 2**23)
    assert len(data) < 2**14
    with pytest.raises(MeshError, match=f"unpack to more than {2**22 + 100 * len(data)} bytes"):
        read_3mf(data)
    monkeypatch.setattr(threemf, "LARGEST_PARTS", 2**20)
    with pytest.raises(MeshError, match="unpack to more than 1048576 bytes"):
        read_3mf(data)


COMPONENT = '<component objectid="1"/>'
ATTRIBUTES = " ".join(f"b{i}=''" for i in range(200_000))


@pytest.mark.parametrize(
    ("resources", "build", "phrase"),
    [
        ("".join(f'<object id="{i}"/>' for i in range(MOST_PLACEMENTS + 1)), ITEM, "more than 100000 objects"),
        (OBJECT, ITEM * (MOST_PLACEMENTS + 1), "more than 100000 objects, components and items"),
        (
            f'<object id="2"><components>{COMPONENT * (MOST_PLACEMENTS + 1)}</components></object>',
            ITEM,
            "more than 100000",
        ),
        ("".join(f"<x:n{i}/>" for i in range(1001)), ITEM, "elements have more than 1000 different names"),
        (f"<!-- {'x' * 2**21} -->", ITEM, "an element or a comment has more than 1048576 bytes"),
        (f"<x:a {ATTRIBUTES}/>", ITEM, "line 3: an element or a comment has more"),
    ],
    ids=["objects", "items", "components", "names", "comment", "attributes"],
)
def test_a_small_file_cannot_hold_any_number_of_things(resources: str, build: str, phrase: str) -> None:
    data = package(model_xml(resources, build), method=zipfile.ZIP_STORED)
    with memory_limited(), time_limited(), pytest.raises(MeshError, match=phrase):
        read_3mf(data)


def test_a_long_text_between_elements_is_passed_over() -> None:
    assert len(corners_of(package(model_xml(OBJECT + "\n" * 2**21), method=zipfile.ZIP_STORED))) == 1
