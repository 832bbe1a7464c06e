import subprocess
import sys

import pytest

from osm2xodr.osmParsing.options import DRIVABLE, PRESETS, ParseOptions, WaySelection, parse_ways_option


def test_presets_grow() -> None:
    major, drivable, everything = (PRESETS[name].highways for name in ("major", "drivable", "all"))
    assert major < drivable < everything
    assert sorted(drivable - major) == ["living_street", "residential", "road", "service", "unclassified"]
    assert sorted(everything - drivable) == ["busway", "raceway", "track"]
    assert sorted(major) == sorted(
        f"{name}{link}"
        for name in ("motorway", "trunk", "primary", "secondary", "tertiary")
        for link in ("", "_link")
    )


def test_default_leaves_driveways_out() -> None:
    assert ParseOptions().ways == DRIVABLE == parse_ways_option("drivable")
    assert sorted(DRIVABLE.services_out) == ["drive-through", "driveway", "emergency_access", "parking_aisle"]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("residential", WaySelection(frozenset({"residential"}))),
        (" primary , secondary ", WaySelection(frozenset({"primary", "secondary"}))),
        ("drivable,track", WaySelection(DRIVABLE.highways | {"track"}, DRIVABLE.services_out)),
        # Service roads that are named by themselves are meant as a whole.
        ("drivable,service", WaySelection(DRIVABLE.highways)),
        ("service", WaySelection(frozenset({"service"}))),
        ("drivable,all", PRESETS["all"]),
        ("major,raceway,", WaySelection(PRESETS["major"].highways | {"raceway"})),
    ],
)
def test_lists(text: str, expected: WaySelection) -> None:
    assert parse_ways_option(text) == expected


@pytest.mark.parametrize(
    ("text", "start"),
    [
        (
            "motorways",
            "'motorways' is not a kind of way that cars drive on; choose from major, drivable, all or a list of ",
        ),
        ("residential,footway", "'footway' is not a kind of way"),
        ("", "no kind of way is given; choose from major, drivable, all"),
        (" , ", "no kind of way is given"),
    ],
)
def test_unknown_kinds_of_ways(text: str, start: str) -> None:
    with pytest.raises(ValueError, match="choose from") as caught:
        parse_ways_option(text)
    assert str(caught.value).startswith(start)
    assert "living_street" in str(caught.value)


@pytest.mark.parametrize("width", [0.0, -3.0, 1.0, 50.0, float("nan"), float("inf")])
def test_lane_width_must_be_one(width: float) -> None:
    with pytest.raises(ValueError, match=r"give a width from 2 to 5\.5 m"):
        ParseOptions(default_lane_width=width)


def test_import_is_light() -> None:
    code = (
        "import sys, osm2xodr.osmParsing\n"
        "print(sorted({'osmium', 'pyproj', 'rasterio', 'scipy', 'lxml'} & sys.modules.keys()))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
