"""What becomes of outcomes that workers hold."""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from typing import Any

import pytest
from distributed.comm import CommClosedError

from osm2xodr.batching import workers as running
from osm2xodr.batching.area_process import AreaJob, Outcome
from osm2xodr.errors import Osm2xodrError


class LostOnce:
    """A task whose outcome is lost with its worker before anybody fetches it, and found again."""

    def __init__(self, key: str, areas: int = 1) -> None:
        self.key = key
        self.areas = areas
        self.status = "finished"
        self.asked = 0

    def add_done_callback(self, then: Callable[[Any], None]) -> None:
        self.asked += 1
        then(self)
        self.status = "lost" if self.asked == 1 else "finished"

    def result(self) -> list[Outcome]:
        assert self.status == "finished"
        return [Outcome("", 1.0)] * self.areas

    def exception(self) -> None:
        return None

    def release(self) -> None:
        self.status = "released"


class Client:
    status = "running"

    def __init__(self) -> None:
        self.futures: list[LostOnce] = []

    def submit(self, function: object, block: list[AreaJob], *, key: str, priority: int, pure: bool) -> LostOnce:
        self.futures.append(LostOnce(key, len(block)))
        return self.futures[-1]

    def run(self, function: object, batch: str, *, on_error: str) -> None:
        pass


def test_an_outcome_that_is_lost_with_its_worker_is_waited_for_again() -> None:
    client, jobs = Client(), [AreaJob("a", ()), AreaJob("b", (), block="x"), AreaJob("c", (), block="x")]
    with contextlib.ExitStack() as stack:
        found = list(running._outcomes_of_cluster(client, jobs, "batch", stack))
    assert found == [(job, Outcome("", 1.0)) for job in jobs]
    assert [(future.asked, future.status) for future in client.futures] == [(2, "released"), (2, "released")]


def test_an_outcome_that_ends_with_the_connection_says_that_the_scheduler_is_gone() -> None:
    class CutOff(LostOnce):
        def result(self) -> list[Outcome]:
            raise CommClosedError("Connection reset by peer")

    with pytest.raises(Osm2xodrError, match="the Dask scheduler is gone; start it"):
        running._outcomes_of(CutOff("a"), [AreaJob("a", ())])
