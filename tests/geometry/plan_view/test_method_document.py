"""The document of the method has every number of the plan view, with its current value."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

from osm2xodr.geometry.plan_view import defaults

TEXT = (Path(__file__).parents[3] / "docs" / "method" / "plan_view.md").read_text(encoding="utf-8")


def rows() -> list[tuple[str, str, str, str]]:
    """Return module, name, value and unit of every row of the tables of numbers."""
    found = []
    for module, table in re.findall(r"^### `([\w.]+)`\n\n((?:\|.*\n)+)", TEXT, flags=re.MULTILINE):
        for line in table.splitlines()[2:]:
            name, value, unit, source = (cell.strip() for cell in line.strip("|").split("|"))
            assert source, f"{name} has no source"
            found.append((module, name.strip("`"), value, unit))
    return found


def test_every_default_of_the_plan_view_is_there() -> None:
    own = {name for name in vars(defaults) if re.fullmatch(r"[A-Z][A-Z0-9_]*", name)}
    assert own == {name for module, name, _, _ in rows() if module == defaults.__name__}


@pytest.mark.parametrize(("module", "name", "value", "unit"), rows(), ids=lambda cell: str(cell)[-40:])
def test_numbers_are_those_of_the_code(module: str, name: str, value: str, unit: str) -> None:
    current = getattr(import_module(module), name)
    if isinstance(current, Mapping):
        assert {key: float(number) for key, number in (item.split() for item in value.split(", "))} == dict(current)
        return
    stated = [float(number) * (np.pi / 180 if unit == "°" else 1.0) for number in value.split(", ")]
    assert stated == pytest.approx(list(current) if isinstance(current, Sequence | np.ndarray) else [current])


def test_names_in_the_text_are_in_the_tables() -> None:
    prose = TEXT.partition("## Numbers")[0]
    named = set(re.findall(r"`(_?[A-Z][A-Z0-9]*_[A-Z0-9_]+|_[A-Z]+)`", prose))
    assert len(named) > 40
    assert named <= {name for _, name, _, _ in rows()}
