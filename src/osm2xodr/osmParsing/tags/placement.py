"""Where among its lanes the line of a way runs: ``placement``."""

from __future__ import annotations

import re
from collections.abc import Sequence
from itertools import accumulate
from typing import Final

from osm2xodr.diagnostics import Kind
from osm2xodr.model import Direction, LaneSpec
from osm2xodr.osmParsing.tags.values import Findings, Tags

PLACEMENT_TAGS: Final = ("placement", "placement:forward", "placement:backward")

_PLACEMENT: Final = re.compile(r"(left_of|middle_of|right_of):(-?\d+)")
# The placements of both directions agree if they differ by no more than this, m.
_PLACEMENTS_AGREE: Final = 0.1


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
