"""Which strips along a road become one lane."""

from __future__ import annotations

from dataclasses import replace

import pytest
from margin_cases import PARKING, TRACK, VERGE, WALK, Strips
from road_measures import width_at

from osm2xodr.geometry.roadside.strip_columns import columns_of, present, widths_of
from osm2xodr.geometry.roadside.strips import MarginStretch, Notch
from osm2xodr.model import LaneType, MarginSpec


def test_strips_are_matched_by_kind_and_order() -> None:
    def columns(*strips: Strips) -> list[tuple[MarginSpec | None, ...]]:
        pieces = tuple(MarginStretch(100.0 * k, 100.0 * (k + 1), (), item, k) for k, item in enumerate(strips))
        return [column.strips for column in columns_of(pieces, -1)]

    low = replace(WALK, height=0.0)
    assert columns((PARKING, WALK), (VERGE, WALK)) == [(None, VERGE), (PARKING, None), (WALK, WALK)]
    assert columns((VERGE, TRACK, VERGE, WALK), (VERGE, WALK)) == [
        (VERGE, VERGE),
        (TRACK, None),
        (VERGE, None),
        (WALK, WALK),
    ]
    assert columns((TRACK,), (WALK,)) == [(None, WALK), (TRACK, None)]
    assert columns((WALK,), (), (WALK,)) == [(WALK, None, WALK)]
    assert columns((WALK,), (low,)) == [(None, low), (WALK, None)]


def test_room_that_nobody_parks_in_opens_where_parking_closes_and_closes_where_it_opens() -> None:
    free = MarginSpec(LaneType.RESTRICTED, PARKING.width)
    ends = [(0.0, 50.0), (50.0, 60.0), (60.0, 100.0)]
    strips = ((PARKING, WALK), (free, WALK), (PARKING, WALK))
    margins = tuple(MarginStretch(*end, (), strip, 1) for end, strip in zip(ends, strips, strict=True))
    columns = columns_of(margins, -1)
    by_type = {column.kind.type: widths_of(column, margins) for column in columns}
    assert list(by_type) == [LaneType.RESTRICTED, LaneType.PARKING, LaneType.SIDEWALK]
    inner = [
        [width_at(by_type[kind], s) for kind in list(by_type)[:2]] for s in (44.0, 47.0, 50.0, 55.5, 57.75, 60.0)
    ]
    full = PARKING.width
    half = [full / 2, full / 2]
    assert inner == [pytest.approx(pair) for pair in ([0, full], half, [full, 0], [full, 0], half, [0, full])]
    for k in range(1001):
        assert width_at(by_type[LaneType.RESTRICTED], 0.1 * k) + width_at(by_type[LaneType.PARKING], 0.1 * k) == (
            pytest.approx(full)
        )
    # It is in all sections in which it has any width.
    assert [len(present(columns, margins, *end)) for end in ends] == [3, 3, 2]
    assert [len(present(columns, margins, *end)) for end in ((0.0, 40.0), (40.0, 50.0))] == [3, 3]


def test_a_strip_that_ends_in_a_notch_ends_where_it_did() -> None:
    notch = Notch(1, 45.0, 45.0, 0.5, 0.1, 0.1)
    margins = (MarginStretch(0.0, 50.0, (WALK,), (), 1, notches=(notch,)), MarginStretch(50.0, 100.0, (), (), 1))
    (column,) = columns_of(margins, 1)
    widths = widths_of(column, margins)
    assert [round(width_at(widths, s), 6) for s in (20.0, 30.0, 40.0, 45.0, 50.0, 60.0, 100.0)] == [
        *(2.0, 2.0, 1.0, 0.5),
        *(0.0, 0.0, 0.0),
    ]
    places = [0.25 * k for k in range(401)]
    assert min(width_at(widths, s) for s in places) > -1e-9
    assert max(width_at(widths, s) - notch.reach_at(s) for s in places) < 1e-9


def test_a_notch_ends_where_the_road_does() -> None:
    notch = Notch(1, 5.0, 5.0, 0.5, 0.25, 0.25)
    wide = replace(WALK, width=4.0)
    margins = (MarginStretch(0.0, 10.0, (WALK,), (), 1, notches=(notch,)), MarginStretch(10.0, 12.0, (wide,), (), 1))
    (column,) = columns_of(margins, 1)
    widths = widths_of(column, margins)
    assert [width_at(widths, s) for s in (0.0, 5.0, 10.0)] == [1.75, 0.5, 1.75]
