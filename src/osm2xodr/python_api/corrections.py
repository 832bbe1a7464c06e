"""Reads files of corrections, TOML or GeoJSON, and says what is wrong with them."""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path
from typing import Any, Final

from osm2xodr.errors import InputError
from osm2xodr.model import Corrections, NodeCorrection, WayCorrection
from osm2xodr.system import parse_json

_ELEMENT: Final = re.compile(r"(way|node|relation)/(-?\d{1,18})", re.ASCII)
_ID: Final = re.compile(r"-?\d{1,18}", re.ASCII)
# Properties of features that name the element, and those of `--osm-issues` and of notes, which say nothing else.
_NAMES: Final = ("osm", "@id", "id")
_COMMENTS: Final = frozenset({"note", "code", "kind", "message", "url"})


def read_corrections(path: Path, *, shared: bool = False) -> Corrections:
    """Read corrections from a file: GeoJSON if its name ends in ``.json`` or ``.geojson``, else TOML.

    `shared` says that they are for more than one area, so that some may match nothing in it.

    Raises
    ------
    InputError
        The file cannot be read, or names unknown keys, or values that cannot be.
    """
    # They load the stages.
    from osm2xodr.batching import decoded, read_file
    from osm2xodr.osmParsing import drops_relation, node_correction, way_correction

    text = decoded(path, read_file(path))
    is_json = path.suffix.lower() in (".json", ".geojson")
    ways: dict[int, WayCorrection] = {}
    nodes: dict[int, NodeCorrection] = {}
    relations: set[int] = set()
    for (kind, number), keys in (_geojson(path, text) if is_json else _toml(path, text)).items():
        try:
            if kind == "way":
                ways[number] = way_correction(keys)
            elif kind == "node":
                nodes[number] = node_correction(number, keys)
            elif drops_relation(keys):
                relations.add(number)
        except ValueError as error:
            raise InputError(f"{path}: {kind}/{number}: {error}") from error
    return Corrections(ways, nodes, frozenset(relations), shared)


_Elements = dict[tuple[str, int], dict[str, Any]]


def _toml(path: Path, text: str) -> _Elements:
    """Return the keys of each element of a TOML file: tables ``[way.1]``, or lines ``way.1.lanes = 2``."""
    from osm2xodr.batching import parse_toml, unknown_key
    from osm2xodr.osmParsing import CORRECTION_KEYS

    document = parse_toml(path, text)
    found: _Elements = {}
    for kind, table in document.items():
        if kind not in CORRECTION_KEYS:
            raise InputError(f"{path}: {unknown_key(kind, tuple(CORRECTION_KEYS))}; write such as way.123.lanes = 2")
        if not isinstance(table, dict):
            raise InputError(f"{path}: {kind} is {table!r}; name an element, such as {kind}.123")
        for number, keys in table.items():
            if not _ID.fullmatch(number):
                raise InputError(f"{path}: {kind}.{number} is no id of OpenStreetMap; write such as {kind}.123")
            if not isinstance(keys, dict):
                raise InputError(f"{path}: {kind}/{number} is {keys!r}; write such as {kind}.{number}.drop = true")
            _check_keys(kind, keys, f"{path}: {kind}/{number}")
            found[kind, int(number)] = keys
    return found


def _geojson(path: Path, text: str) -> _Elements:
    """Return the keys of each element that features of a GeoJSON file name in their properties."""
    try:
        document = parse_json(text)
    except ValueError as error:
        raise InputError(f"{path} is not GeoJSON ({error}); give corrections in GeoJSON, or in TOML") from error
    features = document.get("features") if isinstance(document, dict) else None
    if not isinstance(features, list):
        raise InputError(f"{path} is no FeatureCollection of GeoJSON; give one, or corrections in TOML")
    found: _Elements = {}
    for place, feature in enumerate(features, start=1):
        given = feature.get("properties") if isinstance(feature, dict) else None
        properties = given if isinstance(given, dict) else {}
        # Tables of programs have a column for each key, empty where there is nothing to say.
        keys = {key: value for key, value in properties.items() if value is not None and key not in _NAMES}
        keys = {key: value for key, value in keys.items() if key not in _COMMENTS}
        if not keys:
            continue
        name = next((properties[key] for key in _NAMES if properties.get(key) is not None), None)
        match = _ELEMENT.fullmatch(name) if isinstance(name, str) else None
        where = f"{path}, feature {place}"
        if match is None:
            raise InputError(f'{where}: it names no element; give it a property such as "osm": "way/123"')
        element = match[1], int(match[2])
        _check_keys(match[1], keys, f"{where}: {name}")
        for key, value in keys.items():
            # Programs write whole numbers as they write others.
            if isinstance(value, float) and value.is_integer():
                value = int(value)
            if found.setdefault(element, {}).setdefault(key, value) != value:
                raise InputError(f"{where}: {name}: {key} is given twice; give it once")
    return found


def _check_keys(kind: str, keys: Iterable[str], where: str) -> None:
    """Refuse keys that are not those of a kind of elements."""
    from osm2xodr.batching import unknown_key
    from osm2xodr.osmParsing import CORRECTION_KEYS

    for key in keys:
        if key not in CORRECTION_KEYS[kind]:
            raise InputError(f"{where}: {unknown_key(key, CORRECTION_KEYS[kind])}")
