"""Areas spread over processes: on this machine, or on those of a Dask cluster."""

from __future__ import annotations

import contextlib
import dataclasses
import importlib.util
import logging
import os
import queue
import secrets
import signal
import tempfile
import threading
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from multiprocessing import resource_tracker
from types import FrameType
from typing import Any, Final

from osm2xodr.batch.workers.area_process import AreaJob, Outcome, end_areas, run_area
from osm2xodr.errors import Osm2xodrError
from osm2xodr.system import LEAST_MEMORY

# An area during whose conversion so many workers died is given up.
_BATCH_WORKER_DEATHS: Final = 3

# Dask's, which are loaded when there is work.
_Client = Any
_Future = Any

# How often it looks whether the scheduler is still there, s.
_LOOK: Final = 0.5
# How long an existing scheduler may take to answer, s.
_PATIENCE: Final = 10.0
# Dask looks after tasks of milliseconds, fifty times a second and in each of its processes; areas take seconds.
_CALM: Final = {
    "distributed.admin.tick.interval": "500ms",
    "distributed.admin.tick.limit": "1h",
    "distributed.admin.system-monitor.interval": "10s",
    "distributed.worker.profile.enabled": False,
    "distributed.scheduler.worker-saturation": 1.0,
}
# What Dask calls tasks that have ended.
_ENDED: Final = frozenset({"finished", "error", "cancelled"})


@dataclass(frozen=True, slots=True)
class Workers:
    """Who converts."""

    count: int = 1  # How many processes on this machine, at least 1; not looked at with a scheduler
    # Address of an existing scheduler, such as ``tcp://host:8786``; empty for a cluster on this machine
    scheduler: str = ""
    memory: int | None = None  # Bytes that an area may take; None for an equal share of what the machine has


def check_dask() -> None:
    """Refuse to go on without Dask.

    Raises
    ------
    Osm2xodrError
        It is not installed.
    """
    if importlib.util.find_spec("distributed") is None or importlib.util.find_spec("cryptography") is None:
        raise Osm2xodrError("batches need Dask's distributed and cryptography: pip install 'osm2xodr[batch]'")


@contextlib.contextmanager
def running(jobs: Sequence[AreaJob], workers: Workers) -> Iterator[Iterator[tuple[AreaJob, Outcome]]]:
    """Convert areas, and stop all that still runs at the end of the block.

    Parameters
    ----------
    jobs
        The areas; the first are begun first.
    workers
        Who converts them.

    Yields
    ------
    Iterator
        Each area with its outcome, as they end.

    Raises
    ------
    Osm2xodrError
        There is no Dask, or no scheduler at the address, or it ended.
    """
    check_dask()
    batch = secrets.token_hex(8)
    count = max(1, min(workers.count, len(jobs)))
    with _quiet(), contextlib.ExitStack() as stack:
        # Starting it lets SIGINT through again in the thread that does so.
        resource_tracker.ensure_running()
        with uninterrupted():
            client = stack.enter_context(_client(count, workers))
            memory = _share(client, count, workers)
        yield _outcomes(client, [dataclasses.replace(job, batch=batch, memory=memory) for job in jobs], batch, stack)


def _outcomes(
    client: _Client, jobs: Sequence[AreaJob], batch: str, stack: contextlib.ExitStack
) -> Iterator[tuple[AreaJob, Outcome]]:
    """Submit all jobs and yield them as they end."""
    done: queue.SimpleQueue[_Future] = queue.SimpleQueue()
    futures: dict[str, tuple[AreaJob, _Future]] = {}
    stack.callback(_stop, client, futures, batch)
    for place, job in enumerate(jobs):
        key = f"osm2xodr-{batch}-{job.name}"
        future = client.submit(run_area, job, key=key, priority=-place, pure=False)
        futures[key] = job, future
        future.add_done_callback(done.put)
    while futures:
        try:
            future = done.get(timeout=_LOOK)
        except queue.Empty:
            if client.status != "running":
                raise Osm2xodrError("the Dask scheduler is gone; start it, and run the same command again") from None
            continue
        if future.status not in _ENDED:
            # A worker that dies takes outcomes along that nobody has fetched: these areas are being made again.
            future.add_done_callback(done.put)
            continue
        job, _ = futures.pop(future.key)
        yield job, _outcome(future)
        future.release()


def _outcome(future: _Future) -> Outcome:
    """Return how a task that has ended did so."""
    from distributed import KilledWorker

    if future.status == "finished":
        outcome: Outcome = future.result()
        return outcome
    if future.status == "cancelled":
        raise Osm2xodrError("the Dask scheduler is gone, or took the areas back; run the same command again")
    error = future.exception()
    if isinstance(error, KilledWorker):
        return Outcome("its workers died again and again, perhaps for want of memory; use fewer --workers")
    text = " ".join(str(error).split())
    return Outcome(
        f"its worker cannot run it ({type(error).__name__}: {text}); install the osm2xodr of the batch there"
    )


def _stop(client: _Client, futures: dict[str, tuple[AreaJob, _Future]], batch: str) -> None:
    """Take back what has not ended, and have workers stop what they do for it."""
    # The scheduler may be gone, and workers may be dying: they stop by themselves then.
    with contextlib.suppress(Exception):
        if futures:
            client.cancel([future for _, future in futures.values()], force=True)
        client.run(end_areas, batch, on_error="ignore")


@contextlib.contextmanager
def _client(count: int, workers: Workers) -> Iterator[_Client]:
    import dask
    from distributed import Client, LocalCluster

    if workers.scheduler:
        try:
            client = Client(workers.scheduler, timeout=_PATIENCE, set_as_default=False)
        except (OSError, ValueError, ImportError) as error:
            raise Osm2xodrError(
                f"no Dask scheduler answers at {workers.scheduler}; start one there: {error}"
            ) from error
        with _closing(client):
            yield client
        return
    settings = {"distributed.scheduler.allowed-failures": _BATCH_WORKER_DEATHS - 1, **_CALM}
    with contextlib.ExitStack() as stack:
        folder = stack.enter_context(tempfile.TemporaryDirectory(prefix="osm2xodr-", ignore_cleanup_errors=True))
        stack.enter_context(dask.config.set(settings))
        # Whoever reaches a scheduler can have it run anything. So it listens on this machine only, and speaks only to
        # those who hold the keys made for this batch: its workers and nobody else who works on this machine.
        cluster = LocalCluster(
            n_workers=count,
            threads_per_worker=1,
            processes=True,
            host="127.0.0.1",
            security=True,
            dashboard_address="127.0.0.1:0",
            worker_dashboard_address="127.0.0.1:0",
            scheduler_kwargs={"dashboard": False},
            # Areas have processes of their own, with bounds of their own.
            memory_limit=0,
            local_directory=folder,
            silence_logs=logging.CRITICAL,
        )
        with _closing(cluster), _closing(Client(cluster, set_as_default=False)) as client:
            yield client


@contextlib.contextmanager
def _closing(thing: Any) -> Iterator[Any]:
    """Close a client or cluster at the end, whatever happens meanwhile."""
    try:
        yield thing
    finally:
        with uninterrupted():
            thing.close()


def _share(client: _Client, count: int, workers: Workers) -> int:
    """Return how much memory each area may take, bytes; 0 for no bound."""
    if workers.memory is not None:
        return workers.memory
    if workers.scheduler:
        shares = [share for share in client.run(_worker_share).values() if share]
        return max(min(shares), LEAST_MEMORY) if shares else 0
    import psutil
    from distributed.system import MEMORY_LIMIT

    available = min(int(psutil.virtual_memory().available), int(MEMORY_LIMIT))
    return max(available // count, LEAST_MEMORY)


def _worker_share(dask_worker: Any) -> int:
    """Return how much memory each task of a worker may take, bytes; 0 for no bound. Runs in the worker."""
    return int(dask_worker.memory_manager.memory_limit or 0) // max(1, int(dask_worker.state.nthreads))


@contextlib.contextmanager
def _quiet() -> Iterator[None]:
    """Keep Dask from telling of what is no matter of the user's, such as workers that end."""
    # All logs, since its parts have levels of their own, which they set when they are loaded.
    before = logging.root.manager.disable
    logging.disable(logging.CRITICAL)
    try:
        yield
    finally:
        logging.disable(before)


@contextlib.contextmanager
def uninterrupted() -> Iterator[None]:
    """Put off the wish to end the process to the end of the block.

    SIGINT is blocked, which holds for threads and processes that are started meanwhile, and for those that they
    start: a Ctrl-C at the terminal reaches this process alone, which then stops its workers in order.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    wished: list[int] = []

    def put_off(number: int, frame: FrameType | None) -> None:
        wished.append(number)

    numbers: tuple[int, ...] = (signal.SIGTERM, signal.SIGHUP)
    before = {number: signal.getsignal(number) for number in numbers}
    for number in numbers:
        if before[number] is not signal.SIG_IGN:
            signal.signal(number, put_off)
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
        for number in wished[:1]:
            os.kill(os.getpid(), number)
        signal.pthread_sigmask(signal.SIG_SETMASK, mask)
