"""The ground around the roads: estimated in windows, and read at places.

Windows estimated around OSM's streets serve the roads that are built from them: the first places decide where the
windows' lattice lies, and windows that turn out to be missing later are estimated then.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import fields, replace
from typing import Final

import numpy as np

from osm2xodr.curves import exp, log, smooth_step
from osm2xodr.defaults import COARSE_CELL
from osm2xodr.geometry.heights.ground_windows import (
    CORE,
    INNER,
    MARGIN,
    RIM,
    SIZE,
    Estimator,
    Single,
    WindowEstimates,
    unknown_windows,
)
from osm2xodr.model import BoolArray, FloatArray, IntArray, Surface, SurfaceQuality
from osm2xodr.system import record

# Cell sizes within this share of each other count as equal: the rows of a geographic grid differ by less.
_SAME_CELL: Final = 0.1
# Smaller cell sizes count as this one, m: keeps logarithms finite.
_SMALLEST_CELL: Final = 1e-3
# Windows are numbered row by row; a row has fewer than this.
_ROW: Final = 1 << 24
# Windows are sampled in blocks of this many by this many, which share their cells; in tiles of this many cells.
_BLOCK: Final = 16
_TILE: Final = MARGIN
_TILES: Final = SIZE // _TILE
# Cores that are read at a time, and the nodes of the patch that the spline on a core needs: one more on every side.
_GROUP: Final = 128
_PATCH: Final = CORE + 3
# Share with which nodes without data around them take part in a blend: only where all windows have none.
_UNSUPPORTED_SHARE: Final = 1e-6
# Windows fade out from this many margins from their edge to 1.5 margins farther in: the four around a core's corner
# overlap there.
_FADE_FROM: Final = 0.25
_FADE_OVER: Final = 1.5


@record(eq=False)
class GroundLayer:
    """The ground on cells of one size."""

    cell: float  # Cell size, m
    sigma: float  # Standard error of the elevation model's heights, m
    origin: tuple[float, float]  # Where the lattice begins, local, m
    number: IntArray  # (W,) Numbers of the windows, ascending
    windows: WindowEstimates


@record(eq=False)
class Ground:
    """The ground around the roads where cells are coarse."""

    smoothing: float  # Factor on the penalty on its roughness
    layers: tuple[GroundLayer, ...] = ()  # One for each size of cells
    origin: tuple[float, float] | None = None  # Where new lattices begin, local, m; None for the fewest windows


@record(eq=False)
class GroundReading:
    """The ground at places."""

    z: FloatArray  # (n,) Height, m; NaN where no window reaches or none has data, and where cells are fine
    # (n,) Rise per metre to the east and to the north
    slope_x: FloatArray
    slope_y: FloatArray
    sigma: FloatArray  # (n,) Standard error, m
    log_relief: FloatArray  # (n,) ln A of the relief's spectrum A / k⁴, of no unit


def is_coarse(cell: FloatArray) -> BoolArray:
    """Return where the ground has to be estimated from the cells around a road."""
    return np.asarray(cell >= COARSE_CELL)


def cell_class(cell: FloatArray) -> IntArray:
    """Return equal numbers for cell sizes that are about the same."""
    out: IntArray = np.round(log(np.maximum(cell, _SMALLEST_CELL)) / _SAME_CELL).astype(np.int64)
    return out


def estimate_ground(
    surface: Surface,
    x: FloatArray,
    y: FloatArray,
    smoothing: float = 1.0,
    reach: float = 0.0,
    origin: tuple[float, float] | None = None,
) -> Ground:
    """Estimate the ground in the windows around places x, y (n,), local, m, and within reach of them, m."""
    return complete_ground(Ground(smoothing, origin=origin), surface, surface.quality(x, y), x, y, reach)


def complete_ground(
    ground: Ground, surface: Surface, quality: SurfaceQuality, x: FloatArray, y: FloatArray, reach: float = 0.0
) -> Ground:
    """Return the ground with all windows that hold places, (n,), or lie within reach of them, m."""
    layers = {int(cell_class(np.array([layer.cell]))[0]): layer for layer in ground.layers}
    for size, here in _by_cell(quality.cell_size):
        cell, sigma = float(np.median(quality.cell_size[here])), float(np.median(quality.sigma[here]))
        # So that small areas lie in few windows.
        origin = ground.origin or (float(x[here].min()) - reach, float(y[here].min()) - reach)
        layer = layers.get(size) or GroundLayer(cell, sigma, origin, np.zeros(0, np.int64), unknown_windows(0))
        around = [(0.0, 0.0), *(itertools.product((reach, -reach), repeat=2) if reach else ())]
        found = [np.unique(_window_at(layer, x[here] + dx, y[here] + dy)) for dx, dy in around]
        new = np.setdiff1d(np.concatenate(found), layer.number)
        layers[size] = _with_windows(layer, surface, new, ground.smoothing)
    return replace(ground, layers=tuple(layer for _, layer in sorted(layers.items())))


def read_ground(ground: Ground, cell: FloatArray, x: FloatArray, y: FloatArray) -> GroundReading:
    """Read the ground, which has windows for all coarse places, at local x, y with cells of these sizes, (n,), m."""
    out = GroundReading(*np.full((5, len(x)), np.nan))
    layers = {int(cell_class(np.array([layer.cell]))[0]): layer for layer in ground.layers}
    for size, here in _by_cell(cell):
        number = _window_at(layers[size], x[here], y[here])
        order = np.argsort(number, kind="stable")
        here, number = here[order], number[order]
        first = np.unique(number, return_index=True)[1][::_GROUP]
        for begin, end in itertools.pairwise([*first.tolist(), len(here)]):
            _read_group(layers[size], number[begin:end], here[begin:end], x, y, out)
    return out


def _by_cell(cell: FloatArray) -> Iterator[tuple[int, IntArray]]:
    """Yield the classes of coarse cells, and the places of each."""
    coarse = np.flatnonzero(is_coarse(cell))
    size = cell_class(cell[coarse])
    for one in np.unique(size).tolist():
        yield one, coarse[size == one]


def _window_at(layer: GroundLayer, x: FloatArray, y: FloatArray) -> IntArray:
    """Return the numbers of the windows whose cores hold places."""
    x0, y0 = layer.origin
    column, row = (np.floor(value / (CORE * layer.cell)).astype(np.int64) for value in (x - x0, y - y0))
    out: IntArray = row * _ROW + column + _ROW // 2
    return out


def _column_and_row(number: IntArray) -> tuple[IntArray, IntArray]:
    return number % _ROW - _ROW // 2, number // _ROW


def _with_windows(layer: GroundLayer, surface: Surface, new: IntArray, smoothing: float) -> GroundLayer:
    """Return a layer with new windows."""
    if not len(new):
        return layer
    estimator = Estimator(layer.cell, layer.sigma, smoothing)
    column, row = _column_and_row(new)
    block = (row // _BLOCK) * _ROW + column // _BLOCK
    numbers, found = [layer.number], [layer.windows]
    for one in np.unique(block):
        some = new[block == one]
        numbers.append(some)
        found.append(estimator.estimate(_sampled(surface, layer, some)))
    number = np.concatenate(numbers)
    order = np.argsort(number)
    names = (item.name for item in fields(WindowEstimates))
    arrays = (np.concatenate([getattr(part, name) for part in found])[order] for name in names)
    return replace(layer, number=number[order], windows=WindowEstimates(*arrays))


def _sampled(surface: Surface, layer: GroundLayer, number: IntArray) -> FloatArray:
    """Return heights on windows, (W, SIZE, SIZE), NaN where unknown; cells that windows share are read once."""
    column, row = _column_and_row(number)
    step = np.arange(_TILES)
    tile_row = (2 * row - 1)[:, None, None] + step[:, None]
    tile_column = (2 * column - 1)[:, None, None] + step[None, :]
    tile, inverse = np.unique(tile_row * _ROW + tile_column + _ROW // 2, return_inverse=True)
    column, row = (index[:, None] * _TILE + np.arange(_TILE) for index in _column_and_row(tile))
    x, y = (index.ravel() for index in np.broadcast_arrays(column[:, None, :], row[:, :, None]))
    x0, y0 = layer.origin
    z, measured = surface.heights(x0 + x * layer.cell, y0 + y * layer.cell)
    tiles = np.where(measured, z, np.nan).reshape(-1, _TILE, _TILE)
    stacked = tiles[inverse.ravel()].reshape(len(number), _TILES, _TILES, _TILE, _TILE)
    out: FloatArray = stacked.swapaxes(2, 3).reshape(len(number), SIZE, SIZE)
    return out


def _ramp() -> Single:
    """Return a window's share at its nodes: it falls smoothly from its middle to its rim."""
    position = np.arange(RIM, SIZE - RIM)
    edge = np.minimum(position, SIZE - 1 - position) - _FADE_FROM * MARGIN
    t = np.clip(edge / (_FADE_OVER * MARGIN), 0.0, 1.0)
    out: Single = smooth_step(t).astype(np.float32)
    return out


_RAMP = _ramp()


def _patches(layer: GroundLayer, cores: IntArray) -> Single:
    """Blend windows on the nodes of cores and around them.

    Returns spline coefficients, ln A, ln N and share of known heights, (4, cores, _PATCH, _PATCH), NaN where there is
    no window.
    """
    weights = np.zeros((len(cores), _PATCH, _PATCH), np.float32)
    sums = np.zeros((4, len(cores), _PATCH, _PATCH), np.float32)
    windows = layer.windows
    for down in (-1, 0, 1):
        for across in (-1, 0, 1):
            wanted = cores + down * _ROW + across
            k = np.minimum(np.searchsorted(layer.number, wanted), max(len(layer.number) - 1, 0))
            there = np.flatnonzero((layer.number[k] == wanted) & np.isfinite(windows.log_noise[k]))
            k = k[there]
            (to_row, from_row), (to_column, from_column) = _overlap(down), _overlap(across)
            share = _RAMP[from_row, None] * _RAMP[None, from_column]
            supported = windows.supported[k, from_row, from_column]
            weight = share * np.where(supported, np.float32(1.0), np.float32(_UNSUPPORTED_SHARE))
            weights[there, to_row, to_column] += weight
            values = windows.spline[k, from_row, from_column]
            sums[0, there, to_row, to_column] += weight * values
            sums[1, there, to_row, to_column] += weight * windows.log_relief[k, from_row, from_column]
            sums[2, there, to_row, to_column] += weight * windows.log_noise[k, None, None]
            sums[3, there, to_row, to_column] += share * supported
    with np.errstate(invalid="ignore", divide="ignore"):
        sums[:3] /= weights
    return sums


def _overlap(step: int) -> tuple[slice, slice]:
    """Return the nodes of a core's patch that the window `step` cores on has, and their numbers in that window."""
    # The window's first node, counted from the patch's first.
    shift = step * CORE - MARGIN + RIM + 1
    first, last = max(0, shift), min(_PATCH, shift + INNER)
    return slice(first, last), slice(first - shift, last - shift)


def _read_group(
    layer: GroundLayer, number: IntArray, here: IntArray, x: FloatArray, y: FloatArray, out: GroundReading
) -> None:
    """Read the ground at the places `here`, which lie in cores of these numbers, (n,), into `out`."""
    cores, core = np.unique(number, return_inverse=True)
    spline, relief, noise, known = _patches(layer, cores)
    column, row = _column_and_row(number)
    u = (x[here] - layer.origin[0]) / layer.cell - CORE * column
    v = (y[here] - layer.origin[1]) / layer.cell - CORE * row
    i, j = (np.clip(np.floor(value).astype(np.int64), 0, CORE - 1) for value in (v, u))
    across, slope_across = _spline_weights(np.asarray(u - j, np.float64))
    up, slope_up = _spline_weights(np.asarray(v - i, np.float64))
    base = core * _PATCH**2
    flat = spline.ravel()
    z, dx, dy = np.zeros((3, len(here)))
    for a in range(4):
        line = base + (i + a) * _PATCH + j
        values = [flat[line + b] for b in range(4)]
        value = across[0] * values[0] + across[1] * values[1] + across[2] * values[2] + across[3] * values[3]
        z += up[a] * value
        dy += slope_up[a] * value
        for b in range(4):
            dx += up[a] * slope_across[b] * values[b]
    nearest = base + (i + 1 + (v - i > 0.5)) * _PATCH + j + 1 + (u - j > 0.5)
    z[known.ravel()[nearest] <= 0.0] = np.nan
    out.z[here], out.slope_x[here], out.slope_y[here] = z, dx / layer.cell, dy / layer.cell
    out.log_relief[here] = relief.ravel()[nearest]
    # Of a thin-plate smoother: the root of N / (8 sqrt(N / A)).
    out.sigma[here] = exp(0.25 * (noise.ravel()[nearest] + out.log_relief[here])) / np.sqrt(8.0)
    out.sigma[here[np.isnan(z)]] = np.nan


def _spline_weights(t: FloatArray) -> tuple[list[FloatArray], list[FloatArray]]:
    """Return the weights of the four coefficients around places in the cubic B-spline, and in its slope."""
    r = 1.0 - t
    inner = ((4.0 - 3.0 * a * a * (2.0 - a)) / 6.0 for a in (t, r))
    value = [r * r * r / 6.0, *inner, t * t * t / 6.0]
    slope = [-0.5 * r * r, 0.5 * t * (3.0 * t - 4.0), 0.5 * r * (4.0 - 3.0 * r), 0.5 * t * t]
    return value, slope
