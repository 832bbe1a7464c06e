from __future__ import annotations

import math
import re

import pytest
from hypothesis import given, strategies as st

from osm2xodr.xodrWriter.speeds import lane_speed_attributes, road_speed_attributes

UNIT = {"km/h": 1.0 / 3.6, "mph": 0.44704}


@pytest.mark.parametrize("kmh", [5, 7, 20, 30, 50, 80, 120, 130])
def test_kilometres_per_hour(kmh: int) -> None:
    assert road_speed_attributes(kmh / 3.6) == f'max="{kmh}" unit="km/h"'


@pytest.mark.parametrize("mph", range(5, 86, 5))
def test_miles_per_hour(mph: int) -> None:
    assert road_speed_attributes(mph * 0.44704) == f'max="{mph}" unit="mph"'


def test_odd_speeds() -> None:
    assert road_speed_attributes(12.34) == 'max="44.424" unit="km/h"'


def test_no_limit() -> None:
    assert road_speed_attributes(math.inf) == 'max="no limit"'
    assert lane_speed_attributes(math.inf) == 'max="400" unit="km/h"'


@given(st.floats(min_value=0.5, max_value=90.0))
def test_speeds_stay_what_they_are(speed: float) -> None:
    found = re.fullmatch(r'max="([\d.]+)" unit="(.*)"', lane_speed_attributes(speed))
    assert found is not None
    assert float(found[1]) * UNIT[found[2]] == pytest.approx(speed, abs=0.003)
