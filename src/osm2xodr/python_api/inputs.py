"""What a conversion reads: corrections, and the map: a file, standard input, or an area cut out of one of them.

Corrections are files in TOML or GeoJSON; errors say what is wrong with them.
"""

from __future__ import annotations

import contextlib
import dataclasses
import re
import shutil
import sys
import tempfile
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any, Final, NamedTuple

from osm2xodr.errors import EmptyAreaError, InputError, OptionError, Osm2xodrError
from osm2xodr.model import Corrections, NodeCorrection, WayCorrection
from osm2xodr.python_api.options import ConvertOptions, refused
from osm2xodr.system import STANDARD_OUTPUT, parse_json

# Begin of the names of temporary folders.
_PREFIX: Final = "osm2xodr-"

_ELEMENT: Final = re.compile(r"(way|node|relation)/(-?\d{1,18})", re.ASCII)
_ID: Final = re.compile(r"-?\d{1,18}", re.ASCII)
# Properties of features that name the element, and those of `--osm-issues` and of notes, which say nothing else.
_ELEMENT_NAMES: Final = ("osm", "@id", "id")
_COMMENTS: Final = frozenset({"note", "code", "kind", "message", "url"})


class AreaMap(NamedTuple):
    """A map of an area and of nothing else."""

    path: Path  # The file
    options: ConvertOptions  # How to convert it
    on_stage: Callable[[str], None]  # Takes the names of stages, which may name the file


@contextlib.contextmanager
def area_map(area: Path, options: ConvertOptions, on_stage: Callable[[str], None]) -> Iterator[AreaMap]:
    """Yield the file with all of an area and nothing else.

    That is `area` itself, or a temporary file: what the options cut out of it, and what comes from standard input,
    because maps are read twice. Errors inside name what the user named.

    Raises
    ------
    OptionError
        `bbox` is none, or the options exclude each other.
    InputError
        The map or the polygons cannot be read; there is nothing to drive on in the area.
    """
    given = options.name_for(area)
    for option in ("bbox", "polygon"):
        other = "polygon" if option == "bbox" and options.polygon is not None else "frame"
        if getattr(options, option) is not None and getattr(options, other) is not None:
            raise OptionError(f"{option} and {other} exclude each other; give one of them", option, other)
    cut = options.bbox is not None or options.polygon is not None
    if not cut and area != STANDARD_OUTPUT:
        yield AreaMap(area, options, on_stage)
        return
    with tempfile.TemporaryDirectory(prefix=_PREFIX) as folder:
        path = area
        if area == STANDARD_OUTPUT:
            path = Path(folder) / "standard_input"
            with path.open("wb") as stream:
                shutil.copyfileobj(sys.stdin.buffer, stream)
        with _named_as(path, area):
            if cut:
                on_stage("cutting out the area")
                target = Path(folder) / "area.osm.pbf"
                _cut_out(path, target, options)
                path = target
        with _named_as(path, area):
            alone = options.changed(name=given, bbox=None, polygon=None, clip=False)
            yield AreaMap(path, alone, lambda stage: on_stage(stage.replace(str(path), _name(area))))


def _cut_out(source: Path, target: Path, options: ConvertOptions) -> None:
    """Cut an area out of a map, as a batch does."""
    # They load the reader of OSM files.
    from osm2xodr.batching import cut_areas
    from osm2xodr.fetching import place_of_box, place_of_file
    from osm2xodr.osmParsing import parse_ways_option

    place = place_of_box(str(options.bbox)) if options.polygon is None else place_of_file(Path(options.polygon))
    with refused("ways"):
        ways = parse_ways_option(str(options.ways))
    kept = frozenset[int]()
    if options.corrections is not None:
        kept = read_corrections(Path(options.corrections)).kept_ways()
    whole = place.cut_request(target)
    request = dataclasses.replace(
        whole, ways=ways, include_private=options.include_private, kept=kept, allow_partial=options.allow_partial
    )
    if not any(cut_areas(source, [request]).values()):
        raise EmptyAreaError(f"there is nothing to drive on in this part of {source}; give another area")


@contextlib.contextmanager
def _named_as(path: Path, given: Path) -> Iterator[None]:
    """Let errors name the file that was given in place of a temporary one."""
    try:
        yield
    except Osm2xodrError as error:
        error.args = (str(error).replace(str(path), _name(given)), *error.args[1:])
        raise


def _name(area: Path) -> str:
    """Return how users call a map."""
    return "standard input" if area == STANDARD_OUTPUT else str(area)


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
        keys = {key: value for key, value in properties.items() if value is not None and key not in _ELEMENT_NAMES}
        keys = {key: value for key, value in keys.items() if key not in _COMMENTS}
        if not keys:
            continue
        name = next((properties[key] for key in _ELEMENT_NAMES if properties.get(key) is not None), None)
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
