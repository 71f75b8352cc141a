"""The tolerances and limits of the scene file, each with its unit and its consequence."""

LARGEST_DOCUMENT = 64 * 2**20
"""Bytes. A larger scene file is refused before it is parsed."""

DEEPEST_NESTING = 64
"""Mappings and lists within each other. A deeper document is refused."""

MOST_PATTERN_COMPARISONS = 20_000_000
"""Of different patterns in `pairs` with names of bodies, some 5 s. What would take more is refused."""

LARGEST_NUMBER = 1e15
"""In the file's units. Beyond it squares and products would near the end of float64."""

SMALLEST_SIZE = 1e-15
"""In the file's units. A size or a span of time below it is refused: its square or inverse would be lost."""

SMALLEST_COORDINATE = 1e-60
"""In the file's units. A mesh file's coordinates nearer to 0 are read as 0: no scale makes that more than 1e-45 m.

The squares of smaller lengths would be lost. In the scene itself no number is read as 0 that is not.
"""

SHORTEST_DIRECTION = 1e-290
"""A direction whose components are all smaller is refused: floats so near to 0 have no digits left to say where to."""

ROTATION_ROUNDING = 1e-5
"""How far a rotation may be off without a word: the length of a quaternion, or any stretch of a matrix, from 1.

Rotations written to 5 decimals are within it. The nearest one is taken.
"""

ROTATION_TOLERANCE = 1e-3
"""So far it may be off with a warning of how far that moves the body's points. Beyond, it is refused."""

LAST_ROW_TOLERANCE = 1e-6
"""How far an entry of a matrix's last row may be from 0 0 0 1."""

AMBIGUOUS_TURN = 1e-6
"""rad. Keys this near to half a turn apart are warned of: rounding decides which way round they turn."""

PARALLEL_AXES = 1e-12
"""How far the cosine between two axes may be from 1 where turns about them count as turns about one."""

WIDE_TURN = 150.0
"""deg. Keys further apart than this are warned of: a missing key would go unnoticed."""

FAN_TOLERANCE = 1e-9
"""Of a polygon's squared area: how far a triangle of a fan may turn against it before the fan does not fit."""

FLAT_TOLERANCE = 1e-5
"""Of a mesh file's largest coordinate: how far the corners of a polygon may lie off one plane without a warning.

The five or six digits that many files have explain as much.
"""

COARSE_GRID = 2e-6
"""Of a mesh file's longest side: 32-bit floats that are farther apart where it lies are warned of.

They are where it lies more than some 20 of its sizes from its own origin.
"""

PERPENDICULAR_TOLERANCE = 1e-6
"""How far the cosine between an orbit's axis and start may be from 0. Within it the rest is projected out."""

UNLIKELY_RATIO = 500.0
"""A mesh file this many times larger or smaller than the rest of its scene is warned of: its unit may be another."""

COARSE_PLACE = 1e6
"""A body farther from the origin than this many times its smallest shape is warned of: floats are coarse there."""

COARSE_TERMS = 1e8
"""A motion whose terms may add up to more than this many times the body's smallest shape is warned of.

They bound the error of measurement, and often by much: hence 100 times what is warned of as a place.
"""

FARTHEST_PLACE = 1e30
"""m. A motion whose terms may add up to more is refused: no distance could be told, and far beyond none is finite."""

MOST_ROUNDING = 1.0
"""A body that rounding may misplace in its parent by more than this many times its size is refused.

Everything within that distance would be called a contact.
"""
