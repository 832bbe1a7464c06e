"""Areas spread over the processes of a Dask cluster, on this machine or on others."""

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

# An area is given up after the death of so many workers that converted it; a choice.
_WORKER_DEATHS: Final = 3

# Dask's classes, which are loaded when there is work.
_Client = Any
_Future = Any

_GONE: Final = "the Dask scheduler is gone; start it, and run the same command again"
# How often the connection to the scheduler is checked, s.
_CONNECTION_CHECK: Final = 0.5
# How long an existing scheduler may take to answer, s.
_CONNECT_TIMEOUT: Final = 10.0
# Dask is made for tasks of milliseconds: each process looks after them fifty times a second. Areas take seconds.
_SETTINGS: Final = {
    "distributed.admin.tick.interval": "500ms",
    "distributed.admin.tick.limit": "1h",
    "distributed.admin.system-monitor.interval": "10s",
    "distributed.worker.profile.enabled": False,
    "distributed.scheduler.worker-saturation": 1.0,
}
# Dask's statuses of tasks that have ended.
_ENDED: Final = frozenset({"finished", "error", "cancelled"})


@dataclass(frozen=True, slots=True)
class Workers:
    """The processes that convert."""

    count: int = 1  # How many on this machine, at least 1; ignored with a scheduler
    # Address of an existing scheduler, such as ``tcp://host:8786``; empty for a cluster on this machine
    scheduler: str = ""
    memory: int | None = None  # Bytes that an area may take; None for an equal share of what the machine has


def check_dask() -> None:
    """Raise `Osm2xodrError` if Dask is not installed."""
    if importlib.util.find_spec("distributed") is None or importlib.util.find_spec("cryptography") is None:
        raise Osm2xodrError("batches need Dask's distributed and cryptography: pip install 'osm2xodr[batch]'")


@contextlib.contextmanager
def running(jobs: Sequence[AreaJob], workers: Workers) -> Iterator[Iterator[tuple[AreaJob, Outcome]]]:
    """Convert areas, the first ones first, and stop those that still run at the end of the block.

    Yields an iterator over the areas and their outcomes, as they end. Without Dask or its scheduler it raises
    `Osm2xodrError`.
    """
    check_dask()
    batch = secrets.token_hex(8)
    count = max(1, min(workers.count, len(jobs)))
    with _quiet(), contextlib.ExitStack() as stack:
        # Here, because starting it unblocks SIGINT in this thread.
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
            future = done.get(timeout=_CONNECTION_CHECK)
        except queue.Empty:
            if client.status != "running":
                raise Osm2xodrError(_GONE) from None
            continue
        if future.status not in _ENDED:
            # Outcomes that were not fetched are lost with their worker: these areas are being made again.
            future.add_done_callback(done.put)
            continue
        job, _ = futures.pop(future.key)
        yield job, _outcome(future)
        future.release()


def _outcome(future: _Future) -> Outcome:
    """Return the outcome of a task that has ended."""
    from distributed import KilledWorker

    if future.status == "finished":
        try:
            outcome: Outcome = future.result()
        except OSError as lost:
            # The outcome was lost with the connection on its way here.
            raise Osm2xodrError(_GONE) from lost
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
    """Cancel the tasks that have not ended, and stop their conversions."""
    # If the scheduler is gone or workers are dying, they stop by themselves.
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
            client = Client(workers.scheduler, timeout=_CONNECT_TIMEOUT, set_as_default=False)
        except (OSError, ValueError, ImportError) as error:
            raise Osm2xodrError(
                f"no Dask scheduler answers at {workers.scheduler}; start one there: {error}"
            ) from error
        with _closing(client):
            yield client
        return
    settings = {"distributed.scheduler.allowed-failures": _WORKER_DEATHS - 1, **_SETTINGS}
    with contextlib.ExitStack() as stack:
        folder = stack.enter_context(tempfile.TemporaryDirectory(prefix="osm2xodr-", ignore_cleanup_errors=True))
        stack.enter_context(dask.config.set(settings))
        # Whoever reaches a scheduler can have it run anything. So it listens on this machine only, and talks only to
        # those who hold the keys made for this batch: its workers, and no other user of this machine.
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
    """Close a client or cluster at the end of the block, undisturbed by signals."""
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
    """Silence Dask's log, which reports what does not concern the user, such as workers that end."""
    # All logs are disabled, since modules of Dask set levels of their own when they are loaded.
    before = logging.root.manager.disable
    logging.disable(logging.CRITICAL)
    try:
        yield
    finally:
        logging.disable(before)


@contextlib.contextmanager
def uninterrupted() -> Iterator[None]:
    """Defer the signals that end the process to the end of the block.

    SIGINT is blocked, also for threads and processes that are started meanwhile, and for those that they start:
    Ctrl-C at the terminal reaches this process alone, which then stops its workers in order.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    deferred: list[int] = []

    def defer(number: int, frame: FrameType | None) -> None:
        deferred.append(number)

    before = {number: signal.getsignal(number) for number in (signal.SIGTERM, signal.SIGHUP)}
    for number, handler in before.items():
        if handler is not signal.SIG_IGN:
            signal.signal(number, defer)
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
        for late in deferred[:1]:
            os.kill(os.getpid(), late)
        signal.pthread_sigmask(signal.SIG_SETMASK, mask)
