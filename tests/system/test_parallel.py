"""Work in copies of the process: order, errors, death and interruption."""

from __future__ import annotations

import multiprocessing
import os
import signal
import time

import numpy as np
import pytest

from osm2xodr.errors import Osm2xodrError
from osm2xodr.system.parallel import Task, available_jobs, can_fork, map_parallel

needs_fork = pytest.mark.skipif(not can_fork(), reason="this system cannot copy processes")


@pytest.mark.parametrize("jobs", [1, 2, 3, 20])
def test_values_come_in_the_order_of_the_items(jobs: int) -> None:
    assert list(map_parallel(lambda item: item * item, range(11), jobs)) == [k * k for k in range(11)]


def test_nothing_to_do_is_no_work() -> None:
    assert list(map_parallel(lambda item: item, [], 4)) == []


@needs_fork
def test_items_are_shared_between_this_process_and_its_copies() -> None:
    processes = list(map_parallel(lambda item: os.getpid(), range(4), 2))
    assert processes[0] == processes[2] == os.getpid()
    assert processes[1] == processes[3] != os.getpid()


@needs_fork
def test_copies_see_arrays_of_the_parent_and_hand_back_their_own() -> None:
    shared = np.arange(1e6)
    sums = map_parallel(lambda k: shared[k::4] * 2, range(4), 2)
    assert [part.sum() for part in sums] == [float(shared[k::4].sum() * 2) for k in range(4)]
    assert shared[1] == 1


def fail(item: int) -> int:
    if item == 3:
        raise ValueError(f"item {item} is wrong")
    return item


@pytest.mark.parametrize("jobs", [1, 2])
def test_an_error_reaches_the_caller(jobs: int) -> None:
    with pytest.raises(ValueError, match="item 3 is wrong"):
        list(map_parallel(fail, range(5), jobs))
    assert not multiprocessing.active_children()


@needs_fork
def test_values_are_there_as_soon_as_they_are_made_and_copies_end_with_the_last_that_is_asked_for() -> None:
    values = map_parallel(lambda item: time.sleep(60) if item > 1 else item, range(4), 2)
    assert [next(values), next(values)] == [0, 1]
    values.close()
    assert not multiprocessing.active_children()


@needs_fork
def test_values_larger_than_a_pipe_come_whole() -> None:
    found = list(map_parallel(lambda item: bytes([item]) * 3_000_000, range(5), 2))
    assert [(len(each), each[0], each[-1]) for each in found] == [(3_000_000, k, k) for k in range(5)]


@needs_fork
def test_an_error_of_this_process_stops_its_copies() -> None:
    def work(item: int) -> None:
        if item == 0:
            raise KeyboardInterrupt
        time.sleep(60)

    began = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        list(map_parallel(work, range(2), 2))
    assert time.monotonic() - began < 30
    assert not multiprocessing.active_children()


@needs_fork
def test_a_copy_that_is_killed_is_told_with_a_remedy() -> None:
    def die() -> None:
        os.kill(os.getpid(), signal.SIGKILL)

    with pytest.raises(Osm2xodrError, match=r"killed \(exit status -9\).*--jobs 1"):
        Task(die, apart=True).result()


@needs_fork
def test_a_task_that_is_cancelled_ends() -> None:
    task = Task(lambda: time.sleep(60), apart=True)
    task.cancel()
    assert not multiprocessing.active_children()


def test_a_task_in_this_process_runs_when_it_is_asked() -> None:
    seen: list[int] = []
    task = Task(lambda: seen.append(1), apart=False)
    assert seen == []
    task.result()
    assert seen == [1]


@pytest.mark.parametrize("apart", [False, pytest.param(True, marks=needs_fork)])
def test_a_result_is_worked_out_once(apart: bool) -> None:
    runs: list[int] = []

    def work() -> int:
        runs.append(1)
        return len(runs)

    task = Task(work, apart=apart)
    assert [task.result(), task.result()] == [1, 1]
    assert len(runs) == (0 if apart else 1)


def test_at_least_one_process_can_run() -> None:
    assert 1 <= available_jobs() <= (os.cpu_count() or 1)


@needs_fork
def test_a_task_ends_with_its_block() -> None:
    with pytest.raises(KeyboardInterrupt), Task(lambda: time.sleep(60), apart=True):
        raise KeyboardInterrupt
    assert not multiprocessing.active_children()
    with Task(lambda: 7, apart=True) as task:
        assert task.result() == 7


def copies_within_a_copy() -> list[int]:
    with Task(os.getpid, apart=True) as task:
        return [os.getpid(), task.result()]


@needs_fork
def test_a_copy_makes_no_copies_of_its_own() -> None:
    with Task(copies_within_a_copy, apart=True) as task:
        copy, inner = task.result()
    assert copy == inner != os.getpid()
