"""Records as text, and how true their numbers stay."""

from __future__ import annotations

import re
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import assume, given, settings, strategies as st
from sample_road_maps import crossing, plan_view, profile

from osm2xodr.curves.plan_views import lengths as lengths_of
from osm2xodr.xodrWriter.document import cubic_texts, plan_view_texts
from osm2xodr.xodrWriter.formatting import position


def read(text: str) -> list[dict[str, float]]:
    """Read attributes back, one dict per line."""
    return [{k: float(v) for k, v in re.findall(r'(\w+)="([^"]*)"', line)} for line in text.splitlines()]


def test_plan_view_texts() -> None:
    texts = plan_view_texts(crossing().plan_view, 0, 4)
    assert len(texts) == 4
    assert texts[0] == '<geometry s="0" x="0" y="0" hdg="0" length="100"><line/></geometry>\n'
    assert texts[1].endswith(
        '<geometry s="80" x="190" y="0" hdg="0" length="31.4159265"><arc curvature="0.05"/></geometry>\n'
    )


def test_some_curves_only() -> None:
    plan = crossing().plan_view
    assert plan_view_texts(plan, 1, 3) == plan_view_texts(plan, 0, 4)[1:3]
    assert plan_view_texts(plan, 4, 4) == []


def test_curves_without_records() -> None:
    table = profile([[], [(0.0, 1.0, 2.0, 3.0, 4.0)], []])
    assert cubic_texts(table, np.full(3, 1.0), "laneOffset", 0, 3) == [
        "",
        '<laneOffset s="0" a="1" b="2" c="3" d="4"/>\n',
        "",
    ]


def test_dust_is_swept() -> None:
    plan = plan_view([[(-1e-12, 3e-11, -2e-14, -1e-14, 5.0, 0.0)]])
    assert plan_view_texts(plan, 0, 1) == ['<geometry s="0" x="0" y="0" hdg="0" length="5"><line/></geometry>\n']
    table = profile([[(0.0, 7.0, -1e-14, 1e-17, -1e-21)]])
    assert cubic_texts(table, np.array([5.0]), "elevation", 0, 1) == ['<elevation s="0" a="7" b="0" c="0" d="0"/>\n']


def test_the_slightest_arc_stays_an_arc() -> None:
    plan = plan_view([[(0.0, 0.0, 0.0, 0.0, 5.0, 1e-15)]])
    assert '<arc curvature="1e-15"/>' in plan_view_texts(plan, 0, 1)[0]


coordinate = st.floats(min_value=-25_000.0, max_value=25_000.0)


@given(
    coordinate,
    coordinate,
    st.floats(min_value=-7.0, max_value=7.0),
    st.floats(min_value=0.01, max_value=2000.0),
)
def test_ends_of_lines_stay_within_a_micrometre(x: float, y: float, hdg: float, length: float) -> None:
    """The end that a reader computes is the end that was meant, so that records and roads touch."""
    record = read(plan_view_texts(plan_view([[(0.0, x, y, hdg, length, 0.0)]]), 0, 1)[0])[0]
    end_x = record["x"] + record["length"] * np.cos(record["hdg"])
    end_y = record["y"] + record["length"] * np.sin(record["hdg"])
    assert end_x == pytest.approx(x + length * np.cos(hdg), abs=2e-7)
    assert end_y == pytest.approx(y + length * np.sin(hdg), abs=2e-7)


@settings(max_examples=200)
@given(
    st.floats(min_value=-500.0, max_value=5000.0),
    st.floats(min_value=-0.5, max_value=0.5),
    st.floats(min_value=-0.5, max_value=0.5),
    st.floats(min_value=-200.0, max_value=200.0),
    st.floats(min_value=0.5, max_value=2000.0),
)
def test_elevation_records_meet(z: float, grade: float, grade_end: float, rise: float, length: float) -> None:
    """Height and grade at the end of a record, as read, are those that the next record starts with."""
    rise = max(min(rise, 0.5 * length), -0.5 * length)
    c = (3.0 * rise - (2.0 * grade + grade_end) * length) / length**2
    d = ((grade + grade_end) * length - 2.0 * rise) / length**3
    table = profile([[(0.0, z, grade, c, d), (length, z + rise, grade_end, 0.0, 0.0)]])
    text = cubic_texts(table, np.array([2.0 * length]), "elevation", 0, 1)[0]
    assume(text)  # A level road at height 0 has no records.
    one, two = read(text)
    ds = two["s"] - one["s"]
    height = one["a"] + ds * (one["b"] + ds * (one["c"] + ds * one["d"]))
    slope = one["b"] + ds * (2.0 * one["c"] + 3.0 * ds * one["d"])
    assert height == pytest.approx(two["a"], abs=1e-6)
    assert slope == pytest.approx(two["b"], abs=1e-6)


@given(st.lists(st.floats(min_value=1e-3, max_value=5000.0), min_size=2, max_size=20))
def test_nothing_starts_beyond_the_end_of_its_road(lengths: list[float]) -> None:
    s = np.concatenate([[0.0], np.cumsum(lengths)[:-1]])
    plan = plan_view([[(at, 0.0, 0.0, 0.0, length, 0.0) for at, length in zip(s, lengths, strict=True)]])
    total = float(position(lengths_of(plan)[0]))
    heights = profile([[(at, 1.0, 0.0, 0.0, 0.0) for at in (*s, lengths_of(plan)[0])]])
    starts = [record["s"] for record in read(cubic_texts(heights, lengths_of(plan), "elevation", 0, 1)[0])]
    assert max(starts) <= total
    assert starts == sorted(starts)
    records = read(plan_view_texts(plan, 0, 1)[0])
    for one, two in pairwise(records):
        assert one["s"] + one["length"] == pytest.approx(two["s"], abs=2e-7)


def test_profiles_that_are_zero_throughout() -> None:
    zero, late, dust = (0.0, 0.0, 0.0, 0.0, 0.0), (5.0, 0.0, 0.0, 1e-9, 0.0), (0.0, 1e-12, 0.0, 0.0, -1e-21)
    lengths = np.full(5, 100.0)
    table = profile([[], [zero], [zero, late], [dust], [(0.0, 3.0, 0.0, 0.0, 0.0)]])
    records = [text.count("<elevation ") for text in cubic_texts(table, lengths, "elevation", 0, 5)]
    assert records == [0, 0, 2, 0, 1]
    assert cubic_texts(table, lengths, "elevation", 2, 5) == cubic_texts(table, lengths, "elevation", 0, 5)[2:]


def test_spirals_have_the_curvature_at_either_end() -> None:
    plan = plan_view([[(0.0, 1.0, 2.0, 0.5, 40.0, 0.01)]])
    plan = replace(plan, rate=np.array([-0.001]))
    text = plan_view_texts(plan, 0, 1)[0]
    assert text == (
        '<geometry s="0" x="1" y="2" hdg="0.5" length="40"><spiral curvStart="0.01" curvEnd="-0.03"/></geometry>\n'
    )
