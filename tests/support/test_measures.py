"""The measures of the scenes find what is wrong, for they are only worth something if they do."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from lane_graph import LaneGraph
from tiny_map import tiny_map
from xodr_file import Geometry, XodrFile, read_xodr
from xodr_measure import (
    Figure,
    above,
    broken_references,
    length_errors,
    links_to_another_kind,
    profile_jumps,
    record_gaps,
    record_kinks,
    sections_past_the_end,
    step_figures,
)


def changed(folder: Path, old: str = "", new: str = "") -> XodrFile:
    text = tiny_map()
    assert old in text
    path = folder / "map.xodr"
    path.write_text(text.replace(old, new, 1) if old else text, encoding="utf-8")
    return read_xodr(path)


def largest(figures: list[Figure]) -> float:
    return max(f.value for f in figures)


def test_an_arc_is_where_a_circle_is() -> None:
    arc = Geometry(s=5.0, x=1.0, y=2.0, hdg=math.pi / 2, length=10.0 * math.pi, curvature=0.1)
    x, y, hdg = arc.pose(np.array([5.0, 5.0 + 5.0 * math.pi, 5.0 + 10.0 * math.pi]))
    assert x == pytest.approx([1.0, -9.0, -19.0])
    assert y == pytest.approx([2.0, 12.0, 2.0])
    assert hdg == pytest.approx([math.pi / 2, math.pi, 1.5 * math.pi])


def test_nothing_is_wrong_with_the_map(tmp_path: Path) -> None:
    network = changed(tmp_path)
    assert broken_references(network) == []
    assert largest(record_gaps(network) + record_kinks(network) + length_errors(network)) < 1e-7
    figures = step_figures(network)
    assert len(figures.centre) == 6  # two ways through, seen from both ends, and from both sides at the first
    for found in (figures.centre, figures.edge, figures.height, figures.heading, figures.grade):
        assert largest(found) < 1e-7


def test_lanes_of_a_road_lie_beside_its_line(tmp_path: Path) -> None:
    edges, hdg, grade = changed(tmp_path).roads["4"].lane_end(-1, at_start=False)
    assert edges == pytest.approx(np.array([[0.0, 0.0, 5.6], [0.0, 3.5, 5.6]]))
    assert (hdg, grade) == pytest.approx((math.pi, -0.01))


@pytest.mark.parametrize(
    ("old", "new", "figure", "size"),
    [
        ('x="-20" y="0" hdg="0"', 'x="-20" y="0.02" hdg="0"', lambda n: largest(record_gaps(n)), 0.02),
        ('x="-20" y="0" hdg="0"', 'x="-20" y="0" hdg="0.03"', lambda n: largest(record_kinks(n)), 0.03),
        ('id="2" length="50"', 'id="2" length="50.5"', lambda n: largest(length_errors(n)), 0.5),
        ('x="10" y="0" hdg="0"', 'x="10" y="0.25" hdg="0"', lambda n: largest(step_figures(n).centre), 0.25),
        ('x="10" y="0" hdg="0"', 'x="10" y="0" hdg="0.2"', lambda n: largest(step_figures(n).heading), 0.2),
        ('a="5.6"', 'a="5.7"', lambda n: largest(step_figures(n).height), 0.1),
        ('a="5.7" b="0.01"', 'a="5.7" b="0.04"', lambda n: largest(step_figures(n).grade), 0.03),
        (
            'a="5.6" b="0.01" c="0" d="0"/>',
            'a="5.6" b="0.01" c="0" d="0"/><elevation s="5" a="5.85" b="0" c="0" d="0"/>',
            lambda n: largest(profile_jumps(n)[0]),
            0.2,
        ),
    ],
)  # fmt: skip
def test_gaps_and_steps_are_found(tmp_path: Path, old: str, new: str, figure: object, size: float) -> None:
    assert callable(figure)
    assert figure(changed(tmp_path, old, new)) == pytest.approx(size, abs=1e-6)


def test_a_wider_lane_beyond_a_link_is_a_gap_of_its_edge(tmp_path: Path) -> None:
    text = tiny_map()
    head, tail = text.split('<road id="3"')
    path = tmp_path / "map.xodr"
    path.write_text(head + '<road id="3"' + tail.replace('a="3.5"', 'a="3.9"', 1), encoding="utf-8")
    figures = step_figures(read_xodr(path))
    assert largest(figures.edge) == pytest.approx(0.4)
    assert largest(figures.centre) == pytest.approx(0.2)


@pytest.mark.parametrize(
    ("old", "new", "fault"),
    [
        ('elementId="1" contactPoint', 'elementId="8" contactPoint', "road 3: names road 8, which is not there"),
        ('junction id="9"', 'junction id="2"', "id 2 is used 2 times"),
        ('junction id="9"', 'junction id="2"', "road 3: belongs to junction 9, which is not there"),
        ('<predecessor id="-1"/>', '<predecessor id="-2"/>', "road 3: lane -1 names lane -2 of road 1"),
        ('from="-1"', 'from="1"', "junction 9: connection 0 links lanes ((1, -1),), its road 3 [(-1, -1)]"),
        ('incomingRoad="2"', 'incomingRoad="1"', "junction 9: connecting road 4 does not name its incoming road 1"),
        ('road id="2"', 'road id="x"', "id x is not a number above 0"),
    ],
)  # fmt: skip
def test_broken_references_are_found(tmp_path: Path, old: str, new: str, fault: str) -> None:
    assert fault in broken_references(changed(tmp_path, old, new))


def test_lanes_that_lead_to_another_kind_are_found(tmp_path: Path) -> None:
    assert links_to_another_kind(changed(tmp_path)) == []
    text = tiny_map()
    k = text.index('type="driving"', text.index('<road id="3"'))
    path = tmp_path / "map.xodr"
    path.write_text(text[:k] + 'type="biking"' + text[k + 14 :], encoding="utf-8")
    assert links_to_another_kind(read_xodr(path)) == [
        "3:start:-1 to 1:end:-1: biking to driving",
        "3:end:-1 to 2:start:-1: biking to driving",
        "1:end:-1 to 3:start:-1: driving to biking",
    ]


def test_a_section_that_ends_past_its_road_is_found(tmp_path: Path) -> None:
    assert sections_past_the_end(changed(tmp_path)) == []
    text = tiny_map().replace('length="60.0"', 'length="842.231625369"')
    section = text[text.index('<laneSection s="0">') : text.index("</laneSection>") + len("</laneSection>")]
    text = text.replace(section, section + section.replace('s="0"', 's="225.857286096"', 1), 1)
    path = tmp_path / "map.xodr"
    path.write_text(text, encoding="utf-8")
    assert len(sections_past_the_end(read_xodr(path))) == 1


@pytest.mark.parametrize(
    ("old", "new", "complaint"),
    [
        ("<line/>", "<poly3/>", "poly3"),
        ('<lane id="1"', '<lane id="2"', "have a hole"),
        ('<lane id="-1"', '<lane id="1"', "wrong side"),
        ('<elevation s="0"', '<elevation s="1"', "start at 0"),
        ('<width sOffset="0"', '<width sOffset="0.5"', "start at 0"),
        ('b="0.01"', 'b="nan"', "b=nan"),
        ('laneSection s="0"', 'laneSection s="2"', "lane sections"),
        ("<geoReference>", '<offset x="1"/><geoReference>', "offset"),
    ],
)
def test_what_is_not_understood_is_refused(tmp_path: Path, old: str, new: str, complaint: str) -> None:
    with pytest.raises(ValueError, match=complaint):
        changed(tmp_path, old, new)


def test_places_above_a_limit_are_listed_worst_first() -> None:
    figures = [Figure(0.1, "a"), Figure(math.nan, "b"), Figure(3.0, "c"), Figure(2.0, "d")]
    assert above(figures, 1.0)[-2:] == ["c: 3", "d: 2"]
    assert len(above(figures, 1.0)) == 3


def test_one_drives_on_through_the_junction_and_back_but_not_round(tmp_path: Path) -> None:
    graph = LaneGraph(changed(tmp_path))
    assert graph.next == {("1", 0, -1): {("3", 0, -1)}, ("3", 0, -1): {("2", 0, -1)}, ("2", 0, 1): {("4", 0, -1)},
                          ("4", 0, -1): {("1", 0, 1)}}  # fmt: skip
    assert graph.ends() == {("2", 0, -1), ("1", 0, 1)}
    start = graph.lanes_at(-40.0, -1.5, 0.0)
    assert start == {("1", 0, -1)}
    assert graph.lanes_at(-40.0, -1.5, math.pi) == {("1", 0, 1)}
    assert graph.distances(start, 100.0) == {("1", 0, -1): -60.0, ("3", 0, -1): 0.0, ("2", 0, -1): 10.0}
