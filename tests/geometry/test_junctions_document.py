"""The document of the method names every number of junctions and connecting roads, with its current value."""

from __future__ import annotations

import ast
import importlib
import math
import re
from pathlib import Path

import pytest

from osm2xodr import defaults as shared
from osm2xodr.conventions import priority_rank, ranks_at_junction
from osm2xodr.geometry import defaults as geometry
from osm2xodr.geometry.plan_view import defaults as plan_view

ROOT = Path(__file__).parents[2]
TEXT = (ROOT / "docs" / "method" / "junctions.md").read_text(encoding="utf-8")
ROW = re.compile(r"^\| `(\w+)` \| ([\d.]+)(°?) \|[^|]*\| ([\w/]+) \| .+ \|$", re.MULTILINE)
FOLDERS = ("junctions", "connections", "pavement", "boundaries")
# Numbers that only keep arithmetic apart from zero, or the work at once in the processor's cache.
TECHNICAL = {
    *("_NO_LINE_BELOW", "_NO_ANGLE", "_LONGEST_TANGENT", "_SHORTEST_RECORD", "_SAME_POSE", "_CLOSED", "_WITHIN"),
    *(
        "_TOO_LONG",
        "_SHIFT_DECIMALS",
        "_SAME_RATIO",
        "_ROWS_AT_ONCE",
        "_PAIRS_AT_ONCE",
        "_PAIRS_PER_SHARE",
        "_DISTANCES_AT_ONCE",
        "_AT_ONCE",
        "_SHARED_FROM",
    ),
    *(
        "_PIECE_LENGTH",
        "_MOST_LANES",
        "_WIDTH_DECIMALS",
        "_SAME_WIDTH",
        "FREE",
        "STRIP",
        "PAVED",
        "FACE",
        "_APART",
        "_AT_ONCE",
    ),
}


def module_of(where: str) -> str:
    for folder in FOLDERS:
        if (ROOT / "src" / "osm2xodr" / "geometry" / folder / f"{where}.py").exists():
            return f"osm2xodr.geometry.{folder}.{where}"
    return {
        "junctions/defaults": "osm2xodr.geometry.junctions.defaults",
        "connections/defaults": "osm2xodr.geometry.connections.defaults",
        "pavement/defaults": "osm2xodr.geometry.pavement.defaults",
        "boundaries/defaults": "osm2xodr.geometry.boundaries.defaults",
        "geometry/defaults": "osm2xodr.geometry.defaults",
        "merge_setbacks": "osm2xodr.geometry.merge_setbacks",
        "connecting_marks": "osm2xodr.geometry.connecting_marks",
        "plan_view/defaults": "osm2xodr.geometry.plan_view.defaults",
        "osm2xodr/defaults": "osm2xodr.defaults",
    }[where]


def documented() -> dict[tuple[str, str], float]:
    """Return the values in the document by module and name, angles in radians."""
    found = {}
    for name, number, degrees, where in ROW.findall(TEXT):
        found[module_of(where), name] = math.radians(float(number)) if degrees else float(number)
    return found


def numbers(module: str) -> dict[str, float]:
    """Return the numbers at the top of a module."""
    path = ROOT / "src" / Path(*module.split(".")).with_suffix(".py")
    body = ast.parse(path.read_text(encoding="utf-8")).body
    names = [node.target.id for node in body if isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name)]
    values = {name: getattr(importlib.import_module(module), name) for name in names}
    return {name: float(value) for name, value in values.items() if isinstance(value, int | float)}


def modules() -> list[str]:
    folders = [ROOT / "src" / "osm2xodr" / "geometry" / folder for folder in FOLDERS]
    paths = [path for folder in folders for path in sorted(folder.glob("*.py")) if path.name != "__init__.py"]
    paths += sorted((ROOT / "src" / "osm2xodr" / "geometry").glob("merge_*.py"))
    return [".".join(path.relative_to(ROOT / "src").with_suffix("").parts) for path in paths]


def test_the_document_has_the_values_of_the_code() -> None:
    assert len(documented()) > 60
    for (module, name), value in documented().items():
        assert float(getattr(importlib.import_module(module), name)) == pytest.approx(value, rel=1e-9), name


@pytest.mark.parametrize("module", modules())
def test_every_number_of_junctions_and_connections_is_in_the_document(module: str) -> None:
    rows = documented()
    assert [name for name in numbers(module) if name not in TECHNICAL and (module, name) not in rows] == []


def test_numbers_of_other_modules_that_decide_about_junctions_are_in_the_document() -> None:
    names = {
        name for module, name in documented() if module in (geometry.__name__, plan_view.__name__, shared.__name__)
    }
    assert names >= {
        *("SHORTEST_STREET_BETWEEN_JUNCTIONS", "SHORTEST_ROAD", "ARM_REACH", "ARM_REACH_MOTORWAY"),
        *("ARM_SETBACK_STEP", "TIGHT_BEND", "BEND_IN_JUNCTION", "HALF_NARROW_LANE", "INNER_EDGE_RADIUS"),
        *("CONNECTING_RADIUS", "MOST_SWING", "MOST_SWING_BACK", "LEAST_TURN_BACK", "PRIORITY_RANK_MINOR"),
    }


def test_names_in_the_document_are_those_of_the_code() -> None:
    known = {name for _, name in documented()} | {"KERB_RADIUS", "KERB_RADIUS_OTHER"}
    named = set(re.findall(r"`(_?[A-Z][A-Z_]+)`", TEXT))
    assert named - known == set()


def test_kerb_radii_are_those_of_the_code() -> None:
    rows = dict(re.findall(r"^\| (\w+) \| (\d+) \|$", TEXT, re.MULTILINE))
    assert {name: float(value) for name, value in rows.items()} == dict(plan_view.KERB_RADIUS)
    assert f"| all others (`KERB_RADIUS_OTHER`) | {plan_view.KERB_RADIUS_OTHER:g} |" in TEXT


def test_ranks_are_those_of_the_code() -> None:
    rows = re.findall(r"^\| (\d+) \| ([a-z][\w, ()*`]+) \|$", TEXT, re.MULTILINE)
    assert [int(rank) for rank, _ in rows] == list(range(10, -1, -1))
    for rank, classes in rows:
        if classes.startswith("ramps where"):
            assert ranks_at_junction(["trunk_link", "primary_link", "residential"])[:2] == [int(rank)] * 2
            continue
        for name in classes.split(", "):
            value = {"all others": "escape", "all other ramps (`*_link`)": "motorway_link"}.get(name, name)
            assert priority_rank(value) == int(rank), name
