"""OpenDRIVE's words as Lanelet2's tags, and the numbers of this export.

The tags are those of Lanelet2's documents LaneletPrimitives, LinestringTagging and RegulatoryElementTagging.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

Tags = dict[str, str]

ROAD: Final = "road"
BUS_LANE: Final = "bus_lane"
# Kinds of lanelets that motor traffic turns on.
TURNING: Final = frozenset({ROAD, BUS_LANE})
_CAR_TEXT: Final = (
    "driving entry exit onRamp offRamp connectingRamp slipLane bidirectional mwyEntry mwyExit HOV shared"
)
_WALKS: Final = "walkway"
# Lanes with these types become lanelets: their subtype, and who may use them.
LANELETS: Final[dict[str, tuple[str, tuple[str, ...]]]] = {
    **{kind: (ROAD, ("vehicle", "bicycle")) for kind in _CAR_TEXT.split()},
    "bus": (BUS_LANE, ("vehicle:bus",)),
    "taxi": (BUS_LANE, ("vehicle:taxi",)),
    "biking": ("bicycle_lane", ("bicycle",)),
    "sidewalk": (_WALKS, ("pedestrian",)),
    "walking": (_WALKS, ("pedestrian",)),
}
MOTORWAY: Final = "motorway"
# Types of roads outside towns; other types are inside, and where a road has none its place is unknown.
_NONURBAN: Final = frozenset({"rural", MOTORWAY})
_UNKNOWN_PLACE: Final = frozenset({"", "unknown"})

# Road marks: type and subtype of the bound, and whether one may change lanes to the left and to the right of it,
# along s, where the mark does not say. Marks that are not listed are solid.
_LINE: Final = "line_thin"
_MARKS: Final = {
    "broken": (_LINE, "dashed", True, True),
    "broken broken": (_LINE, "dashed", True, True),
    "botts dots": (_LINE, "dashed", True, True),
    "solid": (_LINE, "solid", False, False),
    "solid solid": (_LINE, "solid_solid", False, False),
    # Who is on the side of the broken line may cross it.
    "solid broken": (_LINE, "solid_dashed", True, False),
    "broken solid": (_LINE, "dashed_solid", False, True),
    "curb": ("curbstone", "high", False, False),
    "grass": ("road_border", "", False, False),
    "edge": ("road_border", "", False, False),
}
_UNMARKED: Final = frozenset({"", "none"})
_TURNED_ROUND: Final = {"solid broken": "broken solid", "broken solid": "solid broken"}
# ``laneChange``, whose ids ascend from right to left: to the left, to the right.
_CHANGES: Final = {"both": (True, True), "none": (False, False), "increase": (True, False), "decrease": (False, True)}

# Ways through junctions that turn by more than this turn left or right, rad (30 degrees): a choice, between the turns
# that OSM's wiki calls slight (35 degrees and more) and the bends of ways that lead straight on.
TURN_LEAST: Final = 0.5236
# Lanes that are nowhere wider than this are no lanelets, m: it is less than any road mark.
NARROWEST: Final = 0.01
# Lanelets that are longer, m, or turn by more, rad, or by some of both, are divided: CommonRoad's designer tells the
# sides of lanelets apart in a frame along them, which it cannot make around hairpins. Choices.
LONGEST: Final = 200.0
MOST_TURN: Final = 3.1416
# Points of a bound that are closer together than this are one, m: readers divide by their distance.
CLOSEST: Final = 0.01
# Ends of linked lanes that are farther apart than this are reported, m: the checker's lane gaps are small below it.
GAP_REPORTED: Final = 0.10
# Kerbs lower than this are ``low``, m: rolled ones have 0.05 (`osm2xodr.defaults.KERB_HEIGHT`), usual ones 0.12.
KERB_LOW: Final = 0.06
# Height of a light's or a sign's body where the file has none, m: a usual signal head with three lenses of 0.2 m
# (EN 12368) is 0.9 m high.
LIGHT_HEIGHT: Final = 0.9
SIGN_HEIGHT: Final = 0.6
# Width of the same, m.
BODY_WIDTH: Final = 0.3


@dataclass(frozen=True)
class Mark:
    """A road mark as a bound: what it looks like, and where one may change lanes across it, along s."""

    type: str
    subtype: str
    to_left: bool
    to_right: bool

    def tags(self) -> Tags:
        """Return the tags of the bound."""
        tags = {"type": self.type, **({"subtype": self.subtype} if self.subtype else {})}
        if self.to_left == self.to_right:
            return {**tags, "lane_change": _yes(self.to_left)}
        return {**tags, "lane_change:left": _yes(self.to_left), "lane_change:right": _yes(self.to_right)}


def mark_of(kind: str, change: str, *, outwards_left: bool, low: bool, bare: str) -> Mark:
    """Return a road mark as a bound.

    `outwards_left` says that the mark belongs to a lane left of the centre, whose double lines count from the inside
    to the outside; `low` that a kerb is one that wheels can cross; `bare` is the type of a bound without a mark.
    """
    if kind in _UNMARKED:
        stated = _CHANGES.get(change, (bare == "virtual",) * 2)
        return Mark(bare, "", *stated)
    if outwards_left:
        kind = _TURNED_ROUND.get(kind, kind)
    type_, subtype, left, right = _MARKS.get(kind, _MARKS["solid"])
    if low and type_ == "curbstone":
        subtype = "low"
    return Mark(type_, subtype, *_CHANGES.get(change, (left, right)))


def location_of(road_type: str) -> str:
    """Return where a road of a type is: ``urban``, ``nonurban``, or nothing where that is unknown."""
    if road_type in _UNKNOWN_PLACE:
        return ""
    return "nonurban" if road_type in _NONURBAN else "urban"


def lanelet_tags(
    subtype: str, participants: tuple[str, ...], *, location: str, both_ways: bool, speed: float
) -> Tags:
    """Return the tags of a lanelet; `speed` is its limit, m/s, NaN where unknown and infinite where there is none.

    Limits are in km/h without a unit, Lanelet2's default, for Autoware reads no unit.
    """
    tags = {"type": "lanelet", "subtype": subtype}
    if location:
        tags["location"] = location
    tags["one_way"] = _yes(not both_ways)
    if math.isfinite(speed):
        tags["speed_limit"] = f"{round(3.6 * speed, 2):g}"
    return {**tags, **{f"participant:{who}": "yes" for who in participants}}


def sign_type(country: str, kind: str, subtype: str) -> str:
    """Return a traffic sign as Lanelet2 names it: country and code, such as de274-50."""
    name = f"{'' if country == 'OpenDRIVE' else country.lower()}{kind}"
    return name if subtype in ("", "-1", "none") else f"{name}-{subtype}"


def _yes(value: bool) -> str:
    return "yes" if value else "no"
