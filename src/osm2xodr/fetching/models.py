"""The table of elevation models, and where the files of a model are."""

from __future__ import annotations

import difflib
import math
import re
from collections.abc import Iterable, Mapping
from configparser import ConfigParser, Error, SectionProxy
from dataclasses import replace
from pathlib import Path
from typing import Final

from osm2xodr.errors import InputError, OptionError
from osm2xodr.fetching.connection import check_address
from osm2xodr.fetching.place import Box
from osm2xodr.system import record

_TABLE: Final = Path(__file__).with_name("elevation_models.ini")
_NEEDED: Final = ("title", "kind", "cell", "crs", "licence", "attribution")
_OPTIONAL: Final = ("url", "by_hand", "tile", "corner", "extent", "datum", "page")
_CORNERS: Final = ("south-west", "north-west")
_PLACEHOLDER: Final = re.compile(r"\{([^{}]*)\}")
_FIELD: Final = re.compile(r"(?:(x|y|x_km|y_km)([+-]\d{1,6})?|(lat|lon|NS|EW|ns|ew))(?::0(\d))?")


@record
class ElevationModel:
    """An elevation model whose files are on a server."""

    name: str
    title: str
    covered: bool  # Whether it shows canopy and roofs
    cell: float  # Side of a cell, m, about
    crs: str  # What its files are divided in
    tile: float  # Side of a file in units of `crs`; 0 where one file holds everything
    north: bool  # Whether files are named after their north-west corner rather than the south-west one
    # Addresses with placeholders, in the order in which they are tried; empty where its files are to be had by hand
    urls: tuple[str, ...]
    extent: Box  # Where it has heights: west, south, east, north, degrees
    datum: str  # EPSG code of what heights refer to; empty if unknown
    licence: str
    attribution: str
    page: str
    by_hand: str = ""  # How to get its files where they have no addresses

    def reaches(self, box: Box) -> bool:
        """Return whether it may have heights in a box (west, south, east, north, degrees)."""
        west, south, east, north = self.extent
        return west < box[2] and box[0] < east and south < box[3] and box[1] < north

    def files(self, bounds: Box) -> list[tuple[str, ...]]:
        """Return the files that reach into bounds in `crs`, from south-west on: their addresses, as of `urls`."""
        if not self.tile:
            return [self.urls]
        west, south, east, north = bounds
        columns = range(math.floor(west / self.tile), math.ceil(east / self.tile))
        rows = range(math.floor(south / self.tile), math.ceil(north / self.tile))
        corners = [(column * self.tile, (row + self.north) * self.tile) for row in rows for column in columns]
        return [tuple(_filled(url, x, y) for url in self.urls) for x, y in corners]


def read_models(files: Iterable[Path]) -> dict[str, ElevationModel]:
    """Return the elevation models by name: those that come along, and those of the user's files.

    `InputError` names what is wrong with a file.
    """
    models: dict[str, ElevationModel] = {}
    for path in (_TABLE, *files):
        # Addresses have signs of percent.
        parser = ConfigParser(interpolation=None, strict=True)
        try:
            parser.read_string(path.read_text(encoding="utf-8"), str(path))
        except OSError as error:
            why = (error.strerror or str(error)).lower()
            raise InputError(f"{path} cannot be read: {why}; check the path given with --dem-models") from error
        except (Error, UnicodeDecodeError) as error:
            why = " ".join(str(error).split())
            raise InputError(f"{path} is no table of elevation models ({why}); see docs/fetch.md") from error
        for name in parser.sections():
            models[name] = _model(parser[name], f"{path}, [{name}]")
    return models


def choose_models(
    names: Iterable[str], models: Mapping[str, ElevationModel], url: str | None
) -> list[ElevationModel]:
    """Return models by name, with another address if one is given; `OptionError` for names that are none."""
    found = []
    for name in dict.fromkeys(names):
        if name not in models:
            near = difflib.get_close_matches(name, models, 1)
            hint = f"do you mean {near[0]}?" if near else f"there are {', '.join(models)}"
            raise OptionError(f"dem_model {name} is unknown; {hint}", "dem_model")
        found.append(models[name])
    if url is None:
        for model in found:
            if model.by_hand:
                raise OptionError(
                    f"dem_model {model.name} has to be got by hand: {model.by_hand} ({model.page}); give its files "
                    "to convert with --dem, or an address of yours here with --dem-url",
                    "dem_model",
                )
        return found
    _check_url(url, "dem_url", found[0].tile)
    return [replace(found[0], urls=(url,), by_hand="")]


def _model(keys: SectionProxy, where: str) -> ElevationModel:
    """Return the model of a section."""
    for key in keys:
        if key not in _NEEDED + _OPTIONAL:
            known = ", ".join(_NEEDED + _OPTIONAL)
            raise InputError(f"{where}: {key!r} is no key of an elevation model; the keys are {known}")
    for key in _NEEDED:
        if not keys.get(key, "").strip():
            raise InputError(f"{where}: {key} is missing; see docs/fetch.md")
    kind, corner = keys["kind"], keys.get("corner", _CORNERS[0])
    if kind not in ("dtm", "dsm"):
        raise InputError(f"{where}: kind is {kind!r}; write dtm or dsm")
    if corner not in _CORNERS:
        raise InputError(f"{where}: corner is {corner!r}; write {' or '.join(_CORNERS)}")
    (cell,) = _numbers(keys["cell"], 1, f"{where}: cell")
    (tile,) = _numbers(keys.get("tile", "0"), 1, f"{where}: tile")
    if cell <= 0.0 or tile < 0.0:
        raise InputError(f"{where}: cell and tile are lengths; write numbers above 0")
    west, south, east, north = _numbers(keys.get("extent", "-180, -90, 180, 90"), 4, f"{where}: extent")
    urls = tuple(line.strip() for line in keys.get("url", "").splitlines() if line.strip())
    by_hand = " ".join(keys.get("by_hand", "").split())
    if bool(urls) == bool(by_hand):
        raise InputError(
            f"{where}: it needs either url or by_hand, which says how to get its files; see docs/fetch.md"
        )
    for url in urls:
        try:
            _check_url(url, "url", tile)
        except OptionError as error:
            raise InputError(f"{where}: {error}") from error
    return ElevationModel(
        keys.name, keys["title"], kind == "dsm", cell, keys["crs"], tile, corner == "north-west", urls,
        (west, south, east, north), keys.get("datum", ""), keys["licence"], keys["attribution"], keys.get("page", ""),
        by_hand,
    )  # fmt: skip


def _numbers(text: str, count: int, where: str) -> list[float]:
    try:
        numbers = [float(word) for word in text.split(",")]
    except ValueError:
        numbers = []
    if len(numbers) != count or not all(map(math.isfinite, numbers)):
        raise InputError(f"{where} is {text!r}; write {'a number' if count == 1 else f'{count} numbers with commas'}")
    return numbers


def _check_url(url: str, option: str, tile: float) -> None:
    """Refuse an address that is none, or has placeholders that nothing is known for."""
    for field in _PLACEHOLDER.findall(url):
        if not _FIELD.fullmatch(field):
            raise OptionError(f"{option} {url} has {{{field}}}, which stands for nothing; see docs/fetch.md", option)
    if tile and not _PLACEHOLDER.search(url):
        raise OptionError(
            f"{option} {url} is the same for all files of the model; write {{x}} or {{lat}} where they differ", option
        )
    check_address(option, _filled(url, 0.0, 0.0))


def _filled(url: str, x: float, y: float) -> str:
    """Return an address with the placeholders filled in for the corner of a file."""
    column, row = round(x), round(y)
    numbers = {"x": column, "y": row, "x_km": column // 1000, "y_km": row // 1000}
    words = {
        "lon": str(abs(column)),
        "lat": str(abs(row)),
        "NS": "S" if row < 0 else "N",
        "EW": "W" if column < 0 else "E",
        "ns": "s" if row < 0 else "n",
        "ew": "w" if column < 0 else "e",
    }

    def fill(match: re.Match[str]) -> str:
        field = _FIELD.fullmatch(match[1])
        assert field is not None
        text = words[field[3]] if field[3] else str(numbers[field[1]] + int(field[2] or 0))
        return text.rjust(int(field[4] or 0), "0")

    return _PLACEHOLDER.sub(fill, url)
