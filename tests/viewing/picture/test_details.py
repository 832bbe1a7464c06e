"""What pictures show from near: marks, paint on the road, signals; and nothing of it from afar."""

from __future__ import annotations

import io
import math
from pathlib import Path

import numpy as np
import pytest
from sample_road_maps import furnished_crossing
from xodr_text import LINE, cubics, document, geometry, lane, read_text, road, section

from osm2xodr.diagnostics import Diagnostics
from osm2xodr.furniture_shapes import forms, placed_objects
from osm2xodr.opendrive.reader import read_xodr
from osm2xodr.opendrive.tables import OpenDrive
from osm2xodr.viewing import PictureOptions
from osm2xodr.viewing.colours import Ramp
from osm2xodr.viewing.picture.contents import Picture, make_picture
from osm2xodr.viewing.picture.details import Line, Polygon, mark_lines
from osm2xodr.xodrWriter import WriteOptions, write_xodr

# 1500 pixels for 150 m: ten per metre.
BOX = (0.0, -20.0, 150.0, 40.0)
WHITE = "#ffffff"


@pytest.fixture
def file(tmp_path: Path) -> OpenDrive:
    stream = io.BytesIO()
    write_xodr(furnished_crossing(), stream, WriteOptions(), Diagnostics())
    (tmp_path / "map.xodr").write_bytes(stream.getvalue())
    return read_xodr(tmp_path / "map.xodr")


def metres(picture: Picture, shape: Polygon | Line) -> np.ndarray:  # type: ignore[type-arg]
    """Return corners in x and y of the file."""
    return np.stack((BOX[0] + shape.corners[:, 0] / 10.0, BOX[3] - shape.corners[:, 1] / 10.0), axis=1)


def test_crosswalks_are_bars_across_the_road(file: OpenDrive) -> None:
    picture = make_picture(file, PictureOptions(BOX, 1500))
    white = [metres(picture, item) for item in picture.shapes if isinstance(item, Polygon) and item.colour == WHITE]
    bars = [item for item in white if len(item) == 4 and 77.5 < item[:, 0].min() < 82.5]
    # 7 m take 7 bars of 0.5 m with 6 gaps, 0.25 m from the kerbs, each over the crosswalk's 4 m.
    assert len(bars) == 7
    assert all(np.ptp(item[:, 0]) == pytest.approx(4.0, abs=0.05) for item in bars)
    assert all(np.ptp(item[:, 1]) == pytest.approx(0.5, abs=0.1) for item in bars)
    ends = np.concatenate(bars)[:, 1]
    assert (ends.min(), ends.max()) == pytest.approx((-3.25, 3.25), abs=0.1)


def test_signals_are_symbols_of_a_size(file: OpenDrive) -> None:
    picture = make_picture(file, PictureOptions(BOX, 1500))
    lamps = [
        metres(picture, item).mean(axis=0)
        for item in picture.shapes
        if isinstance(item, Polygon) and item.colour == forms.GREEN
    ]
    # Lights 1 and 2; references have no head of their own.
    assert np.array(lamps) == pytest.approx(np.array([[98.0, -4.93], [112.0, 4.07]]), abs=0.05)
    rings = [item for item in picture.shapes if isinstance(item, Polygon) and item.colour == forms.RED]
    assert min(abs(metres(picture, item).mean(axis=0) - (20.0, -4.0)).max() for item in rings) < 0.05


def test_from_afar_there_are_roads_alone(file: OpenDrive) -> None:
    picture = make_picture(file, PictureOptions((-1000.0, -1000.0, 1000.0, 1000.0), 800))
    assert {type(item) for item in picture.shapes} == {Polygon}
    assert WHITE not in {item.colour for item in picture.shapes}


def test_a_lamp_that_repeats_stands_where_its_copies_do(file: OpenDrive) -> None:
    lamps = [thing for thing in placed_objects(file) if thing.item.attributes["type"] == "streetLamp"]
    assert [(thing.x, thing.y) for thing in lamps] == [
        pytest.approx((110.0 + 20.0 * k, -5.0), abs=1e-6) for k in range(4)
    ]
    assert placed_objects(file, frozenset({0})) == [thing for thing in placed_objects(file) if thing.item.road == 0]


def test_what_goes_on_along_a_bend_follows_it(tmp_path: Path) -> None:
    fence = (
        '<objects><object id="1" type="barrier" s="0" t="6" zOffset="0"><repeat s="10" length="20" distance="0"'
        ' tStart="6" tEnd="6" heightStart="1" heightEnd="1" zOffsetStart="0" zOffsetEnd="0" widthStart="0.4"/>'
        "</object></objects>"
    )
    bend = road("1", geometry('<arc curvature="0.02"/>', 60.0), 60.0, more=fence)
    (thing,) = placed_objects(read_text(tmp_path, document(bend)))
    # The bend's centre is at (0, 50).
    distance = [math.dist(corner, (0.0, 50.0)) for corner in thing.corners]
    half = len(distance) // 2
    assert distance[:half] == pytest.approx([50.0 - 6.2] * half, abs=1e-6)
    assert distance[half:] == pytest.approx([50.0 - 5.8] * half, abs=1e-6)
    # From 0.2 to 0.6 rad, a corner at least every 2 m.
    turns = [math.atan2(x, 50.0 - y) for x, y in thing.corners[:half]]
    assert (turns[0], turns[-1]) == pytest.approx((0.2, 0.6))
    assert max(np.diff(turns)) <= 0.04 + 1e-9


def test_dashes_are_3_m_with_gaps_of_6_m() -> None:
    grid = np.array([[[0.0, 0.0], [0.0, 30.0], [0.0, 60.0]], [[200.0, 0.0], [200.0, 30.0], [200.0, 60.0]]])
    lines = mark_lines(grid, [["none", 0, WHITE], ["broken", 2, WHITE], ["curb", 1, WHITE]], 10.0)
    assert [item.corners[:, 0].tolist() for item in lines[:-1]] == [[0.0, 30.0], [90.0, 120.0], [180.0, 200.0]]
    assert {item.corners[0, 1] for item in lines[:-1]} == {30.0}
    assert lines[-1].colour != WHITE


@pytest.mark.parametrize("length", [1e7, 1e300])
def test_lines_of_no_end_are_not_dashed(length: float) -> None:
    """As those of damaged files may be, whose dashes would take for ever."""
    grid = np.array([[[0.0, 0.0], [0.0, 30.0], [0.0, 60.0]], [[length, 0.0], [length, 30.0], [length, 60.0]]])
    (line,) = mark_lines(grid, [["none", 0, WHITE], ["broken", 2, WHITE], ["none", 0, WHITE]], 10.0)
    assert line.corners[:, 0].tolist() == [0.0, length]


def test_double_lines_are_two() -> None:
    grid = np.array([[[0.0, 0.0], [0.0, 30.0], [0.0, 60.0]], [[200.0, 0.0], [200.0, 30.0], [200.0, 60.0]]])
    kinds = [["none", 0, WHITE], ["solid broken", 1, "#e8b400"], ["none", 0, WHITE]]
    lines = mark_lines(grid, kinds, 10.0)
    assert len([item for item in lines if item.corners[0, 1] < 30.0]) == 1
    assert len([item for item in lines if item.corners[0, 1] > 30.0]) == 3
    assert {item.colour for item in lines} == {"#e8b400"}


def test_colours_are_spread_over_what_is_in_the_box(tmp_path: Path) -> None:
    flat = section(0.0, right=lane(-1, (0, 3.5)))
    low = road("1", lanes=flat, elevation=cubics("elevation", (0, 100.0, 0.3)))
    high = road("2", geometry(LINE, 100.0, x=1000.0), lanes=flat, elevation=cubics("elevation", (0, 900.0)))
    drive = read_text(tmp_path, document(low, high))
    whole = make_picture(drive, PictureOptions(colour="height")).mode.scale
    part = make_picture(drive, PictureOptions((-10.0, -10.0, 110.0, 10.0), 800, "height")).mode.scale
    assert isinstance(whole, Ramp)
    assert isinstance(part, Ramp)
    assert whole.high >= 900.0
    assert (part.low, part.high) == (100.0, 130.0)
