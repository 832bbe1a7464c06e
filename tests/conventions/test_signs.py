"""The numbers of signs by country, compared with catalogues by hand.

Ranks of roads at a junction.
"""

from __future__ import annotations

import json
from pathlib import Path

import pytest

import osm2xodr.conventions
from osm2xodr.conventions import ranks_at_junction
from osm2xodr.conventions.signs import COMMON, SignCode, is_supplementary, sign_code, sign_meaning, sign_meanings

TABLE = json.loads((Path(osm2xodr.conventions.__file__).parent / "sign_codes.json").read_text(encoding="utf-8"))


def test_every_country_names_its_source() -> None:
    assert len(TABLE["countries"]) >= 20
    for country, item in TABLE["countries"].items():
        assert len(country) == 2
        assert item["source"]
        assert "stop" in item["codes"]


@pytest.mark.parametrize("country", TABLE["countries"])
def test_own_codes_read_back_as_what_they_mean(country: str) -> None:
    for meaning in TABLE["countries"][country]["codes"]:
        value = 30.0 if "speed" in meaning else None
        code = sign_code(meaning, value, country, own_codes=True, value_in_subtype=True)
        assert code is not None
        assert code.country == country
        written = code.type if code.subtype == "-1" else f"{code.type}-{code.subtype}"
        found, number = sign_meaning(country, written)
        assert found == meaning
        assert number in (value, None)


# What CARLA's SignalType.cpp and esmini's de_traffic_signals.txt call these numbers.
COMMON_CODES = {
    "stop": "206",
    "give_way": "205",
    "maxspeed": "274",
    "maxspeed_zone": "274.1",
    "no_overtaking": "276",
    "priority_next": "301",
    "priority_road": "306",
    "priority_road_end": "307",
    "city_limit": "310",
    "city_limit_end": "311",
    "no_entry": "267",
    "roundabout": "215",
    "crosswalk": "350",
}


@pytest.mark.parametrize("country", ["DE", "US", "FR", "XX", ""])
@pytest.mark.parametrize("meaning", COMMON_CODES)
def test_common_codes_are_the_same_everywhere(meaning: str, country: str) -> None:
    value = 50.0 if "speed" in meaning else None
    found = sign_code(meaning, value, country, own_codes=False, value_in_subtype=True)
    assert found == SignCode(COMMON_CODES[meaning], "50" if value else "-1", COMMON)
    bare = sign_code(meaning, value, country, own_codes=False, value_in_subtype=False)
    assert bare == SignCode(COMMON_CODES[meaning], "" if value else "-1", COMMON)


@pytest.mark.parametrize(
    ("country", "meaning", "value", "code"),
    [
        ("US", "stop", None, ("R1-1", "-1", "US")),
        ("US", "maxspeed", 45.0, ("R2-1", "-1", "US")),
        ("FR", "stop", None, ("AB4", "-1", "FR")),
        ("GB", "give_way", None, ("602", "-1", "GB")),
        ("NL", "maxspeed", 50.0, ("A1", "50", "NL")),
        ("NL", "maxspeed_zone", 30.0, ("A1-30-ZB", "-1", "NL")),
        ("SE", "maxspeed", 70.0, ("C31", "7", "SE")),
        ("DE", "pass_left", None, ("222", "10", "DE")),
        # What a country's table lacks has the common number.
        ("JP", "give_way", None, ("205", "-1", "DE")),
        ("XX", "stop", None, ("206", "-1", "DE")),
    ],
)
def test_own_codes(country: str, meaning: str, value: float | None, code: tuple[str, str, str]) -> None:
    assert sign_code(meaning, value, country, own_codes=True, value_in_subtype=True) == SignCode(*code)


def test_what_no_common_catalogue_has() -> None:
    assert sign_code("all_way", None, "US", own_codes=False, value_in_subtype=True) is None
    assert sign_code("all_way", None, "US", own_codes=True, value_in_subtype=True) == SignCode("R1-3P", "-1", "US")
    assert "all_way" in sign_meanings()


@pytest.mark.parametrize(
    ("country", "code", "meaning", "value"),
    [
        ("DE", "274-30", "maxspeed", 30.0),
        ("DE", "274-53", "maxspeed", 30.0),
        ("DE", "274-60", "maxspeed", 60.0),
        ("DE", "274.1-20", "maxspeed_zone", 20.0),
        ("DE", "274", "maxspeed", None),
        ("DE", "133-12", "pedestrians", None),
        ("DE", "209-20", "turn_right", None),
        ("FR", "ab4", "stop", None),
        ("ES", "R-2", "stop", None),
        ("ES", "R301", "maxspeed", None),
        ("NL", "A01-050", "maxspeed", 50.0),
        ("NL", "B06", "give_way", None),
        ("PL", "B20", "stop", None),
        ("SE", "C31-5", "maxspeed", 50.0),
        ("CH", "2.30", "maxspeed", None),
        ("CH", "3.01", "stop", None),
        ("AT", "52.a.10a", "maxspeed", None),
        ("US", "R1-1", "stop", None),
        ("US", "R1-9", "", None),
        ("DE", "9999", "", None),
        ("XX", "206", "", None),
    ],
)
def test_meanings_of_codes(country: str, code: str, meaning: str, value: float | None) -> None:
    assert sign_meaning(country, code) == (meaning, value)


def test_supplementary_plates() -> None:
    assert is_supplementary("DE", "1022-10")
    assert not is_supplementary("DE", "274")
    assert is_supplementary("US", "R1-3P")
    assert is_supplementary("FR", "M9z")
    assert not is_supplementary("XX", "1022-10")


@pytest.mark.parametrize(
    ("highways", "expected"),
    [
        (["trunk_link", "trunk_link", "residential"], [5, 5, 4]),
        # A street that crosses ramps, and a ramp that ends.
        (["trunk_link", "trunk_link", "residential", "unclassified"], [3, 3, 4, 4]),
        (["trunk_link", "residential", "residential"], [3, 4, 4]),
        (["motorway_link", "motorway_link", "motorway"], [5, 5, 10]),
        (["primary_link", "primary", "primary", "residential"], [5, 8, 8, 4]),
        (["tertiary", "residential", "service"], [6, 4, 1]),
    ],
)
def test_ramps_rank_above_streets_that_end(highways: list[str], expected: list[int]) -> None:
    assert ranks_at_junction(highways) == expected
