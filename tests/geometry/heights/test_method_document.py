"""The method document against the code: kinds of observations, modules and names."""

from __future__ import annotations

import re
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path

from osm2xodr.geometry import heights
from osm2xodr.geometry.heights.observations import Kind

DOCUMENT = (Path(__file__).parents[3] / "docs" / "method" / "heights.md").read_text("utf-8")


def rows(name: str) -> list[list[str]]:
    """Return the cells of the rows of tables that begin with names of constants, by a regular expression."""
    found = re.findall(rf"^\| `({name})` \|(.*)\|$", DOCUMENT, re.MULTILINE)
    return [[first, *(cell.strip() for cell in rest.split("|"))] for first, rest in found]


def test_every_kind_of_observation_is_explained() -> None:
    assert {row[0] for row in rows("[A-Z_]+")} >= set(Kind.__members__)


def test_the_modules_that_the_document_names_are_there() -> None:
    table = re.findall(r"^\| .+ \| ((?:`\w+`(?:, )?)+) \| [\d, ]+ \|$", DOCUMENT, re.MULTILINE)
    named = {name for cell in table for name in re.findall(r"`(\w+)`", cell)}
    folder = Path(heights.__file__).parent
    there = {path.stem for path in folder.iterdir()} - {"defaults", "problem", "profiles"}
    there = {name for name in there if not name.startswith("__")}
    assert named == there


def test_the_code_that_the_document_names_is_there() -> None:
    for module, name in re.findall(r"`([a-z_.]+)\.(\w+)`", DOCUMENT):
        if module != "profiles" or name != "py":
            there = import_module(f"{heights.__name__}.{module}")
            assert hasattr(there, name) or find_spec(f"{there.__name__}.{name}"), f"{module}.{name}"
