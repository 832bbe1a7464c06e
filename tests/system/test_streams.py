from __future__ import annotations

import io
import os

import pytest

from osm2xodr.system import Progress, advance, shown, stage, time_left

PLAN = (("reading", 3.0), ("reading heights", 1.0), ("drawing", 4.0))


class Terminal(io.StringIO):
    """A stream that says that it is a terminal."""

    def isatty(self) -> bool:
        return True


class Clock:
    """A clock that is set by hand."""

    def __init__(self) -> None:
        self.time = 0.0

    def __call__(self) -> float:
        return self.time


def run(stream: io.StringIO, clock: Clock, *, quiet: bool = False, verbose: bool = False) -> str:
    """Read for 6 s, look at the middle of that, skip heights, and draw for 4 s of 8."""
    with shown(Progress(stream, quiet=quiet, verbose=verbose, plan=PLAN, clock=clock)):
        stage("reading a.xodr")
        for clock.time, part in ((0.05, 0.01), (3.0, 0.5), (6.0, 1.0)):
            advance(part)
        stage("drawing roads")
        for clock.time, part in ((6.05, 0.01), (10.0, 0.5)):
            advance(part)
    return stream.getvalue()


def test_terminals_show_share_and_time_left_in_one_line() -> None:
    lines = run(Terminal(), Clock()).split("\r\x1b[K")
    assert [line for line in lines if line] == [
        "reading a.xodr … 0 %",
        # 1.5 of 8 took 3 s.
        "reading a.xodr … 19 %, about 13 s left",
        "reading a.xodr … 38 %, about 10 s left",
        "drawing roads … 50 %, about 6 s left",
        "drawing roads … 75 %, about 3 s left",
    ]
    assert lines[-1] == ""


def test_elsewhere_it_is_a_line_for_each_stage_and_every_ten_seconds() -> None:
    stream, clock = io.StringIO(), Clock()
    with shown(Progress(stream, plan=PLAN, clock=clock)):
        stage("reading a.xodr")
        clock.time = 12.0
        stage("drawing roads")
    assert stream.getvalue() == "osm2xodr: drawing roads 50 %, about 12 s left\n"
    stream, clock = io.StringIO(), Clock()
    with shown(Progress(stream, plan=PLAN, clock=clock)):
        stage("drawing")
        for second in range(101):
            clock.time = second / 2.0
            advance(second / 100.0)
    # At 10, 20, 30, 40 and 50 s.
    assert [line.split("%")[0] for line in stream.getvalue().splitlines()] == [
        f"osm2xodr: drawing {share} " for share in (60, 70, 80, 90, 100)
    ]


def test_nothing_is_said_by_commands_that_are_quick() -> None:
    stream, clock = io.StringIO(), Clock()
    with shown(Progress(stream, plan=PLAN, clock=clock)):
        for clock.time, name in ((0.5, "reading a"), (9.9, "drawing")):
            stage(name)
    assert stream.getvalue() == ""


@pytest.mark.parametrize("stream", [io.StringIO(), Terminal()])
def test_nothing_is_said_to_those_who_are_quiet(stream: io.StringIO) -> None:
    assert run(stream, Clock(), quiet=True) == ""
    assert run(stream, Clock(), quiet=True, verbose=True) == ""


def test_the_verbose_see_the_time_of_each_stage() -> None:
    lines = run(io.StringIO(), Clock(), verbose=True).splitlines()
    assert lines == ["   6.00 s  reading a.xodr", "   4.00 s  drawing roads"]


def test_nothing_happens_where_nothing_is_shown() -> None:
    stage("reading")
    advance(0.5)


def test_copies_of_the_process_are_silent(monkeypatch: pytest.MonkeyPatch) -> None:
    stream = Terminal()
    with shown(Progress(stream, plan=PLAN)):
        stage("reading")
        before = stream.getvalue()
        with monkeypatch.context() as other:
            other.setattr(os, "getpid", lambda: -1)
            stage("drawing")
            advance(0.5)
        assert stream.getvalue() == before


def test_time_left() -> None:
    assert [time_left(seconds) for seconds in (0.1, 89.0, 300.0, 9000.0)] == [
        "about 1 s left",
        "about 89 s left",
        "about 5 min left",
        "about 2.5 h left",
    ]
