"""The user's own grade limits."""

from __future__ import annotations

import numpy as np
import pytest
from elevation_helpers import make_problem, straight

from osm2xodr import defaults
from osm2xodr.errors import InputError
from osm2xodr.geometry.heights.problem import end_spans, span_at, span_roads
from osm2xodr.geometry.options import parse_grade_limits


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
        ("motorway=0.05=0.06", "'0.05=0.06' is not a number"),
        ("motorway=0.0049", "0.0049 is not between 0.005 and 0.31"),
        ("motorway=31.1%", "31.1% is not between 0.005 and 0.31"),
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


def test_bounds_of_limits_are_allowed() -> None:
    table = parse_grade_limits("motorway=0.005,track=0.31,road=0.5%")
    assert (table["motorway"], table["track"], table["road"]) == (0.005, 0.31, 0.005)


def test_refusals_say_what_is_wrong_and_how_to_write_it() -> None:
    classes = ", ".join(sorted({*defaults.GRADE_LIMIT, "busway", "pedestrian", "raceway", "road"}))
    for text, message in (
        (" autobahn = 0.05", f"max grade for 'autobahn': no such class of roads; choose from {classes}"),
        (" motorway ", "max grade 'motorway' is not class=limit; write e.g. motorway=0.05,residential=12%"),
        ("motorway=0.05,motorway=1%", "max grade for 'motorway' is given twice; give it once"),
        ("road=steep", "max grade for 'road': 'steep' is not a number; write e.g. 0.08 or 8%"),
        ("road=8", "max grade for 'road': 8 is not between 0.005 and 0.31; write rise per metre, e.g. 0.08, or 8%"),
    ):
        with pytest.raises(InputError) as caught:
            parse_grade_limits(text)
        assert str(caught.value) == message


def test_spans_along_and_at_the_ends_of_roads() -> None:
    """Of the second of three roads, which has three spans, from 0, 20 and 50 m on."""
    spans = [(0.0, 0, 0), (20.0, 1, 1), (50.0, 0, 0)]
    roads = [straight((0.0, y), (90.0, y), spans=spans if y == 9.0 else spans[:1]) for y in (0.0, 9.0, 18.0)]
    problem = make_problem(roads)
    road, s = np.array([0, 1, 1, 1, 1, 2]), np.array([60.0, 0.0, 19.9, 20.0, 90.0, 0.0])
    assert span_at(problem, road, s).tolist() == [0, 1, 1, 2, 3, 4]
    assert end_spans(problem).tolist() == [[0, 0], [1, 3], [4, 4]]
    assert span_roads(problem).tolist() == [0, 1, 1, 1, 2]
