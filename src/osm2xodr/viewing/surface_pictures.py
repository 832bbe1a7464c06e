"""Pictures of grids of heights and errors, as elements of a page of HTML."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from html import escape
from typing import Final

import numpy as np

from osm2xodr.model import FloatArray
from osm2xodr.viewing.colours import Pixels, Ramp
from osm2xodr.viewing.picture import as_png

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
