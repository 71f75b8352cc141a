from google.protobuf import timestamp_pb2 as _timestamp_pb2
from google.protobuf.internal import containers as _containers
from google.protobuf.internal import enum_type_wrapper as _enum_type_wrapper
from google.protobuf import descriptor as _descriptor
from google.protobuf import message as _message
from typing import ClassVar as _ClassVar, Iterable as _Iterable, Mapping as _Mapping, Optional as _Optional, Union as _Union

DESCRIPTOR: _descriptor.FileDescriptor

class Point(_message.Message):
    __slots__ = ("x", "y", "z")
    X_FIELD_NUMBER: _ClassVar[int]
    Y_FIELD_NUMBER: _ClassVar[int]
    Z_FIELD_NUMBER: _ClassVar[int]
    x: float
    y: float
    z: float
    def __init__(self, x: _Optional[float] = ..., y: _Optional[float] = ..., z: _Optional[float] = ...) -> None: ...

class Feature(_message.Message):
    __slots__ = ("kind", "triangle", "index", "shape")
    class Kind(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
        __slots__ = ()
        UNKNOWN: _ClassVar[Feature.Kind]
        VERTEX: _ClassVar[Feature.Kind]
        EDGE: _ClassVar[Feature.Kind]
        FACE: _ClassVar[Feature.Kind]
    UNKNOWN: Feature.Kind
    VERTEX: Feature.Kind
    EDGE: Feature.Kind
    FACE: Feature.Kind
    KIND_FIELD_NUMBER: _ClassVar[int]
    TRIANGLE_FIELD_NUMBER: _ClassVar[int]
    INDEX_FIELD_NUMBER: _ClassVar[int]
    SHAPE_FIELD_NUMBER: _ClassVar[int]
    kind: Feature.Kind
    triangle: int
    index: int
    shape: int
    def __init__(self, kind: _Optional[_Union[Feature.Kind, str]] = ..., triangle: _Optional[int] = ..., index: _Optional[int] = ..., shape: _Optional[int] = ...) -> None: ...

class Wakeup(_message.Message):
    __slots__ = ("timestamp", "pair", "pair_id", "body_a", "body_b", "reason", "level", "bound", "clearance", "sleep")
    class Reason(_message.Message):
        __slots__ = ()
        class Value(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
            __slots__ = ()
            UNKNOWN: _ClassVar[Wakeup.Reason.Value]
            START: _ClassVar[Wakeup.Reason.Value]
            TIME_BOUND: _ClassVar[Wakeup.Reason.Value]
            TIME_RESOLUTION: _ClassVar[Wakeup.Reason.Value]
            KNOT: _ClassVar[Wakeup.Reason.Value]
            WINDOW: _ClassVar[Wakeup.Reason.Value]
            CONTACT: _ClassVar[Wakeup.Reason.Value]
            REFINE: _ClassVar[Wakeup.Reason.Value]
            END: _ClassVar[Wakeup.Reason.Value]
            MINIMUM: _ClassVar[Wakeup.Reason.Value]
        UNKNOWN: Wakeup.Reason.Value
        START: Wakeup.Reason.Value
        TIME_BOUND: Wakeup.Reason.Value
        TIME_RESOLUTION: Wakeup.Reason.Value
        KNOT: Wakeup.Reason.Value
        WINDOW: Wakeup.Reason.Value
        CONTACT: Wakeup.Reason.Value
        REFINE: Wakeup.Reason.Value
        END: Wakeup.Reason.Value
        MINIMUM: Wakeup.Reason.Value
        def __init__(self) -> None: ...
    class Level(_message.Message):
        __slots__ = ()
        class Value(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
            __slots__ = ()
            UNKNOWN: _ClassVar[Wakeup.Level.Value]
            SPHERE: _ClassVar[Wakeup.Level.Value]
            MESH: _ClassVar[Wakeup.Level.Value]
        UNKNOWN: Wakeup.Level.Value
        SPHERE: Wakeup.Level.Value
        MESH: Wakeup.Level.Value
        def __init__(self) -> None: ...
    TIMESTAMP_FIELD_NUMBER: _ClassVar[int]
    PAIR_FIELD_NUMBER: _ClassVar[int]
    PAIR_ID_FIELD_NUMBER: _ClassVar[int]
    BODY_A_FIELD_NUMBER: _ClassVar[int]
    BODY_B_FIELD_NUMBER: _ClassVar[int]
    REASON_FIELD_NUMBER: _ClassVar[int]
    LEVEL_FIELD_NUMBER: _ClassVar[int]
    BOUND_FIELD_NUMBER: _ClassVar[int]
    CLEARANCE_FIELD_NUMBER: _ClassVar[int]
    SLEEP_FIELD_NUMBER: _ClassVar[int]
    timestamp: _timestamp_pb2.Timestamp
    pair: str
    pair_id: int
    body_a: str
    body_b: str
    reason: Wakeup.Reason.Value
    level: Wakeup.Level.Value
    bound: str
    clearance: float
    sleep: float
    def __init__(self, timestamp: _Optional[_Union[_timestamp_pb2.Timestamp, _Mapping[str, object]]] = ..., pair: _Optional[str] = ..., pair_id: _Optional[int] = ..., body_a: _Optional[str] = ..., body_b: _Optional[str] = ..., reason: _Optional[_Union[Wakeup.Reason.Value, str]] = ..., level: _Optional[_Union[Wakeup.Level.Value, str]] = ..., bound: _Optional[str] = ..., clearance: _Optional[float] = ..., sleep: _Optional[float] = ...) -> None: ...

class Distance(_message.Message):
    __slots__ = ("timestamp", "pair", "pair_id", "body_a", "body_b", "distance", "witness_a", "witness_b", "feature_a", "feature_b", "excess")
    TIMESTAMP_FIELD_NUMBER: _ClassVar[int]
    PAIR_FIELD_NUMBER: _ClassVar[int]
    PAIR_ID_FIELD_NUMBER: _ClassVar[int]
    BODY_A_FIELD_NUMBER: _ClassVar[int]
    BODY_B_FIELD_NUMBER: _ClassVar[int]
    DISTANCE_FIELD_NUMBER: _ClassVar[int]
    WITNESS_A_FIELD_NUMBER: _ClassVar[int]
    WITNESS_B_FIELD_NUMBER: _ClassVar[int]
    FEATURE_A_FIELD_NUMBER: _ClassVar[int]
    FEATURE_B_FIELD_NUMBER: _ClassVar[int]
    EXCESS_FIELD_NUMBER: _ClassVar[int]
    timestamp: _timestamp_pb2.Timestamp
    pair: str
    pair_id: int
    body_a: str
    body_b: str
    distance: float
    witness_a: Point
    witness_b: Point
    feature_a: Feature
    feature_b: Feature
    excess: float
    def __init__(self, timestamp: _Optional[_Union[_timestamp_pb2.Timestamp, _Mapping[str, object]]] = ..., pair: _Optional[str] = ..., pair_id: _Optional[int] = ..., body_a: _Optional[str] = ..., body_b: _Optional[str] = ..., distance: _Optional[float] = ..., witness_a: _Optional[_Union[Point, _Mapping[str, object]]] = ..., witness_b: _Optional[_Union[Point, _Mapping[str, object]]] = ..., feature_a: _Optional[_Union[Feature, _Mapping[str, object]]] = ..., feature_b: _Optional[_Union[Feature, _Mapping[str, object]]] = ..., excess: _Optional[float] = ...) -> None: ...

class Collision(_message.Message):
    __slots__ = ("timestamp", "pair", "pair_id", "body_a", "body_b", "phase", "time_clear", "time_touching", "kind", "triangle_a", "triangle_b", "point", "shape_a", "shape_b", "key_before_a", "key_after_a", "key_before_b", "key_after_b")
    class Phase(_message.Message):
        __slots__ = ()
        class Value(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
            __slots__ = ()
            UNKNOWN: _ClassVar[Collision.Phase.Value]
            BEGIN: _ClassVar[Collision.Phase.Value]
            END: _ClassVar[Collision.Phase.Value]
        UNKNOWN: Collision.Phase.Value
        BEGIN: Collision.Phase.Value
        END: Collision.Phase.Value
        def __init__(self) -> None: ...
    class Kind(_message.Message):
        __slots__ = ()
        class Value(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
            __slots__ = ()
            UNKNOWN: _ClassVar[Collision.Kind.Value]
            SURFACE: _ClassVar[Collision.Kind.Value]
            CONTAINED: _ClassVar[Collision.Kind.Value]
        UNKNOWN: Collision.Kind.Value
        SURFACE: Collision.Kind.Value
        CONTAINED: Collision.Kind.Value
        def __init__(self) -> None: ...
    TIMESTAMP_FIELD_NUMBER: _ClassVar[int]
    PAIR_FIELD_NUMBER: _ClassVar[int]
    PAIR_ID_FIELD_NUMBER: _ClassVar[int]
    BODY_A_FIELD_NUMBER: _ClassVar[int]
    BODY_B_FIELD_NUMBER: _ClassVar[int]
    PHASE_FIELD_NUMBER: _ClassVar[int]
    TIME_CLEAR_FIELD_NUMBER: _ClassVar[int]
    TIME_TOUCHING_FIELD_NUMBER: _ClassVar[int]
    KIND_FIELD_NUMBER: _ClassVar[int]
    TRIANGLE_A_FIELD_NUMBER: _ClassVar[int]
    TRIANGLE_B_FIELD_NUMBER: _ClassVar[int]
    POINT_FIELD_NUMBER: _ClassVar[int]
    SHAPE_A_FIELD_NUMBER: _ClassVar[int]
    SHAPE_B_FIELD_NUMBER: _ClassVar[int]
    KEY_BEFORE_A_FIELD_NUMBER: _ClassVar[int]
    KEY_AFTER_A_FIELD_NUMBER: _ClassVar[int]
    KEY_BEFORE_B_FIELD_NUMBER: _ClassVar[int]
    KEY_AFTER_B_FIELD_NUMBER: _ClassVar[int]
    timestamp: _timestamp_pb2.Timestamp
    pair: str
    pair_id: int
    body_a: str
    body_b: str
    phase: Collision.Phase.Value
    time_clear: float
    time_touching: float
    kind: Collision.Kind.Value
    triangle_a: int
    triangle_b: int
    point: Point
    shape_a: int
    shape_b: int
    key_before_a: str
    key_after_a: str
    key_before_b: str
    key_after_b: str
    def __init__(self, timestamp: _Optional[_Union[_timestamp_pb2.Timestamp, _Mapping[str, object]]] = ..., pair: _Optional[str] = ..., pair_id: _Optional[int] = ..., body_a: _Optional[str] = ..., body_b: _Optional[str] = ..., phase: _Optional[_Union[Collision.Phase.Value, str]] = ..., time_clear: _Optional[float] = ..., time_touching: _Optional[float] = ..., kind: _Optional[_Union[Collision.Kind.Value, str]] = ..., triangle_a: _Optional[int] = ..., triangle_b: _Optional[int] = ..., point: _Optional[_Union[Point, _Mapping[str, object]]] = ..., shape_a: _Optional[int] = ..., shape_b: _Optional[int] = ..., key_before_a: _Optional[str] = ..., key_after_a: _Optional[str] = ..., key_before_b: _Optional[str] = ..., key_after_b: _Optional[str] = ...) -> None: ...

class Span(_message.Message):
    __slots__ = ("timestamp", "pair", "pair_id", "body_a", "body_b", "verdict", "start", "end", "clearance", "depth_limit", "error")
    class Verdict(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
        __slots__ = ()
        UNKNOWN: _ClassVar[Span.Verdict]
        CLEAR: _ClassVar[Span.Verdict]
        BREACH: _ClassVar[Span.Verdict]
        CONTACT: _ClassVar[Span.Verdict]
        UNRESOLVED: _ClassVar[Span.Verdict]
        POSSIBLE: _ClassVar[Span.Verdict]
    UNKNOWN: Span.Verdict
    CLEAR: Span.Verdict
    BREACH: Span.Verdict
    CONTACT: Span.Verdict
    UNRESOLVED: Span.Verdict
    POSSIBLE: Span.Verdict
    TIMESTAMP_FIELD_NUMBER: _ClassVar[int]
    PAIR_FIELD_NUMBER: _ClassVar[int]
    PAIR_ID_FIELD_NUMBER: _ClassVar[int]
    BODY_A_FIELD_NUMBER: _ClassVar[int]
    BODY_B_FIELD_NUMBER: _ClassVar[int]
    VERDICT_FIELD_NUMBER: _ClassVar[int]
    START_FIELD_NUMBER: _ClassVar[int]
    END_FIELD_NUMBER: _ClassVar[int]
    CLEARANCE_FIELD_NUMBER: _ClassVar[int]
    DEPTH_LIMIT_FIELD_NUMBER: _ClassVar[int]
    ERROR_FIELD_NUMBER: _ClassVar[int]
    timestamp: _timestamp_pb2.Timestamp
    pair: str
    pair_id: int
    body_a: str
    body_b: str
    verdict: Span.Verdict
    start: float
    end: float
    clearance: float
    depth_limit: float
    error: float
    def __init__(self, timestamp: _Optional[_Union[_timestamp_pb2.Timestamp, _Mapping[str, object]]] = ..., pair: _Optional[str] = ..., pair_id: _Optional[int] = ..., body_a: _Optional[str] = ..., body_b: _Optional[str] = ..., verdict: _Optional[_Union[Span.Verdict, str]] = ..., start: _Optional[float] = ..., end: _Optional[float] = ..., clearance: _Optional[float] = ..., depth_limit: _Optional[float] = ..., error: _Optional[float] = ...) -> None: ...

class Window(_message.Message):
    __slots__ = ("timestamp", "body", "start", "end", "box_min", "box_max")
    TIMESTAMP_FIELD_NUMBER: _ClassVar[int]
    BODY_FIELD_NUMBER: _ClassVar[int]
    START_FIELD_NUMBER: _ClassVar[int]
    END_FIELD_NUMBER: _ClassVar[int]
    BOX_MIN_FIELD_NUMBER: _ClassVar[int]
    BOX_MAX_FIELD_NUMBER: _ClassVar[int]
    timestamp: _timestamp_pb2.Timestamp
    body: str
    start: float
    end: float
    box_min: Point
    box_max: Point
    def __init__(self, timestamp: _Optional[_Union[_timestamp_pb2.Timestamp, _Mapping[str, object]]] = ..., body: _Optional[str] = ..., start: _Optional[float] = ..., end: _Optional[float] = ..., box_min: _Optional[_Union[Point, _Mapping[str, object]]] = ..., box_max: _Optional[_Union[Point, _Mapping[str, object]]] = ...) -> None: ...

class World(_message.Message):
    __slots__ = ("timestamp", "min_distance", "pair", "contacts", "pairs")
    class Pair(_message.Message):
        __slots__ = ("pair", "distance", "verdict")
        PAIR_FIELD_NUMBER: _ClassVar[int]
        DISTANCE_FIELD_NUMBER: _ClassVar[int]
        VERDICT_FIELD_NUMBER: _ClassVar[int]
        pair: str
        distance: float
        verdict: str
        def __init__(self, pair: _Optional[str] = ..., distance: _Optional[float] = ..., verdict: _Optional[str] = ...) -> None: ...
    TIMESTAMP_FIELD_NUMBER: _ClassVar[int]
    MIN_DISTANCE_FIELD_NUMBER: _ClassVar[int]
    PAIR_FIELD_NUMBER: _ClassVar[int]
    CONTACTS_FIELD_NUMBER: _ClassVar[int]
    PAIRS_FIELD_NUMBER: _ClassVar[int]
    timestamp: _timestamp_pb2.Timestamp
    min_distance: float
    pair: str
    contacts: int
    pairs: _containers.RepeatedCompositeFieldContainer[World.Pair]
    def __init__(self, timestamp: _Optional[_Union[_timestamp_pb2.Timestamp, _Mapping[str, object]]] = ..., min_distance: _Optional[float] = ..., pair: _Optional[str] = ..., contacts: _Optional[int] = ..., pairs: _Optional[_Iterable[_Union[World.Pair, _Mapping[str, object]]]] = ...) -> None: ...
