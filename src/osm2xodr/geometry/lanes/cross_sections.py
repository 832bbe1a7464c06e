"""The lanes of a street at one place: from OSM's left-to-right order to OpenDRIVE's count outwards from a centre."""

from __future__ import annotations

from osm2xodr.geometry.lanes.lane_connectivity import COUNTED_LANES
from osm2xodr.model import Direction, LaneSpec, Rule, StreetAttributes
from osm2xodr.system import record


@record
class CrossSection:
    """All lanes of a street at one place."""

    # Lanes left and right of the centre, from the centre outwards: ids 1, 2, … and -1, -2, …
    left: tuple[LaneSpec, ...]
    right: tuple[LaneSpec, ...]
    centre: float  # t of the centre (OpenDRIVE's lane offset), m
    # t of the carriageway's edges, m
    left_edge: float
    right_edge: float


Piece = tuple[float, StreetAttributes, CrossSection]
"""(s on a street's curve from which it holds, attributes, cross-section)."""


@record
class EndLane:
    """One lane of a cross-section, usually where its street ends."""

    id: int  # OpenDRIVE's lane id
    t: float  # Position of its middle off the street's reference line, left of the street's own direction, m
    spec: LaneSpec  # What it is


def cross_section(attributes: StreetAttributes, rule: Rule) -> CrossSection:
    """Lay out a street's lanes about the OSM line.

    Lanes along the street lie right of the centre with right-hand traffic, left of it with left-hand traffic; lanes
    for both directions lie on the same side as they, next to the centre.
    """
    lanes = attributes.lanes_ltr
    total = sum(lane.width for lane in lanes)
    left_edge = attributes.middle_offset + attributes.moved_aside + total / 2
    if rule is Rule.RIGHT_HAND:
        on_left = sum(lane.direction is Direction.BACKWARD for lane in lanes)
    else:
        on_left = sum(lane.direction is not Direction.BACKWARD for lane in lanes)
    left, right = lanes[:on_left], lanes[on_left:]
    return CrossSection(left[::-1], right, left_edge - sum(lane.width for lane in left), left_edge, left_edge - total)


def end_lanes(section: CrossSection, rule: Rule, along: bool) -> tuple[EndLane, ...]:
    """Return the lanes whose traffic runs along the street (or against it), left to right as their drivers see them.

    Lanes for both directions are left out: see `centre_lanes`.
    """
    return lanes_of(section, Direction.FORWARD if along else Direction.BACKWARD, along)


def centre_lanes(section: CrossSection, along: bool) -> tuple[EndLane, ...]:
    """Return the lanes for both directions, left to right as drivers along the street (or against it) see them."""
    return lanes_of(section, Direction.BOTH, along)


def lanes_of(section: CrossSection, direction: Direction, along: bool) -> tuple[EndLane, ...]:
    """Return the lanes of one direction, left to right as seen along the street or against it."""
    found: list[EndLane] = []
    for side, lanes in ((1, section.left), (-1, section.right)):
        t = section.centre
        for number, lane in enumerate(lanes, start=1):
            if lane.direction is direction:
                found.append(EndLane(side * number, t + side * lane.width / 2, lane))
            t += side * lane.width
    return tuple(sorted(found, key=lambda lane: -lane.t if along else lane.t))


def car_directions(section: CrossSection) -> set[Direction]:
    """Return the directions of traffic on lanes for cars, buses and taxis; lanes for both say nothing more."""
    lanes = (*section.left, *section.right)
    return {lane.direction for lane in lanes if lane.type in COUNTED_LANES} - {Direction.BOTH}
