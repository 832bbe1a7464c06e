"""Buildings of OpenStreetMap as blocks with simple roofs, on the ground and off the roads.

What is left of each area where roads run, how high it is, how its roof bends, and walls and roofs of that.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, Final

import numpy as np
import shapely

from osm2xodr.exporting.scene.arrangement import area_of, half_edges, polygons_of, triangles_of
from osm2xodr.exporting.scene.ground import Ground
from osm2xodr.exporting.scene.model import Level, Part, RoadSurface
from osm2xodr.model import BoolArray, Building, FloatArray, IntArray
from osm2xodr.opendrive import Frame

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


@dataclass(frozen=True, eq=False)
class Footprint:
    """What is left of a building's outline."""

    row: int  # Of the building
    whole: Any  # A polygon: the outline itself
    areas: Any  # What of it stands on the ground
    # What of it hangs above passages, and the lowest height there, m
    above: tuple[tuple[Any, float], ...]


class _Roads:
    """The roads on the ground, as triangles."""

    def __init__(self, surface: RoadSurface, passage: BoolArray) -> None:
        rows = np.flatnonzero((surface.level == Level.GROUND) | passage)
        self._corners = surface.vertices[surface.faces[rows]]
        shapes = shapely.polygons(self._corners[:, :, :2])
        flat = shapely.area(shapes) > 0.0
        self._shapes, self._corners, self._passage = shapes[flat], self._corners[flat], passage[rows][flat]
        self._tree = shapely.STRtree(self._shapes)

    def at(self, areas: Sequence[Any]) -> tuple[IntArray, IntArray]:
        """Return pairs of areas and triangles that share a place."""
        area, road = self._tree.query(areas, predicate="intersects")
        order = np.lexsort((road, area))
        return area[order], road[order]

    def cut(self, area: Any, rows: IntArray) -> tuple[Any, tuple[tuple[Any, float], ...]]:
        """Return what of an area lies on no road, and what of it lies above passages, with its lowest height, m."""
        taken = shapely.union_all(self._shapes[rows])
        left = shapely.difference(area, taken)
        inside = rows[self._passage[rows]]
        if not len(inside):
            return left, ()
        over = shapely.intersection(area, shapely.union_all(self._shapes[inside]))
        return left, ((over, float(self._corners[inside][..., 2].max()) + PASSAGE),)


def footprints_of(
    buildings: Sequence[Building],
    frame: Frame,
    surface: RoadSurface,
    passage: BoolArray,
    found: defaultdict[str, list[str]],
) -> list[Footprint]:
    """Return what stands of buildings; `found` gets the ids of those ``repaired``, ``clipped`` and ``on_roads``.

    Outlines whose parts cover them stand for nothing.
    """
    rows, outlines = _outlines(buildings, frame, found)
    if not rows:
        return []
    outlines = _without_parts(buildings, rows, outlines)
    roads = _Roads(surface, passage)
    area, road = roads.at(outlines)
    first = np.searchsorted(area, np.arange(len(outlines) + 1))
    out = []
    for k, (row, outline) in enumerate(zip(rows, outlines, strict=True)):
        whole = float(shapely.area(outline))
        if whole < AREA_LEAST:
            continue
        near = road[first[k] : first[k + 1]]
        left, above = roads.cut(outline, near) if len(near) else (outline, ())
        lost = whole - float(shapely.area(left)) - sum(float(shapely.area(over)) for over, _ in above)
        osm_id = buildings[row].osm_id
        hangs = bool(buildings[row].min_height or buildings[row].min_level)
        if lost > LOST_SHARE * whole and not hangs:
            found["on_roads"].append(osm_id)
            continue
        if lost > AREA_LEAST:
            found["clipped"].append(osm_id)
        out.append(Footprint(row, outline, _large(left), tuple((_large(over), z) for over, z in above)))
    return out


def _outlines(
    buildings: Sequence[Building], frame: Frame, found: defaultdict[str, list[str]]
) -> tuple[list[int], list[Any]]:
    """Return polygons of inertial x, y, and the row of the building of each."""
    if not buildings:
        return [], []
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
        stand = [j for j in own if not (buildings[rows[parts[j]]].min_height or buildings[rows[parts[j]]].min_level)]
        out[k] = _largest(shapely.difference(outlines[k], shapely.union_all(shapes[stand])))
    return out


def _large(shape: Any) -> Any:
    """Return the polygons of a shape that are large enough to be seen."""
    parts = polygons_of(shape)
    return shapely.multipolygons(parts[shapely.area(parts) > AREA_LEAST])


def _largest(shape: Any) -> Any:
    """Return the largest polygon of a shape: what parts leave of an outline otherwise are slivers."""
    parts = polygons_of(shape)
    return parts[int(np.argmax(shapely.area(parts)))] if len(parts) else shapely.Polygon()


# ---------------------------------------------------------------- roofs

# Shapes as they are drawn by values of ``roof:shape``; the others are drawn flat.
SHAPES: Final = {
    **dict.fromkeys(("gabled", "half-hipped", "gambrel", "saltbox", "round"), "gabled"),
    **dict.fromkeys(("hipped", "mansard", "half_hipped", "side_hipped"), "hipped"),
    **dict.fromkeys(("pyramidal", "dome", "onion", "cone"), "pyramidal"),
}


@dataclass(frozen=True, eq=False)
class Box:
    """The smallest rectangle around an outline: u along its longer side (the ridge), v to the left of it."""

    middle: FloatArray  # x, y, m
    along: FloatArray  # Unit vector of u
    half_length: float  # m
    half_width: float  # m


def box_of(outline: shapely.Polygon, building: Building) -> Box:
    """Return the smallest rectangle around an outline, with the ridge as the building's tags want it."""
    corners = shapely.get_coordinates(shapely.minimum_rotated_rectangle(outline))[:4]
    one, other = corners[1] - corners[0], corners[2] - corners[1]
    if (np.hypot(*one) < np.hypot(*other)) != building.ridge_across:
        one, other = other, one
    length, width = float(np.hypot(*one)), float(np.hypot(*other))
    return Box(corners.mean(0), one / max(length, 1e-9), 0.5 * length, 0.5 * width)


def roof_pieces(outline: shapely.Polygon, box: Box, shape: str) -> FloatArray:
    """Return the triangles of a roof, (n, 3, 3): x, y, m, and the height from 0 at eaves to 1 at the ridge.

    `shape` is one of the values of `SHAPES`, or ``flat``.
    """
    regions, rise = _REGIONS[shape](box), _RISES[shape]
    pieces = outline if regions is None else shapely.intersection(outline, regions)
    xy, _ = triangles_of(polygons_of(pieces))
    off = xy - box.middle
    u = np.abs(off @ box.along)
    v = np.abs(off @ np.array([-box.along[1], box.along[0]]))
    return np.concatenate([xy, np.clip(rise(u, v, box), 0.0, 1.0)[..., None]], -1)


def _regions(box: Box, corners: list[list[tuple[float, float]]]) -> FloatArray:
    """Return polygons from their corners in shares of half the length and width, larger than the box by a half."""
    across = np.array([-box.along[1], box.along[0]])
    return np.array(
        [
            shapely.Polygon(
                [box.middle + u * box.half_length * box.along + v * box.half_width * across for u, v in ring]
            )
            for ring in corners
        ]
    )


def _gabled(box: Box) -> FloatArray:
    return _regions(box, [[(-2, 0), (2, 0), (2, 2), (-2, 2)], [(-2, -2), (2, -2), (2, 0), (-2, 0)]])


def _hipped(box: Box) -> FloatArray:
    # The ridge ends as far from the short sides as from the long ones.
    end = max(1.0 - box.half_width / max(box.half_length, 1e-9), 0.0)
    slant = 2.0 * (1.0 - end) + end
    if end == 0.0:
        return _pyramidal(box)
    return _regions(
        box,
        [
            [(-end, 0), (end, 0), (slant, 2), (-slant, 2)],
            [(-slant, -2), (slant, -2), (end, 0), (-end, 0)],
            [(end, 0), (slant, -2), (slant, 2)],
            [(-end, 0), (-slant, 2), (-slant, -2)],
        ],
    )


def _pyramidal(box: Box) -> FloatArray:
    a, b, c, d = (-2, -2), (2, -2), (2, 2), (-2, 2)
    return _regions(box, [[(0, 0), *sides] for sides in ([a, b], [b, c], [c, d], [d, a])])


_REGIONS: Final[dict[str, Callable[[Box], FloatArray | None]]] = {
    "flat": lambda _: None,
    "gabled": _gabled,
    "hipped": _hipped,
    "pyramidal": _pyramidal,
}
_RISES: Final[dict[str, Callable[[FloatArray, FloatArray, Box], FloatArray]]] = {
    "flat": lambda u, v, box: np.zeros_like(u),
    "gabled": lambda u, v, box: 1.0 - v / box.half_width,
    "hipped": lambda u, v, box: np.minimum(
        1.0 - v / box.half_width, (box.half_length - u) / min(box.half_width, box.half_length)
    ),
    "pyramidal": lambda u, v, box: 1.0 - np.maximum(u / box.half_length, v / box.half_width),
}


# ---------------------------------------------------------------- walls and roofs

# Corners of roofs closer together than this are one, m; triangles of less area than its square are none.
_SAME: Final = 1e-4
_NAME: Final = "Building"


@dataclass(frozen=True, eq=False)
class Block:
    """A building between two heights."""

    area: Any  # A polygon
    box: Box  # Of the whole building, over which its roof stands
    shape: str  # Of the roof: a value of `SHAPES`, or ``flat``
    # Heights, m
    low: float
    eaves: float
    ridge: float
    hangs: bool  # Whether one can see it from below


def meshes_of(blocks: Sequence[Block]) -> tuple[Part, ...]:
    """Return the walls and roofs of blocks."""
    roofs = [_roof(block) for block in blocks]
    if not roofs:
        return ()
    corners = np.concatenate(roofs)
    owner = np.repeat(np.arange(len(blocks)), [len(roof) for roof in roofs])
    vertices, faces = _merged(corners, owner)
    # A triangle whose corners are the same, or on one line, is none.
    a, b, c = (vertices[faces[:, k], :2] for k in range(3))
    whole = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0]) > _SAME**2
    faces, owner = faces[whole], owner[whole]
    low = np.array([block.low for block in blocks])
    hangs = np.array([block.hangs for block in blocks])[owner]
    start, end, of = _outer_edges(faces, len(vertices))
    walls, walls_uv = _walls(vertices[start], vertices[end], low[owner[of]])
    floors = vertices[faces[hangs][:, ::-1]]
    floors[..., 2] = low[owner[hangs], None]
    standing = np.concatenate([walls, floors]).reshape(-1, 3)
    standing_uv = np.concatenate([walls_uv, floors[..., :2]]).reshape(-1, 2)
    flat = np.array([block.shape == "flat" for block in blocks])[owner]
    return (
        Part(_NAME, "wall", standing, standing_uv, np.arange(len(standing)).reshape(-1, 3)),
        _roofs("roof", vertices, faces[~flat]),
        _roofs("roof_flat", vertices, faces[flat]),
    )


def _roofs(material: str, vertices: FloatArray, faces: IntArray) -> Part:
    """Return triangles of roofs of one material, with the vertices that they have."""
    used, number = np.unique(faces, return_inverse=True)
    return Part(_NAME, material, vertices[used], vertices[used, :2], number.reshape(-1, 3))


def _roof(block: Block) -> FloatArray:
    """Return the triangles of a roof, (n, 3, 3), m."""
    out = roof_pieces(block.area, block.box, block.shape)
    out[..., 2] = block.eaves + out[..., 2] * (block.ridge - block.eaves)
    return out


def _merged(corners: FloatArray, owner: IntArray) -> tuple[FloatArray, IntArray]:
    """Return vertices (n, 3), m, and triangles (m, 3) of them: each block has its own."""
    flat = corners.reshape(-1, 3)
    keys = np.column_stack([np.repeat(owner, 3), np.rint(flat[:, :2] / _SAME).astype(np.int64)])
    _, first, number = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    return flat[first], number.reshape(-1, 3)


def _outer_edges(faces: IntArray, count: int) -> tuple[IntArray, IntArray, IntArray]:
    """Return both ends of the edges that only one triangle has, and that triangle."""
    start, end = half_edges(faces)
    outer = np.flatnonzero(~np.isin(start * count + end, end * count + start))
    return start[outer], end[outer], outer // 3


def _walls(start: FloatArray, end: FloatArray, low: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the triangles of walls below edges, (n, 3, 3), m, and their u along the wall and v from its foot."""
    foot, last = start.copy(), end.copy()
    foot[:, 2] = last[:, 2] = low
    length = np.hypot(*(end - start)[:, :2].T)
    zero = np.zeros(len(start))
    quads = np.stack([foot, last, end, start], 1)
    u = np.column_stack([zero, length, length, zero])
    v = np.column_stack([zero, zero, end[:, 2] - low, start[:, 2] - low])
    halves = np.array([0, 1, 2, 0, 2, 3])
    return quads[:, halves].reshape(-1, 3, 3), np.stack([u, v], -1)[:, halves].reshape(-1, 3, 2)


# ---------------------------------------------------------------- heights and blocks


@dataclass(frozen=True, slots=True)
class Heights:
    """Heights of a building above the ground, m."""

    floor: float  # Of its lowest floor: above 0 for parts that stand on others or hang between them
    eaves: float  # Of the top of its walls
    ridge: float  # Of the highest point of its roof
    guessed: bool  # Whether no tag says how high it is


def heights_of(building: Building, half_width: float, pitched: bool) -> Heights:
    """Return the heights of a building of which half of the shorter side is given, m.

    `pitched` says whether its roof has a shape that is not flat.
    """
    roof = _roof_height(building, half_width) if pitched else 0.0
    guessed = building.height is None and building.levels is None
    if building.height is not None:
        ridge = building.height
    else:
        storeys = STOREYS.get(building.kind, STOREYS_OTHER) if building.levels is None else building.levels
        # Storeys in the roof are not among those below.
        ridge = storeys * STOREY + roof
    floor = building.min_height
    if floor is None:
        floor = 0.0 if building.min_level is None else building.min_level * STOREY
    floor = min(floor, max(ridge - WALL_LEAST, 0.0))
    ridge = max(ridge, floor + WALL_LEAST)
    eaves = max(ridge - roof, floor if building.is_part and floor > 0.0 else floor + WALL_LEAST)
    return Heights(floor, min(eaves, ridge), ridge, guessed)


def _roof_height(building: Building, half_width: float) -> float:
    """Return the height of a building's roof, m."""
    if building.roof_height is not None:
        return building.roof_height
    if building.roof_levels:
        return building.roof_levels * STOREY
    return min(ROOF_SLOPE * half_width, ROOF_MOST)


# Between points of an outline at which the ground below it is looked up, m: half of its smallest squares.
_STEP = 2.5


@dataclass(frozen=True, eq=False)
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
    for item in footprints_of(buildings, frame, surface, passage, found):
        building = buildings[item.row]
        block = _block(building, item, ground, found)
        if block is None:
            found["off_ground"].append(building.osm_id)
            continue
        found["drawn"].append(building.osm_id)
        blocks += block
    ids = {name: tuple(dict.fromkeys(rows)) for name, rows in sorted(found.items())}
    return Buildings(meshes_of(blocks), ids)


def _block(
    building: Building, item: Footprint, ground: Ground, found: defaultdict[str, list[str]]
) -> list[Block] | None:
    """Return the blocks of a building, one for each area that is left of it; None off the ground."""
    corners = shapely.get_coordinates(shapely.segmentize(item.whole, _STEP))
    below = ground.heights(corners[:, 0], corners[:, 1])
    # At shores the elevation model may end below a building.
    below = below[np.isfinite(below)]
    if not len(below):
        return None
    low, high = float(below.min()), float(below.max())
    shape = SHAPES.get(building.roof_shape, "flat")
    if building.roof_shape not in ("", "flat", *SHAPES):
        found["flat"].append(building.osm_id)
    box = box_of(item.whole, building)
    if min(box.half_length, box.half_width) <= 0.0:
        shape = "flat"
    heights = heights_of(building, min(box.half_length, box.half_width), shape != "flat")
    eaves, ridge = low + heights.eaves, low + heights.ridge
    if heights.guessed:
        found["guessed"].append(building.osm_id)
        # A guess must not be buried on a slope.
        more = max(high + STOREY - eaves, 0.0) if heights.floor == 0.0 else 0.0
        eaves, ridge = eaves + more, ridge + more
    floor = low + heights.floor if heights.floor > 0.0 else low - BELOW_GROUND
    blocks = [Block(area, box, shape, floor, eaves, ridge, heights.floor > 0.0) for area in polygons_of(item.areas)]
    for over, lowest in item.above:
        # What is above a passage is as high as the rest, but hangs.
        if lowest < eaves:
            blocks += [Block(area, box, shape, max(lowest, floor), eaves, ridge, True) for area in polygons_of(over)]
    return blocks
