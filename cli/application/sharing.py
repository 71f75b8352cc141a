"""A run whose pairs are shared by workers, and what they told of it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from itertools import chain
from tempfile import SpooledTemporaryFile, gettempdir
from typing import IO, Any, NamedTuple

from ...formats.log.viewer.pictures import Picture, pictures
from ...formats.log.viewer.viewer import ViewerOptions
from ...scheduler.model.share import shares_of
from ...scheduler.parallel.merge import Stream, packed_ticks, stream, told_in_order, windows_of
from ...scheduler.parallel.transport import Work, packed, unpacked_stream
from ...scheduler.snapshots.schedule import Instant, Taken, instants
from .errors import WorkerError
from .workers import Team, team_of

#: Shares for each worker, so that one that got slow pairs is not waited for; fewer of a crowd, each of which goes
#: through all windows.
SHARES_A_WORKER, SHARES_OF_A_CROWD = 8, 2
#: Shares beyond which there are only as many as workers.
MANY_SHARES = 128
#: Rows of pictures for each worker.
ROWS_A_WORKER = 4
#: Bytes of what a call tells that are kept in memory; of more all is in a file.
KEPT_BYTES = 1 << 20


class Camera(NamedTuple):
    """When (s) pictures are taken, besides at collisions, how much each shows, and the ns added to its log time."""

    times: Sequence[float]
    options: ViewerOptions
    epoch: int


class Told(NamedTuple):
    """What workers told: streams for `merged`, the pictures, and the seconds it took inside FCL."""

    streams: list[IO[bytes]]
    pictures: Taken[Picture]
    fcl: float


def told_by_workers(
    work: Work,
    pairs: int,
    jobs: int,
    cluster: str | None,
    camera: Camera | None,
    done: Callable[[str, int, int], None],
) -> Told:
    """Have all shares run, and then the pictures taken; return what is told.

    Args:
        work: to be shared.
        pairs: how many there are.
        jobs: how many processes of this machine run them, unless there is a cluster.
        cluster: address of its scheduler.
        camera: None for no pictures.
        done: is told of each step how many calls of how many are done.

    Raises:
        WorkerError: when workers cannot be had, or are lost; and what a share raises, as it would here.
    """
    with team_of(jobs, cluster) as team:
        sent = team.sent(packed(work))
        ticks = None
        if work.crowded:
            parts = team.results(windows_of, [(sent, share) for share in shares_of(team.size)])
            ticks = team.sent(packed_ticks(work, parts))
        shares = max(team.size, min((SHARES_OF_A_CROWD if work.crowded else SHARES_A_WORKER) * team.size, MANY_SHARES))
        shares = max(1, min(shares, pairs))
        done("certifying", 0, shares)
        streams: list[Stream] = []
        kept = []
        for told in team.results(stream, [(sent, share, ticks) for share in shares_of(shares)]):
            kept.append(_kept(told.turns))
            streams.append(told._replace(turns=b""))
            done("certifying", len(kept), shares)
        fcl = sum(told.fcl for told in streams)
        if camera is None:
            return Told(kept, Taken(iter(()), iter(())), fcl)
        seen, taking = _pictures(team, sent, camera, streams, done)
        return Told(kept, seen, fcl + taking)


def _pictures(
    team: Team, sent: Any, camera: Camera, streams: Iterable[Stream], done: Callable[[str, int, int], None]
) -> tuple[Taken[Picture], float]:
    """Have the pictures taken, in rows of neighbours; return them, and the seconds it took inside FCL."""
    kinds = [_rows(kind, ROWS_A_WORKER * team.size) for kind in instants(told_in_order(streams), camera.times)]
    calls = [(sent, camera.options, camera.epoch, row) for row in chain(*kinds)]
    taken, fcl = [], 0.0
    for told in team.results(pictures, calls):
        taken.append(_kept(told.packed))
        fcl += told.fcl
        done("taking snapshots", len(taken), len(calls))
    ticks, occasions = taken[: len(kinds[0])], taken[len(kinds[0]) :]
    return Taken(*(chain.from_iterable(map(unpacked_stream, kind)) for kind in (ticks, occasions))), fcl


def _rows(all_of_a_kind: list[Instant], count: int) -> list[list[Instant]]:
    """Return instants as so many rows, at most."""
    length = max(1, -(-len(all_of_a_kind) // count))
    return [all_of_a_kind[first : first + length] for first in range(0, len(all_of_a_kind), length)]


def _kept(told: bytes) -> IO[bytes]:
    """Return what a call told as a file, from its begin."""
    try:
        file = SpooledTemporaryFile(KEPT_BYTES)  # noqa: SIM115  (who unpacks it reads it)
        file.write(told)
        file.seek(0)
    except OSError as error:
        problem = f"cannot store the events of the workers in {gettempdir()}: {error.strerror}"
        raise WorkerError(problem, "free space there, or name another folder in TMPDIR") from error
    return file
