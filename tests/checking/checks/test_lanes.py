"""Lanes within roads: folds in curves."""

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


def test_a_fold_is_measured(tree: Tree, path: Path) -> None:
    replaced = one(tree, "road[@id='4']/planView/geometry/line")
    replaced.tag = "arc"
    replaced.set("curvature", "0.4")
    found = [item for item in checked(tree, path).findings if item.rule == "folded-lane"]
    # The left lane's border is 3.5 m from a line that turns round 2.5 m to its left.
    assert [(item.road, item.lane) for item in found] == [("4", 1)]
    assert found[0].value == pytest.approx(1.0)
