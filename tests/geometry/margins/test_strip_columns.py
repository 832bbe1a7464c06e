"""Which strips along a road become one lane."""

from __future__ import annotations

from dataclasses import replace

from margin_cases import PARKING, TRACK, VERGE, WALK, Strips

from osm2xodr.geometry.margins.strip_columns import columns_of
from osm2xodr.geometry.margins.strips import MarginStretch
from osm2xodr.model import MarginSpec


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
