"""Which processes convert: those of this machine, or the workers of a Dask scheduler.

Each process of this machine has a thread that hands it one area after the other, and waits for its end.
"""

from __future__ import annotations

import contextlib
import dataclasses
import queue
import secrets
import threading
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from osm2xodr.batching.workers.area_process import AreaJob, Outcome, blocks_of, end_areas, run_each
from osm2xodr.batching.workers.dask_cluster import on_scheduler
from osm2xodr.system import LEAST_MEMORY, available_memory, uninterrupted

_Ended = tuple[AreaJob, Outcome | BaseException]


@dataclass(frozen=True, slots=True)
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
