"""Streets with lanes in a short notation, as stage 1 hands them on, and their stretches and layouts as roads."""

from __future__ import annotations

from dataclasses import replace

from osm2xodr.geometry.lanes.cross_sections import CrossSection, cross_section
from osm2xodr.geometry.lanes.lane_sections import LaneLayout, lay_out_lanes
from osm2xodr.geometry.lanes.road_stretches import Stretch, stretches
from osm2xodr.model import Direction, LaneSpec, LaneType, Rule, StreetAttributes, Structure

KINDS = {"d": LaneType.DRIVING, "b": LaneType.BUS, "t": LaneType.TAXI, "c": LaneType.BIKING}
RUNS = {"<": Direction.BACKWARD, ">": Direction.FORWARD, "=": Direction.BOTH}


def lanes(text: str, width: float = 3.5) -> tuple[LaneSpec, ...]:
    """Read lanes from left to right, such as ``d< d>/left,through c>:not_left``.

    Turns stand after ``/``, change after ``:``. Lanes for bicycles are 1.5 m wide.
    """
    out = []
    for item in text.split():
        rest, _, change = item.partition(":")
        kind, _, turns = rest.partition("/")
        own_width = 1.5 if kind[0] == "c" else width
        marks = frozenset(turn for turn in turns.split(",") if turn)
        out.append(LaneSpec(KINDS[kind[0]], RUNS[kind[1]], own_width, marks, change))
    return tuple(out)


def street(text: str, highway: str = "primary", width: float = 3.5, **more: object) -> StreetAttributes:
    """Return a street with lanes; `more` are other fields."""
    plain = StreetAttributes(
        osm_way_id=1,
        reversed=False,
        highway=highway,
        name="",
        ref="",
        lanes_ltr=lanes(text, width),
        middle_offset=0.0,
        speed_forward=None,
        speed_backward=None,
        structure=Structure.GROUND,
        layer=0,
        grade=None,
        roundabout=False,
    )
    return replace(plain, **more)  # type: ignore[arg-type]


def section(text: str, rule: Rule = Rule.RIGHT_HAND, width: float = 3.0, middle: float = 0.0) -> CrossSection:
    """Return the cross-section of lanes about a middle at some t, m."""
    return cross_section(street(text, width=width, middle_offset=middle), rule)


def cut(*pieces: tuple[float, StreetAttributes], begin: float = 0.0, end: float = 100.0) -> list[Stretch]:
    """Return the stretches of a road from pieces (s where it begins, attributes), cut to a part of the street."""
    return stretches(
        [(s, item, cross_section(item, Rule.RIGHT_HAND)) for s, item in pieces], begin, end, Rule.RIGHT_HAND
    )


def in_a_row(*pieces: tuple[float, StreetAttributes]) -> list[Stretch]:
    """Return the stretches of a road of pieces of some length, m, one after the other."""
    starts = [0.0]
    for length, _ in pieces:
        starts.append(starts[-1] + length)
    placed = [(s, item) for s, (_, item) in zip(starts, pieces, strict=False)]
    return cut(*placed, end=starts[-1])


def layout(*pieces: tuple[float, StreetAttributes], begin: float = 0.0, end: float = 100.0) -> LaneLayout:
    """Return the lanes of a road from pieces (s where it begins, attributes) with right-hand traffic."""
    return lay_out_lanes(cut(*pieces, begin=begin, end=end), Rule.RIGHT_HAND)
