"""A scene file's text becomes plain values, each with its line and column, or one located fault."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
import yaml

from closecall.formats.scene.limits import DEEPEST_NESTING, LARGEST_DOCUMENT
from closecall.formats.scene.text.document import Document
from closecall.formats.scene.text.errors import SceneError
from closecall.formats.scene.text.source import read_bytes, read_document
from closecall.formats.scene.text.yaml_document import read_yaml

LOADERS = [getattr(yaml, "CSafeLoader", yaml.SafeLoader), yaml.SafeLoader]


def in_yaml(text: str | bytes) -> Document:
    return read_document(text if isinstance(text, bytes) else text.encode(), "s.yaml")


def in_json(text: str) -> Document:
    return read_document(text.encode(), "s.json")


def fault(text: str | bytes, name: str = "s.yaml") -> str:
    with pytest.raises(SceneError) as caught:
        read_document(text if isinstance(text, bytes) else text.encode(), name)
    assert len(caught.value.faults) == 1
    assert "\n" not in str(caught.value)
    return str(caught.value)


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1e-3", 0.001),
        ("1E3", 1000.0),
        ("+12", 12),
        ("-0.5", -0.5),
        (".5", 0.5),
        ("5.", 5.0),
        ("007", 7),
        ("0o17", 15),
        ("0x1F", 31),
        ("true", True),
        ("False", False),
        ("on", "on"),
        ("yes", "yes"),
        ("No", "No"),
        ("1_000", "1_000"),
        ("12:30", "12:30"),
        ("2024-01-01", "2024-01-01"),
        ("0b11", "0b11"),
        ("-0o7", "-0o7"),
        ("'1'", "1"),
        ('"true"', "true"),
        ("tRUE", "tRUE"),
        ("<<", "<<"),
        ("=", "="),
        ("1e", "1e"),
        ("٣", "٣"),
    ],
)
def test_plain_scalars_follow_the_core_schema_of_yaml_1_2(text: str, value: object) -> None:
    read = in_yaml(f"a: {text}").value
    assert read == {"a": value}
    assert isinstance(read, dict)
    assert type(read["a"]) is type(value)


@pytest.mark.parametrize("text", [".inf", "-.INF", "+.Inf", ".nan", ".NaN", "1e400", "-1e400", "9" * 400, "9" * 5000])
def test_numbers_that_are_not_finite_are_refused_where_they_stand(text: str) -> None:
    assert fault(f"a:\n  - {text}").startswith("s.yaml:2:5: a[0]: expected a finite number")


@pytest.mark.parametrize("text", ["NaN", "Infinity", "-Infinity", "1e400", "9" * 5000])
def test_json_numbers_that_are_not_finite_are_refused_where_they_stand(text: str) -> None:
    assert fault(f'{{"a":\n [{text}]}}', "s.json").startswith("s.json:2:3: a[0]: expected a finite number")


def test_lists_are_tuples_and_keys_are_the_text_that_is_written() -> None:
    assert in_yaml("1: [a, {on: 2}]\n0x10: []\n").value == {"1": ("a", {"on": 2}), "0x10": ()}


def test_every_value_and_key_knows_its_line_and_column() -> None:
    document = in_yaml("# c\na:\n  b: [1,\n    {c: é, d: 2}]\n")
    assert document.keys == {
        ("a",): (2, 1),
        ("a", "b"): (3, 3),
        ("a", "b", 1, "c"): (4, 6),
        ("a", "b", 1, "d"): (4, 12),
    }
    assert document.values[("a", "b")] == (3, 6)
    assert document.values[("a", "b", 0)] == (3, 7)
    assert document.values[("a", "b", 1)] == (4, 5)
    assert document.values[("a", "b", 1, "d")] == (4, 15)


def test_json_positions_count_characters_and_lines() -> None:
    document = in_json('{\n\t"é": [1,\r\n   {"c": "x"}]\n}')
    assert document.keys == {("é",): (2, 2), ("é", 1, "c"): (3, 5)}
    assert document.values[("é",)] == (2, 7)
    assert document.values[("é", 0)] == (2, 8)
    assert document.values[("é", 1, "c")] == (3, 10)


@pytest.mark.parametrize("loader", LOADERS, ids=["libyaml", "pure"])
def test_libyaml_and_the_pure_parser_tell_the_same(loader: object) -> None:
    text = 'a: [1, "x\\/y", {b: 1e-3}]\nc:\n  - d\n  - |\n    e\n'
    document = read_yaml(text, "s.yaml", loader)
    assert document.value == {"a": (1, "x/y", {"b": 0.001}), "c": ("d", "e\n")}
    assert document.values[("c", 1)] == (4, 5)
    with pytest.raises(SceneError, match=r"^s.yaml:2:1: a: the key 'a' appears twice"):
        read_yaml("a: 1\na: 2\n", "s.yaml", loader)
    with pytest.raises(SceneError, match=r"^s.yaml:2:1: a\[1\]: not valid YAML"):
        read_yaml("a: [1\n", "s.yaml", loader)


@pytest.mark.parametrize(
    ("text", "begin", "phrase"),
    [
        ("a: 1\nb: 2\na: 3\n", "s.yaml:3:1: a: ", "appears twice"),
        ("x: {a: 1, a: 2}", "s.yaml:1:11: x.a: ", "appears twice"),
        ("a: &n 1\n", "s.yaml:1:4: a: ", "the anchor '&n' is not allowed"),
        ("a: *n\n", "s.yaml:1:4: a: ", "the alias '*n' is not allowed"),
        ("a: !!str 1\n", "s.yaml:1:4: a: ", "the tag 'tag:yaml.org,2002:str' is not allowed"),
        ("a: !x [1]\n", "s.yaml:1:4: a: ", "the tag '!x' is not allowed"),
        ("a: 1\n---\nb: 2\n", "s.yaml:2:1: scene: ", "second document"),
        ("[1]: 2\n", "s.yaml:1:1: scene: ", "a key must be text"),
        ("a:\nb: 1\n", "s.yaml:1:3: a: ", "nothing is written here"),
        ("a: [1, ~]\n", "s.yaml:1:8: a[1]: ", "nothing is written here"),
        ("", "s.yaml:1:1: scene: ", "the file is empty"),
        ("# nothing\n", "s.yaml:1:1: scene: ", "the file is empty"),
        ("---\n", "s.yaml:2:1: scene: ", "the file is empty"),
        ("a: b\0c", "s.yaml:1:5: scene: ", "U+0000 is not allowed"),
        ("a: 1\nb: \x1b[0m", "s.yaml:2:4: scene: ", "U+001B is not allowed"),
        ('a: "x\n', "s.yaml:2:1: a: ", "not valid YAML"),
        ("a: 1\n\tb: 2\n", "s.yaml:2:1: a: ", ": it is a tab, indent with spaces"),
        ("a: @b\n", "s.yaml:1:4: a: ", ": put text that begins with this character in quotes"),
        ("a:b\nc: 1\n", "s.yaml:2:2: scene: ", ": is a space missing after a colon, or are quotes around text with"),
        ("a:\n  b: 1\n c: 1\n", "s.yaml:3:2: ", ": is the line indented as those above?"),
        (b"a: 1\nb: \xc3\xa9\xff", "s.yaml:2:5: scene: ", "the byte 0xFF is not UTF-8"),
        ("a: 1".encode("utf-16"), "s.yaml:1:1: scene: ", "the file is UTF-16 text, expected YAML or JSON in UTF-8"),
    ],
)
def test_what_yaml_may_not_hold_is_refused_where_it_stands(text: str | bytes, begin: str, phrase: str) -> None:
    line = fault(text)
    assert line.startswith(begin)
    assert phrase in line


@pytest.mark.parametrize(
    ("text", "begin", "phrase"),
    [
        ('{"a": 1,\n"a": 2}', "s.json:2:1: a: ", "appears twice"),
        ('{"a": null}', "s.json:1:7: a: ", "nothing is written here"),
        ("", "s.json:1:1: scene: ", "the file is empty"),
        (" \n", "s.json:1:1: scene: ", "the file is empty"),
        ('{"a": 1', "s.json:1:8: scene: ", "expected ',' or '}'"),
        ('{"a": [1,]}', "s.json:1:10: a[1]: ", "expecting value"),
        ('{"a": 1,}', "s.json:1:9: scene: ", "expected a key in double quotes"),
        ("{a: 1}", "s.json:1:2: scene: ", "expected a key in double quotes"),
        ('{"a" 1}', "s.json:1:6: scene: ", "expected ':'"),
        ('{"a": 01}', "s.json:1:8: scene: ", "expected ','"),
        ('{"a": 1} 2', "s.json:1:10: scene: ", "more text follows"),
        ('{"a": "\\ud83d"}', "s.json:1:7: a: ", "surrogate"),
        ('{"a": "x\ny"}', "s.json:1:9: a: ", "invalid control character"),
        ("closecall: 1", "s.json:1:1: scene: ", "not valid JSON"),
    ],
)
def test_what_json_may_not_hold_is_refused_where_it_stands(text: str, begin: str, phrase: str) -> None:
    line = fault(text, "s.json")
    assert line.startswith(begin)
    assert phrase in line


@pytest.mark.parametrize(
    "text",
    [
        '{"a":1,"b":[true,false,-0.5e+2]}',
        '{"a":\t1,\n\t"b": 2}',
        '{"a": "x\\/y\\u00e9\\n"}',
        '{"a": "\\ud83d\\ude00"}',
        '{"' + "k" * 5000 + '": 1}',
        '{"a"\n:\n1}',
        '{"a": "\x7f\ufffe"}',
        "[]",
        '"text"',
    ],
)
def test_all_json_is_read_as_python_reads_it(text: str) -> None:
    def tuples(value: object) -> object:
        if isinstance(value, dict):
            return {key: tuples(inner) for key, inner in value.items()}
        return tuple(map(tuples, value)) if isinstance(value, list) else value

    assert in_json(text).value == tuples(json.loads(text))


@pytest.mark.parametrize("name", ["s.yaml", "s.json"])
def test_nesting_is_read_to_its_limit_and_refused_beyond(name: str) -> None:
    deep = "[" * DEEPEST_NESTING + "]" * DEEPEST_NESTING
    read_document(deep.encode(), name)
    assert "nested more than 64 deep" in fault(f"[{deep}]", name)
    assert "nested more than 64 deep" in fault("[" * 100_000, name)


@pytest.mark.parametrize(("name", "text"), [("s.yaml", "a: 1"), ("s.json", '{"a": 1}')])
def test_a_byte_order_mark_is_skipped_and_counts_for_no_column(name: str, text: str) -> None:
    document = read_document(b"\xef\xbb\xbf" + text.encode(), name)
    assert document.value == {"a": 1}
    assert document.key_position(("a",)) == ((1, 1) if name == "s.yaml" else (1, 2))


def test_a_file_that_cannot_be_read_is_a_fault(tmp_path: Path) -> None:
    for path, reason in [
        (tmp_path / "none.yaml", "No such file"),
        (tmp_path, "directory"),
        (Path("a\0b"), "null"),
    ]:
        with pytest.raises(SceneError, match=rf":1:1: scene: the file cannot be read: .*{reason}"):
            read_bytes(path, LARGEST_DOCUMENT)


def test_a_document_over_the_limit_is_refused_unread(tmp_path: Path) -> None:
    path = tmp_path / "big.yaml"
    with path.open("wb") as file:
        file.truncate(LARGEST_DOCUMENT + 1)
    expected = r"larger than 67108864 bytes, split it or allow more with --max-bytes"
    with pytest.raises(SceneError, match=rf":1:1: scene: the file is {expected}"):
        read_bytes(path, LARGEST_DOCUMENT)


def test_a_document_of_just_the_limit_is_read(tmp_path: Path) -> None:
    path = tmp_path / "s.yaml"
    path.write_bytes(b"a: 1")
    assert read_bytes(path, 4) == b"a: 1"
    with pytest.raises(SceneError, match="larger than 3 bytes"):
        read_bytes(path, 3)
