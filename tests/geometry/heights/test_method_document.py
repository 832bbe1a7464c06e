"""The method document against the code: constants, symbols, modules."""

from __future__ import annotations

import re
from collections.abc import Mapping
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path

import pytest

from osm2xodr.geometry import heights
from osm2xodr.geometry.heights import defaults
from osm2xodr.geometry.heights.observations import Kind

DOCUMENT = (Path(__file__).parents[3] / "docs" / "method" / "heights.md").read_text("utf-8")
CONSTANTS = {name: value for name, value in vars(defaults).items() if name.isupper()}


def shown(value: object) -> str:
    """Return a value as the document writes it."""
    if isinstance(value, Mapping):
        return ", ".join(f"{key} {item:g}" for key, item in value.items())
    if isinstance(value, tuple):
        return ", ".join(f"({shown(item)})" if isinstance(item, tuple) else f"{item:g}" for item in value)
    assert isinstance(value, (int, float))
    return f"{value:g}"


def rows(name: str) -> list[list[str]]:
    """Return the cells of the rows of tables that begin with names of constants, by a regular expression."""
    found = re.findall(rf"^\| `({name})` \|(.*)\|$", DOCUMENT, re.MULTILINE)
    return [[first, *(cell.strip() for cell in rest.split("|"))] for first, rest in found]


@pytest.mark.parametrize("name", CONSTANTS)
def test_every_parameter_is_explained_with_its_value(name: str) -> None:
    ((_, symbol, value, unit, source),) = rows(name)
    assert value == shown(CONSTANTS[name])
    assert unit
    assert source
    # The symbol is that of a formula.
    assert not symbol or DOCUMENT.count(symbol.strip("$").split(",")[0].strip("()")) > 1


def test_no_parameter_is_explained_that_is_not_there() -> None:
    assert {row[0] for row in rows("[A-Z_]+")} - set(Kind.__members__) == set(CONSTANTS)


def test_every_kind_of_observation_is_explained() -> None:
    assert {row[0] for row in rows("[A-Z_]+")} >= set(Kind.__members__)


SETTINGS = rows(r"[a-z_.]+\.\w+")


@pytest.mark.parametrize(("name", "value"), [row[:2] for row in SETTINGS], ids=[row[0] for row in SETTINGS])
def test_settings_of_the_numerical_methods_have_their_values(name: str, value: str) -> None:
    module, constant = name.rsplit(".", 1)
    assert value == shown(getattr(import_module(f"{heights.__name__}.{module}"), constant))


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


def test_links_lead_somewhere() -> None:
    docs = Path(__file__).parents[3] / "docs"
    for page in (docs / "elevation.md", *sorted((docs / "method").glob("*.md"))):
        for target in re.findall(r"\]\(([\w./]+\.md)\)", page.read_text("utf-8")):
            assert (page.parent / target).is_file(), f"{page.name} -> {target}"
