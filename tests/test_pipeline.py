"""Work of several processes: the same road map, and the same findings in the same order."""

from __future__ import annotations

import io
from collections.abc import Callable
from pathlib import Path

import pytest
from scene_files import scene_named

from osm2xodr.diagnostics import Diagnostic, Diagnostics
from osm2xodr.geometry.connections import connecting_roads
from osm2xodr.pipeline import PipelineOptions, convert
from osm2xodr.system import Task
from osm2xodr.xodrWriter import write_xodr

SCENE = "i5_exit_ramp"


def made(jobs: int, dems: tuple[Path, ...]) -> tuple[bytes, list[Diagnostic]]:
    """Return the file and the findings of a small scene with signs, lights, sidewalks and floors."""
    found = Diagnostics()
    conversion = convert(PipelineOptions(scene_named(SCENE).osm, dems, jobs=jobs), found)
    stream = io.BytesIO()
    write_xodr(conversion.road_map, stream, conversion.options, found, jobs)
    return stream.getvalue(), list(found)


@pytest.mark.parametrize("heights", [False, True])
def test_bytes_and_findings_do_not_depend_on_processes(heights: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    # Small parts, so that there is work for all.
    monkeypatch.setattr(connecting_roads, "_AT_ONCE", 50)
    monkeypatch.setattr(connecting_roads, "_SHARED_FROM", 40)
    monkeypatch.setattr("osm2xodr.geometry.junctions.arm_trims._PAIRS_PER_SHARE", 40)
    monkeypatch.setattr("osm2xodr.geometry.connections.overrun_arms._PAIRS_PER_SHARE", 40)
    monkeypatch.setattr("osm2xodr.xodrWriter.document._ROADS_PER_BLOCK", 40)
    dems = (scene_named(SCENE).dem,) if heights else ()
    once = made(1, dems)
    assert len(once[1]) > 10
    assert b"<signal " in once[0]
    for jobs in (2, 3):
        assert made(jobs, dems) == once


def test_parts_are_drawn_as_the_whole(monkeypatch: pytest.MonkeyPatch) -> None:
    whole = made(1, ())
    monkeypatch.setattr(connecting_roads, "_AT_ONCE", 50)
    monkeypatch.setattr(connecting_roads, "_SHARED_FROM", 40)
    monkeypatch.setattr("osm2xodr.geometry.junctions.arm_trims._PAIRS_PER_SHARE", 40)
    monkeypatch.setattr("osm2xodr.geometry.connections.overrun_arms._PAIRS_PER_SHARE", 40)
    parts = made(1, ())
    assert parts[0].count(b"<road ") == whole[0].count(b"<road ")
    assert parts[0].count(b"<laneLink ") == whole[0].count(b"<laneLink ")
    assert parts[1] == whole[1]


@pytest.mark.parametrize(("copies_from", "copied"), [(35, True), (36, False)])
def test_few_streets_are_converted_by_one_process(
    copies_from: int, copied: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The scene has 35 streets."""

    def task(function: Callable[[], object], *, apart: bool) -> Task[object]:
        asked.append(apart)
        return Task(function, apart=False)

    asked: list[bool] = []
    monkeypatch.setattr("osm2xodr.pipeline.Task", task)
    convert(PipelineOptions(scene_named(SCENE).osm, jobs=2, copies_from=copies_from), Diagnostics())
    assert asked == [copied]
