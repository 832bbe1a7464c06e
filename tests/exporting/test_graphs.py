"""The graph of lanes: where cars go from lane to lane, and how far."""

from __future__ import annotations

import math
from pathlib import Path

import networkx
import pytest
from t_junction import ARC, sound_map
from xodr_text import document, lane, read_text, road, section

import osm2xodr


def test_ways_through_a_junction(tmp_path: Path) -> None:
    path = tmp_path / "t.xodr"
    path.write_text(sound_map(), encoding="utf-8")
    graph = osm2xodr.read(path).to_networkx()
    # Two ways along each of roads 1 to 4, 2 with two sections, and six through the junction.
    assert len(graph) == 2 * 5 + 6
    assert set(graph.successors(("1", 0, -1))) == {("10", 0, -1), ("12", 0, -1)}
    assert set(graph.predecessors(("1", 0, 1))) == {("11", 0, -1), ("14", 0, -1)}
    assert list(graph.successors(("2", 0, -1))) == [("2", 1, -1)]
    assert list(graph.successors(("4", 0, 1))) == [("2", 1, 1)]
    route = networkx.shortest_path(graph, ("1", 0, -1), ("4", 0, -1), weight="length_m")
    assert route == [("1", 0, -1), ("10", 0, -1), ("2", 0, -1), ("2", 1, -1), ("4", 0, -1)]
    length = networkx.path_weight(graph, route, "length_m")
    assert length == pytest.approx(50.0 + 20.0 + 50.0)
    assert networkx.path_weight(graph, route, "time_s") == pytest.approx(length / (50.0 / 3.6))
    # The lane right of the reference line, to the right: 1.75 m nearer to the centre of a circle of 10 m.
    assert graph.nodes["12", 0, -1]["length_m"] == pytest.approx(ARC * 8.25 / 10.0, abs=0.05)
    assert graph.nodes["1", 0, -1] == {
        "road": "1", "road_name": "", "section": 0, "lane": -1, "lane_type": "driving", "direction": "forward",
        "s_start_m": 0.0, "s_end_m": 50.0, "length_m": pytest.approx(50.0), "speed_kmh": pytest.approx(50.0),
    }  # fmt: skip


def mark(kind: str, change: str = "") -> str:
    return f'<roadMark sOffset="0" type="{kind}"' + (f' laneChange="{change}"/>' if change else "/>")


@pytest.mark.parametrize(
    ("inner", "changes"),
    [
        (mark("broken"), {(-1, -2), (-2, -1)}),
        (mark("solid"), set()),
        (mark("solid", "both"), {(-1, -2), (-2, -1)}),
        (mark("broken", "increase"), {(-2, -1)}),
        (mark("broken", "decrease"), {(-1, -2)}),
        # For some of its length.
        (mark("solid") + mark("broken").replace('"0"', '"40"'), {(-1, -2), (-2, -1)}),
    ],
)
def test_lanes_are_changed_where_marks_let_one(inner: str, changes: set[tuple[int, int]], tmp_path: Path) -> None:
    right = lane(-1, (0, 3.0), more=inner) + lane(-2, (0, 3.0), more=mark("broken"))
    right += lane(-3, (0, 2.0), kind="biking")
    file = read_text(tmp_path, document(road("1", lanes=section(0.0, lane(1, (0, 3.0)), right))))
    graph = osm2xodr.RoadNetwork(file).to_networkx()
    # Never to lanes of the other way, nor to those that are for others.
    assert set(graph) == {("1", 0, 1), ("1", 0, -1), ("1", 0, -2)}
    found = {(one[2], other[2]): data for one, other, data in graph.edges(data=True)}
    assert found.keys() == changes
    for data in found.values():
        assert data == {"kind": "change", "length_m": 0.0, "time_s": 0.0}


def test_lanes_of_both_ways_stand_twice(tmp_path: Path) -> None:
    both = section(0.0, "", lane(-1, (0, 3.0), kind="bidirectional"))
    file = read_text(tmp_path, document(road("1", lanes=both)))
    graph = osm2xodr.RoadNetwork(file).to_networkx()
    assert set(graph) == {("1", 0, -1, "forward"), ("1", 0, -1, "backward")}
    assert math.isnan(graph.nodes["1", 0, -1, "forward"]["speed_kmh"])
