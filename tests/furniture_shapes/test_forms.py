"""Outlines of arrows and signs."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from xodr_text import document, read_text, road

from osm2xodr.furniture_shapes import forms, placed_objects

WHITE = forms.WHITE


def test_arrows_point_where_they_say() -> None:
    straight = np.concatenate(forms.arrow("arrowStraight", 5.0))
    assert (straight[:, 0].min(), straight[:, 0].max()) == (-2.5, 2.5)
    assert np.abs(straight[:, 1]).max() < 0.5
    left = np.concatenate(forms.arrow("arrowLeft", 5.0))
    right = np.concatenate(forms.arrow("arrowRight", 5.0))
    assert left[:, 1].max() > 0.7 > 0.2 > -left[:, 1].min()
    assert sorted(map(tuple, left.round(9).tolist())) == sorted((u, -v + 0.0) for u, v in right.round(9).tolist())
    both = np.concatenate(forms.arrow("arrowLeftStraight", 5.0))
    assert both[:, 0].max() == 2.5
    assert both[:, 1].max() > 0.7


@pytest.mark.parametrize(
    ("kind", "name", "colours"),
    [
        ("206", "", {forms.RED, WHITE}),
        ("R1-1", "stop", {forms.RED, WHITE}),
        ("205", "", {forms.RED, WHITE}),
        ("274", "maxspeed", {forms.RED, WHITE}),
        ("306", "", {forms.AMBER, WHITE}),
        ("310", "city_limit", {forms.AMBER}),
        ("999", "", {forms.BLUE, WHITE}),
    ],
)
def test_faces_of_signs(kind: str, name: str, colours: set[str]) -> None:
    assert {colour for _, colour in forms.sign_symbol(kind, name)} == colours


def test_marks_are_lines_beside_a_border() -> None:
    assert forms.mark_pattern("broken", 2, WHITE) == [(0.0, True, WHITE)]
    assert forms.mark_pattern("solid", 1, "#e8b400") == [(0.0, False, "#e8b400")]
    # The first word is the left line; double lines are 0.28 m apart.
    assert forms.mark_pattern("solid broken", 1, WHITE) == [(-0.14, False, WHITE), (0.14, True, WHITE)]
    assert forms.mark_pattern("botts dots", 2, WHITE) == [(0.0, True, WHITE)]
    # A kerb is grey whatever colour it has; grass is not painted.
    assert forms.mark_pattern("curb", 1, WHITE) == [(0.0, False, "#8c8a84")]
    assert forms.mark_pattern("grass", 1, WHITE) == forms.mark_pattern("none", 0, WHITE) == []


@pytest.mark.parametrize(
    ("attributes", "outlined"),
    [
        ('type="-1"', True),
        ("", True),
        ('type="none" height="0.0"', True),
        ('type="-1" height="2.0"', False),
        ('type="patch"', False),
        ('type="van"', False),
    ],
)
def test_flat_objects_of_unknown_type_are_outlined(tmp_path: Path, attributes: str, outlined: bool) -> None:
    thing = f'<objects><object id="1" s="50" t="0" length="4" width="2" {attributes}/></objects>'
    text = document(road().replace("</road>", f"{thing}</road>"))
    (placed,) = placed_objects(read_text(tmp_path, text))
    found = list(forms.forms_of(placed))
    assert forms.is_decal(placed) == outlined
    if outlined:
        assert {type(form) for form in found} == {forms.Stroke}
        assert len(found) == 4
    else:
        assert {type(form) for form in found} == {forms.Area}


def test_crosswalks_of_damaged_widths_have_no_bars() -> None:
    assert len(forms.bars([(0.0, 0.0), (3.0, 0.0), (3.0, 900.0), (0.0, 900.0)])) == 900
    for width in (1e5, float("inf")):
        corners = [(0.0, 0.0), (3.0, 0.0), (3.0, width), (0.0, width)]
        assert forms.bars(corners) == [corners]
