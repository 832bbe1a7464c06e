from __future__ import annotations

import pytest
from pyproj import CRS

from osm2xodr.surface.grids.units import horizontal_crs, metres_per, vertical_unit


@pytest.mark.parametrize(
    ("name", "metres"),
    [
        ("m", 1.0),
        ("Metre", 1.0),
        (" meters ", 1.0),
        ("[m]", 1.0),
        ("ft", 0.3048),
        ("Feet", 0.3048),
        ("US survey foot", 0.3048006096012192),
        ("us-ft", 0.3048006096012192),
        ("US_survey_foot", 0.3048006096012192),
        ("cm", 0.01),
        ("mm", 0.001),
        ("dm", 0.1),
        ("furlong", None),
        ("", None),
    ],
)
def test_names_of_units(name: str, metres: float | None) -> None:
    assert metres_per(name) == metres


@pytest.mark.parametrize(
    ("crs", "expected"),
    [
        ("EPSG:4326", None),
        ("EPSG:32632", None),
        ("EPSG:4979", ("metre", 1.0)),
        ("EPSG:7415", ("metre", 1.0)),
        ("EPSG:2263+6360", ("US survey foot", 0.30480060960121924)),
        ("EPSG:26910+8228", ("foot", 0.3048)),
    ],
)
def test_unit_of_a_crs(crs: str, expected: tuple[str, float] | None) -> None:
    assert vertical_unit(CRS.from_user_input(crs)) == expected


@pytest.mark.parametrize(
    ("crs", "plain"),
    [
        ("EPSG:4979", "EPSG:4326"),
        ("EPSG:7415", "EPSG:28992"),
        ("EPSG:2263+6360", "EPSG:2263"),
        ("EPSG:32632", "EPSG:32632"),
    ],
)
def test_crs_without_heights(crs: str, plain: str) -> None:
    assert horizontal_crs(CRS.from_user_input(crs)) == CRS.from_user_input(plain)
