"""From elevation models to the surface of the ground: the steps of stage 2 in order, and what is reported of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Final

import numpy as np

from osm2xodr.curves import hypot, ranks
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.errors import CoverageError, InputError
from osm2xodr.model import FloatArray, LocalFrame, Street
from osm2xodr.projection import to_geographic
from osm2xodr.surface.grids import FOOT, DemSource, GridFrame, convert_heights, parse_datum, rasters_in, unstated
from osm2xodr.surface.mosaic import (
    DemWindow,
    bounds_deg,
    by_priority,
    describe_all,
    fit_trend,
    make_layers,
    read_windows,
)
from osm2xodr.surface.options import SurfaceOptions
from osm2xodr.surface.sampling import Bounds, DemSummary, DemSurface, LayeredSurface, qualities_of

# Largest number of cells that are kept of all elevation models (128 MB in single precision), and for a bicubic
# spline, which takes 30 bytes more per cell. Where the roads span more, the finest models are averaged over blocks of
# cells, with a note.
_CELLS_MAX: Final = 2**25
_CELLS_MAX_BICUBIC: Final = 2**23
# Spacing of the points along roads that say which cells are needed, m: below the cells of the coarsest elevation
# models in use (90 m).
_POINT_STEP: Final = 50.0
# Places whose heights OSM knows that tell a model in feet, at least, and how high they must be, m: another datum must
# not look like another unit. And how far heights may be off, as a share. Choices.
_FEET_PLACES: Final = 3
_FEET_ABOVE: Final = 50.0
_FEET_TOLERANCE: Final = 0.15
# Cells of height 0 from which a model is reported as level: few may be so by chance, or on a shore. A choice.
_LEVEL_CELLS: Final = 100

# Least share of the roads that elevation models must cover unless the user allows less: guesses should not outweigh
# measurements. A choice.
_COVERAGE_MIN: Final = 0.5
# Number of files that a message names before "and n more".
_FILES_NAMED: Final = 3


def points_along(streets: Sequence[Street], step: float = _POINT_STEP) -> tuple[FloatArray, FloatArray]:
    """Return local x, y (n,) of points along streets (one at least), their ends among them, up to `step` apart, m."""
    points = np.concatenate([street.points for street in streets])
    counts = np.array([len(street.points) for street in streets])
    first = np.concatenate([[0], np.cumsum(counts)])
    # All streets are put end to end on one line, with gaps between them, and interpolated at once.
    pieces = hypot(*np.diff(points, axis=0).T)
    pieces[first[1:-1] - 1] = 1.0
    along = np.concatenate([[0.0], np.cumsum(pieces)])
    start, end = along[first[:-1]], along[first[1:] - 1]
    steps = np.maximum(np.ceil((end - start) / step).astype(np.int64), 1)
    index = ranks(steps + 1)
    at = np.repeat(start, steps + 1) + index * np.repeat((end - start) / steps, steps + 1)
    return np.interp(at, along, points[:, 0]), np.interp(at, along, points[:, 1])


def read_surface(
    paths: Sequence[Path],
    frame: LocalFrame,
    x: FloatArray,
    y: FloatArray,
    options: SurfaceOptions,
    diagnostics: Diagnostics,
) -> DemSurface:
    """Make the surface of the ground from elevation models: local raster files of any CRS, cells and unit.

    Zip archives stand for the rasters in them. Where several overlap, finer cells come first, then the order given;
    their seams are blended. Neither positions nor cells are resampled: heights are found in each raster's own CRS.
    x, y (n,), m, are points along all roads in a local frame: they decide what is read. Diagnostics get what is
    guessed or repaired.

    Raises
    ------
    InputError
        A file is missing, damaged, no raster, an image, not local, or without CRS; or heights cannot be converted to
        the wanted vertical datum.
    CoverageError
        The elevation models lie elsewhere, or have no heights at the roads.
    """
    if not paths:
        raise InputError("no elevation model was given; name at least one file")
    x, y = np.asarray(x, np.float64).reshape(-1), np.asarray(y, np.float64).reshape(-1)
    if not len(x):
        raise InputError("there are no roads to find heights for; choose an area that has some")
    paths = [raster for path in paths for raster in rasters_in(path)]
    known = unstated(options.dem_crs, options.dem_unit, options.dem_encoding)
    described = describe_all(paths, known, frame, diagnostics)
    bounds = [bounds_deg(cells) for _, cells in described]
    cells_max = _CELLS_MAX_BICUBIC if options.method == "bicubic" else _CELLS_MAX
    windows = read_windows(described, x, y, cells_max, diagnostics)
    used = _in_datum(_used(paths, windows, bounds, frame, x, y, diagnostics), options, diagnostics)
    layers = make_layers(by_priority(used), cells_max, options.dem_type, diagnostics)
    trend = fit_trend(layers, options.polynomial_order)
    if trend.polynomial.order < options.polynomial_order:
        wanted, fitted = options.polynomial_order, trend.polynomial.order
        text = f"{paths[0]}: too few heights for a trend of degree {wanted}; degree {fitted} was fitted."
        diagnostics.note("trend-order", "", text)
    layered = LayeredSurface(layers, trend, options.method)
    source = layered.sample(x, y)[1]
    if not (source >= 0).any():
        remedy = "give an elevation model that covers the roads"
        raise CoverageError(f"{names_of(paths)}: no road has a measured height; {remedy}")
    main = int(np.bincount(source[source >= 0]).argmax())
    sigmas = np.array([layer.sigma if options.sigma is None else options.sigma for layer in layers])
    if options.method == "polynomial":
        sigmas = np.maximum(sigmas, trend.polynomial.rms)
    summaries = tuple(_summary(*item) for item in zip(described, windows, bounds, strict=True))
    return DemSurface(
        layers[main].cell_size,
        float(sigmas[main]),
        summaries,
        trend.polynomial,
        layered,
        qualities_of(layered, main, sigmas),
    )


def suspect_feet(
    paths: Sequence[Path], surface: DemSurface, x: FloatArray, y: FloatArray, z: FloatArray, diagnostics: Diagnostics
) -> None:
    """Report elevation models that seem to be in feet: heights are 3.28 times those at known places.

    x, y (n,), m, are these places, and z their heights by OSM, m.
    """
    high = z >= _FEET_ABOVE
    if high.sum() < _FEET_PLACES:
        return
    found, measured = surface.heights(x[high], y[high])
    ratio = found[measured] / z[high][measured] * FOOT
    like = np.abs(ratio - 1.0) < _FEET_TOLERANCE
    if len(ratio) >= _FEET_PLACES and like.mean() > 0.5:
        text = f"at {like.sum()} of {len(ratio)} places heights are 3.28 times what OSM's ele says, as of feet"
        diagnostics.guessed(
            "dem-unit", "", f"{names_of(paths)}: {text}; if they are feet, say so with --dem-unit ft."
        )


def _in_datum(windows: list[DemWindow], options: SurfaceOptions, diagnostics: Diagnostics) -> list[DemWindow]:
    """Convert heights to the wanted vertical datum, if any; else report if the models have several."""
    if options.vertical_datum is None:
        names = sorted({window.source.datum.name for window in windows if window.source.datum is not None})
        if len(names) > 1:
            diagnostics.note(
                "dem-datums",
                "",
                f"{names_of([window.source.path for window in windows])}: heights refer to several datums "
                f"({', '.join(names)}) and were taken as they are; --vertical-datum converts them to one.",
            )
        return windows
    target = parse_datum(options.vertical_datum)
    given = None if options.dem_vertical_datum is None else parse_datum(options.dem_vertical_datum)
    out = []
    for window in windows:
        source = window.source.datum if given is None else given
        if source is None:
            raise InputError(
                f"{window.source.path}: the elevation model does not say to which datum its heights refer, so "
                "that they cannot be converted; name it with --dem-vertical-datum, or leave --vertical-datum out"
            )
        z = convert_heights(window.source.path, window.z, window.frame, source, target, diagnostics)
        out.append(replace(window, z=z))
    return out


def _used(
    paths: Sequence[Path],
    windows: Sequence[DemWindow | None],
    bounds: Sequence[Bounds],
    frame: LocalFrame,
    x: FloatArray,
    y: FloatArray,
    diagnostics: Diagnostics,
) -> list[DemWindow]:
    """Return the windows with heights, report averaged and unused models; fail if none has heights at the roads."""
    averaged = [window for window in windows if window is not None and window.block > 1]
    if averaged:
        names, block = names_of([window.source.path for window in averaged]), max(window.block for window in averaged)
        why = f"the roads span more cells than are kept; blocks of {block} x {block} cells were averaged."
        diagnostics.note("dem-averaged", "", f"{names}: {why}")
    away = [path for path, window in zip(paths, windows, strict=True) if window is None]
    reached = [window for window in windows if window is not None]
    used = [window for window in reached if np.isfinite(window.z).any()]
    empty = [window.source.path for window in reached if not np.isfinite(window.z).any()]
    for unused, why in ((away, "it does not reach the roads"), (empty, "it has only nodata around the roads")):
        if unused:
            diagnostics.note("dem-unused", "", f"{names_of(unused)}: not used, {why}.")
    for window in used:
        _report_level(window, diagnostics)
    if used:
        return used
    names = names_of(paths)
    if empty:
        remedy = "give an elevation model with heights there"
        raise CoverageError(f"{names}: all cells around the roads are nodata; {remedy}")
    lon, lat = to_geographic(frame, x, y)
    roads = float(lon.min()), float(lat.min()), float(lon.max()), float(lat.max())
    west, south, east, north = zip(*bounds, strict=True)
    covered = min(west), min(south), max(east), max(north)
    places = f"covers {box_text(covered)} but the roads lie at {box_text(roads)}"
    raise CoverageError(f"{names}: the elevation model {places}; give one that covers the roads")


def _report_level(window: DemWindow, diagnostics: Diagnostics) -> None:
    """Report an elevation model that is 0 all around the roads, as no ground is but undeclared voids are."""
    z = window.z[np.isfinite(window.z)]
    if len(z) >= _LEVEL_CELLS and not z.any():
        text = f"{window.source.path}: all {len(z):,} cells around the roads have the height 0"
        diagnostics.note("dem-level", "", f"{text}; look whether they are voids or the file is the wrong one.")


def _summary(described: tuple[DemSource, GridFrame], window: DemWindow | None, bounds: Bounds) -> DemSummary:
    """Summarise an elevation model."""
    source, cells = described
    code = source.crs.to_json_dict().get("id")
    return DemSummary(
        source.path,
        source.driver,
        f"{code['authority']}:{code['code']}" if code else source.crs.name,
        source.dtype,
        source.unit,
        source.nodata,
        float(np.sqrt(np.prod((cells if window is None else window.frame).steps()))),
        bounds,
        0 if window is None else int(window.z.size),
        0 if window is None else int(np.count_nonzero(np.isnan(window.z))),
        0.0 if window is None else window.share,
        0 if window is None else window.outliers,
        source.attribution,
    )


def judge_coverage(
    paths: Sequence[Path],
    options: SurfaceOptions,
    coverage: float,
    length: float,
    places: tuple[FloatArray, FloatArray],
    diagnostics: Diagnostics,
) -> None:
    """Report what elevation models do not measure of the roads, and fail if that is too much.

    `coverage` is the share of the roads that is measured, `length`, m, that of the rest, and `places` are longitudes
    and latitudes (n,) of its ends, degrees.

    Raises
    ------
    CoverageError
        Less is measured than the options ask for.
    """
    names = names_of(paths)
    if not len(places[0]):
        return
    if options.coverage_least is not None:
        if coverage < options.coverage_least:
            wanted = f"and --fail-below-coverage asks for {100.0 * options.coverage_least:g} %"
            remedy = "give elevation models that cover the roads"
            raise CoverageError(f"{names}: {_only(coverage)}, {wanted}; {remedy}")
    elif coverage < _COVERAGE_MIN and not options.allow_partial:
        remedy = "give elevation models that cover the roads, or allow the rest to be guessed with --allow-partial"
        raise CoverageError(f"{names}: {_only(coverage)}; {remedy}")
    lon, lat = places
    box = box_text((float(lon.min()), float(lat.min()), float(lon.max()), float(lat.max())))
    share = f"{_percent(1.0 - coverage)} of the roads ({length / 1e3:,.1f} km, {box})"
    diagnostics.guessed("dem-gap", "", f"{names}: {share} have no measured height; it was filled in.")


def _only(coverage: float) -> str:
    return f"only {_percent(coverage)} of the roads have a measured height"


def names_of(paths: Sequence[Path]) -> str:
    """Name files in a sentence, the first few of many."""
    more = f" and {len(paths) - _FILES_NAMED} more" if len(paths) > _FILES_NAMED else ""
    return ", ".join(str(path) for path in paths[:_FILES_NAMED]) + more


def box_text(box: Bounds) -> str:
    """Format a box for a message."""
    west, south, east, north = box
    return f"{west:.4f} to {east:.4f} E, {south:.4f} to {north:.4f} N"


def _percent(share: float) -> str:
    """Format a share with enough digits not to be rounded to nothing or everything."""
    percent = 100.0 * share
    return f"{percent:{'.2g' if percent < 1.0 else '.0f' if percent <= 99.0 else '.2f'}} %"
