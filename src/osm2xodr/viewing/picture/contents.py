"""A picture of a road network: what is in it and where; `drawing` draws it.

Roads whose heights were not measured are hatched.
"""

from __future__ import annotations

import math
import textwrap
from collections.abc import Iterable, Sequence
from typing import Final

import numpy as np

from osm2xodr.curves import owners, unique_inverse, wrapped
from osm2xodr.errors import InputError
from osm2xodr.furniture_shapes import DECAL_COLOUR, FURNITURE_FROM, MARKS_FROM, PlacedObject, PlacedSignal, rank_of
from osm2xodr.model import FloatArray, IntArray
from osm2xodr.opendrive import Frame, OpenDrive, frame_of
from osm2xodr.system import advance, record, stage
from osm2xodr.viewing.colours import Categories, Mode, Ramp, drawn_types, lane_speeds, make_modes, nice_step
from osm2xodr.viewing.options import PictureOptions
from osm2xodr.viewing.picture.details import HATCHING, Line, Parts, Polygon, Shape, furniture_shapes, mark_lines
from osm2xodr.viewing.scene import Scene, border_marks, credits_of, make_scene, unmeasured

# Height of the legend's band below the map as a share of the width, and its least height, pixels.
_BAND: Final = 0.045
_LEAST_BAND: Final = 44
# Margin around the roads as a share of the longer side, and pixels in all at most. Choices.
_MARGIN: Final = 0.03
_MOST_PIXELS: Final = 100_000_000
# Colours of a ramp in a picture.
_SHADES: Final = 64
# Letters of credits, and the height of a line of them, pixels; how many letters of their size are as wide as they are
# high, rather too few, so that lines end within the picture; and lines at most: files may say anything.
CREDIT_SIZE: Final = 11.0
CREDIT_LINE: Final = 16
_CREDIT_LETTER: Final = 0.6
_MOST_CREDIT_LINES: Final = 4
# Width of the scale bar at most, as a share of the picture's.
_BAR_SHARE: Final = 0.16
# Types of the lanes that close the floor of junctions.
_FLOOR: Final = ("border", "shoulder")
# Places of shapes of one level: areas by the number of kinds that cover theirs, the floor before all, then these.
_LOWEST: Final = 100
_MARKS: Final = 1
_FURNITURE: Final = 2
# Lanes that are narrower have no width, pixels.
_NO_WIDTH: Final = 1e-3
# Pixels per metre from which carriageways have edges.
_EDGES_FROM: Final = 1.5
_LATITUDE_MOST: Final = 90.0
_BOX_ORDER: Final = "write west,south,east,north, longitudes first and third"
# A strip higher than something by more than this is above it, m: less than the clearance of any bridge for cars.
_OVERHEAD: Final = 3.0
# Distance of strokes along the road: m, and pixels, at least; half of the length of a stroke, pixels, at least.
_APART: Final = 4.0
_APART_PIXELS: Final = 9.0
_HALF: Final = 4.0
# How far the left end of a stroke is ahead of its middle, as a share of what it is beside it.
_SLANT: Final = 0.7
# Width, pixels.
_WIDTH: Final = 1.5


@record(eq=False)
class Picture:
    """What is drawn, in pixels from the top left."""

    # Of the whole picture; the map takes all of it except the band of the legend
    width: int
    height: int
    map_height: int
    band: int  # Height of the legend's band below the map; lines of credits follow it
    scale: float  # Pixels per metre
    # Roads, the lowest first, with edges outside of junctions unless these would be too fine; at large scales also
    # marks, objects and signals
    shapes: list[Shape]
    mode: Mode  # What the colours mean
    bar: float  # Length of the scale bar, m
    title: str  # Name of the file
    credits: list[str]  # Lines that say whose data it is made of
    decals: bool = False  # Whether outlines of flat objects of unknown type are among the shapes
    hatched: bool = False  # Whether roads are hatched because their heights were not measured

    @property
    def outline(self) -> float:
        """Width of the outline of areas in their own colour, pixels: it keeps thin roads visible, and hides seams."""
        return float(np.clip(1.6 - 5.0 * self.scale, 0.4, 1.4))


def make_picture(file: OpenDrive, options: PictureOptions) -> Picture:
    """Lay out the picture of a file.

    Raises
    ------
    InputError
        Nothing of the file can be drawn or lies in the box, or it has no speeds to show.
    """
    stage("drawing roads")
    scene = make_scene(file)
    if not len(scene.s):
        raise InputError(f"{file.path} has no road that can be drawn: none has both a plan view and lanes")
    x, y, _ = scene.border_places()
    west, south, east, north = options.box or _around(x, y)
    scale = options.width / (east - west)
    map_height = max(1, round((north - south) * scale))
    if options.width * map_height > _MOST_PIXELS:
        raise InputError(
            f"the picture would have {options.width:,} x {map_height:,} pixels;"
            " give a smaller --width or a flatter box"
        )
    strips = _seen(file, scene, x, y, (west, south, east, north))
    if not len(strips):
        raise InputError(
            f"{file.path} has no road within --bbox; its roads lie at x and y within {_in_words(_around(x, y))}"
        )
    scene = scene.only(strips)
    modes = make_modes(file, scene, drawn_types(file, scene), has_findings=False)
    mode = next((mode for mode in modes if mode.key == options.colour), None)
    if mode is None:
        raise InputError(f"{file.path} states no speeds{' there' if options.box else ''}; choose another --color")
    x, y, _ = scene.border_places()
    parts, places = Parts(scene), np.stack(((x - west) * scale, (north - y) * scale), axis=1)
    drawn = _drawn(file, scene, mode, places, scale, parts)
    if scale >= FURNITURE_FROM:
        roads = frozenset(scene.strip_road.tolist())
        furniture = furniture_shapes(file, roads, lambda x, y: ((x - west) * scale, (north - y) * scale), scale)
        drawn += _furniture(furniture, parts)
    shapes = [shape for _, shape in sorted(drawn, key=lambda item: item[0])]
    band = max(_LEAST_BAND, round(_BAND * options.width))
    lines = credit_lines(credits_of(file), options.width)
    return Picture(
        options.width,
        map_height + band + credits_height(lines),
        map_height,
        band,
        scale,
        shapes,
        mode,
        nice_step(_BAR_SHARE * options.width / scale),
        file.header.attributes.get("name", "") or file.path.name,
        lines,
        any(isinstance(shape, Line) and shape.colour == DECAL_COLOUR for shape in shapes),
        bool(np.any(np.diff(unmeasured(file).start)[scene.strip_road] > 0)),
    )


def credit_lines(text: str, width: int) -> list[str]:
    """Break credits into lines that fit a width, pixels."""
    letters = max(8, int((width - 2 * CREDIT_SIZE) / (_CREDIT_LETTER * CREDIT_SIZE)))
    return textwrap.wrap(text, letters, max_lines=_MOST_CREDIT_LINES, placeholder=" …")


def credits_height(lines: list[str]) -> int:
    """Return the height of lines of credits with their margin, pixels."""
    return CREDIT_LINE * len(lines) + CREDIT_LINE // 2 if lines else 0


def _around(x: FloatArray, y: FloatArray) -> tuple[float, float, float, float]:
    """Return the box around everything, with a margin."""
    known = np.isfinite(x) & np.isfinite(y)
    west, east, south, north = x[known].min(), x[known].max(), y[known].min(), y[known].max()
    margin = _MARGIN * max(east - west, north - south, 20.0)
    return float(west - margin), float(south - margin), float(east + margin), float(north + margin)


def _in_words(box: tuple[float, float, float, float]) -> str:
    """Write a box as the option takes it."""
    return ",".join(f"{math.floor(value) if k < 2 else math.ceil(value)}" for k, value in enumerate(box))


def _seen(
    file: OpenDrive, scene: Scene, x: FloatArray, y: FloatArray, box: tuple[float, float, float, float]
) -> IntArray:
    """Return the strips that extend into a box, the lowest first."""
    west, south, east, north = _strip_boxes(scene, x, y)
    seen = (east >= box[0]) & (west <= box[2]) & (north >= box[1]) & (south <= box[3])
    rows = np.flatnonzero(seen & (np.diff(scene.lane_start) > 0))
    return np.asarray(rows[np.lexsort((rows, _levels(file, scene, rows)))])


def _levels(file: OpenDrive, scene: Scene, rows: IntArray) -> FloatArray:
    """Return the heights by which some strips lie over each other, (rows,), m.

    Roads through one junction are one surface: they keep their order, sidewalks round corners behind lanes for cars.
    """
    height, junction = _heights(scene)[rows], file.roads.junction[scene.strip_road[rows]]
    within = np.flatnonzero(junction >= 0)
    if len(within):
        of = unique_inverse(junction[within])[1]
        height[within] = (np.bincount(of, height[within]) / np.bincount(of))[of]
    return height


def _strip_boxes(scene: Scene, x: FloatArray, y: FloatArray) -> list[FloatArray]:
    """Return west, south, east, north of each strip, each (strips,); x, y are the places of the borders."""
    start = scene.border_start[:-1]
    return [limit.reduceat(values, start) for limit in (np.fmin, np.fmax) for values in (x, y)]


def _drawn(
    file: OpenDrive, scene: Scene, mode: Mode, places: FloatArray, scale: float, parts: Parts
) -> list[tuple[tuple[int, int], Shape]]:
    """Return the shapes of strips, each with its level and its place there: areas of one colour each, edges, marks.

    Of one level lies lowest what only closes the floor of a junction, then what is beside the carriageway, then what
    is driven on, as in scenes; marks are on top.
    """
    lane_colour, station_colour = _colours(file, scene, mode)
    kinds, kind_of = border_marks(file, scene) if scale >= MARKS_FROM else ([], np.zeros(0, np.int64))
    gaps = unmeasured(file)
    rank = [_rank(file, lane, int(file.roads.junction[scene.strip_road[strip]])) for strip, lane in _lanes_of(scene)]
    out: list[tuple[tuple[int, int], Shape]] = []
    begin = scene.border_start
    for strip in range(len(scene.strip_road)):
        advance(0.15 + 0.55 * strip / len(scene.strip_road))
        whole = places[begin[strip] : begin[strip + 1]].reshape(int(scene.strip_stations[strip]), -1, 2)
        first, lane = int(scene.station_start[strip]), int(scene.lane_start[strip])
        every = slice(first, first + len(whole))
        kept = _rows(scene.s[every], 1.0 / scale)
        ranks, borders = rank[lane : int(scene.lane_start[strip + 1])], lane + strip
        rows_of_road = slice(*gaps.start[scene.strip_road[strip] :][:2].tolist())
        stretches = list(zip(gaps.begin[rows_of_road].tolist(), gaps.end[rows_of_road].tolist(), strict=True))
        for level, rows in _by_level(kept, np.maximum.reduceat(parts.level[every], kept).tolist()):
            grid, halves = whole[rows], _halves(scene.heading[every][rows])
            if lane_colour is not None:
                shades = list(zip(lane_colour[lane : lane + len(ranks)], ranks, strict=True))
                for a, b in _runs(shades):
                    pieces = (part for half in halves for part in _with_width(grid, *half, a, b))
                    colour, order = shades[a]
                    out += [((level, -order), Polygon(_band(grid, top, end, a, b), colour)) for top, end in pieces]
            elif station_colour is not None:
                along = [station_colour[first + row] for row in rows[:-1]]
                for a, b in _runs(along):
                    out.append(((level, -min(ranks)), Polygon(_band(grid, a, b, 0, grid.shape[1] - 1), along[a])))
            if scale >= _EDGES_FROM and file.roads.junction[scene.strip_road[strip]] == -1:
                out += [((level, -min(ranks)), Line(grid[:, k])) for k in (0, -1)]
            marks: list[Line] = []
            if kinds:
                marks += mark_lines(grid, [kinds[k] for k in kind_of[borders : borders + grid.shape[1]]], scale)
            if stretches:
                marks += hatch_lines(grid, scene.s[first + np.array(rows)], stretches, scale)
            out += [((level, _MARKS), mark) for mark in marks]
    return out


def _lanes_of(scene: Scene) -> Iterable[tuple[int, int]]:
    """Yield strip and row in the file's table of all lanes, from left to right."""
    return zip(owners(scene.lane_start).tolist(), scene.lane, strict=True)


def _rank(file: OpenDrive, lane: int, junction: int) -> int:
    """Return how many kinds of lanes cover a lane, by its row; most what only closes the floor of a junction."""
    kind = file.lanes.type[lane]
    # It is no higher than the road.
    floor = junction >= 0 and kind in _FLOOR and not file.lanes.height[lane].any()
    return _LOWEST if floor else rank_of(kind)


def _by_level(rows: list[int], level: list[int]) -> Iterable[tuple[int, list[int]]]:
    """Yield the rows of a strip in parts of one level each, which share the row between them.

    `level` has that of the part behind each row.
    """
    if len(rows) < 2:
        return
    first = 0
    for k in range(1, len(rows)):
        if k == len(rows) - 1 or level[k] != level[first]:
            yield level[first], rows[first : k + 1]
            first = k


def _furniture(
    furniture: Iterable[tuple[PlacedObject | PlacedSignal, list[Shape]]], parts: Parts
) -> list[tuple[tuple[int, int], Shape]]:
    """Return furniture with its level and its place there: above all that it stands on, below bridges over it."""
    top = int(parts.level.max(initial=0))
    out: list[tuple[tuple[int, int], Shape]] = []
    for thing, shapes in furniture:
        corners = thing.corners if isinstance(thing, PlacedObject) else ((thing.x, thing.y),)
        over = parts.above(np.array(corners), thing.z + _OVERHEAD, thing.item.road)
        out += [((top if over is None else over - 1, _FURNITURE), shape) for shape in shapes]
    return out


def _heights(scene: Scene) -> FloatArray:
    """Return the mean height of each strip, m."""
    return np.nan_to_num(np.add.reduceat(np.nan_to_num(scene.z), scene.station_start[:-1]) / scene.strip_stations)


def _colours(file: OpenDrive, scene: Scene, mode: Mode) -> tuple[list[str] | None, list[str] | None]:
    """Return colours of lanes, or else of stations."""
    scale = mode.scale
    if isinstance(scale, Categories):
        return [scale.colours[k] for k in drawn_types(file, scene)[1].tolist()], None
    if mode.key == "speed":
        return _shades(scale, lane_speeds(file, scene)), None
    value = scene.z if mode.key == "height" else 100.0 * np.abs(scene.grade)
    return None, _shades(scale, value)


def _shades(ramp: Ramp, values: FloatArray) -> list[str]:
    """Return the colours of values in steps, so that neighbours join to one area."""
    step = (ramp.high - ramp.low) / (_SHADES - 1)
    stepped = np.where(np.isfinite(values), ramp.low + step * np.rint((values - ramp.low) / step), np.nan)
    return [f"#{r:02x}{g:02x}{b:02x}" for r, g, b in ramp.colours(stepped).tolist()]


def _rows(s: FloatArray, pixel: float) -> list[int]:
    """Return the stations that are at least a pixel apart, and both ends."""
    rows = [0]
    for k in range(1, len(s) - 1):
        if s[k] - s[rows[-1]] > pixel:
            rows.append(k)
    return [*rows, len(s) - 1]


def _runs(shades: Sequence[object]) -> list[tuple[int, int]]:
    """Return first and last row, exclusive, of neighbours that are alike."""
    ends = [k for k in range(1, len(shades)) if shades[k] != shades[k - 1]]
    return list(zip([0, *ends], [*ends, len(shades)], strict=True))


def _halves(heading: FloatArray) -> list[tuple[int, int]]:
    """Return first and last rows of the parts that a strip is drawn in, by its headings, (n,), rad.

    Where a road turns by more than half a circle, what lies on either side of it may meet itself, and an area that
    overlaps itself would have a hole there.
    """
    last = len(heading) - 1
    turned = np.cumsum(wrapped(heading[1:] - heading[:-1]))
    turns_back = bool(turned.max(initial=0.0) - turned.min(initial=0.0) > math.pi)
    return [(0, last // 2), (last // 2, last)] if turns_back and last > 1 else [(0, last)]


def _with_width(grid: FloatArray, top: int, end: int, left: int, right: int) -> list[tuple[int, int]]:
    """Return first and last rows of the parts of a strip, from row `top` to `end`, on which lanes have any width.

    The outline of others would be a line on what they lie on.
    """
    off = np.abs(grid[top : end + 1, left] - grid[top : end + 1, right]).max(axis=1) > _NO_WIDTH
    pieces = np.concatenate([[False], off[1:] | off[:-1], [False]])
    border = np.flatnonzero(pieces[1:] != pieces[:-1])
    return [(top + first, top + last) for first, last in border.reshape(-1, 2).tolist()]


def _band(grid: FloatArray, top: int, bottom: int, left: int, right: int) -> FloatArray:
    """Return the outline of a part of the grid of a strip."""
    return np.concatenate((grid[top : bottom + 1, left], grid[top : bottom + 1, right][::-1]))


def box_of_degrees(file: OpenDrive, box: tuple[float, float, float, float]) -> tuple[float, float, float, float]:
    """Return the box in x and y of a file (m) around a box of west, south, east, north in degrees, WGS 84.

    Raises
    ------
    InputError
        The file does not say where it lies, or the box is beyond its projection.
    """
    frame, reason = frame_of(file.header)
    if frame is None:
        raise InputError(f"{file.path}: {reason}; give --bbox-xy in metres instead of --bbox")
    west, south, east, north = box
    if max(abs(south), abs(north)) > _LATITUDE_MOST:
        raise InputError(f"--bbox reaches beyond the poles; {_BOX_ORDER}")
    found = _box_in_file(frame, box)
    if not _meets_roads(file, found) and max(abs(west), abs(east)) <= _LATITUDE_MOST:
        swapped = _box_in_file(frame, (south, west, north, east))
        if _meets_roads(file, swapped):
            raise InputError(f"{file.path} has roads within --bbox only if its axes are swapped; {_BOX_ORDER}")
    if not np.isfinite(found).all():
        raise InputError(f"{file.path}: --bbox lies beyond the projection of the file; give one nearer to its roads")
    return found


def _meets_roads(file: OpenDrive, box: tuple[float, float, float, float]) -> bool:
    """Whether a box (m) meets that around all reference lines."""
    west, south, east, north = box
    x, y = file.plan_view.x, file.plan_view.y
    known = np.isfinite(x) & np.isfinite(y)
    x, y = x[known], y[known]
    return bool(len(x) and west <= x.max() and east >= x.min() and south <= y.max() and north >= y.min())


def _box_in_file(frame: Frame, box: tuple[float, float, float, float]) -> tuple[float, float, float, float]:
    """Return the box in x and y of a file around a box in degrees; not finite where it is beyond the projection."""
    west, south, east, north = box
    share = np.linspace(0.0, 1.0, 9)
    lon = np.concatenate((west + share * (east - west), west + share * (east - west), np.repeat((west, east), 9)))
    lat = np.concatenate((np.repeat((south, north), 9), np.tile(south + share * (north - south), 2)))
    x, y = frame.to_inertial(lon, lat)
    if not (np.isfinite(x).all() and np.isfinite(y).all()):
        return math.nan, math.nan, math.nan, math.nan
    return float(x.min()), float(y.min()), float(x.max()), float(y.max())


def hatch_lines(grid: FloatArray, s: FloatArray, stretches: list[tuple[float, float]], scale: float) -> list[Line]:
    """Return strokes on a strip, `grid` (stations, borders, 2), pixels, at s (stations,), m, from left to right.

    `stretches` are begin and end of what is hatched, m, and `scale` is pixels per metre.
    """
    apart = max(_APART, _APART_PIXELS / scale)
    # Counted from the start of the road, so that strokes of neighbouring strips are apart as well.
    places = apart * (0.5 + np.arange(int(s[0] / apart), int(s[-1] / apart) + 1))
    inside = (places >= s[0]) & (places <= s[-1])
    places = places[inside & np.any([(places >= a) & (places <= b) for a, b in stretches], axis=0)]
    edges = [np.column_stack([np.interp(places, s, grid[:, k, axis]) for axis in (0, 1)]) for k in (0, -1)]
    middle, beside = 0.5 * (edges[0] + edges[1]), 0.5 * (edges[0] - edges[1])
    size = np.hypot(*beside.T)[:, None]
    beside = beside * np.fmax(_HALF / np.fmax(size, 1e-9), 1.0)
    # Left of the road is up where it leads to the right: y counts down.
    ahead = _SLANT * np.column_stack([-beside[:, 1], beside[:, 0]])
    ends = zip(middle + beside + ahead, middle - beside - ahead, strict=True)
    return [Line(np.stack(pair), HATCHING, _WIDTH) for pair in ends]
