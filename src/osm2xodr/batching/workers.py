"""Which processes convert: those of this machine, or the workers of a Dask scheduler, on this machine or on others.

Each process of this machine has a thread that hands it one area after the other, and waits for its end.
"""

from __future__ import annotations

import contextlib
import dataclasses
import importlib.util
import logging
import queue
import secrets
import threading
from collections.abc import Iterator, Sequence
from multiprocessing import resource_tracker
from typing import Any, Final

from osm2xodr.batching.area_process import AreaJob, Outcome, blocks_of, end_areas, run_block, run_each
from osm2xodr.errors import Osm2xodrError
from osm2xodr.system import LEAST_MEMORY, available_memory, record, uninterrupted

_Ended = tuple[AreaJob, Outcome | BaseException]

# Dask's classes, which are loaded when there is work.
_Client = Any
_Future = Any

_GONE: Final = "the Dask scheduler is gone; start it, and run the same command again"
# How often the connection to the scheduler is checked, s.
_CONNECTION_CHECK: Final = 0.5
# How long an existing scheduler may take to answer, s.
_CONNECT_TIMEOUT: Final = 10.0
# Dask's statuses of tasks that have ended.
_ENDED: Final = frozenset({"finished", "error", "cancelled"})


@record
class Workers:
    """The processes that convert."""

    server: str  # The module whose processes they are, which answers as `osm2xodr.cli.area_server` does
    count: int = 1  # How many on this machine, at least 1; ignored with a scheduler
    scheduler: str = ""  # Address of a Dask scheduler, such as ``tcp://host:8786``; empty for this machine
    memory: int | None = None  # Bytes that an area may take; None for an equal share of what there is


@contextlib.contextmanager
def running(jobs: Sequence[AreaJob], workers: Workers) -> Iterator[Iterator[tuple[AreaJob, Outcome]]]:
    """Convert areas, the first ones first, and stop those that still run at the end of the block.

    Yields an iterator over the areas and their outcomes, as they end. Without Dask's scheduler, where one is asked
    for, it raises `Osm2xodrError`.
    """
    batch = secrets.token_hex(8)
    jobs = [dataclasses.replace(job, server=workers.server, batch=batch) for job in jobs]
    if workers.scheduler:
        chosen = on_scheduler(jobs, batch, workers.scheduler, workers.memory)
    else:
        chosen = on_this_machine(jobs, batch, max(1, min(workers.count, len(blocks_of(jobs)))), workers.memory)
    with chosen as outcomes:
        yield outcomes


@contextlib.contextmanager
def on_this_machine(
    jobs: Sequence[AreaJob], batch: str, count: int, memory: int | None
) -> Iterator[Iterator[tuple[AreaJob, Outcome]]]:
    """Convert areas in `count` processes; an area may take `memory` bytes, by default an equal share of what is free.

    As `running`; `batch` is the id of the batch.
    """
    if memory is None:
        free = available_memory()
        memory = 0 if free is None else max(free // count, LEAST_MEMORY)
    todo: queue.SimpleQueue[list[AreaJob]] = queue.SimpleQueue()
    for block in blocks_of(jobs):
        todo.put([dataclasses.replace(job, memory=memory) for job in block])
    ended: queue.SimpleQueue[_Ended] = queue.SimpleQueue()
    threads = [threading.Thread(target=_work, args=(todo, ended), daemon=True) for _ in range(count)]
    # Threads have SIGINT blocked, so that Ctrl-C interrupts this one.
    with uninterrupted():
        for thread in threads:
            thread.start()
    try:
        yield _outcomes(ended, len(jobs))
    finally:
        with uninterrupted():
            end_areas(batch)
            for thread in threads:
                thread.join()


def _work(todo: queue.SimpleQueue[list[AreaJob]], ended: queue.SimpleQueue[_Ended]) -> None:
    """Convert areas until none is left."""
    while True:
        try:
            block = todo.get_nowait()
        except queue.Empty:
            return
        left = list(block)
        try:
            for outcome in run_each(block):
                ended.put((left.pop(0), outcome))
        except BaseException as error:
            for job in left:
                ended.put((job, error))


def _outcomes(ended: queue.SimpleQueue[_Ended], count: int) -> Iterator[tuple[AreaJob, Outcome]]:
    for _ in range(count):
        job, outcome = ended.get()
        if isinstance(outcome, BaseException):
            raise outcome
        yield job, outcome


def check_dask() -> None:
    """Raise `Osm2xodrError` if Dask is not installed."""
    if importlib.util.find_spec("distributed") is None:
        raise Osm2xodrError("--scheduler needs Dask: pip install 'osm2xodr[batch]', or leave --scheduler out")


@contextlib.contextmanager
def on_scheduler(
    jobs: Sequence[AreaJob], batch: str, scheduler: str, memory: int | None
) -> Iterator[Iterator[tuple[AreaJob, Outcome]]]:
    """Convert areas on the workers of a scheduler; an area may take `memory` bytes, by default the share of a task.

    As `running`; `batch` is the id of the batch. Without Dask or its scheduler it raises `Osm2xodrError`.
    """
    check_dask()
    with _quiet(), contextlib.ExitStack() as stack:
        # Here, because starting it unblocks SIGINT in this thread.
        resource_tracker.ensure_running()
        with uninterrupted():
            client = stack.enter_context(_client(scheduler))
            share = _share(client) if memory is None else memory
        yield _outcomes_of_cluster(client, [dataclasses.replace(job, memory=share) for job in jobs], batch, stack)


def _outcomes_of_cluster(
    client: _Client, jobs: Sequence[AreaJob], batch: str, stack: contextlib.ExitStack
) -> Iterator[tuple[AreaJob, Outcome]]:
    """Submit all jobs and yield them as they end."""
    done: queue.SimpleQueue[_Future] = queue.SimpleQueue()
    futures: dict[str, tuple[list[AreaJob], _Future]] = {}
    stack.callback(_stop, client, futures, batch)
    for place, block in enumerate(blocks_of(jobs)):
        key = f"osm2xodr-{batch}-{block[0].name}"
        future = client.submit(run_block, block, key=key, priority=-place, pure=False)
        futures[key] = block, future
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
        block, _ = futures.pop(future.key)
        yield from zip(block, _outcomes_of(future, block), strict=True)
        future.release()


def _outcomes_of(future: _Future, block: Sequence[AreaJob]) -> list[Outcome]:
    """Return the outcome of each area of a task that has ended."""
    from distributed import KilledWorker

    if future.status == "finished":
        try:
            outcomes: list[Outcome] = future.result()
        except OSError as lost:
            # The outcome was lost with the connection on its way here.
            raise Osm2xodrError(_GONE) from lost
        return outcomes
    if future.status == "cancelled":
        raise Osm2xodrError("the Dask scheduler is gone, or took the areas back; run the same command again")
    error = future.exception()
    if isinstance(error, KilledWorker):
        died = "its workers died again and again, perhaps for want of memory; use fewer --workers"
        return [Outcome(died, apart=bool(job.block)) for job in block]
    text = " ".join(str(error).split())
    cause = f"its worker cannot run it ({type(error).__name__}: {text}); install the osm2xodr of the batch there"
    return [Outcome(cause) for _ in block]


def _stop(client: _Client, futures: dict[str, tuple[list[AreaJob], _Future]], batch: str) -> None:
    """Cancel the tasks that have not ended, and stop their conversions."""
    # If the scheduler is gone or workers are dying, they stop by themselves.
    with contextlib.suppress(Exception):
        if futures:
            client.cancel([future for _, future in futures.values()], force=True)
        client.run(end_areas, batch, on_error="ignore")


@contextlib.contextmanager
def _client(scheduler: str) -> Iterator[_Client]:
    from distributed import Client

    try:
        client = Client(scheduler, timeout=_CONNECT_TIMEOUT, set_as_default=False)
    except (OSError, ValueError, ImportError) as error:
        raise Osm2xodrError(f"no Dask scheduler answers at {scheduler}; start one there: {error}") from error
    try:
        yield client
    finally:
        with uninterrupted():
            client.close()


def _share(client: _Client) -> int:
    """Return how much memory each area may take, bytes; 0 for no bound."""
    shares = [share for share in client.run(_worker_share).values() if share]
    return max(min(shares), LEAST_MEMORY) if shares else 0


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
