"""Workers that run shares of a scene's pairs: processes of this machine, or the workers of a Dask cluster."""

from __future__ import annotations

import logging
import os
import signal
import sys
import threading
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import CancelledError, Executor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from importlib.metadata import version
from multiprocessing import resource_tracker
from time import sleep
from typing import Any, Literal, TypeVar

from closecall import __version__

from .errors import WorkerError

#: s until a cluster that says nothing counts as lost.
PATIENCE = 10.0
#: Each process of this machine takes one processor.
ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")

ToldT = TypeVar("ToldT")


@dataclass(frozen=True, slots=True)
class Team:
    """Workers at hand.

    Attributes:
        executor: hands calls to them.
        size: how many calls they work at in a time.
        sent: makes of bytes the argument that brings them to a call.
        check: raises a WorkerError if there are none any more.
    """

    executor: Executor
    size: int
    sent: Callable[[bytes], Any] = lambda data: data
    check: Callable[[], None] = lambda: None

    def results(self, work: Callable[..., ToldT], calls: Iterable[tuple[Any, ...]]) -> Iterator[ToldT]:
        """Work at calls; yield what they return, in order.

        Raises:
            WorkerError: when workers are lost; and what a call raises, as it would here.
        """
        with _interrupts_held():
            waiting = [self.executor.submit(work, *arguments) for arguments in calls]
        while waiting:
            wait(waiting[:1], PATIENCE)
            while waiting and waiting[0].done():
                yield waiting.pop(0).result()
            self.check()


def processes(jobs: int | Literal["auto"]) -> int:
    """Return how many processes are meant; "auto" means as many as there are processors that this one may use."""
    if jobs != "auto":
        return jobs
    from loky import cpu_count

    return int(cpu_count())


@contextmanager
def team_of(jobs: int, cluster: str | None) -> Iterator[Team]:
    """Lend so many processes of this machine, or the workers of the cluster whose scheduler has this address.

    Raises:
        WorkerError: when workers cannot be had, or are lost.
    """
    with _cluster(cluster) if cluster is not None else _processes(jobs) as team:
        yield team


@contextmanager
def _processes(jobs: int) -> Iterator[Team]:
    """Start processes on this machine; they end with the block, at once where it fails."""
    from loky import ProcessPoolExecutor

    executor = ProcessPoolExecutor(jobs, env=ONE_THREAD, initializer=_end_with, initargs=(os.getpid(),))
    try:
        yield Team(executor, jobs)
    except BrokenProcessPool as error:
        executor.shutdown(kill_workers=True)
        problem = "a worker process died (killed, or out of memory)"
        raise WorkerError(problem, "no log was written; run again, with fewer --jobs if memory is short") from error
    except BaseException:
        executor.shutdown(kill_workers=True)
        raise
    executor.shutdown()


def _end_with(parent: int) -> None:
    """Have this process end, whatever it is at, when its parent has."""

    def watch() -> None:
        while os.getppid() == parent:
            sleep(1.0)
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()


@contextmanager
def _cluster(address: str) -> Iterator[Team]:
    """Reach the workers of a Dask cluster; what they are still at is cancelled where the block fails."""
    try:
        from distributed import Client, KilledWorker
        from distributed.comm.addressing import resolve_address
    except ImportError as error:
        raise WorkerError("--cluster needs Dask", "pip install 'closecall[cluster]'") from error
    try:
        resolve_address(address)
        client: Any = Client(address, timeout=PATIENCE, set_as_default=False)
    except (OSError, ValueError) as error:
        problem = f"--cluster {address}: no Dask scheduler answers at this address"
        raise WorkerError(problem, "start one with `dask scheduler` and give the address that it prints") from error
    lost = f"--cluster {address}: the workers or the scheduler were lost"
    disabled = logging.root.manager.disable
    logging.disable()  # what matters is raised
    try:
        with client:
            executor = client.get_executor(pure=False)
            try:
                _require_workers(client, f"--cluster {address}: the scheduler has no workers")
                _require_versions(client, address)
                size = sum(client.nthreads().values())
                sent = partial(client.scatter, broadcast=True)
                yield Team(executor, size, sent, partial(_require_workers, client, lost))
            finally:
                executor.shutdown(wait=False)
    except (KilledWorker, CancelledError, OSError) as error:
        raise WorkerError(lost, "no log was written; check their logs and run again") from error
    finally:
        logging.disable(disabled)


def _require_workers(client: Any, problem: str) -> None:
    """Wait a little for a worker where there is none.

    Raises:
        WorkerError: if none comes.
    """
    if client.nthreads():
        return
    try:
        client.wait_for_workers(1, timeout=PATIENCE)
    except TimeoutError as error:
        raise WorkerError(problem, "start workers with `dask worker ADDRESS`") from error


def _require_versions(client: Any, address: str) -> None:
    """Ask the workers for what they run: other versions would tell other bytes, or nothing that can be read.

    Raises:
        WorkerError: if any has other versions.
    """
    here = versions()
    try:
        others = client.run(versions)
    except ImportError as error:
        raise WorkerError(f"--cluster {address}: the workers do not have closecall", f"install {here} there") from error
    for worker, there in others.items():
        if there != here:
            raise WorkerError(f"--cluster {address}: worker {worker} has {there}", f"install {here} there")


def versions() -> str:
    """Return the versions that a log's bytes depend on, of the process that is asked."""
    python = ".".join(map(str, sys.version_info[:2]))
    libraries = (f"{name} {version(name)}" for name in ("numpy", "python-fcl"))
    return ", ".join([f"closecall {__version__}", f"Python {python}", *libraries])


@contextmanager
def _interrupts_held() -> Iterator[None]:
    """Keep Ctrl-C for after the block. Processes that are started within never get it: they leave it to this one."""
    resource_tracker.ensure_running()  # which would let it through when it is started within
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
