"""Plan views: gaps between records are measured, and are errors if large.

Profiles: grades are found where they are steepest.

Lanes within roads: folds in curves.
"""

from __future__ import annotations

from pathlib import Path

import pytest
from checked import checked
from t_junction import Tree, one, sound_tree

from osm2xodr.checking import Severity


@pytest.fixture
def tree() -> Tree:
    return sound_tree()


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "map.xodr"


def test_a_gap_is_measured_where_it_is(tree: Tree, path: Path) -> None:
    one(tree, "road[@id='1']/planView/geometry[@s='30.0']").set("y", "0.25")
    found = [item for item in checked(tree, path).findings if item.rule == "record-gap"]
    assert len(found) == 1
    finding = found[0]
    assert (finding.road, finding.lane, finding.severity) == ("1", None, Severity.ERROR)
    assert finding.s == 30.0
    assert (finding.x, finding.y) == (-30.0, 0.25)
    assert finding.value == pytest.approx(0.25)
    assert finding.limit == 0.01
    assert finding.text == "the record begins 0.25 m away from the end of the previous one"
    # 30 m west of the origin at 49 N, 11 E: a metre of longitude there is 1 / 73172 degrees.
    assert finding.lat == pytest.approx(49 + 0.25 / 111229, abs=1e-7)
    assert finding.lon == pytest.approx(11 - 30 / 73172, abs=1e-6)
    text = path.read_text().splitlines()[finding.line - 1]
    assert '<geometry s="30.0"' in text


def test_small_gaps_are_warnings_and_large_ones_errors(tree: Tree, path: Path) -> None:
    geometry = one(tree, "road[@id='1']/planView/geometry[@s='30.0']")
    severities = []
    for gap in ("0.005", "0.02", "0.2"):
        geometry.set("y", gap)
        counts = checked(tree, path, only=("record-gap",), ignore=()).counts
        severities.append([item.severity for item in counts])
    assert severities == [[], [Severity.WARNING], [Severity.ERROR]]


def test_grades_are_found_between_records(tree: Tree, path: Path) -> None:
    elevation = one(tree, "road[@id='4']/elevationProfile/elevation")
    # Level at both ends of 40 m, and 2 + 18 % in the middle: z' = 6 h s (l - s) / l³.
    elevation.set("c", repr(3 * 5.6 / 40**2))
    elevation.set("d", repr(-2 * 5.6 / 40**3))
    found = checked(tree, path).findings
    assert [(item.rule, item.road) for item in found] == [("grade-steep", "4")]
    assert found[0].s == pytest.approx(20.0)
    assert found[0].value == pytest.approx(100 * 1.5 * 5.6 / 40)


def test_a_fold_is_measured(tree: Tree, path: Path) -> None:
    replaced = one(tree, "road[@id='4']/planView/geometry/line")
    replaced.tag = "arc"
    replaced.set("curvature", "0.4")
    found = [item for item in checked(tree, path).findings if item.rule == "folded-lane"]
    # The left lane's border is 3.5 m from a line that turns round 2.5 m to its left.
    assert [(item.road, item.lane) for item in found] == [("4", 1)]
    assert found[0].value == pytest.approx(1.0)
