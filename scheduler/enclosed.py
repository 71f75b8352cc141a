"""The inside of a mesh: the solids that its skins bound, and which skins are cavities.

The rule and its derivation: `docs/guarantees.md`, "What is inside a mesh".
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .distinct import distinct_points
from .lines import Surroundings
from .meeting import embedded_stars, meet_again, meeting_points, near_each_other
from .rotation import FloatArray
from .scene import IntArray, Solid
from .skins import Skin, edges_of, sides_of, skins_of, twins_of
from .winding import winding_numbers

#: Skins of more triangles in all than this are not searched for crossings before a point's place depends on it.
MOST_SEARCHED = 300_000
#: Places where a skin meets itself, from all over it, that are examined at most.
MOST_PLACES = 300
#: Pairs of triangles whose boxes meet that are examined at most.
MOST_PAIRS = 4_000_000
#: Corners of a skin, from all over it, that decide whether it lies inside another.
MOST_CORNERS = 64
#: How far from such a place, in lengths of the smaller triangle, what lies around it is looked at.
NEAR = (0.2, 1e-2, 1e-4)
#: How near it is looked at too, only to tell whether a skin crosses itself there or touches: it may do so by a hair.
NEARER = (1e-6, 1e-8, 1e-10, 1e-12)


class UndecidedError(Exception):
    """No rule decides what is inside a mesh.

    Attributes:
        problem, remedy: in words.
        triangles: two of the mesh, by index, where it shows.
    """

    def __init__(self, problem: str, triangles: tuple[int, int], remedy: str) -> None:
        super().__init__(problem)
        self.problem, self.triangles, self.remedy = problem, triangles, remedy


@dataclass(frozen=True, slots=True)
class Doubt:
    """A solid that may have been meant otherwise: why, in words, and two triangles where it shows."""

    problem: str
    triangles: tuple[int, int]


@dataclass(frozen=True, slots=True)
class Enclosed:
    """The inside of a mesh: its solids, the largest first, and what is doubtful about them."""

    solids: tuple[Solid, ...]
    doubts: tuple[Doubt, ...]


def enclosed_by(vertices: FloatArray, triangles: IntArray) -> Enclosed:
    """Return what a mesh of vertices (n, 3) m and triangles (m, 3) encloses.

    Raises:
        UndecidedError: no rule can tell.
    """
    firsts, merged = distinct_points(vertices)
    places = merged[triangles]
    points = vertices[firsts]
    a, b, c = places.T
    kept = np.flatnonzero((a != b) & (b != c) & (c != a))
    if not len(kept):
        return Enclosed((), ())
    edges = edges_of(points, places[kept])
    sides = sides_of(edges, len(kept))
    loose = np.zeros(2 * len(kept), dtype=bool)
    loose[sides[edges.triangles[edges.starts[edges.counts == 1]]]] = True
    one_sided = np.flatnonzero((sides[:, 0] == sides[:, 1]) & ~loose[sides[:, 0]])
    if len(one_sided):
        _refuse_one_sided(places, kept, int(one_sided[0]))
    twins = twins_of(places[kept])
    skins = skins_of(points, places, kept, twins, sides)
    bounding = np.zeros(len(places), dtype=bool)
    for skin in skins:
        bounding[skin.sources] = True
    lost = kept[(sides[:, 0] != sides[:, 1]) & (twins < 0) & ~bounding[kept]]
    if len(lost):
        raise UndecidedError(
            "is closed but bounds nothing: it lies on another surface",
            (int(lost[0]), _neighbour(places, kept, int(lost[0]))),
            "remove one of the surfaces that lie on each other, or part them",
        )
    skins = [skin for skin in skins if not (skin.flat and _holds_nothing(points, skin))]
    return _Rule(points, skins).enclosed(firsts) if skins else Enclosed((), ())


def _holds_nothing(points: FloatArray, skin: Skin) -> bool:
    """Tell whether a skin has no room inside: it winds around no point beside its triangles."""
    corners = points[skin.triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(normals, axis=1)
    wide = lengths > 0.0
    steps = (NEAR[-1] / np.sqrt(lengths[wide]))[:, None] * normals[wide]
    middles = corners[wide].mean(axis=1)
    return not np.nan_to_num(Surroundings(corners).windings(np.concatenate((middles + steps, middles - steps)))).any()


def _refuse_one_sided(places: IntArray, kept: IntArray, first: int) -> None:
    source = int(kept[first])
    raise UndecidedError(
        "is closed but has no inside and outside: its front goes over into its back, as a Moebius strip's",
        (source, _neighbour(places, kept, source)),
        "cut the surface apart where it crosses itself",
    )


def _neighbour(places: IntArray, kept: IntArray, source: int) -> int:
    """Return another triangle with two of a triangle's corners."""
    shared = np.isin(places[kept], places[source]).sum(axis=1)
    others = kept[(shared >= 2) & (kept != source)]
    return int(others[0]) if len(others) else source


class _Rule:
    """The rule, applied to the skins of one mesh."""

    def __init__(self, points: FloatArray, skins: list[Skin]) -> None:
        """Take distinct points (n, 3) m, and the skins over them, the largest first."""
        self._points = points
        self._skins = skins
        self._surroundings: dict[int, Surroundings] = {}
        self._self_meetings: dict[int, IntArray] = {}
        self._meetings: dict[tuple[int, int], tuple[int, int]] = {}
        self._doubts: list[Doubt] = []

    def enclosed(self, firsts: IntArray) -> Enclosed:
        """Return the solids, over vertices that the points are the `firsts` of."""
        skins = self._skins
        searched = sum(len(skin.triangles) for skin in skins) <= MOST_SEARCHED
        opposed = {1, -1} <= {skin.winding for skin in skins}
        if searched or opposed:
            searched &= self._find_meetings(opposed)
        crossed = [self._crossed(index) if searched else None for index in range(len(skins))]
        solid = self._hosts()
        self._check_opposed(set(solid))
        found = tuple(
            Solid(
                firsts[skins[host].triangles],
                tuple(firsts[skins[cavity].triangles] for cavity in cavities),
                crossed[host],
            )
            for host, cavities in solid.items()
        )
        return Enclosed(found, tuple(self._doubts))

    def _around(self, skin: int) -> Surroundings:
        if skin not in self._surroundings:
            self._surroundings[skin] = Surroundings(self._points[self._skins[skin].triangles])
        return self._surroundings[skin]

    def _find_meetings(self, opposed: bool) -> bool:
        """Find where skins meet themselves, and where those wound opposite ways meet each other.

        Return whether all places are found: of too many triangles across each other none are, unless `opposed`.
        """
        skins = self._skins
        triangles = np.concatenate([skin.triangles for skin in skins])
        sources = np.concatenate([skin.sources for skin in skins])
        owners = np.repeat(np.arange(len(skins)), [len(skin.triangles) for skin in skins])
        windings = np.array([skin.winding for skin in skins])
        corners = self._points[triangles]
        stars = embedded_stars(corners, owners[:, None] * len(self._points) + triangles)
        self._triangles, self._sources = triangles, sources
        looked, found = 0, [np.empty((0, 2), dtype=np.int64)]
        for i, j in near_each_other(corners):
            looked += len(i)
            if looked > MOST_PAIRS:
                if opposed:
                    self._refuse_tangle(i, j)
                return False
            same = owners[i] == owners[j]
            taken = same | (windings[owners[i]] * windings[owners[j]] < 0)
            i, j, same = i[taken], j[taken], same[taken]
            meet = meet_again(self._points, triangles[i], triangles[j], same[:, None] & stars[i])
            meet |= ~same & (triangles[i][:, :, None] == triangles[j][:, None, :]).any(axis=(1, 2))
            found.append(np.column_stack((i, j))[meet])
        pairs = np.concatenate(found)
        pairs = pairs[np.lexsort(pairs.T[::-1])]
        low, high = np.sort(owners[pairs], axis=1).T
        alone, first = np.unique(low * len(skins) + high, return_index=True)
        for key, place in zip(alone.tolist(), first.tolist(), strict=True):
            one, other = divmod(key, len(skins))
            if one == other:
                self._self_meetings[one] = pairs[(low == one) & (high == one)]
            else:
                self._meetings[one, other] = (int(sources[pairs[place, 0]]), int(sources[pairs[place, 1]]))
        return True

    def _refuse_tangle(self, i: IntArray, j: IntArray) -> None:
        raise UndecidedError(
            "has parts wound opposite ways, and too many triangles across each other to tell cavities by",
            (int(self._sources[i[0]]), int(self._sources[j[0]])),
            "make files of its parts, or let all be wound alike",
        )

    def _crossed(self, index: int) -> bool:
        """Tell whether a skin crosses itself, and refuse one that encloses a space that its winding leaves open."""
        if index not in self._self_meetings:
            return False
        meetings = self._self_meetings[index]
        pairs = meetings[np.unique(np.linspace(0, len(meetings) - 1, MOST_PLACES).astype(np.int64))]
        samples = self._samples(pairs)
        around = self._around(index)
        windings = around.windings(samples.reshape(-1, 3)).reshape(len(pairs), -1)
        around_it = windings[:, : samples.shape[1] * len(NEAR) // len(NEAR + NEARER)]
        both = np.flatnonzero((around_it < 0.0).any(axis=1))
        if len(both):
            self._refuse_crossing(pairs[both[0]], "spaces that it winds around both ways")
        if not ((windings > 1.0) | (windings < 0.0)).any():
            unknown = np.isnan(around_it).all(axis=1).any()
            return bool(unknown) or len(pairs) < len(meetings)  # where it only touches itself it is as if it did not
        place, which = np.nonzero(around_it == 0.0)
        closed = place[~around.open(samples[place, which])]
        if len(closed):
            self._refuse_crossing(pairs[closed[0]], "a space that it winds around not at all")
        return True

    def _samples(self, pairs: IntArray) -> FloatArray:
        """Return points (k, samples, 3) m around where pairs of triangles meet: at `NEAR`, then at `NEARER`."""
        one, other = (self._points[self._triangles[pairs[:, k]]] for k in range(2))
        middles = meeting_points(one, other)
        normals = []
        for corners in (one, other):
            normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
            normals.append(normal / np.maximum(np.linalg.norm(normal, axis=1), 1e-300)[:, None])
        a, b = normals
        ways = np.stack([a + b, a - b, -a + b, -a - b, a, -a, b, -b], axis=1)
        sizes = np.minimum(*(np.ptp(corners, axis=1).max(axis=1) for corners in (one, other)))
        steps = np.concatenate([near * sizes[:, None, None] * ways for near in NEAR + NEARER], axis=1)
        samples: FloatArray = middles[:, None] + steps
        return samples

    def _refuse_crossing(self, pair: IntArray, what: str) -> None:
        one, other = self._sources[pair].tolist()
        raise UndecidedError(
            f"has a closed part that crosses itself and so encloses {what}",
            (one, other),
            "part what crosses, or make it one outer skin",
        )

    def _check_opposed(self, solid: set[int]) -> None:
        """Refuse cavities that touch or cross the skin around them; doubt other solids that meet wound opposite."""
        for skin in self._skins:
            if skin.walls > 0.5:
                self._refuse_touch((int(skin.sources[0]), int(skin.sources[-1])))
        for (larger, smaller), triangles in sorted(self._meetings.items()):
            if not {larger, smaller} <= solid:
                continue  # a cavity may end where another part begins
            corners = self._corners_of(smaller)
            nudge = NEAR[-1] * (self._skins[smaller].high - self._skins[smaller].low).max()
            nudged = (corners[:, None] + nudge * np.vstack((np.eye(3), -np.eye(3)))).reshape(-1, 3)
            held = np.abs(self._winding(larger, nudged)).reshape(-1, 6) > 0.5
            if held.all(axis=1).mean() >= 0.5 or held.any(axis=1).mean() > 0.5:
                self._refuse_touch(triangles)
            problem = "has closed parts that touch or cross, wound opposite ways: each reads as solid"
            self._doubts.append(Doubt(problem, triangles))

    def _corners_of(self, skin: int) -> FloatArray:
        """Return some corners (k, 3) m of a skin, from all over it."""
        corners = np.unique(self._skins[skin].triangles)
        some = np.unique(np.linspace(0, len(corners) - 1, MOST_CORNERS).astype(np.int64))
        return self._points[corners[some]]

    def _refuse_touch(self, triangles: tuple[int, int]) -> None:
        raise UndecidedError(
            "has a cavity that touches or crosses the skin around it",
            triangles,
            "part the two skins, or turn the inner one if it is solid",
        )

    def _winding(self, skin: int, points: FloatArray) -> FloatArray:
        return winding_numbers(points, self._points[self._skins[skin].triangles])

    def _hosts(self) -> dict[int, list[int]]:
        """Return the skins that bound solids, each with its cavities."""
        skins = self._skins
        lows, highs = (np.array([getattr(skin, name) for skin in skins]).reshape(-1, 3) for name in ("low", "high"))
        solid: dict[int, list[int]] = {}
        for index, skin in enumerate(skins):
            around = np.flatnonzero((lows[:index] <= skin.low).all(axis=1) & (highs[:index] >= skin.high).all(axis=1))
            host = next((one for one in around[::-1].tolist() if self._holds(one, index)), None)
            if host in solid and skin.winding * skins[host].winding < 0:
                solid[host].append(index)
                continue
            solid[index] = []
            if host is None or (host not in solid and skin.winding * skins[host].winding < 0):
                continue
            how = "wound alike" if skin.winding * skins[host].winding > 0 else "of mixed orientation"
            self._doubts.append(
                Doubt(
                    f"has a closed part inside another, {how}: both read as solid, there is no cavity",
                    (int(skins[host].sources[0]), int(skin.sources[0])),
                )
            )
        return solid

    def _holds(self, host: int, guest: int) -> bool:
        """Tell whether a skin lies wholly inside a larger one."""
        if (host, guest) in self._meetings:
            return False
        return bool((np.abs(self._winding(host, self._corners_of(guest))) > 0.5).all())
