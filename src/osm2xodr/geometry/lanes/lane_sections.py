"""Lane sections of roads outside junctions: lanes, widths with tapers, links, marks, and the lane offset."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Final

from osm2xodr.conventions import GENERIC, Country
from osm2xodr.geometry import defaults
from osm2xodr.geometry.lanes.cross_sections import CrossSection
from osm2xodr.geometry.lanes.lane_connectivity import Connectivity
from osm2xodr.geometry.lanes.lane_matching import match_lanes
from osm2xodr.geometry.lanes.road_marks import change_kind, mark_kind, road_marks, same_marks
from osm2xodr.model import (
    Cubic,
    Direction,
    Lane,
    LaneSection,
    LaneSpec,
    LaneType,
    RoadMark,
    RoadType,
    Rule,
    StreetAttributes,
)

# Speed above which a road without a better sign is taken for a rural one, m/s (60 km/h: beyond urban limits).
_RURAL_SPEED: Final = 60.0 / 3.6


@dataclass(frozen=True, slots=True)
class Stretch:
    """Part of a road on which the cross-section stays the same."""

    # s on the road, m
    start: float
    end: float
    # What holds there
    attributes: StreetAttributes
    section: CrossSection
    ways: tuple[int, ...]  # The OSM ways that it is made of, in their order


@dataclass(frozen=True, slots=True)
class LaneLayout:
    """Everything that a road says about its lanes."""

    sections: tuple[LaneSection, ...]  # Lane sections; lanes at the road's ends have no links beyond it yet
    offset: tuple[Cubic, ...]  # Lane offset over the road's s
    types: tuple[RoadType, ...]  # Road type and speed


def stretches(
    pieces: Sequence[tuple[float, StreetAttributes, CrossSection]], begin: float, end: float
) -> list[Stretch]:
    """Cut the pieces of a street to the part from s = begin to s = end, which becomes a road.

    Pieces whose lanes are the same become one stretch; a stretch that is too short for a lane section of its own
    joins the longer of its neighbours.

    Parameters
    ----------
    pieces
        (s on the street from which it holds, attributes, cross-section), in ascending s.
    """
    if len(pieces) == 1:
        _, attributes, section = pieces[0]
        return [Stretch(0.0, end - begin, attributes, section, (attributes.osm_way_id,))]
    found: list[Stretch] = []
    for k, (s, attributes, section) in enumerate(pieces):
        lower = max(s, begin) if k else begin
        upper = min(pieces[k + 1][0] if k + 1 < len(pieces) else end, end)
        if upper <= lower:
            continue
        last = found[-1] if found else None
        if last is not None and _same_lanes(last.section, section) and _same_rules(last.attributes, attributes):
            # The later attributes hold the turns that count at the end, the lanes are the same.
            ways = (*last.ways, attributes.osm_way_id)
            found[-1] = Stretch(last.start, upper - begin, attributes, section, ways)
        else:
            found.append(Stretch(lower - begin, upper - begin, attributes, section, (attributes.osm_way_id,)))
    if not found:
        s, attributes, section = max((p for p in pieces if p[0] <= begin), default=pieces[0], key=lambda p: p[0])
        return [Stretch(0.0, end - begin, attributes, section, (attributes.osm_way_id,))]
    return _without_short(found)


def _without_short(found: list[Stretch]) -> list[Stretch]:
    """Mend stretches that are too short for tapers.

    At a road's end, where pockets for turning lanes are, they grow; elsewhere a neighbour takes them over, unless
    traffic runs otherwise there.
    """
    found = _grown_at_ends(found)
    kept: set[float] = set()
    while len(found) > 1:
        k = min(
            (i for i in range(len(found)) if found[i].start not in kept),
            key=lambda i: found[i].end - found[i].start,
            default=-1,
        )
        if k < 0 or found[k].end - found[k].start >= defaults.SHORTEST_LANE_SECTION:
            break
        item = found[k]
        tiny = item.end - item.start < defaults.SHORTEST_ROAD
        heirs = [
            i
            for i in (k - 1, k + 1)
            if 0 <= i < len(found) and (tiny or _directions(found[i].section) == _directions(item.section))
        ]
        if not heirs:
            kept.add(item.start)
            continue
        heir = found[max(heirs, key=lambda i: found[i].end - found[i].start)]
        lo = min(k, found.index(heir))
        ways = (*found[lo].ways, *found[lo + 1].ways)
        merged = Stretch(found[lo].start, found[lo + 1].end, heir.attributes, heir.section, ways)
        found[lo : lo + 2] = [merged]
    return found


def _grown_at_ends(found: list[Stretch]) -> list[Stretch]:
    """Lengthen the stretches at a road's ends, whichever way it is drawn, by what their neighbours can spare."""
    if len(found) < 2:
        return found
    out, lacking = list(found), [defaults.SHORTEST_LANE_SECTION - (item.end - item.start) for item in found]
    for k, beside in sorted(((0, 1), (-1, -2)), key=lambda pair: lacking[pair[0]]):
        missing, room = lacking[k], out[beside].end - out[beside].start
        # Of two stretches neither grows at the cost of the other, which is at an end as well.
        spare = room / 2 if len(out) > 2 else room - defaults.SHORTEST_LANE_SECTION
        if 0 < missing < spare and not _leftover(out[k]):
            border = out[k].start - missing if k else out[k].end + missing
            one, other = min(k, beside), max(k, beside)
            out[one], out[other] = replace(out[one], end=border), replace(out[other], start=border)
    return out


def _leftover(item: Stretch) -> bool:
    """Say whether a junction has left next to nothing of a stretch, and no lane that turns depends on it."""
    tiny = item.end - item.start < defaults.SHORTEST_ROAD
    return tiny and not any(lane.turns for lane in (*item.section.left, *item.section.right))


def _directions(section: CrossSection) -> set[Direction]:
    return {lane.direction for lane in (*section.left, *section.right)}


def _same_lanes(one: CrossSection, other: CrossSection) -> bool:
    def shape(lanes: tuple[LaneSpec, ...]) -> list[tuple[LaneType, Direction, float, Hashable]]:
        return [(lane.type, lane.direction, lane.width, len(lanes) > 1 and change_kind(lane)) for lane in lanes]

    return (
        one.centre == other.centre and shape(one.left) == shape(other.left) and shape(one.right) == shape(other.right)
    )


def _same_rules(one: StreetAttributes, other: StreetAttributes) -> bool:
    speeds = (one.speed_forward, one.speed_backward) == (other.speed_forward, other.speed_backward)
    return speeds and same_marks(one, other)


def lay_out_all(
    roads: Sequence[Sequence[Stretch]], rule: Rule, known: Connectivity | None = None, country: Country = GENERIC
) -> list[LaneLayout]:
    """Build the lane sections of many roads; those of one stretch share what is alike in kind.

    Parameters
    ----------
    roads, rule, known, country
        As for `lay_out_lanes`.
    """
    alike: dict[tuple[CrossSection, Hashable, float | None, float | None], LaneLayout] = {}
    out: list[LaneLayout] = []
    for road in roads:
        if len(road) > 1:
            out.append(lay_out_lanes(road, rule, known, country))
            continue
        attributes = road[0].attributes
        kind = (road[0].section, mark_kind(attributes), attributes.speed_forward, attributes.speed_backward)
        layout = alike.get(kind)
        if layout is None:
            layout = alike[kind] = lay_out_lanes(road, rule, known, country)
        out.append(layout)
    return out


def lay_out_lanes(
    road: Sequence[Stretch], rule: Rule, known: Connectivity | None = None, country: Country = GENERIC
) -> LaneLayout:
    """Build the lane sections of a road from its stretches.

    A lane that opens does so from width 0 after the border of two sections, one that ends does so before it; lane
    offset and widths follow the same cubic, so that every edge between them does too.

    Parameters
    ----------
    road
        At least one stretch.
    rule
        Side of the road that one drives on.
    known
        What relations say about lanes.
    country
        How roads are painted.
    """
    links = [
        match_lanes(a.section, b.section, rule, known.at_border(a.ways[-1], b.ways[0]) if known else None)
        for a, b in pairwise(road)
    ]
    sections: list[LaneSection] = []
    offset: list[Cubic] = []
    types: list[RoadType] = []
    at_border: dict[int, float] = dict(_widths(road[0].section))
    offset_at_border = road[0].section.centre
    for k, stretch in enumerate(road):
        ahead = links[k] if k + 1 < len(road) else None
        widths = _widths(stretch.section)
        length = stretch.end - stretch.start
        most = (
            defaults.TAPER_LENGTH_MOTORWAY
            if stretch.attributes.highway in defaults.FAST_HIGHWAYS
            else defaults.TAPER_LENGTH
        )
        taper = min(most, defaults.TAPER_SHARE * length)
        ending = set() if ahead is None else {lane for lane in widths if lane not in ahead}
        following = road[k + 1].section if ahead is not None else None
        offset_after = _offset_at_border(stretch.section, ending, following, ahead)
        begins = {lane: at_border.get(lane, 0.0) for lane in widths}
        behind = {to: lane for lane, to in links[k - 1].items()} if k else None
        marks = road_marks(stretch.section, stretch.attributes, rule, country)
        lanes = _lanes(_Course(stretch, length, taper, begins, ending, behind, ahead, marks))
        sections.append(LaneSection(stretch.start, lanes))
        offset += [
            Cubic(stretch.start + c.s, c.a, c.b, c.c, c.d)
            for c in tapered(length, taper, offset_at_border, stretch.section.centre, offset_after)
        ]
        types.append(RoadType(stretch.start, _road_type(stretch.attributes), _road_speed(stretch.attributes)))
        if ahead is not None:
            at_border = {to: widths[lane] for lane, to in ahead.items()}
            offset_at_border = offset_after
    return LaneLayout(tuple(sections), without_repeats(offset), _without_equal_types(types))


def _widths(section: CrossSection) -> dict[int, float]:
    """Return width by lane id, leftmost first."""
    left = {number: lane.width for number, lane in enumerate(section.left, start=1)}
    right = {-number: lane.width for number, lane in enumerate(section.right, start=1)}
    return {**dict(reversed(left.items())), **right}


def _offset_at_border(
    section: CrossSection, ending: set[int], following: CrossSection | None, ahead: dict[int, int] | None
) -> float:
    """Return the centre's t at the end of a section.

    Where lanes end and none opens, the others are led to where they go on; where some open as well, to the middle.
    """
    if ending and following is not None and ahead is not None and len(ahead) == len(_widths(following)):
        return following.centre
    return _offset_without(section, ending)


def _offset_without(section: CrossSection, ending: set[int]) -> float:
    """Return the centre's t once the lanes that end are gone and the rest lies about the same middle."""
    if not ending:
        return section.centre
    widths = {lane: 0.0 if lane in ending else width for lane, width in _widths(section).items()}
    left = sum(width for lane, width in widths.items() if lane > 0)
    middle = (section.left_edge + section.right_edge) / 2
    return middle + sum(widths.values()) / 2 - left


def smooth_step(s: float, length: float, start: float, end: float) -> Cubic:
    """Return the cubic from one value to another over a length with no slope at either end."""
    rise = end - start
    return Cubic(s, start, 0.0, 3 * rise / length**2, -2 * rise / length**3)


def tapered(length: float, taper: float, start: float, middle: float, end: float) -> tuple[Cubic, ...]:
    """Return cubics that go from `start` to `middle` in a taper, stay, and go to `end` in another."""
    out: list[Cubic] = []
    stays_from = 0.0
    if abs(middle - start) > 1e-9:
        out.append(smooth_step(0.0, taper, start, middle))
        stays_from = taper
    out.append(Cubic(stays_from, middle))
    if abs(end - middle) > 1e-9:
        out.append(smooth_step(length - taper, taper, middle, end))
    return tuple(out)


@dataclass(frozen=True, slots=True)
class _Course:
    """How the lanes of a stretch come, run and go."""

    # The stretch, its length and that of tapers, m
    stretch: Stretch
    length: float
    taper: float
    begins: dict[int, float]  # Width of each lane at the start, m
    ending: set[int]  # Lanes that end with the stretch
    # The lane that each continues, and the one that continues it; None at the road's ends
    behind: dict[int, int] | None
    ahead: dict[int, int] | None
    marks: dict[int, RoadMark]  # The mark of each lane and of the centre line


def _lanes(course: _Course) -> tuple[Lane, ...]:
    """Return all lanes of a section, leftmost first, with the centre lane among them."""
    section = course.stretch.section
    left = [_lane(course, number, spec) for number, spec in enumerate(section.left, start=1)]
    right = [_lane(course, -number, spec) for number, spec in enumerate(section.right, start=1)]
    return (
        *reversed(left),
        Lane(0, LaneType.NONE, (), road_mark=course.marks[0]),
        *right,
    )


def _lane(course: _Course, lane_id: int, spec: LaneSpec) -> Lane:
    attributes = course.stretch.attributes
    own_speed = attributes.speed_backward if spec.direction is Direction.BACKWARD else attributes.speed_forward
    last_width = 0.0 if lane_id in course.ending else spec.width
    return Lane(
        id=lane_id,
        type=LaneType.BIDIRECTIONAL if spec.direction is Direction.BOTH else spec.type,
        widths=tapered(course.length, course.taper, course.begins[lane_id], spec.width, last_width),
        predecessor=None if course.behind is None else course.behind.get(lane_id),
        successor=None if course.ahead is None else course.ahead.get(lane_id),
        road_mark=course.marks[lane_id],
        speed=own_speed if own_speed != _road_speed(attributes) else None,
    )


def _road_speed(attributes: StreetAttributes) -> float | None:
    if attributes.speed_forward is not None:
        return attributes.speed_forward
    return attributes.speed_backward


def _road_type(attributes: StreetAttributes) -> str:
    """Return OpenDRIVE's road type for a highway value and speed."""
    if attributes.highway in ("motorway", "motorway_link"):
        return "motorway"
    if attributes.highway == "living_street":
        return "lowSpeed"
    speed = _road_speed(attributes)
    fast = speed is not None and speed > _RURAL_SPEED
    if attributes.highway in ("trunk", "trunk_link"):
        return "rural" if fast or speed is None else "townExpressway"
    return "rural" if fast or attributes.highway == "track" else "town"


def _without_equal_types(types: list[RoadType]) -> tuple[RoadType, ...]:
    return tuple(
        item
        for k, item in enumerate(types)
        if k == 0 or (item.type, item.speed) != (types[k - 1].type, types[k - 1].speed)
    )


def without_repeats(cubics: list[Cubic]) -> tuple[Cubic, ...]:
    """Leave out records that say what the one before says: neighbouring constants of the same value."""
    out: list[Cubic] = []
    for item in cubics:
        if out and item.is_flat and out[-1].is_flat and abs(out[-1].a - item.a) < 1e-9:
            continue
        out.append(item)
    return tuple(out)
