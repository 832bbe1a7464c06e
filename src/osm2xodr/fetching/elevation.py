"""Elevation models as they are written: the windows of their files that an area needs."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Final

from osm2xodr.errors import CoverageError, InputError
from osm2xodr.fetching.connection import Connection, Response, host, mark_of, range_of, shown
from osm2xodr.fetching.downloads import Wanted, download, key_of, not_wanted
from osm2xodr.fetching.models import ElevationModel
from osm2xodr.fetching.options import FetchOptions, ServerError
from osm2xodr.fetching.place import DEGREE, Box, widened
from osm2xodr.fetching.rasters import (
    CELLS_MAX,
    PART,
    Raster,
    RasterError,
    RemoteFile,
    bounds_in,
    joined,
    packed,
    read_window,
    unpacked,
    void_share,
)
from osm2xodr.system import make_folder, record, stream_to

# First bytes of TIFF and BigTIFF in both orders of bytes.
_TIFF: Final = (b"II*\0", b"MM\0*", b"II+\0", b"MM\0+")
# Files that are not there: some models have none at sea, or beyond their country (RFC 9110).
_ABSENT: Final = frozenset({404, 410})
# Services that make a file anew for each request (OGC's WCS and WMS): it is asked for once, as a whole.
_CUT_OUT: Final = re.compile(r"[?&]request=get(coverage|map)\b", re.IGNORECASE)
# Elevation models reach farther than the roads by this, m: what lies beside them, and what interpolation needs.
_MARGIN: Final = 150.0
# An area whose box has more cells than this many times what is read is refused before anything is asked for; the box
# of degrees may be larger than that of the model.
_CELLS_SLACK: Final = 1.5


@record
class FetchedModel:
    """An elevation model that was written."""

    paths: tuple[Path, ...]  # Several where its cells change in size or kind within the area
    model: ElevationModel
    urls: tuple[str, ...]  # Addresses of the files that it was cut out of
    absent: int  # How many further files there might be, but are not
    voids: float  # Largest share of cells without a height in a file


def with_margin(box: Box) -> Box:
    """Return a box (west, south, east, north, degrees) with what heights are needed of around it."""
    return widened(box, _MARGIN)


def fetch_models(
    connection: Connection, box: Box, models: Sequence[ElevationModel], options: FetchOptions, out_dir: Path
) -> list[FetchedModel]:
    """Write what elevation models have in a box: ``dem.tif``, ``dem_2.tif`` and so on, in the order of the models.

    Raises
    ------
    CoverageError
        None of them has a height there.
    InputError
        The area is too large for one of them.
    ServerError, OutputError
        A server does not give what it should, or there is no room for it.
    """
    for model in models:
        _check_extent(model, box)
    found: list[FetchedModel] = []
    number = 0
    for model in models:
        fetched, urls, absent = _fetch(connection, box, model, options)
        paths = []
        for raster in fetched:
            number += 1
            target = dem_path(out_dir, number)
            kind = "digital surface model" if model.covered else "digital terrain model"
            with stream_to(target) as stream:
                description = f"{model.title}, {kind}"
                stream.write(packed(raster, description, model.attribution))
            paths.append(target)
        if paths:
            voids = max(void_share(raster) for raster in fetched)
            found.append(FetchedModel(tuple(paths), model, tuple(urls), absent, voids))
        else:
            connection.network.note(f"{model.title} has no heights in the area")
    if not found:
        names = " and ".join(model.title for model in models)
        raise CoverageError(f"{names}: there are no heights in the area; choose another model with --dem-model")
    return found


def dem_path(out_dir: Path, number: int) -> Path:
    """Return the name of an elevation model, counted from 1."""
    return out_dir / ("dem.tif" if number == 1 else f"dem_{number}.tif")


def _check_extent(model: ElevationModel, box: Box) -> None:
    """Refuse a model that cannot have heights in a box, or far too many, before anything is asked for."""
    west, south, east, north = box
    if not model.reaches(box):
        raise CoverageError(
            f"{model.title} has heights from {model.extent[0]:g} to {model.extent[2]:g} E and {model.extent[1]:g} to "
            f"{model.extent[3]:g} N, and the area lies elsewhere; choose another model with --dem-model"
        )
    across = (east - west) * math.cos(math.radians(0.5 * (south + north)))
    cells = across * (north - south) * (DEGREE / model.cell) ** 2
    if cells > _CELLS_SLACK * CELLS_MAX:
        raise InputError(
            f"the area has {cells / 1e6:,.0f} million cells of {model.title}, more than the {CELLS_MAX / 1e6:,.0f} "
            "million that are read; give a smaller area, or a coarser model with --dem-model"
        )


def _fetch(
    connection: Connection, box: Box, model: ElevationModel, options: FetchOptions
) -> tuple[list[Raster], list[str], int]:
    """Return what a model has in a box, the addresses of its files, and how many are absent."""
    files = model.files(bounds_in(model.crs, box))
    rasters: list[Raster] = []
    urls: list[str] = []
    absent = 0
    for place, addresses in enumerate(files):
        state = f"{place} of {len(files)} files"
        connection.network.progress(f"reading {model.title}", state, place / len(files))
        url, raster = _first_window(connection, addresses, box, model, options)
        absent += not url
        if raster is not None:
            rasters.append(raster)
            urls.append(url)
    return joined(rasters, model), urls, absent


def _first_window(
    connection: Connection, addresses: Sequence[str], box: Box, model: ElevationModel, options: FetchOptions
) -> tuple[str, Raster | None]:
    """Return the first address of a file that is there, empty if there is none, and what it has in a box."""
    failed: list[ServerError] = []
    for url in addresses:
        try:
            there, raster = _window(connection, url, box, model, options)
        except ServerError as error:
            failed.append(error)
            continue
        if there:
            for fault in failed:
                connection.network.note(f"{fault}; {shown(url)} was taken instead")
            return url, raster
    if failed:
        # It may be there.
        raise failed[0]
    return "", None


def _window(
    connection: Connection, url: str, box: Box, model: ElevationModel, options: FetchOptions
) -> tuple[bool, Raster | None]:
    """Return whether a file is there, and what it has in a box, from the cache if that is there."""
    folder = options.cache_dir / "elevation"
    kept = folder / f"{key_of(url, model.datum, *(f'{value:.7f}' for value in box))}.tif"
    if options.age and kept.is_file():
        try:
            return True, unpacked(kept)
        except RasterError:
            kept.unlink(missing_ok=True)
    file = _open(connection, url, options)
    if file is None:
        return False, None
    try:
        raster = read_window(file, box, model)
    except RasterError as problem:
        if isinstance(file, Path):
            # It must not be taken for a good one the next time.
            file.unlink(missing_ok=True)
        raise ServerError(
            f"{shown(url)} cannot be read to its end ({problem}); try again later, or give another address with "
            "--dem-url"
        ) from None
    if raster is None:
        return True, None
    make_folder(folder)
    with stream_to(kept) as stream:
        stream.write(packed(raster, model.title, model.attribution))
    # As it comes from the cache the next time, where numbers and names may have been rounded.
    return True, unpacked(kept)


def _wanted(url: str) -> Wanted:
    return Wanted(url, "--dem-url", "a GeoTIFF", lambda head: head.startswith(_TIFF))


def _open(connection: Connection, url: str, options: FetchOptions) -> Path | RemoteFile | None:
    """Return a file to read, None if it is not there; files are downloaded where a server does not send parts."""
    wanted = _wanted(url)
    folder, age = options.cache_dir / "elevation", math.inf if options.age else 0.0

    def read(response: Response) -> RemoteFile | None:
        head = b""
        for chunk in connection.chunks(response):
            head += chunk
            # A server without parts sends everything.
            if len(head) >= PART:
                break
        if not wanted.looks_right(head):
            raise ServerError(not_wanted(wanted, head, response), response.status)
        begins, size = range_of(response)
        if response.status != 206 or begins != 0 or size is None:
            return None
        return RemoteFile(connection, response.geturl(), size, mark_of(response), head)

    try:
        if _CUT_OUT.search(url):
            return download(connection, wanted, folder, age)
        file = connection.ask(url, "--dem-url", read, lambda: {"Range": f"bytes=0-{PART - 1}"})
    except ServerError as error:
        if error.status in _ABSENT:
            return None
        raise
    if file is not None:
        return file
    connection.network.note(f"{host(url)} does not send parts of files; {shown(url)} is downloaded whole")
    return download(connection, wanted, folder, age)
