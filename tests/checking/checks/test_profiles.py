"""Profiles: grades are found where they are steepest."""

from __future__ import annotations

from pathlib import Path

import pytest
from checked import checked
from t_junction import Tree, one, sound_tree


@pytest.fixture
def tree() -> Tree:
    return sound_tree()


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "map.xodr"


def test_grades_are_found_between_records(tree: Tree, path: Path) -> None:
    elevation = one(tree, "road[@id='4']/elevationProfile/elevation")
    # Level at both ends of 40 m, and 2 + 18 % in the middle: z' = 6 h s (l - s) / l³.
    elevation.set("c", repr(3 * 5.6 / 40**2))
    elevation.set("d", repr(-2 * 5.6 / 40**3))
    found = checked(tree, path).findings
    assert [(item.rule, item.road) for item in found] == [("grade-steep", "4")]
    assert found[0].s == pytest.approx(20.0)
    assert found[0].value == pytest.approx(100 * 1.5 * 5.6 / 40)
