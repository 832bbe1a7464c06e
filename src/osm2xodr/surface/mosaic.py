"""From files of elevation models to layers: which windows are read, their priority, and which form one grid."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Final

import numpy as np
from pyproj import CRS, Transformer

from osm2xodr import defaults
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.errors import InputError
from osm2xodr.model import FloatArray, IntArray, LocalFrame
from osm2xodr.projection import transformer_to
from osm2xodr.surface.grids import (
    Cells,
    DemSource,
    GridFrame,
    Unstated,
    describe_dem,
    empty_cells,
    estimate_sigma,
    find_outliers,
    fit_polynomial,
    looks_covered,
    quantum_of,
    read_heights,
    rim_of,
    term_count,
    usual_sigma,
)
from osm2xodr.surface.sampling import Layer, Trend
from osm2xodr.system import record

# Margin that is read around the roads, m and cells: room for lane edges and for fitted curves, which leave the OSM
# line by a few metres; eight cells dampen the end effect of a bicubic spline to 3e-5 of itself (0.27 per cell). Where
# cells are coarse the ground is estimated from those around, which takes more of them.
_MARGIN: Final = 50.0
_MARGIN_CELLS: Final = 8
# Largest number of cells that are read to be averaged: a minute's work, 32 km of cells of 1 m either way. Files of a
# few hundred bytes can claim more.
_CELLS_READ_MAX: Final = 2**30
# Length over which the step between two elevation models fades, m and cells of the coarser one, whichever is longer
# (3 m of step over 100 m: 4.5 % of grade at most); over which heights beyond the last measured cell fall back to the
# trend, m, and over which the trend's slope fades beyond all of them, m. Choices: land does not go on rising, or
# falling into the sea, as it does where it is measured.
_SEAM_RAMP: Final = 100.0
_SEAM_RAMP_CELLS: Final = 4
_EDGE_RAMP: Final = 1000.0
_SLOPE_FADE: Final = 500.0
# Cells along and across that are needed to detect a surface model; if the roads need fewer, more are read.
_DETECTION_CELLS: Final = 200
# Two elevation models on one common grid are joined unless they differ by more than this share of their standard
# error where they meet.
_SAME_MODEL_SHARE: Final = 0.5
# Cell sizes that differ by less than these factors count as equal: when averaging, and in priority.
_SAME_SIZE_AVERAGING: Final = 1.05
_SAME_SIZE_PRIORITY: Final = 1.1
# Number of cells of all layers that the trend is fitted to: a polynomial of at most 21 terms needs no more.
_TREND_CELLS: Final = 20_000
# More cells than this are kept in single precision, which resolves heights to less than a millimetre.
_DOUBLE_CELLS_MAX: Final = 2**24


@record(eq=False)
class DemWindow:
    """The part of an elevation model around the roads."""

    source: DemSource
    frame: GridFrame  # Of the window
    z: Cells  # (rows, cols) Heights, m; NaN in voids
    share: float  # Share of the road points whose cell has a height
    block: int  # A cell of the window is the mean of block x block cells of the model
    outliers: int  # Number of voids whose heights were removed as outliers


def describe_all(
    paths: Sequence[Path], known: Unstated, frame: LocalFrame, diagnostics: Diagnostics
) -> list[tuple[DemSource, GridFrame]]:
    """Read the description of each file, and make the frame of its cells; `known` is what files need not say."""
    transformers: dict[CRS, Transformer] = {}
    out = []
    for path in paths:
        source = describe_dem(path, diagnostics, known)
        if source.crs not in transformers:
            transformers[source.crs] = transformer_to(frame, source.crs)
        out.append((source, source.frame(transformers[source.crs])))
    return out


def bounds_deg(cells: GridFrame) -> tuple[float, float, float, float]:
    """Return west, south, east, north of an elevation model, degrees, WGS 84."""
    lon, lat = cells.lon_lat(*cells.rim())
    return float(np.min(lon)), float(np.min(lat)), float(np.max(lon)), float(np.max(lat))


@record(eq=False)
class _Plan:
    """The window to read of an elevation model: cells from `first` up to `end` (col, row), for roads at col, row."""

    source: DemSource
    cells: GridFrame
    first: IntArray
    end: IntArray
    col: FloatArray
    row: FloatArray
    cell_size: float


def read_windows(
    described: Sequence[tuple[DemSource, GridFrame]],
    x: FloatArray,
    y: FloatArray,
    cells_max: int,
    diagnostics: Diagnostics,
) -> list[DemWindow | None]:
    """Read the window of each elevation model around local positions; None if it reaches none of them.

    No more than `cells_max` cells are kept in all; the finest are averaged where there are more.
    """
    in_crs: dict[CRS, tuple[FloatArray, FloatArray]] = {}
    plans: list[_Plan | None] = []
    for source, cells in described:
        if source.crs not in in_crs:
            in_crs[source.crs] = cells.crs_positions(x, y)
        col, row = cells.cells_at(*in_crs[source.crs])
        with np.errstate(invalid="ignore"):
            on = (col >= -0.5) & (col <= cells.cols - 0.5) & (row >= -0.5) & (row <= cells.rows - 0.5)
        plans.append(_plan(source, cells, col[on], row[on]) if on.any() else None)
    blocks = _blocks([plan for plan in plans if plan is not None], cells_max)
    single = sum(_count(plan, blocks[id(plan)]) for plan in plans if plan is not None) > _DOUBLE_CELLS_MAX
    return [None if plan is None else _read(plan, blocks[id(plan)], single, len(x), diagnostics) for plan in plans]


def _plan(source: DemSource, cells: GridFrame, col: FloatArray, row: FloatArray) -> _Plan:
    """Plan to read the window around fractional cells that lie on an elevation model."""
    low = np.maximum([np.floor(col.min()), np.floor(row.min())], 0.0).astype(np.int64)
    high = np.minimum([np.ceil(col.max()), np.ceil(row.max())], [cells.cols - 1, cells.rows - 1]).astype(np.int64)
    core = cells.window(int(low[0]), int(low[1]), int(high[0] - low[0]) + 1, int(high[1] - low[1]) + 1)
    cell_size = core.cell_size()
    least = defaults.COARSE_MARGIN_CELLS if cell_size >= defaults.COARSE_CELL else _MARGIN_CELLS
    margin = np.maximum(least, np.ceil(_MARGIN / np.array(core.steps())))
    first = np.maximum(low - margin.astype(np.int64), 0)
    end = np.minimum(high + margin.astype(np.int64) + 1, [cells.cols, cells.rows])
    return _Plan(source, cells, first, end, col, row, cell_size)


def _count(plan: _Plan, block: int) -> int:
    """Return the number of cells of a window in blocks."""
    return int(np.prod(-(-plan.end // block) - plan.first // block))


def _blocks(plans: Sequence[_Plan], cells_max: int) -> dict[int, int]:
    """Return how many cells to average in either direction, by id of the plan: no more than needed."""
    finest = min((plan.cell_size for plan in plans), default=1.0)
    for plan in plans:
        if _count(plan, 1) > _CELLS_READ_MAX:
            raise InputError(
                f"{plan.source.path}: around the roads lie {_count(plan, 1):,} cells of {plan.cell_size:.2g} m, more"
                " than can be read; resample it with gdalwarp -tr, or choose a smaller area"
            )
    for times in range(1, 10_000):
        blocks = {}
        for plan in plans:
            alike = plan.cell_size < _SAME_SIZE_AVERAGING * finest
            wanted = times if alike else max(1, int(times * finest / plan.cell_size))
            blocks[id(plan)] = min(wanted, plan.cells.rows, plan.cells.cols)
        if sum(_count(plan, blocks[id(plan)]) for plan in plans) <= cells_max:
            break
    return blocks


def _read(plan: _Plan, block: int, single: bool, points: int, diagnostics: Diagnostics) -> DemWindow:
    """Read a window."""
    # Blocks start at the model's first cell, so that tiles of one model stay on one grid; only whole blocks are read.
    whole = np.array([plan.cells.cols, plan.cells.rows]) // block
    first_col, first_row = (np.minimum(plan.first // block, whole - 1) * block).tolist()
    end_col, end_row = (np.minimum(-(-plan.end // block), whole) * block).tolist()
    cols, rows = end_col - first_col, end_row - first_row
    frame = plan.cells.window(first_col, first_row, cols, rows, block)
    z = read_heights(plan.source, frame, first_col, first_row, block, single, diagnostics)
    outliers = void_outliers(plan.source, frame, z, block, diagnostics)
    col = np.clip((plan.col + 0.5 - first_col) / block, 0, frame.cols - 1).astype(np.int64)
    row = np.clip((plan.row + 0.5 - first_row) / block, 0, frame.rows - 1).astype(np.int64)
    return DemWindow(plan.source, frame, z, int(np.isfinite(z[row, col]).sum()) / points, block, outliers)


def void_outliers(source: DemSource, frame: GridFrame, z: Cells, block: int, diagnostics: Diagnostics) -> int:
    """Turn outliers into voids, in place; report and count them."""
    outliers, step = find_outliers(z, frame.cell_size(), averaged=block > 1)
    count = int(np.count_nonzero(outliers))
    if not count:
        return 0
    row, col = divmod(int(np.flatnonzero(outliers)[0]), frame.cols)
    lon, lat = frame.lon_lat(col, row)
    lowest, highest = float(z[outliers].min()), float(z[outliers].max())
    # Averaged cells on the rim contain some of the outlier.
    z[outliers | rim_of(outliers) if block > 1 else outliers] = np.nan
    diagnostics.repaired(
        "dem-outlier",
        "",
        f"{source.path}: {count} cells of {lowest:.0f} to {highest:.0f} m, the first at {lon:.5f} E, {lat:.5f} N, "
        f"differ from all ground around them by more than {step:.0f} m, as no ground does; they were taken for "
        "voids.",
    )
    return count


def by_priority(windows: Sequence[DemWindow]) -> list[DemWindow]:
    """Order elevation models by cell size, finest first; keep the given order among similar sizes."""
    by_size = sorted(windows, key=lambda window: window.frame.cell_size())
    out: list[DemWindow] = []
    while by_size:
        finest = by_size[0].frame.cell_size()
        alike = [window for window in by_size if window.frame.cell_size() <= _SAME_SIZE_PRIORITY * finest]
        by_size = by_size[len(alike) :]
        out.extend(window for window in windows if any(window is other for other in alike))
    return out


def make_layers(windows: Sequence[DemWindow], cells_max: int, dem_type: str, diagnostics: Diagnostics) -> list[Layer]:
    """Make layers of windows in order of priority, for a `SurfaceOptions.dem_type`; tiles of one model become one."""
    grids: list[tuple[GridFrame, Cells, float, bool]] = []
    waiting = list(windows)
    while waiting:
        frame, z, taken = _join(waiting, cells_max, diagnostics)
        quantum = quantum_of(z, waiting[0].source.quantum) if waiting[0].block == 1 else 0.0
        covered = dem_type == "dsm" if dem_type != "auto" else _is_covered(taken, frame, z, diagnostics)
        grids.append((frame, z, quantum, covered))
        waiting = [window for window in waiting if not any(window is other for other in taken)]
    layers = []
    for index, (frame, z, quantum, covered) in enumerate(grids):
        ramp = _EDGE_RAMP
        if index + 1 < len(grids):
            coarse = max(frame.cell_size(), grids[index + 1][0].cell_size())
            ramp = max(_SEAM_RAMP, _SEAM_RAMP_CELLS * coarse)
        layers.append(Layer(frame, z, estimate_sigma(z, frame.steps(), quantum), ramp, covered))
    return layers


def _is_covered(windows: Sequence[DemWindow], frame: GridFrame, z: Cells, diagnostics: Diagnostics) -> bool:
    """Whether the elevation model of a layer shows canopy and roofs, by its name, else by its heights."""
    named = [window.source.covered for window in windows if window.source.covered is not None]
    covered = named[0] if named else looks_covered(_cells_for_detection(windows[0], z), frame.steps())
    if covered:
        diagnostics.guessed(
            "dem-type",
            "",
            f"{windows[0].source.path}: by its {'name' if named else 'heights'} the elevation model shows canopy and "
            "roofs, and was taken for a surface model; if it shows the ground, give --dem-type dtm.",
        )
    return covered


def _cells_for_detection(window: DemWindow, z: Cells) -> Cells:
    """Return a layer's heights, or if they are few, those of more cells around its first window."""
    wanted = _DETECTION_CELLS
    source, frame = window.source, window.frame
    whole = source.frame(frame.to_crs)
    place = frame.offset_in(whole)
    if z.size >= wanted**2 or window.block > 1 or place is None:
        return z
    cols, rows = min(max(wanted, frame.cols), source.cols), min(max(wanted, frame.rows), source.rows)
    first_col = min(max(place[0] - (cols - frame.cols) // 2, 0), source.cols - cols)
    first_row = min(max(place[1] - (rows - frame.rows) // 2, 0), source.rows - rows)
    around = whole.window(first_col, first_row, cols, rows)
    # Diagnostics about cells that no road needs are not reported.
    return read_heights(source, around, first_col, first_row, 1, False, Diagnostics())


def fit_trend(layers: Sequence[Layer], order: int) -> Trend:
    """Fit the trend to the measured cells of all layers, weighted by area, with at least two cells per term."""
    parts = [_sample_cells(layer, _TREND_CELLS // len(layers)) for layer in layers]
    x, y, z, area = (np.concatenate(values) for values in zip(*parts, strict=True))
    while order > 0 and len(z) < 2 * term_count(order):
        order -= 1
    polynomial = fit_polynomial(x, y, z, order, area)
    cell = max(max(layer.frame.steps()) for layer in layers)
    box = float(x.min()) - cell, float(y.min()) - cell, float(x.max()) + cell, float(y.max()) + cell
    room = 0.5 * float(np.ptp(z))
    # A polynomial's own slope at its rim may be anything: that of the plane through all heights goes on.
    plane = fit_polynomial(x, y, z, min(order, 1), area)
    rise = plane.heights(np.array([0.0, 1.0, 0.0]), np.array([0.0, 0.0, 1.0])) - plane.heights(*np.zeros((2, 1)))
    slope = float(rise[1]), float(rise[2])
    return Trend(polynomial, box, float(z.min()) - room, float(z.max()) + room, slope, _SLOPE_FADE)


def _sample_cells(layer: Layer, count: int) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return local x, y, height and area of about `count` measured cells, evenly spread."""
    known = np.isfinite(layer.z)
    stride = max(1, int(np.ceil(np.sqrt(np.count_nonzero(known) / max(count, 1)))))
    start = stride // 2
    if not known[start::stride, start::stride].any():
        start, stride = 0, 1
    row, col = np.nonzero(known[start::stride, start::stride])
    row, col = row * stride + start, col * stride + start
    x, y = layer.frame.positions(col.astype(np.float64), row.astype(np.float64))
    return x, y, layer.z[row, col].astype(np.float64), np.full(len(x), (layer.frame.cell_size() * stride) ** 2)


def _join(
    windows: Sequence[DemWindow], cells_max: int, diagnostics: Diagnostics
) -> tuple[GridFrame, Cells, list[DemWindow]]:
    """Join the first window with all others on the same grid that agree with it where they meet."""
    anchor = windows[0]
    placed = [(window, window.frame.offset_in(anchor.frame)) for window in windows]
    alike = (anchor.source.covered, None)
    members = [(window, place) for window, place in placed if place is not None and window.source.covered in alike]
    (first_col, first_row), (cols, rows) = _span(members)
    # Tiles far apart would make a mostly empty grid.
    if len(members) == 1 or cols * rows > 2 * cells_max:
        return anchor.frame, anchor.z, [anchor]
    z = empty_cells(rows, cols, anchor.z.dtype == np.float32)
    taken = []
    for window, place in members:
        col, row = place[0] - first_col, place[1] - first_row
        if _fits(z, col, row, window.z, _SAME_MODEL_SHARE * usual_sigma(anchor.frame.cell_size())):
            part = z[row : row + window.frame.rows, col : col + window.frame.cols]
            part[...] = np.where(np.isfinite(part), part, window.z)
            taken.append((window, place))
        else:
            what = f"the elevation model does not agree with {anchor.source.path} where they meet"
            text = f"{window.source.path}: {what}; the step was spread over some distance."
            diagnostics.note("dem-step", "", text)
    (col, row), (cols, rows) = _span(taken)
    z = z[row - first_row : row - first_row + rows, col - first_col : col - first_col + cols].copy()
    return anchor.frame.window(col, row, cols, rows), z, [window for window, _ in taken]


def _span(placed: Sequence[tuple[DemWindow, tuple[int, int]]]) -> tuple[tuple[int, int], tuple[int, int]]:
    """Return first col, row and number of cols, rows of the box around windows."""
    first_col, first_row = min(col for _, (col, _) in placed), min(row for _, (_, row) in placed)
    end_col = max(col + window.frame.cols for window, (col, _) in placed)
    end_row = max(row + window.frame.rows for window, (_, row) in placed)
    return (first_col, first_row), (end_col - first_col, end_row - first_row)


def _fits(z: Cells, col: int, row: int, tile: Cells, tolerance: float) -> bool:
    """Whether a tile fits its surroundings: nine tenths of the common cells, else the median step at the seam."""
    common = z[row : row + tile.shape[0], col : col + tile.shape[1]]
    both = np.isfinite(common) & np.isfinite(tile)
    if both.any():
        return float(np.percentile(np.abs(common[both] - tile[both]), 90)) <= tolerance
    steps = _steps_across(z, col, row, tile)
    return not len(steps) or abs(float(np.median(steps))) <= tolerance


def _steps_across(z: Cells, col: int, row: int, tile: Cells) -> FloatArray:
    """Return the steps up from adjacent cells to a tile, both extrapolated to the seam, m."""
    rows, cols = tile.shape
    beside, across = z[row : row + rows], z[:, col : col + cols].T
    pairs = (
        (beside[:, max(col - 2, 0) : col][:, ::-1], tile[:, :2]),
        (beside[:, col + cols : col + cols + 2], tile[:, ::-1][:, :2]),
        (across[:, max(row - 2, 0) : row][:, ::-1], tile.T[:, :2]),
        (across[:, row + rows : row + rows + 2], tile.T[:, ::-1][:, :2]),
    )
    steps = [
        1.5 * inner[:, 0] - 0.5 * inner[:, 1] - 1.5 * outer[:, 0] + 0.5 * outer[:, 1]
        for outer, inner in pairs
        if outer.shape[1] == 2 and inner.shape[1] == 2
    ]
    found = np.concatenate(steps).astype(np.float64) if steps else np.zeros(0)
    out: FloatArray = found[np.isfinite(found)]
    return out
