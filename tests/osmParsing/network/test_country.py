import gzip
import json
from importlib import resources

import pytest

from osm2xodr.osmParsing.network.country import Place, find_place


@pytest.mark.parametrize(
    ("lat", "lon", "place"),
    [
        (51.500, -0.095, Place("GB", True)),  # London
        (-31.982, 115.900, Place("AU", True)),  # Perth
        (52.474, 13.439, Place("DE", False)),  # Berlin
        (35.895, 14.500, Place("MT", True)),  # Valletta
        (35.681, 139.767, Place("JP", True)),  # Tokyo
        (47.640, -122.303, Place("US", False)),  # Seattle
        (42.560, 1.570, Place("AD", False)),  # Ordino
        (43.737, 7.422, Place("MC", False)),
        (41.902, 12.453, Place("VA", False)),  # within Italy
        (22.300, 114.170, Place("HK", True)),
        (22.600, 114.000, Place("CN", False)),  # Shenzhen, 30 km away
        (36.140, -5.350, Place("GI", False)),
        (18.340, -64.930, Place("VI", True)),  # the one part of the US that drives on the left
        (18.400, -66.100, Place("PR", False)),
        (35.190, 33.360, Place("CY", True)),
        (28.460, -16.250, Place("ES", False)),  # Tenerife: a code of its own is only reserved
        (-16.80, 179.990, Place("FJ", True)),
        (-16.80, -179.990, Place("FJ", True)),
        (78.220, 15.650, Place("SJ", False)),
    ],
)
def test_places(lat: float, lon: float, place: Place) -> None:
    assert find_place(lat, lon) == place


def test_at_sea_the_nearest_country_tells_the_side() -> None:
    assert find_place(50.2, -1.0) == Place("", False)  # in the Channel, nearer to France
    assert find_place(50.45, -1.0) == Place("GB", True)
    assert find_place(30.0, -40.0) == Place("", None)  # the middle of the Atlantic


def test_the_table_is_small_and_says_where_it_is_from() -> None:
    packed = resources.files("osm2xodr.osmParsing.network").joinpath("data/countries.json.gz").read_bytes()
    table = json.loads(gzip.decompress(packed))
    assert len(packed) < 300_000
    assert table["source"].startswith("country-coder ")
    assert "ISC License" in resources.files("osm2xodr.osmParsing.network").joinpath("data/LICENSE").read_text(
        encoding="utf-8"
    )
    codes = {place["code"] for place in table["places"]}
    assert len(codes) > 240
    assert all(len(code) in {0, 2} for code in codes)
    # Countries of the world that drive on the left, a sample, and whole countries that do not.
    left = {place["code"] for place in table["places"] if place["left"]}
    assert {
        "AU",
        "BW",
        "CY",
        "GB",
        "HK",
        "ID",
        "IE",
        "IN",
        "JM",
        "JP",
        "KE",
        "MT",
        "MY",
        "NZ",
        "SG",
        "TH",
        "ZA",
    } <= left
    assert not {"BR", "CN", "DE", "EG", "FR", "GI", "KR", "MM", "NG", "RU", "SE", "US"} & left
