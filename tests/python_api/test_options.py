"""The options of a conversion: what they can be, and that they are those of the stages."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import option_types as types_of_options
import pytest

import osm2xodr
from osm2xodr.python_api.options import DECLARATIONS, ConvertOptions

if TYPE_CHECKING:
    # The gate's mypy finds all of these, and would say so if it did not.
    osm2xodr.convert("area.osm", wais="major")  # type: ignore[call-arg]
    osm2xodr.convert("area.osm", target="karla")  # type: ignore[arg-type]
    osm2xodr.convert("area.osm", jobs="two")  # type: ignore[arg-type]
    ConvertOptions(wais="major")  # type: ignore[call-arg]


def test_the_types_of_options_are_those_of_their_declarations() -> None:
    assert types_of_options.TARGET.read_text(encoding="utf-8") == types_of_options.module()
    keywords = osm2xodr.ConvertKeywords
    assert keywords.__annotations__.keys() == DECLARATIONS.keys()
    assert keywords.__required_keys__ == frozenset()


def test_lists_and_tables_become_text() -> None:
    options = ConvertOptions(
        ways=["motorway", "motorway_link"], max_grade={"motorway": 0.05, "service": 0.1}, objects={"trees", "lamps"}
    )
    assert options.ways == "motorway,motorway_link"
    assert options.max_grade == "motorway=0.05,service=0.1"
    assert options.objects == "lamps,trees"


@pytest.mark.parametrize(
    ("given", "left"),
    [
        ({}, None),
        ({"left_hand": True}, True),
        ({"left_hand": False}, False),
        ({"right_hand": True}, False),
        ({"right_hand": False}, True),
        ({"left_hand": True, "right_hand": False}, True),
    ],
)
def test_both_sides_of_the_road_are_one_option(given: dict[str, Any], left: bool | None) -> None:
    options = ConvertOptions(**given)
    assert options.left_hand is left
    assert options.inputs(Path("a.osm"), ())["left_hand"] is left


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"ways": 3}, "ways: 3 is not text"),
        ({"surface": "cubic"}, "surface: 'cubic' is unknown; choose from nearest, bilinear, bicubic, polynomial"),
        ({"target": "godot"}, "target: 'godot' is unknown"),
        ({"xodr_version": "1.5"}, "xodr_version: '1.5' is unknown; choose from 1.4, 1.6, 1.7, 1.8"),
        ({"polynomial_order": 9}, "polynomial_order: 9 cannot be; give 2 to 5"),
        ({"polynomial_order": 3.5}, "polynomial_order: 3.5 is not a whole number"),
        ({"fail_below_coverage": 95}, "fail_below_coverage: 95.0 cannot be; give 0 to 1"),
        ({"fail_below_coverage": float("nan")}, "fail_below_coverage: nan cannot be; give 0 to 1"),
        ({"fail_below_coverage": 0.9, "allow_partial": True}, "allow_partial and fail_below_coverage exclude each"),
        ({"jobs": 0}, "jobs: 0 cannot be; give 1 or more"),
        ({"smoothing": "much"}, "smoothing: 'much' is not a number"),
        ({"smoothing": float("nan")}, "smoothing: nan is not above 0"),
        ({"turnarounds": "yes"}, "turnarounds: 'yes' is neither True nor False"),
        ({"frame": 1}, "frame: 1 is not a path"),
        ({"left_hand": True, "right_hand": True}, "left_hand and right_hand exclude each other"),
    ],
)
def test_what_cannot_be_is_refused_by_name(given: dict[str, Any], message: str) -> None:
    with pytest.raises(osm2xodr.OptionError) as caught:
        ConvertOptions(**given)
    assert str(caught.value).startswith(message)
    assert set(caught.value.options) == set(given)
    assert isinstance(caught.value, ValueError)
    assert isinstance(caught.value, osm2xodr.Osm2xodrError)


def test_reports_say_what_was_asked_for() -> None:
    options = ConvertOptions(no_structures=True, no_furniture=True, frame="frame.json", date="2024-05-01", jobs=3)
    inputs = options.inputs(Path("in/town.osm.pbf"), [Path("dem.tif")])
    assert list(inputs) == [
        "osm2xodr", "area", "dem", "name", "date", "ways", "include_private", "left_hand", "default_lane_width",
        "default_speeds", "guessed_parking", "guessed_sidewalks", "guessed_shoulders", "surface",
        "polynomial_order", "dem_type", "dem_sigma", "vertical_datum", "dem_vertical_datum", "dem_crs", "dem_unit",
        "dem_encoding", "allow_partial", "fail_below_coverage",
        "smoothing", "max_grade", "structures", "superelevation", "turnarounds", "u_turns", "plan", "target",
        "objects", "furniture", "frame",
    ]  # fmt: skip
    assert (inputs["name"], inputs["structures"], inputs["furniture"]) == ("town", False, False)
    assert inputs["default_speeds"] is True
    assert (inputs["area"], inputs["dem"], inputs["frame"]) == ("in/town.osm.pbf", ["dem.tif"], "frame.json")


def test_every_option_says_what_it_is() -> None:
    text = " ".join((ConvertOptions.__doc__ or "").split())
    for name, declared in DECLARATIONS.items():
        assert f" {name} {' '.join(declared.help.split())}" in text
    own = ["bbox", "polygon", "clip", "corrections", "name", "jobs", "corrections_shared", "frame", "tile"]
    assert [name for name, declared in DECLARATIONS.items() if not declared.per_area] == own
