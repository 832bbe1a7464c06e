"""Tells which connectivity relations could not be kept."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import pairwise

from osm2xodr.diagnostics import Diagnostics
from osm2xodr.geometry.junctions import Movement
from osm2xodr.geometry.lanes import Connectivity, CrossSection, Stretch, end_lanes
from osm2xodr.model import Direction, LaneSpec, Rule, StreetNetwork


def report_unheeded(
    network: StreetNetwork,
    movements: Iterable[tuple[Movement, CrossSection, CrossSection]],
    roads: Sequence[Sequence[Stretch]],
    diagnostics: Diagnostics,
) -> None:
    """Tell which relations decided nothing.

    Parameters
    ----------
    network
        The streets.
    movements
        All movements with the cross-sections of the roads' ends that they enter from and leave on.
    roads
        The stretches of all roads.
    diagnostics
        Where it is told.
    """
    heeded: set[int] = set()
    for item, before, after in movements:
        if item.stated is not None:
            entry = _specs(before, network.rule, item.entry % 2 == 1)
            exit_ = _specs(after, network.rule, item.exit % 2 == 0)
            if item.stated.between(entry, exit_) is not None:
                heeded.update(item.stated.relations)
    known = Connectivity.of(network.connectivities)
    for road in roads:
        for one, other in pairwise(road):
            for direction, stated in known.at_border(one.ways[-1], other.ways[0]).items():
                along = direction is Direction.FORWARD
                pair = (one.section, other.section) if along else (other.section, one.section)
                if stated.between(*(_specs(section, network.rule, along) for section in pair)) is not None:
                    heeded.update(stated.relations)
    for relation in network.connectivities:
        if relation.osm_relation_id not in heeded:
            diagnostics.dropped(
                "connectivity",
                f"relation/{relation.osm_relation_id}",
                "it names lanes or a way that are not there or that nobody may drive to, lanes are linked by habit",
            )


def _specs(section: CrossSection, rule: Rule, along: bool) -> tuple[LaneSpec, ...]:
    return tuple(lane.spec for lane in end_lanes(section, rule, along))
