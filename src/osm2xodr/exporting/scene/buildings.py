"""Buildings of OpenStreetMap as blocks with simple roofs, on the ground and off the roads.

What is left of each area where roads run, how high it is, how its roof bends, and walls and roofs of that.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from types import MappingProxyType
from typing import Any, Final

import numpy as np
import shapely

from osm2xodr.exporting.scene.ground import Ground
from osm2xodr.exporting.scene.meshes import (
    Meshes,
    Planes,
    area_of,
    half_edges,
    lone,
    part_of,
    polygons_of,
    triangles_of,
    walls_between,
)
from osm2xodr.exporting.scene.model import Level, Part, RoadSurface
from osm2xodr.model import BoolArray, Building, FloatArray
from osm2xodr.opendrive import Frame
from osm2xodr.system import record

# Height of a storey, m: OSM wiki, Key:building:levels, and most renderers of it.
STOREY: Final = 3.0
# Storeys of buildings without any height by the value of ``building``, and of all others. Orders of magnitude of
# what most of them have where OSM says it; choices.
STOREYS: Final = MappingProxyType(
    {
        **dict.fromkeys(("apartments", "hotel", "office", "hospital", "dormitory", "residential"), 4.0),
        **dict.fromkeys(("garage", "garages", "carport", "shed", "hut", "kiosk", "roof", "service", "toilets"), 1.0),
        **dict.fromkeys(("bungalow", "cabin", "greenhouse", "static_caravan", "bunker", "container"), 1.0),
        **dict.fromkeys(
            ("allotment_house", "boathouse", "transformer_tower", "stable", "sty", "farm_auxiliary"), 1.0
        ),
        **dict.fromkeys(("house", "detached", "semidetached_house", "terrace", "farm", "school"), 2.0),
        **dict.fromkeys(("church", "cathedral", "mosque", "temple"), 4.0),
        **dict.fromkeys(("industrial", "warehouse", "retail", "supermarket", "barn", "hangar"), 2.0),
    }
)
STOREYS_OTHER: Final = 2.0
# Heights of roofs without one, as a share of half of their width: 30 degrees; at most, m. Choices.
ROOF_SLOPE: Final = 0.577
ROOF_MOST: Final = 6.0
# Least height of walls, m, so that a roof's height cannot be more than the building's.
WALL_LEAST: Final = 0.5
# How far walls reach into the ground below their lowest corner, m. A choice.
BELOW_GROUND: Final = 0.5
# Buildings of which roads take more than this share of the area are left out, and less than this, m², is too small
# to be a building, a part of one or an overlap. Choices.
LOST_SHARE: Final = 0.5
AREA_LEAST: Final = 1.0
# Share of a building's outline that its parts cover if they stand for all of it. A choice.
PARTS_SHARE: Final = 0.9
# Height of passages through buildings above their road, m: RABT's clearance of 4.5 m.
PASSAGE: Final = 4.5


# ---------------------------------------------------------------- outlines


@record(eq=False)
class _Footprint:
    """What is left of a building's outline."""

    building: Building
    whole: Any  # A polygon: the outline itself
    areas: Any  # What of it stands on the ground
    over: Any  # What of it hangs above passages
    passage: float  # The highest place there, m


def _footprints(
    buildings: Sequence[Building],
    frame: Frame,
    surface: RoadSurface,
    passage: BoolArray,
    found: defaultdict[str, list[str]],
) -> Iterator[_Footprint]:
    """Yield what stands of buildings; `found` gets the ids of those ``repaired``, ``clipped`` and ``on_roads``.

    Outlines whose parts cover them stand for nothing.
    """
    rows, outlines = _outlines(buildings, frame, found)
    outlines = _without_parts(buildings, rows, outlines)
    roads = Planes(surface.vertices[surface.faces[(surface.level == Level.GROUND) | passage]])
    inside = passage[(surface.level == Level.GROUND) | passage][roads.rows]
    shapes = shapely.polygons(roads.corners[:, :, :2])
    area, road = shapely.STRtree(shapes).query(outlines, predicate="intersects")
    for k, (row, outline) in enumerate(zip(rows, outlines, strict=True)):
        building, whole = buildings[row], float(shapely.area(outline))
        if whole < AREA_LEAST:
            continue
        near = np.sort(road[area == k])
        below = near[inside[near]]
        left = shapely.difference(outline, shapely.union_all(shapes[near]))
        over = shapely.intersection(outline, shapely.union_all(shapes[below]))
        lost = whole - float(shapely.area(left) + shapely.area(over))
        if lost > LOST_SHARE * whole and not _hangs(building):
            found["on_roads"].append(building.osm_id)
            continue
        if lost > AREA_LEAST:
            found["clipped"].append(building.osm_id)
        highest = float(roads.corners[below, :, 2].max(initial=-np.inf))
        yield _Footprint(building, outline, _large(left), _large(over), highest)


def _hangs(building: Building) -> bool:
    """Whether a building begins above the ground."""
    return bool(building.min_height or building.min_level)


def _outlines(
    buildings: Sequence[Building], frame: Frame, found: defaultdict[str, list[str]]
) -> tuple[list[int], list[Any]]:
    """Return polygons of inertial x, y, and the row of the building of each."""
    rings = [ring for building in buildings for ring in (building.outline, *building.holes)]
    lon, lat = np.concatenate(rings).T
    xy = np.column_stack(frame.to_inertial(lon, lat))
    ends = np.cumsum([len(ring) for ring in rings])
    places = iter(np.split(xy, ends[:-1]))
    rows, shapes = list[int](), list[Any]()
    for row, building in enumerate(buildings):
        own = [next(places) for _ in range(1 + len(building.holes))]
        if not all(np.isfinite(ring).all() for ring in own):
            continue
        shape, repaired = area_of(own[0], own[1:])
        if repaired:
            found["repaired"].append(building.osm_id)
        parts = polygons_of(shape)
        rows += [row] * len(parts)
        shapes += list(parts)
    return rows, shapes


def _without_parts(buildings: Sequence[Building], rows: list[int], outlines: list[Any]) -> list[Any]:
    """Return outlines without the areas where parts of the building stand on the ground."""
    parts = [k for k, row in enumerate(rows) if buildings[row].is_part]
    if not parts:
        return outlines
    shapes = np.array([outlines[k] for k in parts])
    tree = shapely.STRtree(shapes)
    out = list(outlines)
    size = shapely.area(shapes)
    for k, row in enumerate(rows):
        if buildings[row].is_part:
            continue
        near = np.sort(tree.query(outlines[k], predicate="intersects"))
        shared = shapely.area(shapely.intersection(shapes[near], outlines[k]))
        own = near[shared > PARTS_SHARE * size[near]]
        if not len(own):
            continue
        covered = shapely.union_all(shapes[own])
        if shapely.area(shapely.intersection(covered, outlines[k])) > PARTS_SHARE * shapely.area(outlines[k]):
            out[k] = shapely.Polygon()
            continue
        stand = [j for j in own if not _hangs(buildings[rows[parts[j]]])]
        left = polygons_of(shapely.difference(outlines[k], shapely.union_all(shapes[stand])))
        # What parts leave beside the largest polygon are slivers.
        out[k] = max(left, key=shapely.area, default=shapely.Polygon())
    return out


def _large(shape: Any) -> Any:
    """Return the polygons of a shape that are large enough to be seen."""
    parts = polygons_of(shape)
    return shapely.multipolygons(parts[shapely.area(parts) > AREA_LEAST])


# ---------------------------------------------------------------- roofs

# Shapes as they are drawn by values of ``roof:shape``; the others are drawn flat.
SHAPES: Final = MappingProxyType(
    {
        **dict.fromkeys(("gabled", "half-hipped", "gambrel", "saltbox", "round"), "gabled"),
        **dict.fromkeys(("hipped", "mansard", "half_hipped", "side_hipped"), "hipped"),
        **dict.fromkeys(("pyramidal", "dome", "onion", "cone"), "pyramidal"),
    }
)
# Corners of roofs closer together than this are one, m; triangles of less area than its square are none.
_SAME: Final = 1e-4
_NAME: Final = "Building"


@record(eq=False)
class _Roof:
    """A roof over the smallest rectangle around an outline: u along its ridge, v to the left of it.

    Both count in shares of half the length and width. The ridge goes from u = -`ridge` to `ridge`: beyond the
    rectangle (2) under gables, and is a point (0) of pyramids.
    """

    middle: FloatArray  # x, y, m
    half: FloatArray  # (2, 2) Half the length and half the width as vectors, m
    ridge: float | None  # None for a flat roof

    @property
    def half_width(self) -> float:
        """Half of the shorter side, m."""
        return float(np.hypot(*self.half.T).min())

    def triangles(self, area: Any, eaves: float, top: float) -> FloatArray:
        """Return the triangles of the roof over a polygon, (n, 3, 3), m, from its lowest to its highest height."""
        if self.ridge is None:
            xy, _ = triangles_of(polygons_of(area))
            return np.concatenate([xy, np.full((len(xy), 3, 1), eaves)], axis=2)
        e, side = self.ridge, max(self.ridge, 2.0 - self.ridge)
        slopes = [[(-e, 0.0), (e, 0.0), (side, 2.0), (-side, 2.0)], [(e, 0.0), (side, -2.0), (side, 2.0)]]
        rings = [sign * np.array(ring) for ring in slopes[: 2 if e < 1.0 else 1] for sign in (1.0, -1.0)]
        sides = np.array([shapely.Polygon(self.middle + (ring[:, :, None] * self.half).sum(1)) for ring in rings])
        xy, _ = triangles_of(polygons_of(shapely.intersection(area, sides)))
        off = xy - self.middle
        u, v = (np.abs((off * axis).sum(2)) / (axis**2).sum() for axis in self.half)
        rise = np.minimum(1.0 - v, (1.0 - u) / (1.0 - e)) if e < 1.0 else 1.0 - v
        return np.concatenate([xy, eaves + (top - eaves) * np.clip(rise, 0.0, 1.0)[..., None]], axis=2)


def _roof_over(outline: Any, building: Building) -> _Roof:
    """Return the roof over the smallest rectangle around an outline, with the ridge as its tags want it."""
    corners = shapely.get_coordinates(shapely.minimum_rotated_rectangle(outline))[:4]
    half = 0.5 * np.array([corners[1] - corners[0], corners[2] - corners[1]])
    size = np.hypot(*half.T)
    if (size[0] < size[1]) != building.ridge_across:
        half, size = half[::-1], size[::-1]
    shape = SHAPES.get(building.roof_shape) if size.min() > 0.0 else None
    hip = max(1.0 - float(size[1] / max(size[0], 1e-9)), 0.0)
    return _Roof(corners.mean(0), half, {"gabled": 2.0, "hipped": hip, "pyramidal": 0.0, None: None}[shape])


# ---------------------------------------------------------------- walls and roofs


@record(eq=False)
class _Block:
    """A building between two heights."""

    area: Any  # A polygon
    roof: _Roof
    # Heights, m
    low: float
    eaves: float
    top: float
    hangs: bool  # Whether one can see it from below


def _parts_of(blocks: Sequence[_Block]) -> tuple[Part, ...]:
    """Return the walls and roofs of blocks."""
    if not blocks:
        return ()
    roofs = [block.roof.triangles(block.area, block.eaves, block.top) for block in blocks]
    owner = np.repeat(np.arange(len(blocks)), [len(roof) for roof in roofs])
    # Each block has its own vertices.
    corners = np.concatenate(roofs).reshape(-1, 3)
    keys = np.column_stack([np.repeat(owner, 3), np.rint(corners[:, :2] / _SAME).astype(np.int64)])
    _, first, number = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    vertices, faces = corners[first], number.reshape(-1, 3)
    # A triangle whose corners are the same, or on one line, is none.
    whole = Planes(vertices[faces], 0.5 * _SAME**2).rows
    faces, owner = faces[whole], owner[whole]
    low = np.array([block.low for block in blocks])[owner]
    hangs = np.array([block.hangs for block in blocks])[owner]
    start, end = half_edges(faces)
    outer = np.flatnonzero(lone(start, end))
    edges = np.stack([vertices[start[outer]], vertices[end[outer]]], axis=1)
    feet = edges.copy()
    feet[..., 2] = low[outer // 3, None]
    standing = Meshes()
    standing.add(_NAME, "wall", *walls_between(feet, edges))
    floors = vertices[faces[hangs][:, ::-1]]
    floors[..., 2] = low[hangs, None]
    floors = floors.reshape(-1, 3)
    standing.add(_NAME, "wall", floors, floors[:, :2], np.arange(len(floors)).reshape(-1, 3))
    flat = np.array([block.roof.ridge is None for block in blocks])[owner]
    return (
        *standing.parts(),
        part_of(_NAME, "roof", vertices, faces[~flat]),
        part_of(_NAME, "roof_flat", vertices, faces[flat]),
    )


# ---------------------------------------------------------------- heights and blocks

# Between points of an outline at which the ground below it is looked up, m: half of its smallest squares.
_STEP: Final = 2.5


@record(eq=False)
class Buildings:
    """Buildings of a scene, and what became of those that were given."""

    parts: tuple[Part, ...]  # ``Building`` of the materials ``wall``, ``roof`` and ``roof_flat``
    # OSM ids of buildings: ``drawn``; of these ``guessed`` (no tag gives a height), ``flat`` (whose roof has another
    # shape), ``clipped`` (roads take some of their area) and ``repaired`` (outlines that cross themselves); left out
    # ``on_roads`` (these take most of their area) and ``off_ground``
    ids: Mapping[str, tuple[str, ...]]


def building_parts(
    buildings: Sequence[Building], frame: Frame, surface: RoadSurface, passage: BoolArray, ground: Ground
) -> Buildings:
    """Return buildings that stand on the ground and leave roads free.

    `frame` turns their places into inertial x, y. `passage`, (triangles of `surface`,), are roads on the ground that
    lead through buildings, which go on above them.
    """
    found: defaultdict[str, list[str]] = defaultdict(list)
    blocks = []
    for item in _footprints(buildings, frame, surface, passage, found) if buildings else ():
        corners = shapely.get_coordinates(shapely.segmentize(item.whole, _STEP))
        below = ground.heights(corners[:, 0], corners[:, 1])
        # At shores the elevation model may end below a building.
        below = below[np.isfinite(below)]
        found["drawn" if len(below) else "off_ground"].append(item.building.osm_id)
        if len(below):
            blocks += _blocks(item, float(below.min()), float(below.max()), found)
    ids = {name: tuple(dict.fromkeys(rows)) for name, rows in sorted(found.items())}
    return Buildings(_parts_of(blocks), ids)


def _blocks(item: _Footprint, low: float, high: float, found: defaultdict[str, list[str]]) -> list[_Block]:
    """Return the blocks of a building on ground between two heights, m, one for each area that is left of it."""
    building, roof = item.building, _roof_over(item.whole, item.building)
    if building.roof_shape not in ("", "flat", *SHAPES):
        found["flat"].append(building.osm_id)
    floor, eaves, top = _heights(building, roof)
    storey = 0.0
    if building.height is None and building.levels is None:
        found["guessed"].append(building.osm_id)
        # A guess must not be buried on a slope.
        storey = max(high + STOREY - low - eaves, 0.0) if floor == 0.0 else 0.0
    eaves, top = low + eaves + storey, low + top + storey
    foot = low + floor if floor > 0.0 else low - BELOW_GROUND
    blocks = [_Block(area, roof, foot, eaves, top, floor > 0.0) for area in polygons_of(item.areas)]
    # What is above a passage is as high as the rest, but hangs.
    ceiling = item.passage + PASSAGE
    if ceiling < eaves:
        blocks += [_Block(area, roof, max(ceiling, foot), eaves, top, True) for area in polygons_of(item.over)]
    return blocks


def _heights(building: Building, roof: _Roof) -> tuple[float, float, float]:
    """Return how high a building's lowest floor, eaves and ridge are above the ground, m.

    The floor is above 0 for parts that stand on others or hang between them.
    """
    rise = 0.0 if roof.ridge is None else min(ROOF_SLOPE * roof.half_width, ROOF_MOST)
    if roof.ridge is not None and building.roof_height is not None:
        rise = building.roof_height
    elif roof.ridge is not None and building.roof_levels:
        rise = building.roof_levels * STOREY
    top = building.height
    if top is None:
        storeys = STOREYS.get(building.kind, STOREYS_OTHER) if building.levels is None else building.levels
        # Storeys in the roof are not among those below.
        top = storeys * STOREY + rise
    floor = building.min_height
    if floor is None:
        floor = 0.0 if building.min_level is None else building.min_level * STOREY
    floor = min(floor, max(top - WALL_LEAST, 0.0))
    top = max(top, floor + WALL_LEAST)
    eaves = max(top - rise, floor if building.is_part and floor > 0.0 else floor + WALL_LEAST)
    return floor, min(eaves, top), top
