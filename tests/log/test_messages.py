"""The messages: what they are named, how exact their times are, and that the committed Python is theirs."""

from __future__ import annotations

import re
import subprocess
import sys
from enum import Enum
from fractions import Fraction
from importlib.util import find_spec
from itertools import pairwise
from pathlib import Path

import pytest
from google.protobuf.descriptor_pb2 import FileDescriptorProto, FileDescriptorSet

from closecall.formats.log import messages_pb2 as pb
from closecall.formats.log.container.chunks import descriptor_set
from closecall.formats.log.container.clock import nanoseconds
from closecall.formats.log.messages import FactFiller
from closecall.formats.scene.loaded import KeyNames
from closecall.scheduler.model import events

FOLDER = Path(pb.__file__).parent
FACTS = (pb.Wakeup(), pb.Distance(), pb.Collision(), pb.Span())
CONTRACT = {
    "Wakeup": "reason level bound clearance sleep",
    "Distance": "distance witness_a witness_b feature_a feature_b",
    "Collision": "phase time_clear time_touching kind triangle_a triangle_b point shape_a shape_b "
    "key_before_a key_after_a key_before_b key_after_b",
    "Span": "verdict start end clearance depth_limit",
}


@pytest.mark.parametrize("message", FACTS, ids=lambda message: message.DESCRIPTOR.name)
def test_fields_are_those_of_the_contract_in_its_order(message):
    expected = ["timestamp", "pair", "pair_id", "body_a", "body_b", *CONTRACT[message.DESCRIPTOR.name].split()]
    names = [field.name for field in message.DESCRIPTOR.fields]
    assert names[: len(expected)] == expected
    assert message.DESCRIPTOR.fields_by_name["pair_id"].cpp_type == 4  # uint64
    assert message.DESCRIPTOR.fields_by_name["timestamp"].message_type.full_name == "google.protobuf.Timestamp"


@pytest.mark.parametrize(
    ("message", "field", "enum"),
    [
        (pb.Wakeup, "reason", events.Reason),
        (pb.Wakeup, "level", events.Level),
        (pb.Feature, "kind", events.FeatureKind),
        (pb.Collision, "phase", events.Phase),
        (pb.Collision, "kind", events.ContactKind),
        (pb.Span, "verdict", events.Verdict),
    ],
)
def test_enums_have_the_schedulers_bare_names_and_zero_is_unknown(message, field, enum: type[Enum]):
    described = message.DESCRIPTOR.fields_by_name[field].enum_type
    assert [value.name for value in described.values] == ["UNKNOWN", *(value.name for value in enum)]
    assert described.values_by_number[0].name == "UNKNOWN"
    assert described.full_name.startswith(f"closecall.{message.DESCRIPTOR.name}.")


def test_no_message_has_a_map():
    for message in FACTS:
        for field in message.DESCRIPTOR.fields:
            assert field.message_type is None or not field.message_type.GetOptions().map_entry


def test_every_message_and_field_is_commented():
    lines = (FOLDER / "messages.proto").read_text().splitlines()
    field = re.compile(r"\s+[\w.]+ \w+ = \d+;")
    for before, line in pairwise(lines):
        commented = before.lstrip().startswith("//")
        if line.startswith("message "):
            assert commented, line
        if field.match(line) and not re.match(r"  double [xyz] = ", line):
            assert commented, line


def test_schema_carries_its_imports_first():
    names = [file.name for file in descriptor_set(pb.Distance).file]
    assert names == ["google/protobuf/timestamp.proto", "closecall/formats/log/messages.proto"]


def test_generated_python_is_that_of_the_proto_file(tmp_path):
    if find_spec("grpc_tools") is None:
        pytest.skip("grpcio-tools is not installed")
    source = "closecall/formats/log/messages.proto"
    command = [sys.executable, "-m", "grpc_tools.protoc", f"-Iclosecall/formats/log={FOLDER}"]
    subprocess.run([*command, f"--descriptor_set_out={tmp_path / 'set'}", source], check=True)
    (compiled,) = FileDescriptorSet.FromString((tmp_path / "set").read_bytes()).file
    committed = FileDescriptorProto()
    pb.DESCRIPTOR.CopyToProto(committed)
    for file in (compiled, committed):
        _forget_json_names(file.message_type)
    assert committed == compiled


def _forget_json_names(messages):
    """Protoc writes the names of JSON fields, runtimes do not."""
    for message in messages:
        for field in message.field:
            field.ClearField("json_name")
        _forget_json_names(message.nested_type)


def test_generated_stub_names_every_field():
    stub = (FOLDER / "messages_pb2.pyi").read_text()
    for message in FACTS:
        body = stub.split(f"class {message.DESCRIPTOR.name}(")[1]
        for field in message.DESCRIPTOR.fields:
            assert re.search(rf"^    {field.name}: ", body, re.MULTILINE), field.full_name


def test_generated_python_asks_for_no_runtime_version():
    assert "runtime_version" not in (FOLDER / "messages_pb2.py").read_text()


@pytest.mark.parametrize(
    "time",
    [
        0.0,
        0.1 + 0.2,
        1e5 + 1e-9,
        1 / 1024,
        3 / 1024,
        4.9e-10,
        5.1e-10,
        86400.123456789,
        2.0**53 + 2,
        9.2e9,
        -0.25,
        -1e-9,
    ],
)
def test_nanoseconds_are_the_nearest_to_the_exact_time(time):
    assert nanoseconds(time) == round(Fraction(time) * 10**9)


def test_nanoseconds_differ_from_the_float_product_where_that_is_wrong():
    wrong = [
        time for time in (k * 1.000000001 for k in range(10**7, 10**7 + 2000)) if round(time * 1e9) != nanoseconds(time)
    ]
    assert wrong
    assert all(nanoseconds(time) == round(Fraction(time) * 10**9) for time in wrong)


def test_a_message_filled_again_keeps_nothing_of_the_last_fact():
    filler = FactFiller(("one", "other", "third"), {})
    feature = events.Feature(events.FeatureKind.FACE, 3, 4, 5)
    nothing = events.Feature(events.FeatureKind.VERTEX, 0, 0, 0)
    first = events.Distance(1.0, events.PairKey(2, 1, 2), 7.0, (1.0, 2.0, 3.0), (4.0, 5.0, 6.0), feature, feature)
    second = events.Distance(2.0, events.PairKey(0, 0, 1), 0.0, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), nothing, nothing)
    again, fresh = pb.Distance(), pb.Distance()
    filler.fill_distance(again, first)
    filler.fill_distance(again, second)
    filler.fill_distance(fresh, second)
    assert again.SerializeToString() == fresh.SerializeToString()
    assert fresh.HasField("witness_a")
    assert fresh.HasField("feature_b")


def test_a_collision_names_the_keys_around_the_touching_time_of_both_bodies():
    keys = KeyNames((0.0, 2.0), ("home", "reach"), 0.0, 4.0, before=False, after=False)
    filler = FactFiller(("one", "other", "third"), {1: keys})
    nothing = events.Feature(events.FeatureKind.VERTEX, 0, 0, 0)
    message = pb.Collision()
    told = []
    for pair, time in ((events.PairKey(0, 0, 1), 1.0), (events.PairKey(2, 1, 2), 3.0), (events.PairKey(1, 0, 2), 1.0)):
        begin = events.Collision(
            pair, events.Phase.BEGIN, time - 3.0, time, events.ContactKind.SURFACE, nothing, nothing, (0.0, 0.0, 0.0)
        )
        filler.fill_collision(message, begin)
        told.append((message.key_before_a, message.key_after_a, message.key_before_b, message.key_after_b))
    assert told == [("", "", "home", "reach"), ("reach", "", "", ""), ("", "", "", "")]
