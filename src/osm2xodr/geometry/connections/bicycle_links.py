"""Where bicycle lanes lead on through a junction that their like does not continue straight on."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from osm2xodr.defaults import LEAST_TURN_BACK
from osm2xodr.geometry.connections.lane_assignment import ArmLanes, LaneLink, LaneMovement
from osm2xodr.geometry.defaults import STRAIGHT_ON
from osm2xodr.model import LaneSpec, LaneType


def lead_bicycles_on(
    movements: Sequence[LaneMovement],
    entries: dict[int, ArmLanes],
    exits: dict[int, ArmLanes],
    links: Sequence[LaneLink],
    near_side_left: bool,
) -> list[LaneLink]:
    """Return the links that bicycle lanes of one junction lack, besides the known `links` of all lanes.

    Where no movement leads straight on, bicycle lanes lead round the corners to bicycle lanes; one that nothing leads
    straight to is reached round one corner. What still leads nowhere joins the lane for cars at its side: straight
    on, else round the corner of the near side.
    """
    lacking = {(item.entry, lane) for item in movements for lane in _bicycles(entries[item.entry].specs)}
    unreached = {(item.exit, lane) for item in movements for lane in _bicycles(exits[item.exit].specs)}
    lacking -= {(movements[k].entry, lane) for k, lane, _ in links}
    unreached -= {(movements[k].exit, lane) for k, _, lane in links}
    if not lacking and not unreached:
        return []
    ways = [k for k, item in enumerate(movements) if item.entry != item.exit and abs(item.turn) < LEAST_TURN_BACK]
    # Straight on first, then round the corner of the near side.
    ways.sort(key=lambda k: _rank(movements[k].turn, near_side_left))
    straight = [movements[k] for k in ways if abs(movements[k].turn) < STRAIGHT_ON]
    from_straight, to_straight = {item.entry for item in straight}, {item.exit for item in straight}
    found: list[LaneLink] = []
    for k in ways:
        item = movements[k]
        for lane_in, lane_out in _alike(entries[item.entry].specs, exits[item.exit].specs, near_side_left):
            leads_on = (item.entry, lane_in) in lacking and item.entry not in from_straight
            if leads_on or ((item.exit, lane_out) in unreached and item.exit not in to_straight):
                found.append((k, lane_in, lane_out))
                unreached.discard((item.exit, lane_out))
    # Who leads on round a corner only may want to go straight on as well.
    lacking -= {(movements[k].entry, lane) for k, lane, _ in found if movements[k].entry not in from_straight}
    for arm, lane in sorted(lacking):
        first = next((k for k in ways if movements[k].entry == arm and _cars(exits[movements[k].exit].specs)), None)
        if first is not None:
            beside = _at_its_side(lane, entries[arm].specs, exits[movements[first].exit].specs, near_side_left)
            found.append((first, lane, beside))
    return found


def _rank(turn: float, near_side_left: bool) -> tuple[bool, bool, float]:
    """Return a key by which ways straight on come first, then turns to the near side, the straightest first."""
    return abs(turn) >= STRAIGHT_ON, (turn > 0) != near_side_left, abs(turn)


def _bicycles(specs: Sequence[LaneSpec]) -> list[int]:
    return [k for k, spec in enumerate(specs) if spec.type is LaneType.BIKING]


def _cars(specs: Sequence[LaneSpec]) -> list[int]:
    return [k for k, spec in enumerate(specs) if spec.type is LaneType.DRIVING]


def _alike(entry: Sequence[LaneSpec], exit_: Sequence[LaneSpec], near_side_left: bool) -> Iterable[tuple[int, int]]:
    """Pair the bicycle lanes of two arms, from the near side on."""
    ins, outs = _bicycles(entry), _bicycles(exit_)
    return zip(ins, outs, strict=False) if near_side_left else zip(ins[::-1], outs[::-1], strict=False)


def lies_at_left(lane: int, lanes: int, near_side_left: bool) -> bool:
    """Say whether one of some lanes lies at the left of all of them; the middle one lies at the near side."""
    middle = (lanes - 1) / 2
    return lane < middle or (lane == middle and near_side_left)


def _at_its_side(lane: int, own: Sequence[LaneSpec], other: Sequence[LaneSpec], near_side_left: bool) -> int:
    """Return the lane for cars of another arm at the side of its road at which a bicycle lane lies on its own."""
    return _cars(other)[0 if lies_at_left(lane, len(own), near_side_left) else -1]
