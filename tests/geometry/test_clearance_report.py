"""Carriageways that come too close above each other: what is reported is what `check` finds."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from elevation_helpers import Ground
from osm_builder import ROAD, Area, about

from osm2xodr.checking import CheckOptions, CheckResult, check_file
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.geometry import ElevationOptions, build_roads, clearance_report
from osm2xodr.model import RoadLink, RoadMap
from osm2xodr.xodrWriter import WriteOptions, write_xodr

LEVEL = Ground(lambda x, y: 0.0 * x)
HILLS = Ground(lambda x, y: 300.0 + 0.01 * x + 0.002 * np.abs(y), cell_size=5.0, sigma=0.5)
BRIDGE = f"{ROAD} bridge=yes"


def built(
    area: Area, folder: Path, ground: Ground = HILLS, options: ElevationOptions | None = None
) -> tuple[RoadMap, Diagnostics, CheckResult]:
    """Return the road map of an area, what was said about it, and what `check` finds in its file."""
    network, _ = area.parse(folder)
    diagnostics = Diagnostics()
    road_map = build_roads(network, ground, diagnostics, options)
    path = folder / "area.xodr"
    with path.open("wb") as file:
        write_xodr(road_map, file, WriteOptions(), Diagnostics())
    return road_map, diagnostics, check_file(path, CheckOptions(only=("clearance",), ignore=()))


def crossing(tags: str, *, fork: float = 0.0) -> Area:
    """Return a road of 600 m that one with these tags crosses; another begins so far from there, m, if not 0."""
    nodes = {1: (-300.0, 0.0), 2: (fork, 0.0), 3: (300.0, 0.0), 4: (0.0, -300.0), 5: (0.0, -60.0), 6: (0.0, 60.0)}
    nodes |= {7: (0.0, 300.0), 8: (200.0, 150.0)}
    across = {20: ([4, 5], ROAD), 21: ([5, 6], tags), 22: ([6, 7], ROAD)}
    branch = {23: ([2, 8], ROAD)} if fork else {}
    return Area(nodes, {10: ([1, 2, 3], ROAD)} | across | branch)


def replace_way(area: Area, way: int, tags: str) -> Area:
    """Return an area with other tags of a way."""
    return replace(area, ways={**area.ways, way: (area.ways[way][0], tags)})


@pytest.mark.parametrize("fork", [0.0, 0.1])
def test_bridge_passes_over_a_road_and_over_a_junction(tmp_path: Path, fork: float) -> None:
    road_map, diagnostics, result = built(crossing(BRIDGE, fork=fork), tmp_path)
    assert about(diagnostics, "clearance") == []
    assert result.findings == ()
    assert road_map.statistics["layer_crossings"] >= 1.0
    assert road_map.statistics["layer_crossings_too_close"] == 0.0


def test_junction_passes_below_a_street_as_its_ways_do_though_an_arm_is_a_bridge(tmp_path: Path) -> None:
    # A viaduct comes down into a tunnel and merges there with a ramp that runs beside it; a street passes over both.
    lanes = "highway=trunk oneway=yes lanes=2 width=6"
    nodes = {1: (-400.0, 6.4), 2: (-75.0, 6.4), 3: (-68.0, 6.3), 4: (-60.0, 6.1), 5: (0.0, 0.0), 6: (-400.0, -20.0)}
    nodes |= {7: (-200.0, 0.0), 8: (-60.0, 0.0), 9: (200.0, 0.0), 10: (500.0, 0.0)}
    nodes |= {11: (-35.0, -200.0), 12: (-35.0, 200.0)}
    ways = {
        20: ([1, 2, 3], f"{lanes} bridge=yes layer=1"),
        21: ([3, 4], lanes),
        22: ([4, 5], f"{lanes} tunnel=yes layer=-1"),
        23: ([6, 7, 8], lanes),
        24: ([8, 5], f"{lanes} tunnel=yes layer=-1"),
        25: ([5, 9], f"{lanes} tunnel=yes layer=-2"),
        26: ([9, 10], lanes),
        27: ([11, 12], "highway=primary oneway=yes lanes=2"),
    }
    road_map, diagnostics, result = built(Area(nodes, ways), tmp_path, LEVEL)
    assert about(diagnostics, "clearance") == []
    assert result.findings == ()
    assert road_map.statistics["layer_crossings"] == 1.0
    # Of both ramps: 5.2 m over 200 m, and the crests at both ends.
    assert road_map.statistics["grade_max"] < 0.05


def test_sign_on_the_road_below_a_bridge_counts(tmp_path: Path) -> None:
    low, high = (replace_way(crossing(BRIDGE), 10, f"{ROAD} maxheight={text}") for text in ("3.5", "6.3"))
    gaps = []
    for area in (low, high):
        report = built(area, tmp_path)[0].elevation_report
        assert report is not None
        gaps += [item.clearance for item in report.structures]
    assert gaps == pytest.approx([4.2, 7.0], abs=0.1)


def test_what_a_low_sign_leaves_is_reported_as_such(tmp_path: Path) -> None:
    _, diagnostics, result = built(replace_way(crossing(BRIDGE), 10, f"{ROAD} maxheight=2.5"), tmp_path)
    (note,) = about(diagnostics, "clearance")
    assert note.osm_id == "way/21"
    gap = float(note.message.split()[2])
    assert gap == pytest.approx(3.2, abs=0.1)
    assert note.message.endswith("above way/10: 3.2 m are enough there, by its maxheight or a correction")
    (finding,) = result.findings
    assert finding.value == pytest.approx(gap, abs=0.05)


def test_junction_below_a_bridge_lies_inside_of_it(tmp_path: Path) -> None:
    # The bridge crosses connecting roads only: those of the junction right below it.
    road_map, _, _ = built(crossing(BRIDGE, fork=0.1), tmp_path)
    through = [road.id for road in road_map.roads if road.junction is not None]
    assert road_map.elevation_report is not None
    (deck,) = [item for item in road_map.elevation_report.structures if item.kind == "bridge"]
    assert deck.clearance is not None
    assert 5.0 < deck.clearance < 6.5
    assert deck.crossed_way in (10, 23)
    assert len(through) >= 4


def test_roads_that_cross_on_one_layer_are_reported_with_the_reason(tmp_path: Path) -> None:
    road_map, diagnostics, result = built(crossing(ROAD), tmp_path)
    assert about(diagnostics, "clearance") == []
    (note,) = about(diagnostics, "crossing-without-node")
    assert {note.osm_id, *(word.rstrip(":") for word in note.message.split() if "way/" in word)} == {
        "way/10",
        "way/21",
    }
    assert note.message.endswith("both are on one layer and have no node in common there")
    (finding,) = result.findings
    assert road_map.elevation_report is not None
    (tight,) = road_map.elevation_report.tight
    assert {tight.upper_way, tight.lower_way} == {10, 21}
    assert {str(tight.upper), str(tight.lower)} == {finding.road, finding.text.split()[-1]}
    assert finding.value == pytest.approx(tight.clearance, abs=1e-3)
    assert tight.wanted == 4.0
    assert road_map.statistics["layer_crossings_too_close"] == 1.0


def test_what_the_solve_could_not_keep_apart_is_reported_once(tmp_path: Path) -> None:
    # The road below a short bridge ends on both sides at streets that a precise model shows level with it.
    near = {1: (-300.0, 0.0), 2: (-11.0, 0.0), 3: (11.0, 0.0), 4: (300.0, 0.0), 5: (0.0, -11.0), 6: (0.0, 11.0)}
    near |= {7: (-300.0, -11.0), 8: (300.0, -11.0), 9: (-300.0, 60.0), 10: (300.0, 60.0), 11: (0.0, 60.0)}
    ways = {1: ([1, 2], ROAD), 2: ([2, 3], BRIDGE), 3: ([3, 4], ROAD), 4: ([7, 5, 8], ROAD), 5: ([5, 6, 11], ROAD)}
    ways |= {6: ([9, 11, 10], ROAD)}
    exact = Ground(lambda x, y: 300.0 + 0.001 * x, cell_size=1.0, sigma=0.02)
    road_map, diagnostics, result = built(Area(near, ways), tmp_path, exact)
    notes = about(diagnostics, "clearance")
    assert road_map.elevation_report is not None
    pairs = [frozenset((item.upper, item.lower)) for item in road_map.elevation_report.tight]
    assert len(pairs) == len(set(pairs)) == road_map.statistics["layer_crossings_too_close"] == len(notes)
    for finding in result.findings:
        assert frozenset((int(finding.road), int(finding.text.split()[-1]))) in pairs


def test_bridges_of_a_level_world_keep_clear(tmp_path: Path) -> None:
    road_map, diagnostics, result = built(crossing(BRIDGE), tmp_path, LEVEL)
    assert about(diagnostics, "clearance") == []
    assert result.findings == ()
    assert road_map.statistics["layer_crossings"] == 1.0


def test_without_structures_bridges_of_a_level_world_are_reported_as_such(tmp_path: Path) -> None:
    options = ElevationOptions(structures=False)
    road_map, diagnostics, result = built(crossing(BRIDGE), tmp_path, LEVEL, options)
    (note,) = about(diagnostics, "clearance")
    assert note.message.startswith("it passes at the height of way/")
    assert note.message.endswith("all ground is at one height")
    assert len(result.findings) == 1
    assert road_map.elevation_report is None


def test_streets_that_cross_without_a_node_are_level_there(tmp_path: Path) -> None:
    """On this ground they would be 0.5 m apart, as the model errs."""
    steps = Ground(lambda x, y: 300.0 + np.where(np.abs(x) < 40.0, 0.0, 0.5), cell_size=30.0, sigma=3.0)
    road_map, diagnostics, _ = built(crossing(ROAD), tmp_path, steps)
    assert len(about(diagnostics, "crossing-without-node")) == 1
    assert road_map.elevation_report is not None
    (tight,) = road_map.elevation_report.tight
    assert tight.clearance < 0.15


def test_roads_whose_edges_alone_overlap_are_no_crossing(tmp_path: Path) -> None:
    nodes = {1: (-300.0, 0.0), 2: (300.0, 0.0), 3: (-300.0, 2.0), 4: (300.0, 2.0)}
    _, diagnostics, result = built(Area(nodes, {10: ([1, 2], ROAD), 11: ([3, 4], ROAD)}), tmp_path)
    assert about(diagnostics, "crossing-without-node") == about(diagnostics, "clearance") == []
    (note,) = about(diagnostics, "carriageways-overlap")
    assert note.message.endswith("in OSM their lines are 2.0 m apart and do not cross")
    assert len(result.findings) == 1


def test_nodes_at_one_place_that_are_not_one_are_a_crossing_without_a_node(tmp_path: Path) -> None:
    area = crossing(ROAD)
    twin = replace(area, nodes={**area.nodes, 9: (0.0, 0.0)}, ways={**area.ways, 21: ([5, 9, 6], ROAD)})
    _, diagnostics, _ = built(twin, tmp_path)
    assert len(about(diagnostics, "crossing-without-node")) == 1


def test_streets_that_meet_a_kilometre_away_cross_without_a_node_here(tmp_path: Path) -> None:
    nodes = {1: (-300.0, 0.0), 2: (300.0, 0.0), 3: (1000.0, 0.0), 4: (1000.0, 300.0), 5: (0.0, 300.0)}
    nodes |= {6: (0.0, -300.0)}
    ways = {10: ([1, 2, 3], ROAD), 11: ([3, 4, 5, 6], ROAD)}
    _, diagnostics, _ = built(Area(nodes, ways), tmp_path)
    assert len(about(diagnostics, "crossing-without-node")) == 1


def test_one_ways_that_meet_head_on_are_linked_and_do_not_overlap(tmp_path: Path) -> None:
    """A short piece of a one-way street, at a slight bend, has the wrong direction."""
    nodes = {1: (0.0, 0.0), 2: (80.0, 0.0), 3: (95.0, 2.0), 4: (200.0, 0.0)}
    one_way = "highway=secondary oneway=yes"
    ways = {10: ([1, 2], one_way), 11: ([2, 3], one_way.replace("yes", "-1")), 12: ([3, 4], one_way)}
    road_map, diagnostics, result = built(Area(nodes, ways), tmp_path, LEVEL)
    assert result.findings == ()
    assert about(diagnostics, "carriageways-overlap") == about(diagnostics, "clearance") == []
    first, middle, last = road_map.roads
    assert (first.successor, middle.successor) == (RoadLink(False, 2, False), RoadLink(False, 1, False))
    assert (middle.predecessor, last.predecessor) == (RoadLink(False, 3, True), RoadLink(False, 2, True))
    lanes = [lane for road in road_map.roads for section in road.lane_sections for lane in section.lanes]
    assert [(lane.predecessor, lane.successor) for lane in lanes] == [(None, None)] * len(lanes)


def test_roads_may_be_worked_out_in_any_number_of_blocks(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    whole = built(crossing(ROAD), tmp_path, LEVEL)[1]
    monkeypatch.setattr(clearance_report, "_STATIONS_AT_ONCE", 1)
    blocks = built(crossing(ROAD), tmp_path, LEVEL)[1]
    assert len(about(whole, "crossing-without-node")) == 1
    assert list(blocks) == list(whole)
