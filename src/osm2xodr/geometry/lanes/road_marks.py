"""Marks between lanes, on centre lines and at the edges of carriageways, as the country paints them.

Tags decide first (``change:lanes``, ``overtaking``, ``lane_markings``, ``divider``), then the road's class. A double
mark names its lines from the inside outwards, that on the centre line from left to right, both seen along the road.
``laneChange`` names the direction in which drivers may cross, by lane ids: ``increase`` leftwards, ``decrease``
rightwards (ASAM OpenDRIVE 1.8, road markings).
"""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from types import MappingProxyType
from typing import Final

from osm2xodr.conventions import GENERIC, Country, MarkStyle
from osm2xodr.geometry.defaults import FAST_HIGHWAYS
from osm2xodr.geometry.lanes import defaults
from osm2xodr.geometry.lanes.cross_sections import CrossSection
from osm2xodr.model import (
    CAR_LANES,
    VEHICLE_LANES,
    Direction,
    LaneSpec,
    LaneType,
    MarginSpec,
    RoadMark,
    Rule,
    StreetAttributes,
)
from osm2xodr.system import record

NO_MARK: Final = RoadMark("none", width=0.0)
_UNMARKED: Final = RoadMark("none", width=0.0, lane_change="both")
# Whether drivers may leave their lane to the left and to the right (OSM wiki, Key:change).
_CHANGES: Final[Mapping[str, tuple[bool, bool]]] = MappingProxyType(
    {
        "yes": (True, True),
        "no": (False, False),
        "not_left": (False, True),
        "only_right": (False, True),
        "not_right": (True, False),
        "only_left": (True, False),
    }
)
# Whether the line left and right on the centre is solid, by ``divider`` (OSM wiki, Proposal:Divider): lines, and
# things that cannot be crossed.
_DIVIDERS: Final[Mapping[str, tuple[bool, bool]]] = MappingProxyType(
    {
        "dashed_line": (False, False),
        **dict.fromkeys(
            (
                *("solid_line", "double_solid_line", "line", "area", "median", "kerb", "grass_strip", "wall"),
                *("concrete_barrier", "jersey_barrier", "guard_rail", "bollard", "flexible_bollards"),
            ),
            (True, True),
        ),
    }
)
_NO_DIVIDER: Final = frozenset({"no", "none"})
# Strips that make a line at the carriageway's edge needless.
_KERBSIDE: Final = frozenset({LaneType.SIDEWALK, LaneType.PARKING, LaneType.RESTRICTED, LaneType.BORDER})


@record
class _Border:
    """The border of two lanes, seen along the road: who may cross it, and how it is painted."""

    # Whether drivers left of it may cross to the right, and those right of it to the left: a line is solid on the
    # side of drivers who may not.
    to_right: bool
    to_left: bool
    # Of its lines
    color: str
    width: float
    double: bool = False  # Whether two lines of the same kind are painted
    open: bool = False  # Whether all may cross whatever is painted: centre lanes for turning

    def mark(self, leftwards: bool) -> RoadMark:
        """Return the mark in OpenDRIVE's words; `leftwards` says that its inner side is on the right."""
        left, right = ("broken" if free else "solid" for free in (self.to_right, self.to_left))
        words = (right, left) if leftwards else (left, right)
        kind = words[0] if words[0] == words[1] and not self.double else " ".join(words)
        right_too, left_too = self.open or self.to_right, self.open or self.to_left
        change = {(True, True): "both", (True, False): "decrease", (False, True): "increase"}.get(
            (right_too, left_too), "none"
        )
        return RoadMark(kind, self.color, self.width, change)


def road_marks(
    section: CrossSection, attributes: StreetAttributes, rule: Rule, country: Country = GENERIC
) -> dict[int, RoadMark]:
    """Return the mark on the outer edge of every lane of a carriageway, and on its centre line (lane 0)."""
    return _Painter(section, attributes, rule, country.marks).marks()


def mark_kind(attributes: StreetAttributes) -> Hashable:
    """Return the tags that marks depend on, apart from the lanes."""
    return (
        attributes.highway,
        attributes.no_overtaking,
        attributes.marked,
        attributes.divider,
        *(margin[0].type if margin else None for margin in (attributes.margin_left, attributes.margin_right)),
    )


def change_kind(lane: LaneSpec) -> Hashable:
    """Return the lane changes that tags allow; None where those are the usual ones."""
    allowed = _CHANGES.get(lane.change)
    return None if allowed == (True, True) and lane.type in CAR_LANES else allowed


def same_marks(one: StreetAttributes, other: StreetAttributes) -> bool:
    """Say whether two pieces of a street with the same lanes have the same lines between them."""
    return (one.no_overtaking, one.marked, one.divider) == (other.no_overtaking, other.marked, other.divider)


class _Painter:
    """Finds the marks of one cross-section."""

    def __init__(self, section: CrossSection, attributes: StreetAttributes, rule: Rule, style: MarkStyle) -> None:
        self._section = section
        self._attributes = attributes
        self._rule = rule
        self._style = style
        self._lanes = (*reversed(section.left), *section.right)
        fast = attributes.highway in FAST_HIGHWAYS
        self._width = style.width_fast if fast else style.width
        self._edge_width = style.edge_width_fast if fast else style.edge_width
        self._special_width = style.special_width_fast if fast else style.special_width
        # Streets of these classes have lines only where a tag says so.
        self._unlined = attributes.highway in defaults.UNMARKED_HIGHWAYS and not attributes.marked

    def marks(self) -> dict[int, RoadMark]:
        """Return all marks by lane id."""
        on_left = len(self._section.left)
        out = {
            on_left: self._edge(True, self._attributes.margin_left),
            -len(self._section.right): self._edge(False, self._attributes.margin_right),
        }
        for k in range(1, len(self._lanes)):
            # A mark belongs to the lane on its inner side: `on_left - k` left and right of the centre alike.
            out[on_left - k] = self._between(k, leftwards=k < on_left)
        return out

    # ---------------------------------------------------------------- edges

    def _edge(self, left: bool, margin: Sequence[MarginSpec]) -> RoadMark:
        """Return the line at an edge of the carriageway."""
        highway = self._attributes.highway
        if self._attributes.marked is False or self._unlined:
            return NO_MARK
        beside = margin[0].type if margin else LaneType.NONE
        edgeless = highway in defaults.EDGELESS_HIGHWAYS and not self._attributes.marked
        if edgeless or (beside in _KERBSIDE and highway not in FAST_HIGHWAYS):
            return NO_MARK
        color = self._style.median_edge if self._is_median(left) else self._style.outer_edge
        return RoadMark("solid", color, self._edge_width)

    def _is_median(self, left: bool) -> bool:
        """Say whether an edge faces oncoming traffic: the inner edge, where all cars run one way."""
        runs = self._attributes.car_directions()
        if len(runs) != 1 or Direction.BOTH in runs:
            return False
        inner_is_left = (Direction.FORWARD in runs) == (self._rule is Rule.RIGHT_HAND)
        return left == inner_is_left

    # ---------------------------------------------------------------- between lanes

    def _between(self, k: int, leftwards: bool) -> RoadMark:
        """Return the mark between the k-th lane and the one left of it, counted from the left."""
        left, right = self._lanes[k - 1], self._lanes[k]
        for_motors = left.type in VEHICLE_LANES and right.type in VEHICLE_LANES
        if self._attributes.marked is False and for_motors:
            return _UNMARKED
        if left.direction is right.direction:
            return self._of_one_direction(k, left, right).mark(leftwards)
        if not for_motors:
            return _Border(False, False, self._style.centre_solid, self._special_width).mark(leftwards)
        if Direction.BOTH in (left.direction, right.direction):
            # A centre lane for turning, used by both directions: the broken line is on its own side.
            own_left = left.direction is Direction.BOTH
            border = _Border(own_left, not own_left, self._style.centre, self._width, open=True)
            return border.mark(leftwards)
        return self._between_directions(leftwards)

    def _of_one_direction(self, k: int, left: LaneSpec, right: LaneSpec) -> _Border:
        kinds = {left.type, right.type}
        special = len(kinds - CAR_LANES) > 0 and len(kinds) > 1
        # Cars may cross a bicycle lane that lies between their own lanes (before a turn lane).
        free = not special or self._is_between_car_lanes(k if right.type is LaneType.BIKING else k - 1)
        backward = left.direction is Direction.BACKWARD
        # Drivers against the road see its right as their left.
        to_right = _may_leave(left, to_left=backward, otherwise=free)
        to_left = _may_leave(right, to_left=not backward, otherwise=free)
        color = "standard" if special or (to_right and to_left) else self._style.no_change
        return _Border(to_right, to_left, color, self._special_width if special else self._width)

    def _is_between_car_lanes(self, place: int) -> bool:
        lanes = self._lanes
        if lanes[place].type is not LaneType.BIKING or not 0 < place < len(lanes) - 1:
            return False
        return all(
            beside.type in VEHICLE_LANES and beside.direction is lanes[place].direction
            for beside in (lanes[place - 1], lanes[place + 1])
        )

    def _between_directions(self, leftwards: bool) -> RoadMark:
        attributes, style = self._attributes, self._style
        motor_lanes = [lane for lane in self._lanes if lane.type in VEHICLE_LANES]
        forbidden = attributes.no_overtaking
        divider = _DIVIDERS.get(attributes.divider)
        wide = len(motor_lanes) > 2
        if divider is None:
            narrow = sum(lane.width for lane in motor_lanes) < defaults.CENTRE_LINE_FROM
            unmarked = self._unlined or (narrow and not attributes.marked)
            if attributes.divider in _NO_DIVIDER or (unmarked and not forbidden):
                return _UNMARKED
        if divider is not None:
            left_solid, right_solid = divider
        elif wide:
            left_solid = right_solid = True
        else:
            left_runs = Direction.BACKWARD if self._rule is Rule.RIGHT_HAND else Direction.FORWARD
            left_solid = left_runs in forbidden
            right_solid = Direction(-left_runs) in forbidden
        if not left_solid and not right_solid:
            return _Border(True, True, style.centre, self._width).mark(leftwards)
        color = style.centre_solid if wide else style.no_overtaking or style.centre_solid
        double = left_solid and right_solid and self._is_double(len(motor_lanes))
        return _Border(not left_solid, not right_solid, color, self._width, double).mark(leftwards)

    def _is_double(self, motor_lanes: int) -> bool:
        if self._attributes.divider == "double_solid_line":
            return True
        if motor_lanes > 2:
            return 0 < self._style.double_from <= motor_lanes
        return self._style.double_no_overtaking


def _may_leave(lane: LaneSpec, *, to_left: bool, otherwise: bool) -> bool:
    """Say whether drivers may leave their lane on a side as they see it."""
    allowed = _CHANGES.get(lane.change)
    return otherwise if allowed is None else allowed[0 if to_left else 1]
