"""What stands beside roads reaches the page: forms as pictures have them, and signals with their controllers.

Packed numbers come back as they were.
"""

from __future__ import annotations

import io
import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, strategies as st
from sample_road_maps import furnished_crossing

from osm2xodr.diagnostics import Diagnostics
from osm2xodr.furniture_shapes import Area, Disc, forms_of, in_layers, placed_objects
from osm2xodr.opendrive.reader import read_xodr
from osm2xodr.opendrive.tables import OpenDrive
from osm2xodr.viewing.page.things import UNKNOWN, objects_of, pack_arrays, quantised, signal_info
from osm2xodr.xodrWriter import WriteOptions, write_xodr


@pytest.fixture
def file(tmp_path: Path) -> OpenDrive:
    stream = io.BytesIO()
    write_xodr(furnished_crossing(), stream, WriteOptions(), Diagnostics())
    (tmp_path / "map.xodr").write_bytes(stream.getvalue())
    return read_xodr(tmp_path / "map.xodr")


def test_forms_of_objects_are_those_of_pictures(file: OpenDrive) -> None:
    found = objects_of(file, 100.0, -10.0)
    things = in_layers(placed_objects(file))
    assert found.types == [thing.item.attributes["type"] for thing in things]
    assert found.types == ["patch", "crosswalk", "roadMark", "barrier", *["streetLamp"] * 4]
    forms = [form for thing in things for form in forms_of(thing)]
    corners = []
    for form in forms:
        corners += [(form.x, form.y)] if isinstance(form, Disc) else form.corners
    arrays = found.arrays
    assert (arrays["form_x"] / 100.0 + 100.0).tolist() == pytest.approx([x for x, _ in corners], abs=0.0051)
    assert (arrays["form_y"] / 100.0 - 10.0).tolist() == pytest.approx([y for _, y in corners], abs=0.0051)
    assert [found.colours[k] for k in arrays["form_colour"]] == [form.colour for form in forms]
    # Seven bars of the crosswalk; lamps are discs.
    assert [arrays["form_object"].tolist().count(k) for k in range(8)] == [1, 7, 1, 1, 1, 1, 1, 1]
    assert arrays["form_kind"].tolist() == [0 if isinstance(form, Area) else 1 for form in forms]


def test_controllers_name_signals_and_junctions(file: OpenDrive) -> None:
    info = signal_info(file, 0.0, 0.0)
    numbers = [dict(row[9])["id"] for row in info["signals"]]
    assert sorted(numbers) == ["1", "2", "3"]
    found = {name: ([numbers[k] for k in members], roads) for _, name, members, roads in info["controllers"]}
    junction = file.junctions.id.index("5")
    assert found == {"along": (["1", "2"], [junction]), "alone": (["3"], [])}
    # References of roads 3 and 4 name lights 1 and 2.
    referring = {
        number: [file.roads.id[k] for k in row[10]] for number, row in zip(numbers, info["signals"], strict=True)
    }
    assert referring == {"1": ["3"], "2": ["4"], "3": []}
    lights = {number: row[7] for number, row in zip(numbers, info["signals"], strict=True)}
    assert lights == {"1": 1, "2": 1, "3": 0}
    # Both lights have one face.
    faces = {number: row[8] for number, row in zip(numbers, info["signals"], strict=True)}
    assert faces["1"] == faces["2"] != faces["3"]
    assert len(info["faces"]) == 2


def unpacked(contents: list[list[object]], data: bytes) -> dict[str, list[int]]:
    """Read arrays as the page does."""
    out, at = {}, 0
    for name, count in contents:
        assert isinstance(name, str)
        assert isinstance(count, int)
        planes = np.frombuffer(data, np.uint8, 4 * count, at).reshape(4, count).astype(np.uint32)
        steps = planes[0] | planes[1] << 8 | planes[2] << 16 | planes[3] << 24
        out[name] = np.cumsum(steps, dtype=np.uint32).view(np.int32).tolist()
        at += 4 * count
    return out


@given(st.lists(st.integers(-(2**31), 2**31 - 1), max_size=50), st.lists(st.integers(-5, 5), max_size=9))
def test_arrays_come_back(one: list[int], other: list[int]) -> None:
    arrays = {"one": np.array(one, np.int32), "other": np.array(other, np.int32)}
    assert unpacked(*pack_arrays(arrays)) == {"one": one, "other": other}


def test_values_become_steps() -> None:
    values = np.array([0.004, -1.236, math.nan, math.inf, 1e30])
    assert quantised(values, 0.01).tolist() == [0, -124, UNKNOWN, UNKNOWN, 2**31 - 1]
