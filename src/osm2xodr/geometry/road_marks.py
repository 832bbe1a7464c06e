"""Marks between lanes, on centre lines and at the edges of carriageways."""

from __future__ import annotations

from osm2xodr import defaults
from osm2xodr.geometry.cross_section import CrossSection
from osm2xodr.model import RoadMark

_UNMARKED = ("residential", "living_street", "service", "track")
NO_MARK = RoadMark("none", width=0.0)


def outer_mark(lane_id: int, section: CrossSection, highway: str) -> RoadMark:
    """Return the mark between a lane and the next one outwards, or the edge of the carriageway."""
    lanes = section.left if lane_id > 0 else section.right
    wide = highway in defaults.FAST_HIGHWAYS
    width = defaults.MARK_WIDTH_WIDE if wide else defaults.MARK_WIDTH
    if abs(lane_id) == len(lanes):
        if highway in _UNMARKED:
            return NO_MARK
        return RoadMark("solid", width=width)
    if lanes[abs(lane_id) - 1].direction is not lanes[abs(lane_id)].direction:
        return RoadMark("solid broken", width=width, lane_change="both")
    return RoadMark("broken", width=width, lane_change="both")


def centre_mark(section: CrossSection, highway: str) -> RoadMark:
    """Return the mark on the centre line, which is an edge where all lanes lie on one side of it."""
    width = defaults.MARK_WIDTH_WIDE if highway in defaults.FAST_HIGHWAYS else defaults.MARK_WIDTH
    if not section.left or not section.right:
        return NO_MARK if highway in _UNMARKED else RoadMark("solid", width=width)
    if highway in _UNMARKED or section.left_edge - section.right_edge < defaults.CENTRE_LINE_FROM:
        return RoadMark("none", width=0.0, lane_change="both")
    if len(section.left) + len(section.right) > 2:
        return RoadMark("solid", width=width)
    return RoadMark("broken", width=width, lane_change="both")
