"""Lane sections of roads outside junctions: lanes, widths with tapers, links, marks, and the lane offset."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

from osm2xodr.conventions import GENERIC, Country
from osm2xodr.geometry import defaults
from osm2xodr.geometry.lanes.cross_sections import CrossSection
from osm2xodr.geometry.lanes.lane_connectivity import Connectivity
from osm2xodr.geometry.lanes.lane_matching import match_lanes
from osm2xodr.geometry.lanes.road_marks import mark_kind, road_marks
from osm2xodr.geometry.lanes.road_stretches import Stretch
from osm2xodr.model import (
    VEHICLE_LANES,
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
# Values that differ by less are the same: widths and offsets, m.
_SAME_VALUE: Final = 1e-9


@dataclass(frozen=True, slots=True)
class LaneLayout:
    """Everything that a road says about its lanes."""

    sections: tuple[LaneSection, ...]  # Lane sections; lanes at the road's ends have no links beyond it yet
    offset: tuple[Cubic, ...]  # Lane offset over the road's s
    types: tuple[RoadType, ...]  # Road type and speed


def lay_out_all(
    roads: Sequence[Sequence[Stretch]], rule: Rule, known: Connectivity | None = None, country: Country = GENERIC
) -> list[LaneLayout]:
    """Build the lane sections of many roads; roads of a single stretch that are alike share one layout."""
    alike: dict[tuple[CrossSection, Hashable, float | None, float | None], LaneLayout] = {}
    out: list[LaneLayout] = []
    for road in roads:
        if len(road) > 1:
            out.append(lay_out_lanes(road, rule, known, country))
            continue
        attributes = road[0].attributes
        kind = (
            road[0].section,
            mark_kind(attributes),
            attributes.speed_along(Direction.FORWARD),
            attributes.speed_along(Direction.BACKWARD),
        )
        layout = alike.get(kind)
        if layout is None:
            layout = alike[kind] = lay_out_lanes(road, rule, known, country)
        out.append(layout)
    return out


def lay_out_lanes(
    road: Sequence[Stretch], rule: Rule, known: Connectivity | None = None, country: Country = GENERIC
) -> LaneLayout:
    """Build the lane sections of a road from its stretches.

    A lane that opens does so from width 0 after the border of two sections, one that ends does so before it. Lane
    offset and widths follow the same cubic, and so does every edge between lanes.
    """
    links = [
        match_lanes(a.section, b.section, rule, known.at_border(a.ways[-1], b.ways[0]) if known else None)
        for a, b in pairwise(road)
    ]
    sections: list[LaneSection] = []
    offset: list[Cubic] = []
    start_widths, start_offset = _widths(road[0].section), road[0].section.centre
    for k, stretch in enumerate(road):
        ahead = links[k] if k < len(links) else None
        behind = {to: lane for lane, to in links[k - 1].items()} if k else None
        run = _Run(stretch, _taper_length(stretch), start_widths, behind, ahead)
        sections.append(
            LaneSection(stretch.start, run.lanes(road_marks(stretch.section, stretch.attributes, rule, country)))
        )
        end_offset = run.end_offset(None if ahead is None else road[k + 1].section)
        offset += [
            Cubic(stretch.start + c.s, c.a, c.b, c.c, c.d)
            for c in tapered(stretch.length, run.taper, start_offset, stretch.section.centre, end_offset)
        ]
        widths = _widths(stretch.section)
        start_widths = {} if ahead is None else {to: widths[lane] for lane, to in ahead.items()}
        start_offset = end_offset
    types: list[RoadType] = []
    for item in road:
        kind = _road_type(item.attributes), item.attributes.speed_along(Direction.BOTH)
        if not types or kind != (types[-1].type, types[-1].speed):
            types.append(RoadType(item.start, *kind))
    return LaneLayout(tuple(sections), without_repeats(offset), tuple(types))


def _widths(section: CrossSection) -> dict[int, float]:
    """Return width by lane id, leftmost first, m."""
    left = {number: lane.width for number, lane in enumerate(section.left, start=1)}
    right = {-number: lane.width for number, lane in enumerate(section.right, start=1)}
    return {**dict(reversed(left.items())), **right}


def _taper_length(stretch: Stretch) -> float:
    """Return the length over which lanes open and end, m."""
    fast = stretch.attributes.highway in defaults.FAST_HIGHWAYS
    longest = defaults.TAPER_LENGTH_MOTORWAY if fast else defaults.TAPER_LENGTH
    return min(longest, defaults.TAPER_SHARE * stretch.length)


@dataclass(frozen=True, slots=True)
class _Run:
    """A stretch, and how its lanes begin and end."""

    stretch: Stretch
    taper: float  # Length of its tapers, m
    start_widths: dict[int, float]  # Width at the start of the lanes that continue others, m
    # The lane that each continues, and the one that continues it; None at the road's ends
    behind: dict[int, int] | None
    ahead: dict[int, int] | None

    def ends(self, lane: int) -> bool:
        """Say whether a lane ends with the stretch."""
        return self.ahead is not None and lane not in self.ahead

    def end_offset(self, following: CrossSection | None) -> float:
        """Return the lane offset at the end of the stretch, m.

        Where lanes end and none opens, the others are led to where they continue; else they come together about the
        middle.
        """
        section, widths = self.stretch.section, _widths(self.stretch.section)
        if not any(self.ends(lane) for lane in widths):
            return section.centre
        if following is not None and self.ahead is not None and len(self.ahead) == len(_widths(following)):
            return following.centre
        remaining = {lane: 0.0 if self.ends(lane) else width for lane, width in widths.items()}
        middle = (section.left_edge + section.right_edge) / 2
        return middle + sum(remaining.values()) / 2 - sum(width for lane, width in remaining.items() if lane > 0)

    def lanes(self, marks: dict[int, RoadMark]) -> tuple[Lane, ...]:
        """Return all lanes, leftmost first, with the centre lane among them."""
        section = self.stretch.section
        left = [self._lane(number, spec, marks[number]) for number, spec in enumerate(section.left, start=1)]
        right = [self._lane(-number, spec, marks[-number]) for number, spec in enumerate(section.right, start=1)]
        return (*reversed(left), Lane(0, LaneType.NONE, (), road_mark=marks[0]), *right)

    def _lane(self, lane_id: int, spec: LaneSpec, mark: RoadMark) -> Lane:
        attributes = self.stretch.attributes
        start, end = self.start_widths.get(lane_id, 0.0), 0.0 if self.ends(lane_id) else spec.width
        return Lane(
            id=lane_id,
            type=LaneType.BIDIRECTIONAL if spec.direction is Direction.BOTH else spec.type,
            widths=tapered(self.stretch.length, self.taper, start, spec.width, end),
            predecessor=None if self.behind is None else self.behind.get(lane_id),
            successor=None if self.ahead is None else self.ahead.get(lane_id),
            road_mark=mark,
            speed=attributes.speed_along(spec.direction) if spec.type in VEHICLE_LANES else None,
            access=spec.access,
        )


def smooth_step(s: float, length: float, start: float, end: float) -> Cubic:
    """Return the cubic from one value to another over a length with no slope at either end."""
    rise = end - start
    return Cubic(s, start, 0.0, 3 * rise / length**2, -2 * rise / length**3)


def tapered(length: float, taper: float, start: float, middle: float, end: float) -> tuple[Cubic, ...]:
    """Return cubics that go from `start` to `middle` in a taper, stay, and go to `end` in another."""
    out: list[Cubic] = []
    stays_from = 0.0
    if abs(middle - start) > _SAME_VALUE:
        out.append(smooth_step(0.0, taper, start, middle))
        stays_from = taper
    out.append(Cubic(stays_from, middle))
    if abs(end - middle) > _SAME_VALUE:
        out.append(smooth_step(length - taper, taper, middle, end))
    return tuple(out)


def without_repeats(cubics: Sequence[Cubic]) -> tuple[Cubic, ...]:
    """Leave out records that say what the one before says: neighbouring constants of the same value."""
    out: list[Cubic] = []
    for item in cubics:
        if not (out and item.is_flat and out[-1].is_flat and abs(out[-1].a - item.a) < _SAME_VALUE):
            out.append(item)
    return tuple(out)


def _road_type(attributes: StreetAttributes) -> str:
    """Return OpenDRIVE's road type for a highway value and speed."""
    if attributes.highway in ("motorway", "motorway_link"):
        return "motorway"
    if attributes.highway == "living_street":
        return "lowSpeed"
    speed = attributes.speed_along(Direction.BOTH)
    fast = speed is not None and speed > _RURAL_SPEED
    if attributes.highway in ("trunk", "trunk_link"):
        return "rural" if fast or speed is None else "townExpressway"
    return "rural" if fast or attributes.highway == "track" else "town"
