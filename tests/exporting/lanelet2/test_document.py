"""Coordinates of nodes: on Earth, in the file, in squares of MGRS.

OpenDRIVE's words as Lanelet2's tags.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from pyproj import Transformer
from xodr_text import PROJECTION, document, read_text, road

from osm2xodr.errors import InputError
from osm2xodr.exporting.lanelet2.document import (
    PROJECTORS,
    grid_references,
    lanelet_tags,
    location_of,
    mark_of,
    place,
    projector_info,
    sign_type,
)
from osm2xodr.python_api import EXPORT_PROJECTORS

NOWHERE = '<header revMajor="1" revMinor="7"/>'
POINTS = np.array([[0.0, 0.0, 5.0], [100.0, 50.0, 6.0]])


def header(lat: float, lon: float) -> str:
    projection = f"+proj=tmerc +lat_0={lat} +lon_0={lon} +k=1 +datum=WGS84 +units=m"
    return f'<header revMajor="1" revMinor="7"><geoReference>{projection}</geoReference></header>'


def test_projectors_of_the_command_are_those_of_the_module() -> None:
    assert EXPORT_PROJECTORS == PROJECTORS


def test_local_coordinates_are_those_of_the_file(tmp_path: Path) -> None:
    places, reason = place(read_text(tmp_path, document(road())), POINTS, "local")
    assert reason == ""
    np.testing.assert_array_equal(np.column_stack([places.local_x, places.local_y, places.height]), POINTS)
    x, y = Transformer.from_crs("EPSG:4326", PROJECTION, always_xy=True).transform(places.lon, places.lat)
    np.testing.assert_allclose(np.column_stack([x, y]), POINTS[:, :2], atol=1e-6)
    assert projector_info("local", "") == "projector_type: Local\n"


# Grid references by the package mgrs 1.5 (GeoTrans), also in the wide zones of Norway and Svalbard.
@pytest.mark.parametrize(
    ("lat", "lon", "reference"),
    [
        (48.40683, 15.64021, "33UWP4737961717"),
        (35.68124, 139.76712, "54SUE8843549294"),
        (-32.03653, 115.75586, "50HLK8252654838"),
        (60.39299, 5.32415, "32VKN9747700830"),
        (78.22, 15.65, "33XWG1481383004"),
        (-0.5, -78.5, "17MQV7826544681"),
        (0.0001, 9.0, "32NNF0000000011"),
    ],
)
def test_mgrs(tmp_path: Path, lat: float, lon: float, reference: str) -> None:
    places, _ = place(read_text(tmp_path, document(road(), header=header(lat, lon))), POINTS, "mgrs")
    assert places.square == reference[:5]
    assert projector_info("mgrs", places.square).splitlines()[-1] == f"mgrs_grid: {reference[:5]}"
    assert grid_references(places)[0] == reference
    # 100 m east and 50 m north, at the scale of UTM and turned by its convergence.
    moved = np.hypot(np.diff(places.local_x), np.diff(places.local_y))[0]
    assert moved == pytest.approx(np.hypot(100, 50), rel=1.1e-3)


def test_a_file_from_nowhere_lies_at_the_origin(tmp_path: Path) -> None:
    file = read_text(tmp_path, document(road(), header=NOWHERE))
    places, reason = place(file, POINTS, "local")
    assert "no geoReference" in reason
    # A degree is 111.3 km long on the equator.
    np.testing.assert_allclose(places.lon[1], 100 / 111_319.5, rtol=1e-4)
    with pytest.raises(InputError, match="MGRS counts from there"):
        place(file, POINTS, "mgrs")


def test_mgrs_ends_at_the_poles(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="MGRS"):
        place(read_text(tmp_path, document(road(), header=header(85.0, 0.0))), POINTS, "mgrs")


@pytest.mark.parametrize(
    ("kind", "change", "tags"),
    [
        ("solid", "", {"type": "line_thin", "subtype": "solid", "lane_change": "no"}),
        ("broken", "", {"type": "line_thin", "subtype": "dashed", "lane_change": "yes"}),
        ("broken", "none", {"type": "line_thin", "subtype": "dashed", "lane_change": "no"}),
        ("solid solid", "", {"type": "line_thin", "subtype": "solid_solid", "lane_change": "no"}),
        # Right of the centre the first line is the inner, left one: who is right of it may cross to the left.
        (
            "solid broken",
            "",
            {"type": "line_thin", "subtype": "solid_dashed", "lane_change:left": "yes", "lane_change:right": "no"},
        ),
        (
            "broken",
            "increase",
            {"type": "line_thin", "subtype": "dashed", "lane_change:left": "yes", "lane_change:right": "no"},
        ),
        ("curb", "", {"type": "curbstone", "subtype": "high", "lane_change": "no"}),
        ("none", "", {"type": "virtual", "lane_change": "yes"}),
        ("none", "none", {"type": "virtual", "lane_change": "no"}),
        ("what", "", {"type": "line_thin", "subtype": "solid", "lane_change": "no"}),
    ],
)
def test_marks(kind: str, change: str, tags: dict[str, str]) -> None:
    assert mark_of(kind, change, outwards_left=False, low=False, bare="virtual").tags() == tags


def test_marks_left_of_the_centre_count_to_the_left() -> None:
    mark = mark_of("solid broken", "", outwards_left=True, low=False, bare="virtual")
    assert (mark.subtype, mark.to_left, mark.to_right) == ("dashed_solid", False, True)


def test_edges_and_kerbs() -> None:
    assert mark_of("none", "", outwards_left=False, low=False, bare="road_border").tags()["lane_change"] == "no"
    assert mark_of("curb", "", outwards_left=False, low=True, bare="virtual").subtype == "low"


def test_lanelets() -> None:
    tags = lanelet_tags("road", ("vehicle",), location="urban", both_ways=False, speed=50 / 3.6)
    assert tags == {
        "type": "lanelet",
        "subtype": "road",
        "location": "urban",
        "one_way": "yes",
        "speed_limit": "50",
        "participant:vehicle": "yes",
    }
    assert lanelet_tags("road", (), location="", both_ways=True, speed=30 * 0.44704)["speed_limit"] == "48.28"
    for speed in (math.inf, math.nan):
        assert "speed_limit" not in lanelet_tags("road", (), location="", both_ways=True, speed=speed)


def test_places_and_signs() -> None:
    words = ("town", "rural", "motorway", "", "unknown")
    assert [location_of(word) for word in words] == ["urban", "nonurban", "nonurban", "", ""]
    assert sign_type("DE", "274", "50") == "de274-50"
    assert sign_type("DE", "206", "-1") == "de206"
    assert sign_type("OpenDRIVE", "1000003", "") == "1000003"
