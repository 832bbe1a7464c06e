"""The document about lanes names every default of lanes and margins with the value that it has."""

from __future__ import annotations

import re
from pathlib import Path
from types import ModuleType

import pytest

from osm2xodr.geometry import defaults as shared
from osm2xodr.geometry.lanes import defaults as of_lanes
from osm2xodr.geometry.margins import defaults as of_margins

TEXT = (Path(__file__).parents[3] / "docs" / "method" / "lanes.md").read_text("utf-8")
ROWS = dict(re.findall(r"^\| `([A-Z_]+)` \| ([^|]+) \|", TEXT, re.MULTILINE))


def values(module: ModuleType) -> dict[str, object]:
    return {name: value for name, value in vars(module).items() if name.isupper()}


DEFAULTS = values(shared) | values(of_lanes) | values(of_margins)


def test_every_default_of_lanes_and_margins_is_in_the_table() -> None:
    expected = values(of_lanes).keys() | values(of_margins).keys()
    assert expected <= ROWS.keys()
    assert ROWS.keys() <= DEFAULTS.keys()


@pytest.mark.parametrize("name", ROWS)
def test_values_in_the_table_are_those_of_the_code(name: str) -> None:
    value = DEFAULTS[name]
    if isinstance(value, tuple):
        assert tuple(ROWS[name].split(", ")) == value
    else:
        assert float(ROWS[name]) == value


def test_the_text_names_no_constant_that_is_not_in_the_table() -> None:
    named = set(re.findall(r"`([A-Z][A-Z_]+[A-Z])`", TEXT))
    assert named == ROWS.keys()
