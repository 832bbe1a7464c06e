"""Tiles of the sample fit: every road that is cut at a border meets its other half, in the files as written."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from lxml import etree
from xodr_file import Road, XodrFile, read_xodr

from osm2xodr.batching import workflow
from osm2xodr.batching.area_process import AreaJob, Outcome
from osm2xodr.batching.workers import Workers
from osm2xodr.cli import main
from osm2xodr.projection import make_frame, to_local
from osm2xodr.system.limits import parse_duration

SAMPLE = Path(__file__).parents[2] / "data" / "samples" / "andorra_ordino"
SIDE = "1500m"
# What must meet: m, rad, m.
PLACE, HEADING, HEIGHT = 0.01, np.radians(0.1), 0.01
SECONDS = parse_duration("5min")


@pytest.fixture(scope="module")
def tiles(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("tiles")
    arguments = ["batch", "--from", SAMPLE / "area.osm", "--dem", SAMPLE / "dem.tif", "--tiles", SIDE, "-o", out]
    assert main([*map(str, arguments), "--shared-frame", "-q"]) == 0
    return out


@pytest.fixture(scope="module")
def reports(tiles: Path) -> dict[str, dict[str, Any]]:
    found = {path.stem: json.loads(path.read_bytes()) for path in tiles.glob("x*.json")}
    assert len(found) >= 4
    return found


@pytest.fixture(scope="module")
def networks(tiles: Path, reports: dict[str, dict[str, Any]]) -> dict[str, XodrFile]:
    return {name: read_xodr(tiles / f"{name}.xodr") for name in reports}


def end_of(road: Road, at_start: bool) -> tuple[float, float, float, float, float]:
    """Return x, y, heading, z and grade of the reference line at an end."""
    s = np.array([0.0 if at_start else road.length])
    x, y, hdg = (float(value[0]) for value in road.pose(s))
    return x, y, hdg, float(road.elevation.value(s)[0]), float(road.elevation.slope(s)[0])


def lanes_at(road: Road, at_start: bool) -> list[tuple[int, str, float]]:
    """Return id, type and width of the lanes at an end; strips of no width count as none."""
    section = road.section(at_start)
    s = np.array([0.0 if at_start else road.length])
    found = []
    for number, lane in section.lanes.items():
        if number:
            inner, outer = section.edges(number, s)
            if abs(outer[0] - inner[0]) > 1e-3:
                found.append((number, lane.type, round(abs(float(outer[0] - inner[0])), 3)))
    return sorted(found)


def test_every_cut_road_meets_its_other_half(
    reports: dict[str, dict[str, Any]], networks: dict[str, XodrFile]
) -> None:
    halves = 0
    for name, report in reports.items():
        for end in report["border_ends"]:
            neighbour = end["neighbour"]
            if neighbour not in reports:
                assert neighbour == "", f"{neighbour} should have the other half of road {end['road']} of {name}"
                continue
            others = [item for item in reports[neighbour]["border_ends"] if item["neighbour"] == name]
            other = min(others, key=lambda item: abs(item["x"] - end["x"]) + abs(item["y"] - end["y"]))
            road = networks[name].roads[str(end["road"])]
            beyond = networks[neighbour].roads[str(other["road"])]
            one, two = end_of(road, end["at_start"]), end_of(beyond, other["at_start"])
            assert np.hypot(one[0] - two[0], one[1] - two[1]) < PLACE
            assert abs(np.angle(np.exp(1j * (one[2] - two[2])))) < HEADING
            assert abs(one[3] - two[3]) < HEIGHT
            assert one[4] == pytest.approx(two[4], abs=1e-3)
            assert end["at_start"] != other["at_start"]
            assert lanes_at(road, end["at_start"]) == lanes_at(beyond, other["at_start"])
            halves += 1
    assert halves >= 20
    assert halves % 2 == 0


def test_ids_are_unique_among_all_tiles(networks: dict[str, XodrFile]) -> None:
    ids = [int(number) for network in networks.values() for number in (*network.roads, *network.junctions)]
    assert len(ids) == len(set(ids))
    assert max(ids) < 2**31


def test_all_tiles_have_one_projection(tiles: Path, networks: dict[str, XodrFile]) -> None:
    assert len({network.georeference for network in networks.values()}) == 1
    frame = json.loads((tiles / "frame.json").read_bytes())
    assert set(networks) <= {area["name"] for area in frame["areas"]}


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The sample in one file, with its report beside it."""
    out = tmp_path_factory.mktemp("whole") / "whole.xodr"
    report = ["--report-json", out.with_suffix(".json")]
    arguments = ["convert", SAMPLE / "area.osm", "--dem", SAMPLE / "dem.tif", "-o", out, "-q", *report]
    assert main(list(map(str, arguments))) == 0
    return out


def test_each_report_tells_of_its_own_area_and_of_all_that_is_in_it(
    tiles: Path, reports: dict[str, dict[str, Any]], whole: Path
) -> None:
    """Conversions see the surroundings too, of which the neighbours tell."""
    table = json.loads((tiles / "frame.json").read_bytes())
    frame = make_frame(table["lat_0_deg"], table["lon_0_deg"])
    root = etree.parse(SAMPLE / "area.osm").getroot()
    lon_lat = {node.attrib["id"]: (node.attrib["lon"], node.attrib["lat"]) for node in root.iter("node")}
    places = np.column_stack(to_local(frame, *np.array(list(lon_lat.values()), np.float64).T))
    xy = dict(zip(lon_lat, places, strict=True))
    refs = {f"node/{number!s}": [number] for number in lon_lat}
    refs |= {f"way/{way.attrib['id']!s}": [node.attrib["ref"] for node in way.iter("nd")] for way in root.iter("way")}
    told, left_out = set(), 0
    for area in table["areas"]:
        if area["name"] not in reports:
            continue
        low, high = np.min(area["rings"][0], axis=0), np.max(area["rings"][0], axis=0)
        for item in reports[area["name"]]["diagnostics"]:
            if item["osm_id"] in refs:
                nodes = np.array([xy[number] for number in refs[item["osm_id"]]])
                assert ((low <= nodes) & (nodes <= high)).all(axis=1).any(), item
                told.add((item["code"], item["osm_id"]))
            elif item["code"] == "way-selection":
                left_out += int(item["message"].split()[0])
    diagnostics = json.loads(whole.with_suffix(".json").read_bytes())["diagnostics"]
    guessed = {(item["code"], item["osm_id"]) for item in diagnostics if item["kind"] == "guessed"}
    guessed = {item for item in guessed if item[1]}
    assert len(guessed) > 50
    # The cells in which dwellings are counted lie otherwise in another frame, which may move the edge of a town.
    missing = guessed - told
    assert {code for code, _ in missing} <= {"sidewalk"}
    assert len(missing) <= 2
    ways = sum(int(item["message"].split()[0]) for item in diagnostics if item["code"] == "way-selection")
    # Few lie in two tiles.
    assert ways <= left_out <= 1.3 * ways


def test_together_they_are_the_whole(networks: dict[str, XodrFile], whole: Path) -> None:
    """Nothing is lost at the borders and nothing is there twice."""

    def kilometres(network: XodrFile) -> float:
        return float(sum(road.length for road in network.roads.values() if not road.connecting)) / 1000.0

    expected = kilometres(read_xodr(whole))
    # Streets become smooth one by one in areas side by side, so junctions give and take a little more or less.
    assert sum(map(kilometres, networks.values())) == pytest.approx(expected, rel=5e-3)


def test_a_tile_is_what_convert_makes_of_its_cut(tiles: Path, tmp_path: Path) -> None:
    # One of those that were cut off a block that was kept.
    name = max(path.stem for path in tiles.glob("x*.xodr"))
    block = next(
        item["block"] for item in json.loads((tiles / "frame.json").read_bytes())["areas"] if item["name"] == name
    )
    cut, again = tiles / ".cuts" / f"{block}.osm.pbf", tmp_path / "again.xodr"
    arguments = ["convert", cut, "--dem", SAMPLE / "dem.tif", "--frame", tiles / "frame.json", "-o", again, "-q"]
    assert main([*map(str, arguments), "--tile", name, "--name", name]) == 0
    assert again.read_bytes() == (tiles / f"{name}.xodr").read_bytes()


def test_the_second_time_nothing_is_read_or_made(tiles: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from osm2xodr.batching import cutting

    def never(*arguments: object) -> None:
        raise AssertionError("the map was read again")

    monkeypatch.setattr(cutting, "read_source", never)
    before = {path.name: os.stat(path).st_mtime_ns for path in tiles.glob("x*")}
    arguments = ["batch", "--from", SAMPLE / "area.osm", "--dem", SAMPLE / "dem.tif", "--tiles", SIDE, "-o", tiles]
    assert main([*map(str, arguments), "--shared-frame", "-q"]) == 0
    assert {path.name: os.stat(path).st_mtime_ns for path in tiles.glob("x*")} == before


def run_apart(out: Path, monkeypatch: pytest.MonkeyPatch, *more: str) -> tuple[int, list[AreaJob]]:
    """Run the batch in this process, where blocks cannot be laid out; return its status and what was tried."""
    tried: list[AreaJob] = []

    @contextmanager
    def running(jobs: Sequence[AreaJob], workers: Workers) -> Iterator[Iterator[tuple[AreaJob, Outcome]]]:
        def outcomes() -> Iterator[tuple[AreaJob, Outcome]]:
            for job in jobs:
                tried.append(job)
                status = 1 if job.block else main(list(job.arguments))
                yield job, Outcome("no room" if status else "", apart=bool(job.block))

        yield outcomes()

    monkeypatch.setattr(workflow, "running", running)
    arguments = ["batch", "--from", SAMPLE / "area.osm", "--dem", SAMPLE / "dem.tif", "--tiles", "3km", "-o", out]
    return main([*map(str, arguments), "--shared-frame", "-q", *more]), tried


def test_tiles_of_a_block_that_fails_are_made_one_by_one(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    status, tried = run_apart(tmp_path, monkeypatch)
    blocks, alone = ([job.name for job in tried if bool(job.block) is wanted] for wanted in (True, False))
    assert status == 0
    assert blocks
    assert sorted(blocks) == sorted(alone)
    made = {path.stem for path in tmp_path.glob("x*.xodr")}
    assert made
    assert made <= set(alone)
    # They stay as they are, and one that is lost is made by itself again.
    assert run_apart(tmp_path, monkeypatch) == (0, [])
    lost = min(made)
    before = (tmp_path / f"{lost}.xodr").read_bytes()
    (tmp_path / f"{lost}.xodr").unlink()
    status, tried = run_apart(tmp_path, monkeypatch)
    if len(made) > 1:
        assert [(job.name, job.block) for job in tried] == [(lost, "")]
    assert (status, (tmp_path / f"{lost}.xodr").read_bytes()) == (0, before)


def test_no_tile_is_made_alone_beside_others_of_its_block(tiles: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """It would not fit to them."""
    name = max(path.stem for path in tiles.glob("x*.xodr"))
    kept = {path: path.read_bytes() for path in (tiles / f"{name}.xodr", tiles / f"{name}.json")}
    state = tiles / ".state" / f"{name}.json"
    kept[state] = state.read_bytes()
    (tiles / f"{name}.xodr").unlink()
    status, tried = run_apart(tiles, monkeypatch, "--tiles", SIDE)
    for path, data in kept.items():
        path.write_bytes(data)
    assert status == 1
    assert [job.name for job in tried] == [name]
