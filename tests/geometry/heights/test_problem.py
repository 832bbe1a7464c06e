"""The user's own grade limits."""

from __future__ import annotations

import pytest

from osm2xodr import defaults
from osm2xodr.errors import InputError
from osm2xodr.geometry.heights.problem import parse_grade_limits


def test_entries_replace_the_defaults() -> None:
    table = parse_grade_limits("motorway=0.05, residential = 12%,pedestrian=8 %")
    assert (table["motorway"], table["residential"], table["pedestrian"]) == pytest.approx((0.05, 0.12, 0.08))
    assert {name: table[name] for name in ("primary", "track")} == {
        name: defaults.GRADE_LIMIT[name] for name in ("primary", "track")
    }


@pytest.mark.parametrize(
    ("text", "part"),
    [
        ("", "is not class=limit"),
        ("motorway", "'motorway' is not class=limit"),
        ("motorway=", "is not class=limit"),
        ("=0.05", "is not class=limit"),
        ("motorway=0.05,,primary=0.1", "'' is not class=limit"),
        ("autobahn=0.05", "'autobahn': no such class of roads; choose from"),
        ("motorway=0.05,motorway=0.06", "is given twice"),
        ("motorway=steep", "'steep' is not a number"),
        ("motorway=5", "not between 0.005 and 0.31"),
        ("motorway=0", "not between 0.005 and 0.31"),
        ("motorway=nan", "not between"),
        ("motorway=-0.05", "not between"),
    ],
)
def test_what_is_no_table_is_refused(text: str, part: str) -> None:
    with pytest.raises(InputError, match="max grade") as caught:
        parse_grade_limits(text)
    assert part in str(caught.value)
