"""Street networks of `street_cases` with strips beside their carriageways."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

from street_cases import Case

from osm2xodr.diagnostics import Diagnostics
from osm2xodr.geometry import build_roads
from osm2xodr.model import (
    Direction,
    Lane,
    LaneSection,
    LaneType,
    MarginSpec,
    RoadMap,
    Rule,
    StreetAttributes,
    StreetNetwork,
    Surface,
)
from osm2xodr.surface import FlatSurface

Strips = tuple[MarginSpec, ...]

WALK = MarginSpec(LaneType.SIDEWALK, 2.0, height=0.12)
VERGE = MarginSpec(LaneType.BORDER, 1.0, height=0.12)
PARKING = MarginSpec(LaneType.PARKING, 2.2)
TRACK = MarginSpec(LaneType.BIKING, 1.6, Direction.FORWARD, 0.06)
BOTH: tuple[Strips, Strips] = ((WALK,), (WALK,))


def with_margins(
    network: StreetNetwork, choose: Callable[[StreetAttributes], tuple[Strips, Strips]]
) -> StreetNetwork:
    """Return a network with other margins, left and right."""

    def changed(attributes: StreetAttributes) -> StreetAttributes:
        left, right = choose(attributes)
        return replace(attributes, margin_left=left, margin_right=right)

    streets = tuple(
        replace(street, pieces=tuple((node, changed(attributes)) for node, attributes in street.pieces))
        for street in network.streets
    )
    return replace(network, streets=streets)


def built(
    case: Case,
    margins: Mapping[int, tuple[Strips, Strips]],
    rule: Rule = Rule.RIGHT_HAND,
    surface: Surface | None = None,
    diagnostics: Diagnostics | None = None,
) -> RoadMap:
    """Build a case, drawn for right-hand traffic, with margins (left and right) by OSM way; the others have none."""
    mirrored = rule is Rule.LEFT_HAND
    network = (case.mirrored() if mirrored else case).stages(rule).network

    def choose(attributes: StreetAttributes) -> tuple[Strips, Strips]:
        left, right = margins.get(attributes.osm_way_id, ((), ()))
        return (right, left) if mirrored != attributes.reversed else (left, right)

    told = Diagnostics() if diagnostics is None else diagnostics
    return build_roads(with_margins(network, choose), surface or FlatSurface(), told)


def row(*tags: str, length: float = 200.0) -> Case:
    """Make ways 1, 2 … from west to east in a row, one for each set of tags."""
    nodes = {f"p{k}": (k * length, 0.0) for k in range(len(tags) + 1)}
    return Case(nodes, {k + 1: (f"p{k} p{k + 1}", text) for k, text in enumerate(tags)})


def sections_of(roads: RoadMap) -> tuple[LaneSection, ...]:
    """Return those of the first road, the only one in a row."""
    return roads.roads[0].lane_sections


def by_id(section: LaneSection) -> dict[int, Lane]:
    return {lane.id: lane for lane in section.lanes}


def is_led_on(lane: Lane) -> bool:
    """Say whether a lane of a connecting road is a sidewalk that leads from one arm to another."""
    return lane.type is LaneType.SIDEWALK and lane.successor is not None
