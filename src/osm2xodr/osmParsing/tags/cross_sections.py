"""From a way's tags to its cross section: lanes from left to right, and what lies beside them.

``placement`` says where among its lanes the line of the way runs.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import accumulate
from math import inf
from typing import Final

from osm2xodr.conventions import GENERIC, Country
from osm2xodr.diagnostics import Kind, counted
from osm2xodr.model import EVERY_LANE, Access, Direction, LaneSpec, LaneType, MarginSpec, Rule
from osm2xodr.osmParsing.defaults import (
    CARRIAGEWAY_WIDTHS,
    LANE_ALONE_WIDEST,
    LANE_WIDEST,
    LANE_WIDTH_BICYCLE,
    LANE_WIDTH_BUS,
    LANE_WIDTH_MAX,
    LANE_WIDTH_MIN,
    LANE_WIDTH_SIDE_BY_SIDE_MAX,
    LANES_BESIDE_PARKING,
    LANES_SIDE_BY_SIDE,
    MARGIN_WIDTH_MIN,
    PARKED_ALONG,
    PARKING_WIDTH,
    SHOULDER_WIDTH,
)
from osm2xodr.osmParsing.tags.access import KEPT_FOR_HOV
from osm2xodr.osmParsing.tags.beside_lanes import BESIDE_TAGS, contraflow_bus_lane, with_beside_lanes
from osm2xodr.osmParsing.tags.lane_counts import COUNT_TAGS, USER_TAGS, LaneGroups, lane_groups, with_lanes_of_sums
from osm2xodr.osmParsing.tags.lane_lists import CHANGE_TAGS, LIST_TAGS, MOTOR_LANES, TURN_TAGS, Slot
from osm2xodr.osmParsing.tags.margins import (
    MARGIN_TAGS,
    NOTHING,
    PARKING_TAGS,
    Margins,
    read_margins,
    with_free_room,
    with_parking,
    with_rest,
)
from osm2xodr.osmParsing.tags.values import Findings, Tags, first_width
from osm2xodr.system import record

WIDTH_TAGS: Final = ("width:carriageway", "width", "est_width")

PLACEMENT_TAGS: Final = ("placement", "placement:forward", "placement:backward")

# All tags, besides ``highway``, that lanes are read from, and that cross sections are read from.
LANE_TAGS: Final = (
    *(*COUNT_TAGS, *USER_TAGS, *BESIDE_TAGS, "hov"),
    *(*WIDTH_TAGS, *PLACEMENT_TAGS, *TURN_TAGS, *CHANGE_TAGS, *LIST_TAGS),
)
SECTION_TAGS: Final = (*LANE_TAGS, *MARGIN_TAGS)

_PARKING: Final = frozenset(PARKING_TAGS)
# A tagged width agrees with the distance of kerbs if they differ by no more than this, m: tags are whole metres.
_WIDTHS_AGREE: Final = 0.5
# Least distance of the middle of lanes from OSM's line that kerbs tell, m. A choice: lines are drawn no better, and
# lanes shift where it changes.
_LATERAL_LEAST: Final = 0.2
# How far the line of a way may lie aside, and a kerb from where tags have the edge, m. Of 1,164 kerbs in Berlin those
# up to 1 m farther out tell one edge; beyond that the width is wrong, and edges as far on both sides are off by 0.49
# to 0.65 m instead of 0.60 to 1.33; beyond 3 m (13 kerbs) tracks or bays may lie between.
_LINE_ASTRAY: Final = 1.0
_KERB_ASTRAY: Final = 3.0
# Width that lanes beside parked cars have at least, m: RASt 06, two cars pass each other slowly on 4.10 m.
_ROOM_TO_PASS: Final = 4.1

_PLACEMENT: Final = re.compile(r"(left_of|middle_of|right_of):(-?\d+)")
# The placements of both directions agree if they differ by no more than this, m.
_PLACEMENTS_AGREE: Final = 0.1


@record
class Kerbs:
    """Where the kerbs of a carriageway lie, seen along the way: t from the OSM line, left positive, m.

    Cars that park on the carriageway stand between them. None where there is no kerb along that side.
    """

    left: float | None
    right: float | None

    @property
    def apart(self) -> float | None:
        """The distance between both, m; None if only one is known."""
        return None if self.left is None or self.right is None else round(self.left - self.right, 3)

    @property
    def middle(self) -> float:
        """The t of the middle between both, m; 0 if only one is known."""
        return 0.0 if self.left is None or self.right is None else round((self.left + self.right) / 2.0, 3)


@record
class StreetFacts:
    """What is known of the carriageway of a way by the kerbs along it and by the same street before and behind it."""

    kerbs: Kerbs | None = None  # Those that are mapped along the way
    width: float | None = None  # Of the carriageway on the same street, where it is not known here, m
    # Room left and right that parked cars use before and behind the way, and nobody does beside it, m
    no_parking: tuple[float, float] = (0.0, 0.0)
    # Why cars are taken to park on both sides, though no tag says so, and how wide the carriageway may be then, m
    parked: str = ""
    room: float = inf


NO_FACTS: Final = StreetFacts()


@record
class CrossSection:
    """Lanes across a way and the strips beside them, seen along its order of nodes."""

    lanes_ltr: tuple[LaneSpec, ...]  # From left to right
    middle_offset: float  # t of the middle of the lanes off the OSM line, left positive, m
    findings: tuple[tuple[Kind, str, str], ...]  # What was guessed, repaired or ignored
    # Strips beside the lanes, from their edge outwards
    margin_left: tuple[MarginSpec, ...] = ()
    margin_right: tuple[MarginSpec, ...] = ()


def cross_section(
    tags: Tags,
    direction: int,
    rule: Rule,
    default_lane_width: float | None = None,
    closed: int = 0,
    country: Country = GENERIC,
    *,
    in_town: bool = False,
    known_widths: Mapping[int, float] | None = None,
    facts: StreetFacts = NO_FACTS,
) -> CrossSection:
    """Make the cross section of a way from its tags (``highway`` and `SECTION_TAGS`).

    `direction` is 1 or -1 if the way is one-way along or against its order of nodes, else 0; `closed` likewise if
    that direction of a two-way road is closed to cars. `default_lane_width` (m) is that of lanes for cars without a
    tagged width; None takes the country's width for the class of the road, which differs `in_town`, a built-up area.
    `known_widths` are corrections of the widths of lanes, as in `WayCorrection.lane_width`.
    """
    findings: Findings = []
    tags = with_lanes_of_sums(tags, direction, findings)
    way = _Way(tags, direction, rule, default_lane_width, closed, country, in_town, known_widths or {})
    by_tags, parking = _section(way, replace(facts, kerbs=None))
    if facts.kerbs is None:
        return replace(by_tags, findings=(*by_tags.findings, *findings)) if findings else by_tags
    kerbs = _between(facts.kerbs, by_tags, parking, tags, findings)
    section = _section(way, replace(facts, kerbs=kerbs))[0] if kerbs else by_tags
    return replace(section, findings=(*section.findings, *findings))


@record
class _Way:
    """The arguments of `cross_section` that belong to the way alone."""

    tags: Tags
    direction: int
    rule: Rule
    default_lane_width: float | None
    closed: int
    country: Country
    in_town: bool
    known_widths: Mapping[int, float]


def _section(way: _Way, facts: StreetFacts) -> tuple[CrossSection, tuple[float, float]]:
    """Return the cross section, and the width of parking left and right that is part of the carriageway, m."""
    findings: Findings = []
    tags, direction, rule = way.tags, way.direction, way.rule
    runs_one_way = direction or -way.closed
    contraflow_bus = bool(runs_one_way) and contraflow_bus_lane(tags, runs_one_way)
    groups = lane_groups(tags, direction, findings, way.closed, contraflow_bus)
    groups = with_beside_lanes(groups, tags, runs_one_way, rule, findings)
    # Seen along the way, backward lanes are in the reverse of their drivers' order.
    forward = [(slot, Direction.FORWARD) for slot in groups.forward]
    backward = [(slot, Direction.BACKWARD) for slot in reversed(groups.backward)]
    between = [(slot, Direction.BOTH) for slot in groups.both_ways]
    lanes = backward + between + forward if rule is Rule.RIGHT_HAND else forward + between + backward
    margins = with_free_room(read_margins(tags, runs_one_way, rule, findings), facts.no_parking, findings)
    slots = _with_known_widths([slot for slot, _ in lanes], way.known_widths)
    carriageway, parking_left, parking_right = _carriageway(tags, margins, slots, facts, findings)
    usual = way.default_lane_width or _usual_width(groups, tags["highway"], way.country, way.in_town)
    if groups.shared:
        usual = max(usual / 2.0, LANE_WIDTH_MIN)
    chosen = way.default_lane_width is not None
    widest = max(usual, LANE_ALONE_WIDEST if len(slots) == 1 else LANE_WIDEST)
    if carriageway is not None:
        parks = way.in_town and tags["highway"] in PARKED_ALONG and _PARKING.isdisjoint(tags)
        rest = _beside_lanes(slots, widest, carriageway - parking_left - parking_right, parks)
        margins = with_rest(margins, rest, parks, findings)
        parking_left, parking_right = parking_left + rest, parking_right + rest
    widths = _widths(slots, usual, widest, chosen, carriageway, parking_left + parking_right, findings)
    if carriageway is None and facts.parked and sum(widths) + 2.0 * PARKING_WIDTH["parallel"] <= facts.room:
        margins = with_parking(margins, PARKING_WIDTH["parallel"], facts.parked, findings)
    whole = Access.HOV if tags.get("hov") in KEPT_FOR_HOV else Access.ALL
    lanes_ltr = tuple(
        LaneSpec(slot.type, runs, width, slot.turns, slot.change, _access(slot, whole), slot.speed)
        for (slot, runs), width in zip(lanes, widths, strict=True)
    )
    offset = placed_middle(lanes_ltr, [slot.beside for slot in slots], tags, direction, findings)
    if offset is None:
        beside = (parking_right - parking_left) / 2.0
        offset = LANES_BESIDE_PARKING * beside
        # Lanes that leave room beside them may lie anywhere between the kerbs.
        kerbs = facts.kerbs
        if kerbs and kerbs.apart and abs(sum(widths) + parking_left + parking_right - kerbs.apart) <= _WIDTHS_AGREE:
            offset = kerbs.middle + beside if abs(kerbs.middle + beside) >= _LATERAL_LEAST else 0.0
    section = CrossSection(lanes_ltr, offset, tuple(findings), margins.left, margins.right)
    return section, (parking_left, parking_right)


def _between(
    kerbs: Kerbs, by_tags: CrossSection, parking: tuple[float, float], tags: Tags, findings: Findings
) -> Kerbs | None:
    """Return both kerbs of a carriageway, None if those that are mapped are not those of these lanes."""
    half = sum(lane.width for lane in by_tags.lanes_ltr) / 2.0
    left, right = by_tags.middle_offset + half + parking[0], by_tags.middle_offset - half - parking[1]
    tagged = first_width(tags, WIDTH_TAGS, CARRIAGEWAY_WIDTHS, "width", "a road", [])
    found: Kerbs | None = kerbs
    words, misfit = f"{kerbs.apart} m between the kerbs that are mapped along it", f"kerbs {kerbs.apart} m apart"
    if tagged and kerbs.apart and abs(tagged - kerbs.apart) > _WIDTHS_AGREE and WIDTH_TAGS[0] not in tags:
        words = f"{kerbs.apart} m between its kerbs, taken in place of the {tagged:g} m that are tagged"
    for side, edge, own, other in (("left", kerbs.left, left, right), ("right", kerbs.right, right, left)):
        if edge is not None and kerbs.apart is None:
            found = _beside_one_kerb(edge, own, other, tagged is not None)
            words, misfit = f"the kerb mapped along its {side} tells where its edge is", f"a kerb on the {side}"
    lanes = len(by_tags.lanes_ltr)
    if found is None or not _fits(found.apart or 0.0, lanes, sum(parking)):
        findings.append((Kind.DROPPED, "kerbs", f"{misfit}, mapped along it, would not fit {counted(lanes, 'lane')}"))
        return None
    findings.append((Kind.NOTE, "kerbs", words))
    return found


def _beside_one_kerb(edge: float, own: float, other: float, tagged: bool) -> Kerbs | None:
    """Return the kerbs of a carriageway by one `edge`, and where tags have this edge and the other one, t, m.

    `tagged` says whether a tag gives the width. None if the kerb is that of something else.
    """
    farther = abs(edge) - abs(own) if edge * own > 0.0 else -inf
    if abs(farther) > (_LINE_ASTRAY if tagged else _KERB_ASTRAY):
        return None
    if tagged:
        other += edge - own
    elif farther > _LINE_ASTRAY:
        # No line is that far aside: the carriageway is wider on both sides.
        other = -edge
    return Kerbs(max(edge, other), min(edge, other))


def _fits(width: float, lanes: int, parking: float) -> bool:
    """Whether a carriageway may be that of so many lanes and that much parking, else of cars along both sides, m."""
    widest = LANE_WIDTH_MAX if lanes < LANES_SIDE_BY_SIDE else LANE_WIDTH_SIDE_BY_SIDE_MAX
    return LANE_WIDTH_MIN <= width <= lanes * widest + max(parking, 2.0 * PARKING_WIDTH["parallel"])


def _with_known_widths(slots: list[Slot], known: Mapping[int, float]) -> list[Slot]:
    """Return lanes, from left to right, with the widths of corrections; that of all lanes is for motor vehicles."""
    if not known:
        return slots
    every = known.get(EVERY_LANE)
    of = {place: every for place, slot in enumerate(slots) if slot.type in MOTOR_LANES}
    of |= {number - 1: width for number, width in known.items() if number != EVERY_LANE}
    return [replace(slot, width=of.get(place) or slot.width) for place, slot in enumerate(slots)]


def _access(slot: Slot, whole: Access) -> Access:
    """Return which cars may use a lane; `whole` is what the tags of the whole way say."""
    if slot.type is not LaneType.DRIVING:
        return Access.ALL
    return whole if slot.access is Access.ALL else slot.access


def _usual_width(groups: LaneGroups, highway: str, country: Country, in_town: bool) -> float:
    """Return the usual width of a way's lanes for cars, m."""
    every = (*groups.forward, *groups.both_ways, *groups.backward)
    # A lane for bicycles gives room to pass, too; a row of parked cars does not.
    alone = groups.shared or len(every) == 1
    beside = max(sum(slot.type in MOTOR_LANES for slot in group) for group in (groups.forward, groups.backward)) > 1
    return country.lane_width(highway, alone=alone, beside_in_town=beside and in_town)


def tagged_width(tags: Tags) -> float | None:
    """Return the width of a carriageway that was measured, by the tags of a way, m; None if they give none."""
    return first_width(tags, WIDTH_TAGS[:2], CARRIAGEWAY_WIDTHS, "width", "a road", [])


def _carriageway(
    tags: Tags,
    margins: Margins,
    slots: Sequence[Slot],
    facts: StreetFacts,
    findings: Findings,
) -> tuple[float | None, float, float]:
    """Return the width of the carriageway, if known, and what of it parked cars use on the left and right, m.

    The width is read where it is needed: for lanes without one, or for parking. Where parked cars would leave no room
    for a lane, it is taken to be that of the lanes alone, and no part is used for parking.
    """
    parked = margins is not NOTHING and (margins.parking_left or margins.parking_right)
    if not parked and all(slot.width or slot.type not in MOTOR_LANES for slot in slots):
        return None, 0.0, 0.0
    kerbs = facts.kerbs
    names = WIDTH_TAGS[:1] if kerbs else WIDTH_TAGS
    width = first_width(tags, names, CARRIAGEWAY_WIDTHS, "width", "a road", findings)
    if width is None and kerbs:
        width = kerbs.apart
    elif width is None and facts.width and _fits(facts.width, len(slots), 0.0):
        width = facts.width
        findings.append((Kind.GUESSED, "width", f"no width given, {width:g} m as on the same street"))
    left, right = margins.parking_left, margins.parking_right
    if width is None or not parked or width - left - right >= LANE_WIDTH_MIN:
        return width, left, right
    if left != right and width - min(left, right) >= _ROOM_TO_PASS:
        # Whoever parks at an angle does so in bays beside the carriageway then.
        words = f"{width:g} m of width have no room for {max(left, right):g} m of parking, taken to lie beside them"
        findings.append((Kind.GUESSED, "width", words))
        return width, left if left < right else 0.0, right if right < left else 0.0
    words = (
        f"{width:g} m of width have no room for {left + right:g} m of parking, taken to be that of the lanes alone"
    )
    findings.append((Kind.GUESSED, "width", words))
    return width, 0.0, 0.0


def _widths(
    slots: Sequence[Slot],
    usual: float,
    widest: float,
    chosen: bool,
    carriageway: float | None,
    parked: float,
    findings: Findings,
) -> list[float]:
    """Return the width of each lane, m: tagged, else its share of the carriageway, else the usual one.

    The usual width is the user's if `chosen`, else a guess. Of the carriageway `parked` is used for parking or lies
    beside the lanes, m; lanes that get a share are about the `widest` that are built at most.
    """
    widths = [slot.width or _beside_width(slot.type, usual) for slot in slots]
    open_lanes = [place for place, slot in enumerate(slots) if not slot.width and slot.type in MOTOR_LANES]
    if not open_lanes:
        return widths
    if carriageway is None:
        if not chosen:
            findings.append((Kind.GUESSED, "lane-width", f"no width given, lanes of {usual:g} m assumed"))
        return widths
    taken = sum(widths) - sum(widths[place] for place in open_lanes)
    share = (carriageway - parked - taken) / len(open_lanes)
    # What is too little for a strip beside them makes lanes wider.
    width = min(max(share, LANE_WIDTH_MIN), widest + 2.0 * MARGIN_WIDTH_MIN / len(open_lanes))
    if abs(width - share) > 1e-9:
        less = f" less {parked:g} m beside its lanes" if parked else ""
        words = f"{carriageway:g} m of width{less} would make lanes of {share:.2f} m, {width:g} m taken"
        findings.append((Kind.REPAIRED, "lane-width", words))
    for place in open_lanes:
        widths[place] = width
    return widths


def _beside_lanes(slots: Sequence[Slot], widest: float, room: float, parks: bool) -> float:
    """Return how much of the room between kerbs lanes leave on either side when they are as wide as any, m."""
    lanes = (slot.width or (widest if slot.type in MOTOR_LANES else LANE_WIDTH_BICYCLE) for slot in slots)
    rest = min((room - sum(lanes)) / 2.0, PARKING_WIDTH["perpendicular"] if parks else SHOULDER_WIDTH["motorway"])
    return round(rest, 3) if rest >= MARGIN_WIDTH_MIN else 0.0


def _beside_width(kind: LaneType, usual: float) -> float:
    """Return the usual width of a lane by its type, m."""
    if kind is LaneType.BUS:
        return max(usual, LANE_WIDTH_BUS)
    return usual if kind in MOTOR_LANES else LANE_WIDTH_BICYCLE


def is_transition(tags: Tags) -> bool:
    """Whether the line of a way changes its position among the lanes (``placement=transition``)."""
    return any(tags.get(key) == "transition" for key in PLACEMENT_TAGS)


def placed_middle(
    lanes_ltr: Sequence[LaneSpec], beside: Sequence[bool], tags: Tags, direction: int, findings: Findings
) -> float | None:
    """Return the offset of the middle of the lanes from the OSM line, left positive, m; None if not tagged.

    Source: OSM wiki, Key:placement. `beside` marks the lanes that ``placement`` does not count.
    """
    if not any(key in tags for key in PLACEMENT_TAGS):
        return None
    keys: list[tuple[str, Direction]] = []
    if direction >= 0:
        keys.append(("placement:forward", Direction.FORWARD))
    if direction <= 0:
        keys.append(("placement:backward", Direction.BACKWARD))
    if direction:
        keys.insert(0, ("placement", Direction(direction)))
    elif tags.get("placement", "transition") != "transition":
        findings.append((Kind.DROPPED, "placement", "placement of a two-way road names no direction, ignored"))
    if is_transition(tags):
        words = "the line changes its position among the lanes, it is interpolated between the ways before and after"
        findings.append((Kind.NOTE, "placement", words))
    edges = list(accumulate((lane.width for lane in lanes_ltr), initial=0.0))
    # Edges of the lanes that ``placement`` counts: without those from ``cycleway`` or ``busway``.
    counted = [
        (lane.direction, edges[place], edges[place + 1]) for place, lane in enumerate(lanes_ltr) if not beside[place]
    ]
    found = [
        place
        for key, runs in keys
        if key in tags and (place := _line_position(tags[key], counted, runs, findings)) is not None
    ]
    if not found:
        return None
    if abs(found[-1] - found[0]) > _PLACEMENTS_AGREE:
        findings.append((Kind.REPAIRED, "placement", "placement of the two directions differs, the first is taken"))
    return found[0] - sum(lane.width for lane in lanes_ltr) / 2.0


def _line_position(
    text: str, lanes_ltr: Sequence[tuple[Direction, float, float]], runs: Direction, findings: Findings
) -> float | None:
    """Return the distance of the OSM line from the left edge of the carriageway, m; None if it is not given."""
    if text == "transition":
        return None
    # Edges of the lanes of the direction, from left to right as its drivers see them.
    own = [(left, right) for direction, left, right in lanes_ltr if direction is runs]
    if runs is Direction.BACKWARD:
        own = [(right, left) for left, right in reversed(own)]
    found = _PLACEMENT.fullmatch(text.strip())
    if found and own:
        side, lane_number = found[1], int(found[2])
        if side == "left_of" and lane_number == len(own) + 1:
            return own[-1][1]  # left of a lane that ends or begins here
        if side == "right_of" and lane_number == 0:
            return own[0][0]
        if 1 <= lane_number <= len(own):
            left, right = own[lane_number - 1]
            return {"left_of": left, "right_of": right, "middle_of": (left + right) / 2.0}[side]
    findings.append((Kind.DROPPED, "placement", f"placement {text} does not fit {len(own)} lanes and is ignored"))
    return None
