"""Lane sections of roads outside junctions: lanes, widths with tapers, links, marks, and the lane offset."""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Final

from osm2xodr.conventions import GENERIC, Country
from osm2xodr.curves import part_of_cubics
from osm2xodr.geometry.lanes.carriageway_lanes import SAME_VALUE, Carriageway, RoadLane, lay_out_carriageway
from osm2xodr.geometry.lanes.cross_sections import CrossSection
from osm2xodr.geometry.lanes.lane_connectivity import Connectivity
from osm2xodr.geometry.lanes.road_marks import mark_kind, road_marks
from osm2xodr.geometry.lanes.road_stretches import Stretch, same_rules
from osm2xodr.geometry.lanes.tapers import TaperZone, taper_zones
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
from osm2xodr.system import record

# Speed above which a road without a better sign is taken for a rural one, m/s (60 km/h: beyond urban limits).
_RURAL_SPEED: Final = 60.0 / 3.6


@record
class LaneLayout:
    """Everything that a road says about its lanes."""

    sections: tuple[LaneSection, ...]  # Lane sections; lanes at the road's ends have no links beyond it yet
    offset: tuple[Cubic, ...]  # Lane offset over the road's s
    types: tuple[RoadType, ...]  # Road type and speed


def lay_out_all(
    roads: Sequence[Sequence[Stretch]],
    rule: Rule,
    known: Connectivity | None = None,
    country: Country = GENERIC,
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
    road: Sequence[Stretch],
    rule: Rule,
    known: Connectivity | None = None,
    country: Country = GENERIC,
) -> LaneLayout:
    """Build the lane sections of a road from its stretches.

    A section begins where a lane opens, from width 0, and where one has ended, and at the border of two stretches
    that differ in more than that and in the widths of their lanes: in limits, types of lanes or marks.
    """
    zones = taper_zones(road, rule, known)
    carriageway = lay_out_carriageway(road, zones)
    marks_of = [road_marks(item.section, item.attributes, rule, country) for item in road] if len(road) > 1 else []
    borders = [0.0, *_section_borders(road, zones, carriageway, marks_of), road[-1].end]
    sides = [carriageway.between(*pair) for pair in pairwise(borders)]
    ids = [_ids(*pair) for pair in sides]
    sections: list[LaneSection] = []
    for k, (start, end) in enumerate(pairwise(borders)):
        holding = max(range(len(road)), key=lambda i: min(end, road[i].end) - max(start, road[i].start))
        run = _Run(
            start,
            end,
            holding,
            road[holding].attributes,
            ids[k],
            ids[k - 1] if k else {},
            ids[k + 1] if k + 1 < len(ids) else {},
        )
        left, right = (tuple(lane.spec(holding) for lane in lanes) for lanes in sides[k])
        marks = road_marks(replace(road[holding].section, left=left, right=right), run.attributes, rule, country)
        sections.append(LaneSection(start, run.lanes(*sides[k], marks)))
    types: list[RoadType] = []
    for item in road:
        kind = _road_type(item.attributes), item.attributes.speed_along(Direction.BOTH)
        if not types or kind != (types[-1].type, types[-1].speed):
            types.append(RoadType(item.start, *kind))
    return LaneLayout(tuple(sections), carriageway.offset, tuple(types))


def _section_borders(
    road: Sequence[Stretch],
    zones: Sequence[TaperZone],
    carriageway: Carriageway,
    marks_of: Sequence[Mapping[int, RoadMark]],
) -> list[float]:
    """Return where lane sections begin within a road, s, m; `marks_of` has the marks of each stretch."""
    lanes = (*carriageway.left, *carriageway.right)
    out = [s for lane in lanes for s in (lane.begin, lane.end)]
    for k, zone in enumerate(zones, start=1):
        continuing = [(lane.specs[k - 1], lane.specs[k]) for lane in lanes if k in lane.specs and k - 1 in lane.specs]
        kept = all(_same_use(*specs) for specs in continuing)
        shared = any(zone.start <= s <= zone.end for s in out)
        alike = kept and same_rules(road[k - 1].attributes, road[k].attributes)
        if not (alike and (shared or marks_of[k - 1] == marks_of[k])):
            out.append(road[k].start)
    # Places that are the same but for rounding are one border.
    inside = [s for s in sorted(out) if SAME_VALUE < s < road[-1].end - SAME_VALUE]
    return [s for k, s in enumerate(inside) if not k or s - inside[k - 1] > SAME_VALUE]


def _same_use(one: LaneSpec, other: LaneSpec) -> bool:
    """Return whether the same traffic may use a lane in two stretches."""
    return (one.type, one.direction, one.access, one.speed) == (
        other.type,
        other.direction,
        other.access,
        other.speed,
    )


def _ids(left: Sequence[RoadLane], right: Sequence[RoadLane]) -> dict[int, int]:
    """Return ids of lanes by their identity."""
    ids = {id(lane): number for number, lane in enumerate(left, start=1)}
    return ids | {id(lane): -number for number, lane in enumerate(right, start=1)}


@record
class _Run:
    """A lane section to be."""

    # From where to where it reaches on the road, s, m
    start: float
    end: float
    stretch: int  # Index of the stretch that most of it lies in
    attributes: StreetAttributes  # Of that stretch
    # Ids of the lanes of this section, the one before and the one after
    ids: dict[int, int]
    behind: dict[int, int]
    ahead: dict[int, int]

    def lanes(
        self, left: Sequence[RoadLane], right: Sequence[RoadLane], marks: dict[int, RoadMark]
    ) -> tuple[Lane, ...]:
        """Return all lanes, leftmost first, with the centre lane among them."""
        centre = Lane(0, LaneType.NONE, (), road_mark=marks[0])
        return (
            *(self._lane(lane, marks) for lane in reversed(left)),
            centre,
            *(self._lane(lane, marks) for lane in right),
        )

    def _limit(self, spec: LaneSpec) -> float | None:
        if spec.type not in VEHICLE_LANES:
            return None
        return self.attributes.speed_along(spec.direction) if spec.speed is None else spec.speed

    def _lane(self, lane: RoadLane, marks: dict[int, RoadMark]) -> Lane:
        spec, number = lane.spec(self.stretch), self.ids[id(lane)]
        return Lane(
            id=number,
            type=LaneType.BIDIRECTIONAL if spec.direction is Direction.BOTH else spec.type,
            widths=part_of_cubics(lane.widths, self.start, self.end),
            predecessor=self.behind.get(id(lane)),
            successor=self.ahead.get(id(lane)),
            road_mark=marks[number],
            speed=self._limit(spec),
            access=spec.access,
        )


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
