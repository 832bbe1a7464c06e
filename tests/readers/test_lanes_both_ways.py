"""The checker of ASAM takes what is driven or walked both ways for what it is, in OpenDRIVE 1.8 too."""

from __future__ import annotations

import io
from dataclasses import dataclass
from pathlib import Path

import pytest
from junction_cases import CASES
from lxml import etree
from margin_cases import BOTH, built
from real_readers import qc_result
from street_cases import Case

from osm2xodr.diagnostics import Diagnostics
from osm2xodr.model import Rule
from osm2xodr.xodrWriter import WriteOptions, write_xodr

_CROSS = CASES["x"].case
_LINKED_ONCE = "junctions.connection.one_link_to_incoming"
_CHECKER = "check_asam_xodr_junctions_connection_one_link_to_incoming"


@dataclass(frozen=True)
class Expected:
    """A case, and how many connecting roads have a lane for both directions or a sidewalk."""

    case: Case
    both: int
    sidewalks: int


# Sidewalks left of streets that lead one way lie against the only turn between their arms.
EXPECTED = {
    "centre lane": Expected(CASES["centre_lane"].case, 2, 4),
    "one way round a corner": Expected(
        Case(_CROSS.nodes, {1: ("w o", "oneway=yes"), 4: ("o n", "oneway=yes"), 3: ("s o", "")}), 0, 3
    ),
}


def _written(case: Case, rule: Rule, folder: Path, version: str = "1.8") -> Path:
    stream = io.BytesIO()
    road_map = built(case, dict.fromkeys(case.ways, BOTH), rule)
    write_xodr(road_map, stream, WriteOptions(version), Diagnostics())
    path = folder / f"{rule.value}-{version}.xodr"
    path.write_bytes(stream.getvalue())
    return path


def _through(path: Path, **attributes: str) -> int:
    """Return how many lanes with some attributes the connecting roads have."""
    return sum(
        all(lane.get(name) == value for name, value in attributes.items())
        for road in etree.parse(str(path)).getroot().iterfind("road")
        if road.get("junction") != "-1"
        for lane in road.iter("lane")
    )


@pytest.mark.parametrize("rule", list(Rule), ids=lambda rule: rule.value)
@pytest.mark.parametrize("expected", EXPECTED.values(), ids=EXPECTED)
def test_no_issue(expected: Expected, rule: Rule, tmp_path: Path) -> None:
    path = _written(expected.case, rule, tmp_path)
    assert _through(path, type="bidirectional", direction="both") == expected.both
    assert _through(path, type="sidewalk") == expected.sidewalks
    result = qc_result(path, tmp_path)
    assert result.issues == []
    assert _CHECKER in result.checkers["completed"]


def test_it_asks_for_the_direction(tmp_path: Path) -> None:
    path = _written(EXPECTED["centre lane"].case, Rule.RIGHT_HAND, tmp_path)
    path.write_text(path.read_text(encoding="utf-8").replace(' direction="both"', ""), encoding="utf-8")
    (issue,) = qc_result(path, tmp_path).issues
    assert _LINKED_ONCE in issue


@pytest.mark.parametrize("version", ["1.4", "1.6", "1.7"])
def test_earlier_versions_have_no_direction(version: str, tmp_path: Path) -> None:
    path = _written(EXPECTED["centre lane"].case, Rule.RIGHT_HAND, tmp_path, version)
    assert _through(path, type="bidirectional") == 2
    assert " direction=" not in path.read_text(encoding="utf-8")
