"""Roads, their lanes, and junctions as XML; the numbers of tables and furniture come from elsewhere.

A line holds an element with all that belongs to it, such as a record of a table or a lane. Lines are not indented: in
files of millions of lanes blanks would be a tenth of all bytes.
"""

from __future__ import annotations

import math
from operator import attrgetter
from typing import Final, TypeAlias

from osm2xodr.defaults import UNMEASURED_HEIGHTS
from osm2xodr.model import (
    VEHICLE_LANES,
    Access,
    BoundaryEdge,
    Cubic,
    Junction,
    Lane,
    LaneSection,
    LaneType,
    Road,
    RoadLink,
    RoadMark,
    RoadType,
)
from osm2xodr.system import record
from osm2xodr.xodrWriter import formatting
from osm2xodr.xodrWriter.formatting import NUMBER, Words, name_attribute, number, numbers, position, user_data
from osm2xodr.xodrWriter.furniture_text import FurnitureWriter, provenance_text

# Lanes whose marks readers look at: those that cars, bicycles or parked cars are on.
_MARKED: Final = VEHICLE_LANES | {LaneType.BIKING, LaneType.PARKING}

# Ends of roads in the boundaries of junctions.
_ENDS: Final = {0.0: "start", math.inf: "end"}

_ID: Final = attrgetter("id")
_DECIMALS: Final = formatting.POSITION_DECIMALS
_WIDTH: Final = f'<width sOffset="{NUMBER}" a="{NUMBER}" b="{NUMBER}" c="{NUMBER}" d="{NUMBER}"/>'

_Head: TypeAlias = tuple[int, LaneType, int | None, int | None]


class LaneWriter:
    """Make the text of lane sections; remember the parts of lanes, since even whole cities have only a few kinds.

    `marks_in_junctions` also writes marks that are none of connecting roads, see `osm2xodr.conventions.Target`.
    """

    def __init__(self, words: Words, *, marks_in_junctions: bool = False) -> None:
        self._words = words
        self._marks_in_junctions = marks_in_junctions
        self._sections: dict[tuple[int, bool, float | None], str] = {}
        self._heads: dict[_Head, tuple[str, str, tuple[str, ...]]] = {}
        self._widths: dict[tuple[Cubic, ...], str] = {}
        # By side of the centre line, on which the words for a mark may depend.
        self._marks: tuple[dict[RoadMark, str], ...] = ({}, {}, {})

    def sections(
        self,
        sections: tuple[LaneSection, ...],
        length: float,
        *,
        in_junction: bool = False,
        limit: float | None = None,
    ) -> str:
        """Return the ``<laneSection>`` elements of a road of a length, m.

        Lanes whose speed, m/s, is the `limit` of the whole road need not repeat it.
        """
        bare = in_junction and not self._marks_in_junctions
        if len(sections) == 1 and sections[0].s == 0.0:
            # Roads share sections that are alike, so identity is enough (the map keeps them alive).
            key = id(sections[0]), bare, limit
            known = self._sections.get(key)
            if known is None:
                known = self._sections[key] = self._section(sections[0], "0", bare, limit)
            return known
        starts = [position(section.s) for section in sections]
        starts[-1] = formatting.start_of_last(sections[-1].s, length)
        return "".join([self._section(*pair, bare, limit) for pair in zip(sections, starts, strict=True)])

    def _section(self, section: LaneSection, start: str, bare: bool, limit: float | None) -> str:
        """Return one section: left lanes, centre, right lanes, each from left to right."""
        texts: dict[int, list[str]] = {1: [], 0: [], -1: []}
        sign = self._words.lane_id(1)
        lanes = sorted(section.lanes, key=_ID, reverse=sign > 0)
        unmarked = _unmarked(lanes, bare)
        for lane in lanes:
            # 1 left of the centre line, -1 right of it, 0 for the centre lane.
            side = sign * ((lane.id > 0) - (lane.id < 0))
            texts[side].append(self._lane(lane, side, lane.id in unmarked, limit))
        sides = zip(("left", "center", "right"), map("\n".join, texts.values()), strict=True)
        inner = "\n".join([f"<{tag}>{text}</{tag}>" for tag, text in sides if text or tag == "center"])
        return f'<laneSection s="{start}">{inner}</laneSection>\n'

    def _lane(self, lane: Lane, side: int, unmarked: bool, limit: float | None) -> str:
        """Return one lane, its parts in the order of the schema."""
        key = (lane.id, lane.type, lane.predecessor, lane.successor)
        head, text, users = self._heads.get(key) or self._head(key)
        if lane.widths:
            text += self._widths.get(lane.widths) or self._width(lane.widths)
        if lane.road_mark is not None and not unmarked:
            text += self._marks[side].get(lane.road_mark) or self._mark(lane.road_mark, side)
        if lane.speed is not None and lane.speed != limit:
            text += f'<speed sOffset="0" {formatting.lane_speed_attributes(lane.speed)}/>'
        access = self._words.access(lane.access.value) if lane.access is not Access.ALL else ()
        for user in access or users:
            text += f'<access sOffset="0" rule="allow" restriction="{user}"/>'
        if lane.height:
            text += _heights(lane)
        return f"{head}>{text}</lane>" if text else f"{head}/>"

    def _head(self, key: _Head) -> tuple[str, str, tuple[str, ...]]:
        """Return and remember the start of a lane, its links, and who alone may drive on its type."""
        number_, kind, predecessor, successor = key
        runs = self._words.lane_direction(kind.value)
        direction = f' direction="{runs}"' if runs else ""
        words = self._words
        head, links = f'<lane id="{words.lane_id(number_)}" type="{words.lane_type(kind.value)}"{direction}', ""
        if predecessor is not None or successor is not None:
            before = "" if predecessor is None else f'<predecessor id="{words.lane_id(predecessor)}"/>'
            after = "" if successor is None else f'<successor id="{words.lane_id(successor)}"/>'
            links = f"<link>{before}{after}</link>"
        self._heads[key] = found = head, links, words.lane_users(kind.value)
        return found

    def _width(self, widths: tuple[Cubic, ...]) -> str:
        """Return and remember the ``<width>`` elements of a lane."""
        values = [v for w in widths for v in (round(w.s, _DECIMALS), round(w.a, _DECIMALS), w.b, w.c, w.d)]
        text = numbers(_WIDTH * len(widths), values)
        self._widths[widths] = text
        return text

    def _mark(self, mark: RoadMark, side: int) -> str:
        """Return and remember the ``<roadMark>`` of a lane left (1) or right (-1) of the centre, or of that (0)."""
        kind, color = self._words.mark_type(mark.type), self._words.mark_color(mark.color)
        change = self._words.lane_change(mark.lane_change, side)
        text = (
            f'<roadMark sOffset="0" type="{kind}" weight="standard" color="{color}"'
            f' width="{number(mark.width)}" laneChange="{change}"/>'
        )
        self._marks[side][mark] = text
        return text


def _unmarked(lanes: list[Lane], bare: bool) -> frozenset[int]:
    """Return the ids of lanes whose mark is none and is not written; `bare` in junctions, of lanes for cars as well.

    `lanes` are in order. CARLA asks outside junctions for the marks at both edges of a lane that cars, bicycles or
    parked cars are on, and wherever a lane has a mark for that of the next inner lane; without them it ends. See
    `docs/readers.md`.
    """
    out: list[int] = []
    for order in (lanes, lanes[::-1]):
        for lane in order:
            if lane.id == 0 or not _is_none(lane) or not (bare or lane.type not in _MARKED):
                break
            out.append(lane.id)
    whole = bare and len(out) == len(lanes) - 1
    return frozenset(out + [item.id for item in lanes if item.id == 0 and whole and _is_none(item)])


def _is_none(lane: Lane) -> bool:
    return lane.road_mark is not None and lane.road_mark.type == "none"


def _heights(lane: Lane) -> str:
    """Return the ``<height>`` elements of a raised lane: 0 where it has no width.

    libOpenDRIVE finds lanes by their outer borders, and would raise the lane beside it there.
    """
    out, last = "", ""
    for width in lane.widths:
        up = position(lane.height) if width.a or not width.is_flat else "0"
        if up != last:
            out += f'<height sOffset="{position(width.s)}" inner="{up}" outer="{up}"/>'
            last = up
    return out


@record
class RoadTables:
    """The records of one road in the tables of a road map, as text."""

    length: float  # m
    geometry: str
    # Those that may be empty: a height or roll of 0 throughout, no lane offset
    elevation: str
    superelevation: str
    lane_offset: str
    unmeasured: str = ""  # Stretches without a measured height; empty without any


class RoadWriter:
    """Make the text of roads; `left_hand` if they are to say that traffic drives on the left."""

    def __init__(
        self, words: Words, furniture: FurnitureWriter, *, left_hand: bool, marks_in_junctions: bool = False
    ) -> None:
        self._furniture = furniture
        # Without a rule traffic drives on the right (ASAM OpenDRIVE 1.7, 10.1).
        self._side = ' rule="LHT"' if left_hand else ""
        self._words = words
        self._lanes = LaneWriter(words, marks_in_junctions=marks_in_junctions)
        self._types: dict[RoadType, str] = {}

    def road(self, road: Road, tables: RoadTables) -> str:
        """Return a ``<road>``, its parts in the order of the schema."""
        junction, inside = (-1, False) if road.junction is None else (road.junction, True)
        # Elsewhere SUMO reads the limits of lanes alone.
        limit = road.types[0].speed if inside and len(road.types) == 1 else None
        sections = self._lanes.sections(road.lane_sections, tables.length, in_junction=inside, limit=limit)
        return (
            f'<road{name_attribute(road.name)} length="{position(tables.length)}" id="{road.id}"'
            f' junction="{junction}"{self._side}>\n'
            f"{_links(road)}"
            f"{''.join([self._types.get(item) or self._type(item) for item in road.types])}"
            f"<planView>{tables.geometry}</planView>\n"
            f"{_profile('elevationProfile', tables.elevation)}"
            f"{_profile('lateralProfile', tables.superelevation)}"
            f"<lanes>{tables.lane_offset}{sections}</lanes>\n"
            f"{self._furniture.road(road.id, tables.length)}"
            f"{provenance_text(road.osm_way_ids, road.guesses)}"
            f"{user_data(UNMEASURED_HEIGHTS, tables.unmeasured)}"
            "</road>\n"
        )

    def _type(self, item: RoadType) -> str:
        """Return and remember a ``<type>`` with its speed limit."""
        text = f'<type s="{position(item.s)}" type="{self._words.road_type(item.type)}"'
        speed = item.speed
        text += "/>\n" if speed is None else f"><speed {formatting.road_speed_attributes(speed)}/></type>\n"
        self._types[item] = text
        return text


def _profile(element: str, records: str) -> str:
    """Return a profile of records; empty without any, where readers take it for 0."""
    return f"<{element}>{records}</{element}>\n" if records else ""


def _links(road: Road) -> str:
    """Return the ``<link>`` of a road, which must exist even if empty: some readers use it unchecked."""
    inner = _link("predecessor", road.predecessor) + _link("successor", road.successor)
    return f"<link>{inner}</link>\n" if inner else "<link/>\n"


def _link(element: str, link: RoadLink | None) -> str:
    """Return the link of one end of a road."""
    if link is None:
        return ""
    if link.to_junction:
        return f'<{element} elementType="junction" elementId="{link.id}"/>'
    contact = "start" if link.at_start else "end"
    return f'<{element} elementType="road" elementId="{link.id}" contactPoint="{contact}"/>'


def junction_text(junction: Junction, words: Words, controllers: str = "") -> str:
    """Return a ``<junction>``: connections, priorities, the text of its controllers, and its boundary."""
    number_ = words.lane_id
    connections = [
        f'<connection id="{item.id}" incomingRoad="{item.incoming_road}"'
        f' connectingRoad="{item.connecting_road}" contactPoint="start">'
        + "".join([f'<laneLink from="{number_(a)}" to="{number_(b)}"/>' for a, b in item.lane_links])
        + "</connection>\n"
        for item in junction.connections
    ]
    priorities = [f'<priority high="{high}" low="{low}"/>\n' for high, low in junction.priorities]
    return (
        f'<junction{name_attribute(junction.name)} id="{junction.id}">\n'
        f"{''.join(connections)}{''.join(priorities)}{controllers}"
        f"{_boundary(junction, words) if words.has_boundary else ''}</junction>\n"
    )


def _boundary(junction: Junction, words: Words) -> str:
    """Return the ``<boundary>`` of a junction, if it has one.

    Ends of lanes are ``start`` and ``end``: the schema knows no ``begin``, nor a number 0.
    """
    number_ = words.lane_id
    rows = []
    for item in junction.boundary:
        if isinstance(item, BoundaryEdge):
            at = [_ENDS.get(s) or position(s) for s in (item.begin, item.end)]
            rest = f'lane" roadId="{item.road}" boundaryLane="{number_(item.lane)}" sStart="{at[0]}" sEnd="{at[1]}"'
        else:
            rest = f'joint" roadId="{item.road}" contactPoint="{"start" if item.at_start else "end"}"'
            if item.first_lane is not None and item.last_lane is not None:
                rest += f' jointLaneStart="{number_(item.first_lane)}" jointLaneEnd="{number_(item.last_lane)}"'
        rows.append(f'<segment type="{rest}/>\n')
    return f"<boundary>\n{''.join(rows)}</boundary>\n" if rows else ""
