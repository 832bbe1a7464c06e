"""The page that compares ways to find heights on a user's elevation models: one file of HTML that needs no other.

Grids of heights and errors are pictures in it.
"""

from __future__ import annotations

import base64
from collections.abc import Sequence
from html import escape
from typing import Final

import numpy as np

from osm2xodr import __version__, defaults
from osm2xodr.model import FloatArray
from osm2xodr.surface import DemComparison, MethodResult, SurfaceComparison
from osm2xodr.viewing.colours import Pixels, Ramp
from osm2xodr.viewing.picture import as_png
from osm2xodr.viewing.shell import facts, package_text, page_html

# Colours reach to this percentile of the errors, so that a few large ones do not pale all others.
_SHOWN = 99.0
# Pixels along a picture's longer side at most, and along the key to its colours.
_LONGEST_SIDE: Final = 460
_KEY_WIDTH: Final = 220
# Width of the longest bar, pixels, and height of the row of one bar.
_LONGEST_BAR: Final = 240.0
_BAR_ROW: Final = 22
# Low ground to high, and too low by way of right to too high; both keep their order in shades of grey on either side.
_LAND: Final = ("#407460", "#8eaa70", "#e2d6a0", "#b0845c", "#f4f0ec")
_MISFIT: Final = ("#213c8c", "#6e96d2", "#f7f7f7", "#e28c64", "#96181e")
_VOID: Final = "#d2d2d6"


def surface_page(comparison: SurfaceComparison) -> bytes:
    """Return the page, HTML in UTF-8."""
    box = comparison.box_deg
    where = (
        "all of each file" if box is None else "west, south, east, north {:g}, {:g}, {:g}, {:g} degrees".format(*box)
    )
    body = (
        "<h1>How well heights are found in elevation models</h1>\n"
        f'<p class="note">osm2xodr {escape(__version__)}; examined: {escape(where)}.</p>\n'
        "<p>Interpolations are given every other row and column, and are asked for the cells between; the error is "
        "the answer less the height of the cell. Cells are twice as far apart as they are for a road, so roads see "
        "smaller errors, but the same order of methods. A model's own noise is part of every error: the method that "
        "follows noise least is not always the one that follows the ground best. Polynomials are compared with the "
        "heights that they are fitted to: what they miss is terrain that a trend does not have.</p>\n"
        + "".join(_model(model) for model in comparison.models)
    )
    return page_html("Elevation models compared", body, package_text("osm2xodr.viewing", "template/surface.css"))


def _model(model: DemComparison) -> str:
    """Return the section of one elevation model."""
    grid = model.grid
    shown = int(np.argmax([np.isfinite(patch.z).sum() for patch in grid.patches]))
    z = grid.patches[shown].z.astype(np.float64)
    known = z[np.isfinite(z)]
    note = ""
    if len(grid.patches) > 1:
        rows, cols = z.shape
        note = (
            f'<p class="note">{len(grid.patches)} patches of {cols} x {rows} cells were examined, evenly spread; '
            "the pictures show one of them, the figures are for all.</p>\n"
        )
    ramp = land_ramp(float(known.min()), float(known.max()))
    ground = image(relief(z, grid.steps, ramp), grid.steps, "Heights")
    interpolations = _methods("Method", "Errors", grid.interpolations, shown, grid.steps, _verdict(model))
    polynomials = _methods("Degree", "Trend less heights", grid.polynomials, shown, grid.steps)
    return (
        f"<h2>{escape(str(model.path))}</h2>\n{_facts(model)}{note}"
        f"<figure>{ground}<figcaption>Heights {scale_bar(ramp)}</figcaption></figure>\n"
        f"<h3>Interpolations</h3>\n{interpolations}<h3>Polynomials of degree 2 to 5</h3>\n{polynomials}"
    )


def _methods(
    heading: str,
    title: str,
    results: Sequence[MethodResult],
    shown: int,
    steps: tuple[float, float],
    verdict: str = "",
) -> str:
    """Return table, bars, verdict and maps of some methods."""
    prefix = "degree " if heading == "Degree" else ""
    chart = bars([f"{prefix}{result.name}" for result in results], [result.rms for result in results], "m")
    text = f"<p>{verdict}</p>\n" if verdict else ""
    return f"{_table(heading, results)}{chart}\n{text}{_maps(results, shown, steps, title)}"


def _facts(model: DemComparison) -> str:
    """Return the facts about the elevation model."""
    across, along = model.grid.steps
    voids = f"{100.0 * model.voids / max(model.cells, 1):.3g} % of {model.cells:,}"
    if model.outliers:
        voids += f", {model.outliers:,} of them heights that are not the ground"
    lengths = f"({across:.3g} m across, {along:.3g} m along)"
    rows = (
        ("Format", f"{model.driver}, {model.dtype}, heights in {model.unit}"),
        ("Reference system", model.crs),
        ("Cells", f"{model.size[0]:,} x {model.size[1]:,} of {model.cell_size:.3g} m {lengths}"),
        ("Voids", voids),
        ("Standard error of heights, estimated", f"{model.sigma:.2g} m"),
        ("Taken for", "a surface model (canopy and roofs)" if model.covered else "a terrain model (the ground)"),
    )
    return f"{facts(rows)}\n"


def _table(title: str, results: Sequence[MethodResult]) -> str:
    """Return the figures of some methods."""
    best = min((result.rms for result in results), default=0.0)
    rows = "".join(
        f"<tr{' class=best' if result.rms == best else ''}><td>{escape(result.name)}</td><td>{result.rms:.3f}</td>"
        f"<td>{result.p95:.3f}</td><td>{result.maximum:.2f}</td><td>{result.bias:+.3f}</td>"
        f"<td>{100.0 * result.grade_rms:.2f}</td><td>{result.seconds:.3f}</td><td>{result.count:,}</td></tr>"
        for result in results
    )
    heads = ("rms, m", "95 %, m", "largest, m", "mean, m", "grade rms, %", "time, s", "cells")
    head = f"<th>{title}</th>" + "".join(f"<th>{name}</th>" for name in heads)
    return f"<table><tr>{head}</tr>{rows}</table>\n"


def _verdict(model: DemComparison) -> str:
    """Return a sentence on which method is best."""
    best = min(model.grid.interpolations, key=lambda result: result.rms)
    usual = next(result for result in model.grid.interpolations if result.name == defaults.SURFACE_METHOD)
    if not best.count:
        return "There is nothing to compare: no cell lies between others that have a height."
    if usual.rms <= best.rms:
        return f"On these heights {usual.name}, which convert uses by default, has the smallest error."
    share = 100.0 * (1.0 - best.rms / usual.rms)
    return (
        f"On these heights {best.name} has the smallest error, {share:.0f} % below that of {usual.name}, which "
        f"convert uses by default; <code>--surface {best.name}</code> chooses it."
    )


def _maps(results: Sequence[MethodResult], shown: int, steps: tuple[float, float], title: str) -> str:
    """Return pictures of the errors of some methods, all in the same colours."""
    errors: list[FloatArray] = [result.errors[shown] for result in results]
    sizes = [np.abs(error[np.isfinite(error)]) for error in errors]
    limits = sorted(float(np.percentile(size, _SHOWN)) for size in sizes if len(size))
    # The worst method may be off the scale, so that the others can be distinguished.
    ramp = error_ramp(max([1e-3, *limits[-2:][:1]]))
    figures = "".join(
        f"<figure>{image(error_map(error, ramp), steps, f'{title}, {result.name}')}"
        f"<figcaption>{escape(result.name)}</figcaption></figure>"
        for result, error in zip(results, errors, strict=True)
    )
    return f'<p>{escape(title)} {scale_bar(ramp)}</p>\n<div class="pictures">{figures}</div>\n'


def land_ramp(low: float, high: float) -> Ramp:
    """Return the colours of heights between two heights, m."""
    return Ramp(_LAND, low, high, "m", _VOID)


def error_ramp(limit: float) -> Ramp:
    """Return the colours of errors between -limit and limit, m."""
    return Ramp(_MISFIT, -limit, limit, "m", _VOID)


def relief(z: FloatArray, steps: tuple[float, float], ramp: Ramp) -> Pixels:
    """Return heights (rows, cols), m, NaN in voids, as colours, lit from the north-west.

    `steps` are the lengths of one column and of one row, m. The picture, (rows, cols, 3), is one of a coarser grid
    where there are more cells than pixels.
    """
    block = _block_size(z)
    mean = block_means(z, block)
    picture = ramp.colours(mean)
    if min(mean.shape) > 1:
        down, across = np.gradient(mean, steps[1] * block, steps[0] * block)
        # As steep as it takes to see something: the usual slope becomes 45 degrees or so.
        slope = np.hypot(down, across)
        usual = float(np.percentile(slope[np.isfinite(slope)], 90.0)) if np.isfinite(slope).any() else 0.0
        with np.errstate(invalid="ignore"):
            light = (across + down) / (2.0 * max(usual, 1e-9))
        shade = 1.0 + 0.35 * np.clip(np.nan_to_num(light), -1.0, 1.0)
        lit = np.clip(picture * shade[:, :, None], 0.0, 255.0)
        picture = np.where(np.isfinite(mean)[:, :, None], lit, picture).astype(np.uint8)
    return picture


def error_map(error: FloatArray, ramp: Ramp) -> Pixels:
    """Return errors (rows, cols), m, as colours: of each block of cells the largest.

    Blocks have two cells at least in either direction, so that cells that were not predicted do not show as a mesh.
    """
    block = min(max(2, _block_size(error)), *error.shape)
    return ramp.colours(block_extremes(error, block))


def image(pixels: Pixels, steps: tuple[float, float], alternative: str) -> str:
    """Return the element ``img`` of a picture in the ground's proportions; `alternative` is plain text."""
    rows, cols = pixels.shape[:2]
    wide, tall = cols * steps[0], rows * steps[1]
    scale = _LONGEST_SIDE / max(wide, tall)
    data = base64.b64encode(as_png(pixels)).decode("ascii")
    return (
        f'<img alt="{escape(alternative)}" width="{max(1, round(wide * scale))}" '
        f'height="{max(1, round(tall * scale))}" src="data:image/png;base64,{data}">'
    )


def scale_bar(ramp: Ramp) -> str:
    """Return the key to a picture's colours as SVG."""
    stops = "".join(
        f'<stop offset="{k / (len(ramp.stops) - 1):g}" stop-color="{stop}"/>' for k, stop in enumerate(ramp.stops)
    )
    name = f"key-{ramp.stops[0][1:]}"
    labels = "".join(
        f'<text x="{share * _KEY_WIDTH:g}" y="24" text-anchor="{anchor}">'
        f"{(1.0 - share) * ramp.low + share * ramp.high:.4g}</text>"
        for share, anchor in ((0.0, "start"), (0.5, "middle"), (1.0, "end"))
    )
    return (
        f'<svg class="key" width="{_KEY_WIDTH + 30}" height="28" role="img"><defs><linearGradient id="{name}">{stops}'
        f'</linearGradient></defs><rect width="{_KEY_WIDTH}" height="10" fill="url(#{name})"/>{labels}'
        f'<text x="{_KEY_WIDTH + 8}" y="10">{ramp.unit}</text></svg>'
    )


def bars(names: Sequence[str], values: Sequence[float], unit: str) -> str:
    """Return values as horizontal bars, as SVG; the names are plain text."""
    longest = max([*values, 1e-12])
    rows = []
    for k, (name, value) in enumerate(zip(names, values, strict=True)):
        top, width = _BAR_ROW * k, max(1.0, _LONGEST_BAR * value / longest)
        rows.append(
            f'<text x="92" y="{top + 15}" text-anchor="end">{escape(name)}</text>'
            f'<rect class="bar" x="100" y="{top + 3}" width="{width:.1f}" height="16"/>'
            f'<text x="{106 + width:.1f}" y="{top + 15}">{value:.3g} {unit}</text>'
        )
    return f'<svg class="bars" width="440" height="{_BAR_ROW * len(rows) + 4}" role="img">{"".join(rows)}</svg>'


def block_means(z: FloatArray, block: int) -> FloatArray:
    """Return means of the known values in blocks of cells; what is left over at the end is cut off."""
    blocks = _blocks(z, block)
    known = np.isfinite(blocks)
    count = known.sum(axis=(1, 3))
    total = np.where(known, blocks, 0.0).sum(axis=(1, 3))
    return np.where(count > 0, total / np.maximum(count, 1), np.nan)


def block_extremes(z: FloatArray, block: int) -> FloatArray:
    """Return of each block of cells the value that is farthest from 0, NaN where there is none."""
    blocks = _blocks(z, block)
    known = np.isfinite(blocks)
    highest = np.where(known, blocks, -np.inf).max(axis=(1, 3))
    lowest = np.where(known, blocks, np.inf).min(axis=(1, 3))
    return np.where(known.any(axis=(1, 3)), np.where(highest >= -lowest, highest, lowest), np.nan)


def _blocks(z: FloatArray, block: int) -> FloatArray:
    """Return values by block, (rows, block, cols, block)."""
    rows, cols = z.shape[0] // block, z.shape[1] // block
    return z[: rows * block, : cols * block].astype(np.float64).reshape(rows, block, cols, block)


def _block_size(z: FloatArray) -> int:
    """Return how many cells become one pixel in either direction."""
    return min(max(1, -(-max(z.shape) // _LONGEST_SIDE)), *z.shape)
