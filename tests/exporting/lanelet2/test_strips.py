"""Strips of small roads: where lanelets are cut, what is merged, how borders fold."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from xodr_text import LINE, cubics, document, geometry, lane, read_text, road, section

from osm2xodr.exporting.lanelet2.strips import Cut, cut_into_strips

LINKED = "<link><predecessor id='-1'/><successor id='-1'/></link>"


def strips(folder: Path, text: str) -> Cut:
    return cut_into_strips(read_text(folder, document(road(lanes=text))), 0.05, 10.0)


def spans(cut: Cut) -> list[tuple[float, float]]:
    return [(round(strip.s[0], 6), round(strip.s[1], 6)) for strip in cut.strips]


def test_sections_along_which_nothing_changes_are_one_strip(tmp_path: Path) -> None:
    lanes = section(0.0, right=lane(-1, (0, 3.0), more=LINKED)) + section(40.0, right=lane(-1, (0, 3.0), more=LINKED))
    cut = strips(tmp_path, lanes)
    assert spans(cut) == [(0, 100)]
    line = cut.line(cut.strips[0], 0)
    # No point twice where the sections meet.
    assert (np.diff(line[:, 0]) > 0).all()
    assert (line[0, 0], line[-1, 0]) == (0, 100)


@pytest.mark.parametrize("change", ["no link", "another type", "another limit"])
def test_a_change_begins_a_strip(tmp_path: Path, change: str) -> None:
    more = {"another limit": LINKED + '<speed sOffset="0" max="30" unit="km/h"/>'}.get(change, LINKED)
    kind = "bus" if change == "another type" else "driving"
    first = "" if change == "no link" else LINKED
    second = "" if change == "no link" else more
    lanes = section(0.0, right=lane(-1, (0, 3.0), more=first)) + section(
        40.0, right=lane(-1, (0, 3.0), more=second, kind=kind)
    )
    assert spans(strips(tmp_path, lanes)) == [(0, 40), (40, 100)]


def test_long_ones_are_divided(tmp_path: Path) -> None:
    def of(length: float, lanes: str) -> list[tuple[float, float]]:
        text = document(road("1", geometry(LINE, length), length=length, lanes=lanes))
        return spans(cut_into_strips(read_text(tmp_path, text), 0.05, 10.0))

    one = section(0.0, right=lane(-1, (0, 3.0), more=LINKED))
    assert of(200.0, one) == [(0, 200)]
    assert of(480.0, one) == [(0, 160), (160, 320), (320, 480)]
    # Where sections meet that are too long together.
    assert of(320.0, one + section(180.0, right=lane(-1, (0, 3.0), more=LINKED))) == [(0, 180), (180, 320)]


def test_hairpins_are_divided(tmp_path: Path) -> None:
    # Half a circle of 20 m radius, and 20 m more.
    turn = math.pi * 20.0
    plan = geometry('<arc curvature="0.05"/>', turn) + geometry(LINE, 20.0, s=turn, x=0.0, y=40.0, hdg=math.pi)
    lanes = section(0.0, right=lane(-1, (0, 3.0), more=LINKED))
    cut = cut_into_strips(read_text(tmp_path, document(road("1", plan, length=turn + 20.0, lanes=lanes))), 0.05, 2.0)
    (_, middle), (again, end) = spans(cut)
    assert middle == again
    # 1.41 times as much as may be: half of it lies where the road has turned by 97 degrees.
    assert middle == pytest.approx(0.5 * (turn / 200.0 + 1.0 + 0.1) / (1.0 / 200.0 + 0.05 / math.pi), abs=2.0)
    assert end == pytest.approx(turn + 20.0)


def test_a_mark_that_changes_within_a_section_begins_a_strip(tmp_path: Path) -> None:
    marks = '<roadMark sOffset="0" type="solid"/><roadMark sOffset="33.5" type="broken"/>'
    lanes = section(0.0, right=lane(-1, (0, 3.0), more=marks) + lane(-2, (0, 3.0)))
    cut = strips(tmp_path, lanes)
    assert spans(cut) == [(0, 33.5), (33.5, 100)]
    assert [dict(strip.words.marks)[1].subtype for strip in cut.strips] == ["solid", "dashed"]


def test_lanes_are_left_out_where_they_have_no_width(tmp_path: Path) -> None:
    lanes = section(0.0, right=lane(-1, (0, 3.0)) + lane(-2, (0, 2.0), (30, 0.0), (60, 0.0, 0.05)))
    cut = strips(tmp_path, lanes)
    assert spans(cut) == [(0, 30), (30, 60), (60, 100)]
    assert [[one.id for one in strip.words.lanes] for strip in cut.strips] == [[-1, -2], [-1], [-1, -2]]


def test_lanes_without_a_word_in_lanelet2_are_left_out(tmp_path: Path) -> None:
    lanes = section(0.0, right=lane(-1, (0, 3.0)) + lane(-2, (0, 1.0), kind="parking"))
    (strip,) = strips(tmp_path, lanes).strips
    assert [one.id for one in strip.words.lanes] == [-1]
    assert [border for border, _ in strip.words.marks] == [0, 1]
    # An edge without a mark ends the road.
    assert dict(strip.words.marks)[1].type == "road_border"


def test_limits_come_from_the_road_where_lanes_have_none(tmp_path: Path) -> None:
    types = (
        '<type s="0" type="town"><speed max="50" unit="km/h"/></type>'
        '<type s="70" type="rural"><speed max="100" unit="km/h"/></type>'
    )
    cut = cut_into_strips(read_text(tmp_path, document(road(more=types))), 0.05, 10.0)
    assert spans(cut) == [(0, 70), (70, 100)]
    assert [strip.words.location for strip in cut.strips] == ["urban", "nonurban"]
    assert [strip.words.lanes[0].speed * 3.6 for strip in cut.strips] == pytest.approx([50, 100])


def test_borders_beyond_the_centre_of_a_bend_do_not_run_back(tmp_path: Path) -> None:
    # A bend of 4 m radius with a lane of 6 m on its inside, between straight lines.
    turn = 2 * np.pi
    plan = (
        geometry("<line/>", 10.0)
        + geometry('<arc curvature="0.25"/>', turn, 10.0, 10.0)
        + geometry("<line/>", 10.0, 10.0 + turn, 14.0, 4.0, np.pi / 2)
    )
    lanes = section(0.0, lane(1, (0, 6.0)))
    text = document(road(plan=plan, length=20.0 + turn, lanes=lanes, elevation=cubics("elevation", (0, 5.0))))
    cut = cut_into_strips(read_text(tmp_path, text), 0.05, 10.0)
    inner, outer = (cut.line(cut.strips[0], border)[:, :2] for border in (0, 1))
    np.testing.assert_allclose(inner[[0, -1]], [[0, 6], [8, 14]], atol=1e-5)
    # Nothing turns by more than the road does, where the border as it is would turn back.
    steps = np.diff(inner, axis=0)
    assert (steps @ np.array([1.0, 1.0]) >= -1e-9).all()
    assert len(outer) > len(inner)
