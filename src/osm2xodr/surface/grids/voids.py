"""Filling the voids of a grid smoothly from their rims."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import numpy.typing as npt

from osm2xodr.model import BoolArray, FloatArray, IntArray
from osm2xodr.surface.grids.interpolation import Cells

# Rounds of relaxation on each grid, and how far from the rim, in cells of the coarser grid: measured on random voids,
# the membrane is then within 2 % of the range at the rim of a direct solution (0.8 % in the median).
_SWEEPS = 24
_BAND = 4
# Positions in voids whose height without the residual is asked for; between them it is interpolated.
_ASKED = 250_000
_STRIP = 256
# Gaps in neighbouring blocks of so many cells are filled together.
_BLOCK = 64


def fill_voids(
    z: Cells, below: Callable[[FloatArray, FloatArray], FloatArray], steps: tuple[float, float], fade: float
) -> Cells:
    """Return z with its voids filled: what lies below, plus the residual at the void's rim spread over it.

    Parameters
    ----------
    z : (rows, cols)
        Heights, m; NaN in voids.
    below
        Gives the heights that hold where z does not, m, at col, row.
    steps
        Length of one column and of one row, m.
    fade
        Length over which the residual dies down, m.
    """
    gap = np.isnan(z)
    filled = z.copy()
    for box, own in _groups(gap):
        part = _fill_box(z[box], own, _shifted(below, box), steps, fade)
        np.copyto(filled[box], part, where=own)
    return filled


def _fill_box(
    z: Cells,
    gap: BoolArray,
    below: Callable[[FloatArray, FloatArray], FloatArray],
    steps: tuple[float, float],
    fade: float,
) -> Cells:
    """Return z with its voids filled; other cells mean nothing."""
    rim = rim_of(gap)
    touched = gap | rim
    stride = max(1, int(np.ceil(np.sqrt(np.count_nonzero(touched) / _ASKED))))
    lattice = _ask_lattice(touched, stride, below)
    strips = [slice(first, min(first + _STRIP, len(z))) for first in range(0, len(z), _STRIP)]
    out = np.zeros_like(z)
    for strip in strips:
        out[strip] = np.where(rim[strip], z[strip] - between(lattice, stride, strip, z.shape[1]), 0.0)
    fill_from_rim(out, rim, gap, steps, fade)
    for strip in strips:
        out[strip] += between(lattice, stride, strip, z.shape[1])
    return out


def _groups(gap: BoolArray) -> Iterator[tuple[tuple[slice, slice], BoolArray]]:
    """Give groups of gaps that lie well apart, so that each can be filled by itself: its box, its gaps in the box."""
    from scipy import ndimage

    rows, cols = (-(-size // _BLOCK) for size in gap.shape)
    padded = np.pad(gap, ((0, rows * _BLOCK - gap.shape[0]), (0, cols * _BLOCK - gap.shape[1])))
    groups: IntArray = np.zeros((rows, cols), np.int64)
    ndimage.label(padded.reshape(rows, _BLOCK, cols, _BLOCK).any(axis=(1, 3)), np.ones((3, 3)), output=groups)
    for number, found in enumerate(ndimage.find_objects(groups), 1):
        # There is no number that no group has.
        assert found is not None
        down, across = found
        blocks = np.repeat(np.repeat(groups[down, across] == number, _BLOCK, axis=0), _BLOCK, axis=1)
        first_row, first_col = down.start * _BLOCK, across.start * _BLOCK
        own = padded[first_row : down.stop * _BLOCK, first_col : across.stop * _BLOCK] & blocks
        row, col = np.flatnonzero(own.any(axis=1)), np.flatnonzero(own.any(axis=0))
        # With the rim around the gaps.
        box = (
            slice(max(first_row + int(row[0]) - 1, 0), min(first_row + int(row[-1]) + 2, gap.shape[0])),
            slice(max(first_col + int(col[0]) - 1, 0), min(first_col + int(col[-1]) + 2, gap.shape[1])),
        )
        inner = np.zeros((box[0].stop - box[0].start, box[1].stop - box[1].start), bool)
        at_row, at_col = np.nonzero(own)
        inner[at_row + first_row - box[0].start, at_col + first_col - box[1].start] = True
        yield box, inner


def _shifted(
    below: Callable[[FloatArray, FloatArray], FloatArray], box: tuple[slice, slice]
) -> Callable[[FloatArray, FloatArray], FloatArray]:
    """Return `below` for positions that count from a box's first cell."""
    return lambda col, row: below(col + box[1].start, row + box[0].start)


def rim_of(gap: BoolArray) -> BoolArray:
    """Return the cells that touch a gap (by an edge or a corner) and are none."""
    out: BoolArray = _spread(gap) & ~gap
    return out


def fill_from_rim(
    values: Cells, known: BoolArray, free: BoolArray, steps: tuple[float, float], fade: float = np.inf
) -> None:
    """Fill the free cells, in place, with the membrane that hangs on the known ones.

    The membrane solves laplace(r) = r / fade², level across the border of the grid: it has no step at the rim, stays
    within the range of the known values and 0, and dies down over the length `fade`. It is solved on ever coarser
    grids first; on each, the cells near the rim are relaxed (cascadic multigrid with red-black Gauss-Seidel), while
    those farther in are smooth enough as they come from the coarser one. The effort is that of the rim's length.

    Parameters
    ----------
    values : (rows, cols)
        Read where known, 0 or anything finite where they take no part.
    known, free : (rows, cols)
        Cells that hold the membrane, and those to fill. Every free cell is surrounded by known and free ones; there
        is at least one known cell. Other cells take no part.
    steps
        Length of one column and of one row, m.
    fade
        m.
    """
    if not free.any():
        return
    coarse, count = _coarser(values, known)
    coarse_free = np.logical_or.reduce(_quarters(free))
    near = count > 0
    # Where the rim runs through a block, the majority decides, lest the void shrink with every coarser grid.
    coarse_known = near & (~coarse_free | (count > 1))
    if not coarse_known.any():
        coarse_known = near
    coarse_free &= ~coarse_known
    coarse_known |= _surround(coarse, near, coarse_free)
    fill_from_rim(coarse, coarse_known, coarse_free, (2.0 * steps[0], 2.0 * steps[1]), fade)
    np.copyto(values, _twice(_twice(coarse, values.shape[0]).T, values.shape[1]).T, where=free)
    for _ in range(_BAND):
        near = _spread(near)
    near = np.repeat(np.repeat(near, 2, axis=0)[: values.shape[0]], 2, axis=1)[:, : values.shape[1]]
    _relax(values, near & free, steps, fade)


def _spread(mask: BoolArray) -> BoolArray:
    """Return the cells of a mask and all that touch them."""
    beside = mask.copy()
    beside[1:] |= mask[:-1]
    beside[:-1] |= mask[1:]
    around = beside.copy()
    around[:, 1:] |= beside[:, :-1]
    around[:, :-1] |= beside[:, 1:]
    return around


def _coarser(values: Cells, known: BoolArray) -> tuple[Cells, npt.NDArray[np.uint8]]:
    """Return the means of the known cells in blocks of two by two, and how many these are."""
    count: npt.NDArray[np.uint8] = np.add.reduce([quarter.view(np.uint8) for quarter in _quarters(known)])
    total = np.add.reduce(_quarters(np.where(known, values, np.zeros((), values.dtype))))
    mean: Cells = (total / np.maximum(count, 1)).astype(values.dtype)
    return mean, count


def _surround(values: Cells, known: BoolArray, free: BoolArray) -> BoolArray:
    """Give cells beside free ones that take no part the mean of the known ones around them; return which."""
    new: BoolArray = _spread(free) & ~known & ~free
    row, col = np.nonzero(new)
    weights = np.pad(known, 1)
    padded = np.pad(np.where(known, values, np.zeros((), values.dtype)), 1)
    count, total = np.zeros(len(row)), np.zeros(len(row))
    for i in range(3):
        for j in range(3):
            count += weights[row + i, col + j]
            total += padded[row + i, col + j]
    values[row, col] = total / np.maximum(count, 1.0)
    new[row, col] = count > 0.0
    return new


def _quarters(cells: npt.NDArray[Any]) -> list[npt.NDArray[Any]]:
    """Return the four cells of each block of two by two; beyond the grid there is nothing (0, False)."""
    even = np.pad(cells, ((0, cells.shape[0] % 2), (0, cells.shape[1] % 2)))
    return [np.ascontiguousarray(even[i::2, j::2]) for i in (0, 1) for j in (0, 1)]


def _twice(coarse: npt.NDArray[Any], rows: int) -> npt.NDArray[Any]:
    """Interpolate to rows at half the distance, two in each row's block, level at the border."""
    before, after = np.concatenate([coarse[:1], coarse[:-1]]), np.concatenate([coarse[1:], coarse[-1:]])
    out = np.empty((2 * len(coarse), coarse.shape[1]), coarse.dtype)
    out[0::2] = 0.75 * coarse + 0.25 * before
    out[1::2] = 0.75 * coarse + 0.25 * after
    return out[:rows]


def _relax(values: Cells, free: BoolArray, steps: tuple[float, float], fade: float) -> None:
    """Bring each free cell into balance with its neighbours, in place, `_SWEEPS` times."""
    rows, cols = values.shape
    flat = values.reshape(-1)
    across, along = 1.0 / steps[0] ** 2, 1.0 / steps[1] ** 2
    total = 2.0 * (across + along) + 1.0 / fade**2
    row, col = np.nonzero(free)
    colours: list[tuple[npt.NDArray[np.intp], ...]] = []
    for colour in (0, 1):
        pick = (row + col) % 2 == colour
        r, c = row[pick], col[pick]
        # Beyond the border the membrane is level: the neighbour there is the cell itself.
        colours.append(
            (
                r * cols + c,
                r * cols + np.maximum(c - 1, 0),
                r * cols + np.minimum(c + 1, cols - 1),
                np.maximum(r - 1, 0) * cols + c,
                np.minimum(r + 1, rows - 1) * cols + c,
            )
        )
    for _ in range(_SWEEPS):
        for here, left, right, up, down in colours:
            flat[here] = (across * (flat[left] + flat[right]) + along * (flat[up] + flat[down])) / total


def _ask_lattice(
    touched: BoolArray, stride: int, below: Callable[[FloatArray, FloatArray], FloatArray]
) -> FloatArray:
    """Return heights at every stride-th row and column, where a touched cell lies between them."""
    rows, cols = (-(-size // stride) for size in touched.shape)
    padded = np.pad(touched, ((0, rows * stride - touched.shape[0]), (0, cols * stride - touched.shape[1])))
    block = padded.reshape(rows, stride, cols, stride).any(axis=(1, 3))
    wanted = np.zeros((rows + 1, cols + 1), bool)
    for i in (0, 1):
        for j in (0, 1):
            wanted[i : i + rows, j : j + cols] |= block
    out = np.zeros(wanted.shape)
    row, col = np.nonzero(wanted)
    out[row, col] = below((col * stride).astype(np.float64), (row * stride).astype(np.float64))
    return out


def between(lattice: FloatArray, stride: int, strip: slice, cols: int) -> FloatArray:
    """Interpolate a lattice bilinearly to all cells of some rows."""
    row, col = np.arange(strip.start, strip.stop), np.arange(cols)
    u, v = (col % stride / stride)[None, :], (row % stride / stride)[:, None]
    along = lattice[row // stride] * (1.0 - v) + lattice[row // stride + 1] * v
    out: FloatArray = along[:, col // stride] * (1.0 - u) + along[:, col // stride + 1] * u
    return out
