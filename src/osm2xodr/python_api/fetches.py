"""The function ``fetch``. It loads what it needs when it is called."""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Final

from osm2xodr.errors import OptionError
from osm2xodr.fetching import (
    CACHE_AGE,
    DOWNLOAD_MAX,
    ELEVATION_MODEL,
    GEOCODER,
    OVERPASS_SERVERS,
    PATIENCE,
    RETRIES,
)
from osm2xodr.python_api.options import paths

if TYPE_CHECKING:
    from osm2xodr.fetching import FetchedArea, Place, Shows
    from osm2xodr.python_api.files import AnyPath

_MEGABYTE: Final = 1e6
# Names of places with these endings are files.
_GEOJSON: Final = (".geojson", ".json")


def fetch(
    output: AnyPath,
    *,
    bbox: str | Sequence[float] | None = None,
    place: AnyPath | None = None,
    geocoder: str = GEOCODER,
    extract: AnyPath | None = None,
    overpass: str | Iterable[str] = OVERPASS_SERVERS,
    dem_model: str | Iterable[str] = ELEVATION_MODEL,
    dem_models: AnyPath | Iterable[AnyPath] = (),
    dem_url: str | None = None,
    no_osm: bool = False,
    no_dem: bool = False,
    no_surroundings: bool = False,
    allow_partial: bool = False,
    pbf: bool = False,
    cache: AnyPath | None = None,
    max_age: float = CACHE_AGE,
    refresh: bool = False,
    max_download: float = DOWNLOAD_MAX / _MEGABYTE,
    patience: float = PATIENCE,
    retries: int = RETRIES,
    overwrite: bool = False,
    say: Callable[[str], None] | None = None,
    progress: Shows | None = None,
) -> FetchedArea:
    """Get the map of an area from OpenStreetMap, and elevation models of it, ready to convert.

    Give one of `bbox` and `place`.

    Parameters
    ----------
    output
        Folder to write ``area.osm``, ``dem.tif`` and ``SOURCES.md`` to.
    bbox
        West, south, east, north, degrees, WGS 84.
    place
        GeoJSON file with polygons, or the name of a place, which the geocoder is asked for.
    geocoder
        Geocoder with the API of Nominatim.
    extract
        Map to cut the area out of, a file or an address; by default the Overpass API is asked.
    overpass
        Servers of the Overpass API; the next one is asked where one fails.
    dem_model
        Elevation models by name, the preferred one first.
    dem_models
        Tables of further models.
    dem_url
        Where the only elevation model is, as tables write addresses.
    no_osm, no_dem, no_surroundings
        Fetch no map, no elevation model, no buildings and water.
    allow_partial
        Take what there is of an extract that its server did not send in full.
    pbf
        Write ``area.osm.pbf`` instead of ``area.osm``.
    cache
        Folder for what was received; by default ``osm2xodr`` in ``$XDG_CACHE_HOME`` or ``~/.cache``.
    max_age
        How old a map in the cache may be, s.
    refresh
        Take nothing from the cache.
    max_download
        Largest file to download whole, MB.
    patience
        How long a server may be silent or slow, s.
    retries
        How often to ask again where a server is busy or a connection cut.
    overwrite
        Replace files that exist.
    say
        Is called with each sentence about why there is a wait.
    progress
        Is called with what is done at the moment, its state in words, and what share of it is done, if known.

    Returns
    -------
    FetchedArea
        The files: ``convert(found.osm.path, found.dems)`` goes on.

    Raises
    ------
    OptionError
        An option has a value that cannot be, or contradicts another one.
    InputError
        There is no such place, the area has no roads or is too large, or a file cannot be read.
    CoverageError
        There are no heights in the area.
    Osm2xodrError
        A server cannot be reached, or does not give what it was asked for.
    OutputError
        A file cannot be written, or exists.
    """
    area = _area(bbox, place)
    from osm2xodr.fetching import FetchOptions, Network, fetch_area

    network = Network(patience=patience, retries=retries, download_max=round(max_download * _MEGABYTE))
    if say is not None:
        network = dataclasses.replace(network, note=say)
    if progress is not None:
        network = dataclasses.replace(network, progress=progress)
    options = FetchOptions(
        out_dir=Path(output),
        cache_dir=_cache_dir() if cache is None else Path(cache),
        extract=None if extract is None else os.fspath(extract),
        overpass=_each(overpass) or OVERPASS_SERVERS,
        geocoder=geocoder,
        models=_each(dem_model) or (ELEVATION_MODEL,),
        model_files=paths(dem_models),
        model_url=dem_url,
        osm=not no_osm,
        dem=not no_dem,
        surroundings=not no_surroundings,
        pbf=pbf,
        allow_partial=allow_partial,
        age=0.0 if refresh else max_age,
        overwrite=overwrite,
        network=network,
    )
    return fetch_area(area, options)


def _area(bbox: str | Sequence[float] | None, place: AnyPath | None) -> Place | str:
    """Return the area that is asked for; a text where it is the name of a place."""
    from osm2xodr.fetching import place_of_box, place_of_file

    if bbox is not None and place is not None:
        raise OptionError("bbox and place exclude each other; give one of them", "bbox", "place")
    if bbox is not None:
        return place_of_box(bbox if isinstance(bbox, str) else ",".join(map(str, bbox)))
    named = "" if place is None else os.fspath(place)
    if not named.strip():
        raise OptionError("no area is given; give bbox W,S,E,N in degrees, or place NAME|FILE", "bbox", "place")
    is_file = isinstance(place, os.PathLike) or Path(named).is_file() or Path(named).suffix.lower() in _GEOJSON
    return place_of_file(Path(named)) if is_file else named


def _each(given: str | Iterable[str]) -> tuple[str, ...]:
    return (given,) if isinstance(given, str) else tuple(given)


def _cache_dir() -> Path:
    """Return the folder that the system has for such files (XDG Base Directory Specification)."""
    given = os.environ.get("XDG_CACHE_HOME", "")
    # Relative ones are to be ignored.
    return (Path(given) if os.path.isabs(given) else Path("~/.cache").expanduser()) / "osm2xodr"
