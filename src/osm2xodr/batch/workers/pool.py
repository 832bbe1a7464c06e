"""Which processes convert: those of this machine, or the workers of a Dask scheduler."""

from __future__ import annotations

import contextlib
import secrets
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from osm2xodr.batch.workers.area_process import AreaJob, Outcome, blocks_of
from osm2xodr.batch.workers.dask_cluster import on_scheduler
from osm2xodr.batch.workers.local import on_this_machine


@dataclass(frozen=True, slots=True)
class Workers:
    """The processes that convert."""

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
    if workers.scheduler:
        chosen = on_scheduler(jobs, batch, workers.scheduler, workers.memory)
    else:
        chosen = on_this_machine(jobs, batch, max(1, min(workers.count, len(blocks_of(jobs)))), workers.memory)
    with chosen as outcomes:
        yield outcomes
