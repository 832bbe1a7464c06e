"""Pictures of grids of heights and errors, as PNG and SVG text for a page of HTML. Nothing but numpy and zlib."""

from __future__ import annotations

import base64
import struct
import zlib
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from osm2xodr.model import FloatArray

Pixels = npt.NDArray[np.uint8]
Colours = tuple[tuple[float, tuple[int, int, int]], ...]

# Pixels along a picture's longer side at most.
_PIXELS = 460
# Low ground to high, and too low by way of right to too high; both keep their order in shades of grey at either side.
LAND: Colours = (
    (0.0, (64, 116, 96)),
    (0.25, (142, 170, 112)),
    (0.5, (226, 214, 160)),
    (0.75, (176, 132, 92)),
    (1.0, (244, 240, 236)),
)
ERROR: Colours = (
    (0.0, (33, 60, 140)),
    (0.25, (110, 150, 210)),
    (0.5, (247, 247, 247)),
    (0.75, (226, 140, 100)),
    (1.0, (150, 24, 30)),
)
_VOID = (210, 210, 214)


def relief(z: FloatArray, steps: tuple[float, float], low: float, high: float) -> Pixels:
    """Return heights as colours between two heights, lit from the north-west.

    Parameters
    ----------
    z : (rows, cols)
        Heights, m; NaN in voids.
    steps
        Length of one column and of one row, m.
    low, high
        m.

    Returns
    -------
    (rows, cols, 3)
        Of a coarser grid where there are more cells than pixels.
    """
    block = _block(z)
    mean = block_means(z, block)
    picture = _coloured(mean, low, high, LAND)
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


def error_map(error: FloatArray, limit: float) -> Pixels:
    """Return errors (rows, cols), m, as colours between -limit and limit: of each block of cells the largest.

    Blocks have two cells at least in either direction, so that cells that were not predicted do not show as a mesh.
    """
    block = min(max(2, _block(error)), *error.shape)
    return _coloured(block_extremes(error, block), -limit, limit, ERROR)


def png(pixels: Pixels) -> bytes:
    """Return a picture (rows, cols, 3) as a PNG file (ISO/IEC 15948), eight bits per colour."""
    rows, cols = pixels.shape[:2]
    # Each row begins with its filter: none.
    lines = np.concatenate([np.zeros((rows, 1), np.uint8), pixels.reshape(rows, cols * 3)], axis=1)
    header = struct.pack(">IIBBBBB", cols, rows, 8, 2, 0, 0, 0)
    parts = ((b"IHDR", header), (b"IDAT", zlib.compress(lines.tobytes(), 9)), (b"IEND", b""))
    chunks = (
        struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
        for kind, data in parts
    )
    return b"\x89PNG\r\n\x1a\n" + b"".join(chunks)


def image(pixels: Pixels, steps: tuple[float, float], words: str) -> str:
    """Return the element ``img`` of a picture in the ground's proportions; `words` must be safe in HTML."""
    rows, cols = pixels.shape[:2]
    wide, tall = cols * steps[0], rows * steps[1]
    scale = _PIXELS / max(wide, tall)
    data = base64.b64encode(png(pixels)).decode("ascii")
    return (
        f'<img alt="{words}" width="{max(1, round(wide * scale))}" height="{max(1, round(tall * scale))}" '
        f'src="data:image/png;base64,{data}">'
    )


def scale_bar(colours: Colours, low: float, high: float, unit: str) -> str:
    """Return the key to a picture's colours as SVG."""
    stops = "".join(f'<stop offset="{at:g}" stop-color="rgb{colour}"/>' for at, colour in colours)
    name = "land" if colours is LAND else "error"
    middle = 0.5 * (low + high)
    labels = "".join(
        f'<text x="{x}" y="24" text-anchor="{anchor}">{value:.4g}</text>'
        for x, anchor, value in ((0, "start", low), (110, "middle", middle), (220, "end", high))
    )
    return (
        f'<svg class="key" width="250" height="28" role="img"><defs><linearGradient id="{name}">{stops}'
        f'</linearGradient></defs><rect width="220" height="10" fill="url(#{name})"/>{labels}'
        f'<text x="228" y="10">{unit}</text></svg>'
    )


def bars(names: Sequence[str], values: Sequence[float], unit: str) -> str:
    """Return values as horizontal bars, as SVG; the names must be safe in HTML."""
    longest = max([*values, 1e-12])
    rows = "".join(
        f'<text x="92" y="{22 * k + 15}" text-anchor="end">{name}</text>'
        f'<rect class="bar" x="100" y="{22 * k + 3}" width="{max(1.0, 240.0 * value / longest):.1f}" height="16"/>'
        f'<text x="{106 + max(1.0, 240.0 * value / longest):.1f}" y="{22 * k + 15}">{value:.3g} {unit}</text>'
        for k, (name, value) in enumerate(zip(names, values, strict=True))
    )
    return f'<svg class="bars" width="440" height="{22 * len(values) + 4}" role="img">{rows}</svg>'


def block_means(z: FloatArray, block: int) -> FloatArray:
    """Return means of the known values in blocks of cells; what is left over at the end is cut off."""
    blocks = _blocks(z, block)
    known = np.isfinite(blocks)
    count = known.sum(axis=(1, 3))
    total = np.where(known, blocks, 0.0).sum(axis=(1, 3))
    out: FloatArray = np.where(count > 0, total / np.maximum(count, 1), np.nan)
    return out


def block_extremes(z: FloatArray, block: int) -> FloatArray:
    """Return of each block of cells the value that is farthest from 0, NaN where there is none."""
    blocks = _blocks(z, block)
    known = np.isfinite(blocks)
    highest = np.where(known, blocks, -np.inf).max(axis=(1, 3))
    lowest = np.where(known, blocks, np.inf).min(axis=(1, 3))
    out: FloatArray = np.where(known.any(axis=(1, 3)), np.where(highest >= -lowest, highest, lowest), np.nan)
    return out


def _blocks(z: FloatArray, block: int) -> FloatArray:
    """Return values by block, (rows, block, cols, block)."""
    rows, cols = z.shape[0] // block, z.shape[1] // block
    return z[: rows * block, : cols * block].astype(np.float64).reshape(rows, block, cols, block)


def _block(z: FloatArray) -> int:
    """Return how many cells become one pixel in either direction."""
    return min(max(1, -(-max(z.shape) // _PIXELS)), *z.shape)


def _coloured(values: FloatArray, low: float, high: float, colours: Colours) -> Pixels:
    """Return values as colours between two values; grey where there are none."""
    share = np.clip((np.nan_to_num(values) - low) / max(high - low, 1e-12), 0.0, 1.0)
    at = [place for place, _ in colours]
    channels = [np.interp(share, at, [colour[k] for _, colour in colours]) for k in range(3)]
    picture = np.stack(channels, axis=-1)
    picture[~np.isfinite(values)] = _VOID
    return picture.astype(np.uint8)
