"""Manifests: lists of areas that people write, in TOML or CSV, and the files that they name."""

from __future__ import annotations

import csv
import difflib
import io
import math
import shlex
import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final

from osm2xodr.batching.areas import RingDeg, check_names, check_ring, read_file, read_polygons
from osm2xodr.batching.model import Area
from osm2xodr.errors import InputError
from osm2xodr.surface import expand
from osm2xodr.system import record

# Keys of an area beside options of ``convert``, and those that can be the same for all areas.
_OWN: Final = ("name", "osm", "dem", "bbox", "polygon", "options")
_COMMON: Final = frozenset({"osm", "dem", "options"})
_FLAG_WORDS: Final = MappingProxyType(
    {"true": True, "yes": True, "1": True, "false": False, "no": False, "0": False, "": False}
)

_Keys = Mapping[str, Any]


@record
class ManifestContext:
    """What the command line knows about areas."""

    # Names of the options of ``convert`` that an area may have, without dashes; whether each is a flag
    options: Mapping[str, bool]
    # Puts options as typed in order, for areas with elevation models or without; raises ValueError with a sentence
    # where they are wrong
    check: Callable[[tuple[str, ...], bool], tuple[str, ...]]
    dems: tuple[Path, ...] = ()  # Elevation models of areas that name none
    given: tuple[str, ...] = ()  # Options for all areas


def read_manifest(path: Path, context: ManifestContext) -> list[Area]:
    """Read a manifest, ``.toml`` or ``.csv``; paths in it are relative to its folder.

    `InputError` names what is wrong with it: the place, the key, and what to do.
    """
    read = {".toml": _read_toml, ".csv": _read_csv}.get(path.suffix.lower())
    if read is None:
        raise InputError(f"{path} is not a manifest; give a file that ends in .toml or .csv")
    text = decoded(path, read_file(path))
    common, tables = read(path, text)
    if not tables:
        raise InputError(f"{path} lists no areas; give at least one, with a name and an osm file")
    reader = _Reader(path.parent, context, common)
    areas = [reader.area(keys, where) for where, keys in tables]
    check_names((area.name for area in areas), str(path))
    return areas


def _read_toml(path: Path, text: str) -> tuple[tuple[str, _Keys], list[tuple[str, _Keys]]]:
    """Return the defaults and the areas of a TOML file, each with its place."""
    document = parse_toml(path, text)
    for key in document:
        if key not in ("defaults", "area"):
            raise InputError(f"{path}: {unknown_key(key, ('defaults', 'area'))}; write [defaults] and [[area]]")
    common, tables = document.get("defaults", {}), document.get("area", [])
    if not isinstance(common, dict):
        raise InputError(f"{path}: defaults is not a table; write [defaults]")
    if not isinstance(tables, list) or not all(isinstance(item, dict) for item in tables):
        raise InputError(f"{path}: area is not a list of tables; write [[area]], with two brackets, before each")
    names = [f" ({keys['name']})" if isinstance(keys.get("name"), str) else "" for keys in tables]
    found = [(f"{path}, area {place}{names[place - 1]}", keys) for place, keys in enumerate(tables, start=1)]
    return (f"{path}, [defaults]", common), found


def _read_csv(path: Path, text: str) -> tuple[tuple[str, _Keys], list[tuple[str, _Keys]]]:
    """Return no defaults, and the areas of a CSV file, each with its place; empty cells are left out."""
    rows = csv.reader(io.StringIO(text, newline=""), strict=True)
    found: list[tuple[str, _Keys]] = []
    try:
        header = [cell.strip() for cell in next(rows, [])]
        if "name" not in header:
            raise InputError(f"{path}, line 1: it names no columns; begin with a line such as name,osm,dem,bbox")
        doubled = next((cell for cell in header if header.count(cell) > 1), None)
        if doubled is not None:
            raise InputError(f"{path}, line 1: there are two columns {doubled!r}; leave one out")
        for row in rows:
            where = f"{path}, line {rows.line_num}"
            if not any(cell.strip() for cell in row):
                continue
            if len(row) != len(header):
                raise InputError(
                    f"{where}: it has {len(row)} cells, and line 1 has {len(header)}; put text with commas in quotes"
                )
            cells = {key: cell.strip() for key, cell in zip(header, row, strict=True)}
            found.append((where, {key: _cell(key, cell, where) for key, cell in cells.items() if cell}))
    except csv.Error as error:
        raise InputError(f"{path}, line {rows.line_num}: it is not CSV: {error}; check commas and quotes") from error
    return (str(path), {}), found


def _cell(key: str, cell: str, where: str) -> Any:
    """Return the value of a cell as TOML would have it."""
    if key == "dem":
        return [item.strip() for item in cell.split(";") if item.strip()]
    if key == "bbox":
        try:
            return [float(item) for item in cell.split(",")]
        except ValueError:
            raise InputError(
                f'{where}: bbox {cell!r} is not "west,south,east,north" in degrees; write it so'
            ) from None
    return cell


class _Reader:
    """Makes areas of the keys of a manifest."""

    def __init__(self, folder: Path, context: ManifestContext, common: tuple[str, _Keys]) -> None:
        self._folder = folder
        self._context = context
        where, self._common = common
        for key in self._common:
            if key in _OWN and key not in _COMMON:
                raise InputError(f"{where}: {key} cannot be the same for all areas; give it in each [[area]]")
        self._check_keys(self._common, where)
        self._common_options = self._typed(self._common, where)
        self._switches(self._common, where)

    def area(self, keys: _Keys, where: str) -> Area:
        """Return an area."""
        self._check_keys(keys, where)
        name = keys.get("name")
        if not isinstance(name, str):
            raise InputError(f'{where}: it has no name; give one, such as name = "harbour"')
        both = {**self._common, **keys}
        typed = (*self._context.given, *self._common_options, *self._typed(keys, where))
        dems = self._dems(both, where)
        try:
            options = self._context.check((*typed, *self._switches(both, where)), bool(dems))
        except ValueError as error:
            raise InputError(f"{where}: {error}") from error
        outline = self._outline(keys, where)
        return Area(name, self._osm(both, where), dems, options, outline, where)

    def _check_keys(self, keys: _Keys, where: str) -> None:
        known = (*_OWN, *self._context.options)
        for key in keys:
            if key not in known:
                raise InputError(f"{where}: {unknown_key(key, known)}")

    def _osm(self, keys: _Keys, where: str) -> Path:
        osm = keys.get("osm")
        if not isinstance(osm, str) or not osm:
            raise InputError(f'{where}: it has no osm file; give one, such as osm = "area.osm.pbf"')
        return self._folder / osm

    def _dems(self, keys: _Keys, where: str) -> tuple[Path, ...]:
        dems = keys.get("dem")
        if dems is None:
            return self._context.dems
        listed = [dems] if isinstance(dems, str) else dems
        if not isinstance(listed, list) or not all(isinstance(item, str) and item for item in listed):
            raise InputError(
                f'{where}: dem is neither a path nor a list of paths; write dem = "dem.tif" or ["a.tif", "b.tif"]'
            )
        try:
            return expand([str(self._folder / item) for item in listed])
        except InputError as error:
            raise InputError(f"{where}: dem: {error}") from error

    def _typed(self, keys: _Keys, where: str) -> tuple[str, ...]:
        """Return the words of the key ``options``."""
        options = keys.get("options", "")
        if isinstance(options, list) and all(isinstance(item, str) for item in options):
            return tuple(options)
        if not isinstance(options, str):
            raise InputError(f'{where}: options is not text; write options = "--ways major --left-hand"')
        try:
            return tuple(shlex.split(options))
        except ValueError as error:
            raise InputError(f"{where}: options: {str(error).lower()}; check the quotes") from error

    def _switches(self, keys: _Keys, where: str) -> list[str]:
        """Return the options with keys of their own, as on the command line."""
        words = []
        for key, value in keys.items():
            if key in _OWN:
                continue
            if self._context.options[key]:
                chosen = _FLAG_WORDS.get(value.lower()) if isinstance(value, str) else value
                if not isinstance(chosen, bool):
                    raise InputError(f"{where}: {key} is {value!r}; write true or false")
                words += [f"--{key}"] if chosen else []
            elif isinstance(value, bool) or not isinstance(value, (str, int, float)):
                raise InputError(f"{where}: {key} is neither text nor a number; write it as after --{key} of convert")
            else:
                words += [f"--{key}", str(value)]
        return words

    def _outline(self, keys: _Keys, where: str) -> tuple[RingDeg, ...]:
        bbox, polygon = keys.get("bbox"), keys.get("polygon")
        if bbox is not None and polygon is not None:
            raise InputError(f"{where}: bbox and polygon exclude each other; give one of them")
        if bbox is not None:
            return (_box(bbox, where),)
        if isinstance(polygon, str):
            try:
                found = read_polygons(self._folder / polygon)
            except InputError as error:
                raise InputError(f"{where}: polygon: {error}") from error
            return tuple(ring for _, rings in found for ring in rings)
        if polygon is not None:
            return (check_ring(polygon, f"{where}: polygon"),)
        return ()


def _box(box: Any, where: str) -> RingDeg:
    """Return the corners of west, south, east, north."""
    words = f"{where}: bbox is not [west, south, east, north] in degrees"
    numbers = box if isinstance(box, list) else []
    if len(numbers) != 4 or any(isinstance(item, bool) or not isinstance(item, (int, float)) for item in numbers):
        raise InputError(f"{words}; write such as [1.50, 42.50, 1.55, 42.55]")
    west, south, east, north = (float(item) for item in numbers)
    if not (-180.0 <= west < east <= 180.0 and -90.0 < south < north < 90.0):
        raise InputError(
            f"{words}: {west:g}, {south:g}, {east:g}, {north:g}; put west before east, south before north"
        )
    return (west, south), (east, south), (east, north), (west, north)


def parse_toml(path: Path, text: str) -> dict[str, Any]:
    """Return the contents of a TOML file; `InputError` says where it is none."""
    if sys.version_info >= (3, 11):
        import tomllib
    else:
        import tomli as tomllib
    try:
        document: dict[str, Any] = _within_64_bits(tomllib.loads(text))
    except (ValueError, RecursionError) as error:
        raise InputError(f"{path} is not TOML: {error}; see https://toml.io") from error
    return document


def _within_64_bits(value: Any) -> Any:
    """Return a value with infinity in place of whole numbers of more than the 64 bits that TOML has for them."""
    if isinstance(value, dict):
        return {key: _within_64_bits(item) for key, item in value.items()}
    if isinstance(value, list):
        return [_within_64_bits(item) for item in value]
    if isinstance(value, int) and not -(1 << 63) <= value < 1 << 63:
        return math.inf if value > 0 else -math.inf
    return value


def decoded(path: Path, contents: bytes) -> str:
    """Return the text of a file; `InputError` says where it is not UTF-8."""
    try:
        return contents.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError(
            f"{path} is not in UTF-8 ({error.reason} at byte {error.start}); save it as UTF-8"
        ) from error


def unknown_key(key: str, known: Sequence[str]) -> str:
    """Say that a key is unknown, and which one may be meant."""
    near = difflib.get_close_matches(key.replace("_", "-").lstrip("-").lower(), known, 1)
    return f"{key!r} is unknown" + (f"; do you mean {near[0]!r}?" if near else f"; known are {', '.join(known)}")
