"""Changes of `MadeLog`, drawn by a seed: the log stays well formed, and says what cannot be."""

from __future__ import annotations

import json
from collections.abc import Callable
from random import Random
from typing import Any

from google.protobuf.descriptor import FieldDescriptor
from google.protobuf.message import Message
from made_logs import Fact, MadeLog, sound_log
from mcap.opcode import Opcode

from closecall.formats.log.container.identity_reading import read_identity
from closecall.formats.log.result import Folding
from closecall.formats.log.summary import to_json

EVIL = "\x1b]0;owned\x07\x9b\x00\u202e\n\u2028<script>alert(1)</script>"
TEXTS = ("", "|", "a|b|c", "arm", EVIL, "=1+1", "x" * 3000, "\u0301", "\ufffe", "[red]:bomb:[/]")
FLOATS = (
    *(float("nan"), float("inf"), float("-inf"), 1e308, -1e308, 1.8e308, 1e31, 1e30, -1e30, 1e15, -1.0, -0.0, 0.0),
    *(5e-324, 1e-300, 1e9, 9.3e9, -9.3e9, 4.0, 4.000001),
)
COUNTS = (0, 1, 2, 5, 6, 7, 99, 2**31 - 1, 2**31, 2**32 - 1, 2**63 - 1, 2**63, 2**64 - 1)
VALUES = (
    *("", "0", "-5", "5", "nan", "NaN", "inf", "-Infinity", "1e308", "-1e308", "1e999", "9" * 30, str(2**63), "0x10"),
    *("[]", "{}", "null", "true", '"x"', "[1]", "[[1]]", '{"arm": null}', '{"arm": NaN}', '{"arm": [1]}', "[", "٣"),
    *('{"arm": -1}', '{"margin": null}', '{"margin": NaN}', '{"margin": -1}', '{"margin": "x"}', '{"margin": 1e308}'),
    *('[["a","b",NaN]]', '[[["a"],["b"],1]]', '[[["a"],["b"],-1]]', '[[["a"],["b"]]]', "[[[1],[2],3]]", "[" * 3000),
    *('{"arm": [1, 0]}', '{"arm": [0, 1e308]}', '{"arm": ["0", "1"]}', '{"\\ud800": 1}', EVIL, "4.0", "1e9", "1e-300"),
)
JSON_VALUES = (None, True, -1, 0, 2**70, 1e308, -1e308, 5e-324, "", "x", EVIL, "\ud800", [], {}, [1], [1, 0], {"a": 1})

Change = Callable[[MadeLog, Random], None]


def wrong_log(seed: int) -> bytes:
    """Return the log of a seed: sound, wrong in a few ways, and cut short now and then."""
    rng = Random(seed)
    log = sound_log(rng)
    if rng.random() < 0.5:
        _carry_summary(log, rng)
    for _ in range(rng.choice((0, 1, 1, 1, 1, 2, 3))):
        rng.choice(CHANGES)(log, rng)
    data = log.bytes()
    return data if rng.random() < 0.95 else data[: rng.randrange(len(data))]


def _carry_summary(log: MadeLog, rng: Random) -> None:
    assert log.start is not None
    identity = read_identity(log.start)
    folding = Folding(identity)
    for fact in log.facts():
        if fact.topic.startswith(("/spans", "/wakeups", "/distances", "/collisions")):
            folding.add(fact.message, identity.seconds(fact.log_time))
    log.attachments.append(("summary.json", "application/json", to_json(folding.found(None).summary).encode()))


def change_field(log: MadeLog, rng: Random) -> None:
    """Give a field of a message another value, another type of number, or more or fewer elements."""
    message = rng.choice(log.facts()).message
    while True:
        field = rng.choice(message.DESCRIPTOR.fields)
        inner = getattr(message, field.name)
        if hasattr(inner, "append") or hasattr(inner, "add"):
            if not inner or rng.random() < 0.2:
                _resize(inner, rng)
                return
            message = inner = rng.choice(list(inner))
        if not isinstance(inner, Message):
            break
        message = inner
    if isinstance(getattr(message, field.name, None), float | int | str | bool):
        setattr(message, field.name, _other(field.cpp_type, rng))


def _resize(values: Any, rng: Random) -> None:
    if not values or rng.random() < 0.3:
        if hasattr(values, "add"):
            values.add()
        else:
            values.append(rng.choice((0, 1, 2**32 - 1)))
    elif rng.random() < 0.5:
        del values[rng.randrange(len(values)) :]
    else:
        values.extend(list(values) * rng.choice((1, 50)))


def _other(cpp_type: int, rng: Random) -> Any:
    match cpp_type:
        case FieldDescriptor.CPPTYPE_DOUBLE | FieldDescriptor.CPPTYPE_FLOAT:
            return rng.choice(FLOATS)
        case FieldDescriptor.CPPTYPE_STRING:
            return rng.choice(TEXTS).replace("\ud800", "")
        case FieldDescriptor.CPPTYPE_ENUM:
            return rng.choice((0, 1, 2, 5, 99, 2**31 - 1, -1))
        case FieldDescriptor.CPPTYPE_BOOL:
            return True
        case FieldDescriptor.CPPTYPE_INT32:
            return rng.choice((-1, 0, 2**31 - 1))
        case FieldDescriptor.CPPTYPE_INT64:
            return rng.choice((-1, 0, 2**63 - 1))
        case FieldDescriptor.CPPTYPE_UINT32:
            return rng.choice([count for count in COUNTS if count < 2**32])
    return rng.choice(COUNTS)


def change_payload(log: MadeLog, rng: Random) -> None:
    """Let a message's bytes be others than its type's."""
    fact = rng.choice(log.facts())
    data = fact.bytes()
    other = rng.choice(log.facts()).bytes()
    fact.data = rng.choice((b"", data[:-1], data + b"\x00", other, rng.randbytes(20), data[: len(data) // 2], data * 2))


def change_time(log: MadeLog, rng: Random) -> None:
    fact = rng.choice(log.facts())
    fact.log_time = rng.choice((0, 1, 2**63 - 1, 2**63, 2**64 - 1, fact.log_time + 1, 10**18))


def change_facts(log: MadeLog, rng: Random) -> None:
    """Leave messages out, tell them twice, or in another order."""
    chunk = rng.choice(log.chunks)
    match rng.randrange(4):
        case 0:
            chunk.reverse()
        case 1 if chunk:
            del chunk[rng.randrange(len(chunk))]
        case 2 if chunk:
            chunk += [rng.choice(chunk)] * rng.choice((1, 300))
        case 3:
            topic = rng.choice(list(log.schemas))
            chunk[:] = [fact for fact in chunk if fact.topic != topic]


def change_topic(log: MadeLog, rng: Random) -> None:
    """Let a message stand under a topic that is not its own."""
    rng.choice(log.facts()).topic = rng.choice(list(log.schemas))


def change_schema(log: MadeLog, rng: Random) -> None:
    topic = rng.choice(list(log.schemas))
    name, encoding, messages = log.schemas[topic]
    others = [
        *(one[0] for one in log.schemas.values()),
        "",
        "closecall.Nothing",
        "closecall.Point",
        EVIL,
        "foxglove.Log",
    ]
    match rng.randrange(4):
        case 0 | 1:
            name = rng.choice(others)
        case 2:
            encoding = rng.choice(("", "jsonschema", EVIL))
        case 3:
            messages = rng.choice(("", "json", "ros1"))
    log.schemas[topic] = name, encoding, messages


def change_names(log: MadeLog, rng: Random) -> None:
    """Give a body the name of nobody, here and there or everywhere."""
    name, share = rng.choice(TEXTS), rng.choice((0.5, 1.0))
    for fact in log.facts():
        message = fact.message
        if hasattr(message, "pair_id") and message.body_a == "arm" and rng.random() < share:
            message.body_a, message.pair = name, f"{name}|{message.body_b}"


def change_metadata(log: MadeLog, rng: Random) -> None:
    if rng.random() < 0.15:
        log.start, log.end = rng.choice(((None, log.end), (log.start, None), (None, None), ({}, log.end), ({}, {})))
    elif log.start and log.end:
        key, records = rng.choice(list(log.start)), rng.choice(([log.start], [log.end], [log.start, log.end]))
        value = rng.choice((None, *VALUES))
        for record in records:
            record.pop(key, None)
            if value is not None:
                record[key] = value


def change_attachment(log: MadeLog, rng: Random) -> None:
    names = ("summary.json", "scene", "settings.json", "layout.json", "../../evil", "", EVIL)
    data = rng.choice((b"", b"{}", b"[]", b"null", b"\xff\xfe", b"[" * 3000, b'{"closecall": NaN}', bytes(10_000)))
    one = (rng.choice(names), rng.choice(("", EVIL, "text/html")), data)
    log.attachments.insert(rng.randrange(len(log.attachments) + 1), one)


def change_summary(log: MadeLog, rng: Random) -> None:
    """Give a value inside the summary that the log carries another one."""
    for index, (name, kind, data) in enumerate(log.attachments):
        if name == "summary.json" and len(data) > 500:
            value = json.loads(data)
            _change_json(value, rng)
            log.attachments[index] = name, kind, json.dumps(value).encode()


def _change_json(value: Any, rng: Random) -> None:
    while True:
        keys = list(value) if isinstance(value, dict) else list(range(len(value)))
        if not keys:
            return
        key = rng.choice(keys)
        if not isinstance(value[key], dict | list) or not value[key] or rng.random() < 0.15:
            break
        value = value[key]
    if rng.random() < 0.15:
        del value[key]
    else:
        value[key] = rng.choice(JSON_VALUES)


def change_chunk(log: MadeLog, rng: Random) -> None:
    """Let chunks be compressed otherwise than they say, or hold more or less."""
    match rng.randrange(7):
        case 0:
            log.chunk_changes["uncompressed_size"] = rng.choice((0, 1, 2**20, 2**29, 2**29 + 1, 2**40, 2**64 - 1))
        case 1:
            log.chunk_changes["compression"] = rng.choice(("", "zstd", "lz4", "bz2", EVIL))
        case 2:
            log.chunk_changes["uncompressed_crc"] = rng.choice((0, 1))
        case 3:
            log.chunk_changes["data"] = rng.randbytes(50)
        case 4:
            log.inner = bytes(rng.choice((1, 8, 9, 30, 2**24)))
        case 5:
            opcode, length = rng.choice((*Opcode, 0x7F, 0x80, 0xFF)), rng.choice((0, 1, 21, 22, 40, 2**31, 2**64 - 1))
            log.inner = int(opcode).to_bytes(1, "little") + length.to_bytes(8, "little") + bytes(rng.choice((0, 1, 40)))
        case 6:
            log.compression = rng.choice(("", "zstd", "lz4", "lz4 without size"))


def change_records(log: MadeLog, rng: Random) -> None:
    match rng.randrange(3):
        case 0:
            log.swapped = True
        case 1:
            opcode = int(rng.choice((*Opcode, 0x7F, 0x80, 0xFF)))
            log.extra.append((opcode, rng.randbytes(rng.choice((0, 1, 4, 12, 22, 60)))))
        case 2:
            log.extra += [(int(Opcode.MESSAGE_INDEX), b"")] * rng.choice((1, 1000))


def change_index(log: MadeLog, rng: Random) -> None:
    """Let the index at the end say what is not so."""
    places = (0, 1, 8, 9, 100, 2**31, 2**63, 2**64 - 1)
    match rng.randrange(4):
        case 0:
            log.with_index = False
        case 1:
            log.footer_changes[rng.choice(("summary_start", "summary_offset_start"))] = rng.choice(places)
        case 2 | 3:
            log.index_changes[rng.choice(("offset", "length"))] = rng.choice(places)


CHANGES: tuple[Change, ...] = (
    *(change_field,) * 8,
    *(change_metadata,) * 3,
    *(change_summary,) * 2,
    *(change_schema,) * 2,
    *(change_chunk,) * 2,
    change_payload,
    change_time,
    change_facts,
    change_topic,
    change_names,
    change_attachment,
    change_records,
    change_index,
)


def sets_nonsense(log: MadeLog, rng: Random) -> Fact:
    """Give a message a number that cannot be; return the fact."""
    numbers = {"/spans": "start", "/distances": "distance", "/wakeups": "clearance", "/collisions": "time_touching"}
    facts = [fact for fact in log.facts() if fact.topic in numbers]
    fact = rng.choice(facts)
    setattr(fact.message, numbers[fact.topic], rng.choice((float("nan"), float("inf"), -float("inf"), 1e308, -1e308)))
    return fact
