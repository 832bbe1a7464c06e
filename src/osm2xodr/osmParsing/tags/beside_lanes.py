"""Bicycle and bus lanes given by tags of the whole way: ``cycleway``, ``busway``, ``lanes:psv``.

``lanes`` counts bus lanes but not bicycle lanes of the carriageway (OSM wiki, Key:lanes). Where lists give either
lane by lane (``bicycle:lanes``, ``bus:lanes``), the lists decide and nothing is added. Bicycle tracks apart from the
carriageway are in `cycle_tracks`.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Final

from osm2xodr.diagnostics import Kind
from osm2xodr.model import Direction, LaneType, Rule
from osm2xodr.osmParsing.defaults import LANES_PLAUSIBLE_MAX, TAGGED_LANE_WIDTH_MAX, TAGGED_LANE_WIDTH_MIN
from osm2xodr.osmParsing.tags.access import NO_VALUES
from osm2xodr.osmParsing.tags.lane_counts import SIDES, LaneGroups
from osm2xodr.osmParsing.tags.lane_lists import Slot, motor_lanes
from osm2xodr.osmParsing.tags.sides import LEFT_RIGHT, SIDE_KEYS, names_of_side
from osm2xodr.osmParsing.tags.values import Findings, Tags, first_width, parse_count

CYCLE_TAGS: Final = (
    "oneway:bicycle",
    *(f"cycleway{key}{what}" for key in SIDE_KEYS for what in ("", ":oneway", ":lane", ":width", ":est_width")),
)
BUS_TAGS: Final = (
    *(f"busway{key}" for key in SIDE_KEYS),
    *(f"lanes:{user}{way}" for user in ("bus", "psv") for way in ("", ":forward", ":backward")),
)
BESIDE_TAGS: Final = (*CYCLE_TAGS, *BUS_TAGS)

# OSM wiki, Key:cycleway: lanes of the carriageway along with traffic and against it; how they are marked.
_LANES: Final = frozenset({"lane", "buffered_lane", "soft_lane"})
_AGAINST: Final = frozenset({"opposite_lane"})
# Values that, in a key without a side, refer to the far side of a one-way road.
_FAR_SIDE: Final = frozenset({"opposite_lane", "opposite_track"})
_MARKED: Final = frozenset({"exclusive", "advisory", "soft_lane", "mandatory", "suggested"})
REVERSE: Final = frozenset({"-1", "reverse"})
_BOTH: Final = (Direction.FORWARD, Direction.BACKWARD)
_CODE: Final = "cycle-lane"
# A bicycle lane: its side of the way, its direction along it, its width where OSM gives it, m.
_CycleLane = tuple[str, Direction, float | None]


def with_beside_lanes(groups: LaneGroups, tags: Tags, direction: int, rule: Rule, findings: Findings) -> LaneGroups:
    """Add bicycle lanes to the lanes that counts and lists give, and reserve lanes for buses.

    `direction` is 1 or -1 if the way is one-way along or against its order of nodes, else 0.
    """
    if not any(key in tags for key in BESIDE_TAGS):
        return groups
    for key in BUS_TAGS:
        if key.startswith("lanes:") and key in tags and not _count(tags, key) and tags[key] != "0":
            findings.append((Kind.DROPPED, "bus-lane", f"{key}={tags[key]} is not a number of lanes and is ignored"))
    groups = _with_bus_lanes(groups, tags, direction, rule, findings)
    found = [lane for side in LEFT_RIGHT if (lane := _cycle_lane(tags, side, direction, rule, findings))]
    listed = {runs for runs in _BOTH if any(slot.type is LaneType.BIKING for slot in groups.of(runs))}
    for lane in found:
        if lane[1] not in listed:
            groups = _with_cycle_lane(groups, lane, tags, direction, rule, findings)
    return groups


def near_side(runs: Direction, rule: Rule) -> str:
    """Return the side of the way (seen along it) at which a direction of traffic has its outer edge."""
    return "right" if (runs is Direction.FORWARD) == (rule is Rule.RIGHT_HAND) else "left"


def _cycle_lane(tags: Tags, side: str, direction: int, rule: Rule, findings: Findings) -> _CycleLane | None:
    """Return the bicycle lane on one side of the way."""
    own = Direction.FORWARD if near_side(Direction.FORWARD, rule) == side else Direction.BACKWARD
    value, key = side_value(tags, "cycleway", side, direction, own)
    marked = next((tags[f"{name}:lane"] for name in names_of_side("cycleway", side) if f"{name}:lane" in tags), "")
    if value not in _LANES | _AGAINST and not (value is None and marked in _MARKED):
        return None
    keys = (f"{name}:{what}" for name in names_of_side("cycleway", side) for what in ("width", "est_width"))
    width = first_width(tags, keys, (TAGGED_LANE_WIDTH_MIN, TAGGED_LANE_WIDTH_MAX), _CODE, "a lane", findings)
    far = own == -direction
    if direction and (value in _AGAINST or (far and key != "cycleway" and tags.get("oneway:bicycle") in NO_VALUES)):
        return side, Direction(-direction), width
    return side, _along(tags, side, Direction(direction or own), findings), width


def side_value(tags: Tags, key: str, side: str, direction: int, own: Direction) -> tuple[str | None, str]:
    """Return the value tagged for a side, and its key.

    Keys with a side take precedence. The key without one means both sides of a two-way road, but only the near side
    of a one-way road (the far side for lanes against the one-way). `own` is the direction of the lanes on that side.
    """
    for name in (f"{key}:{side}", f"{key}:both"):
        if name in tags:
            return tags[name], name
    value = tags.get(key)
    if value is None or any(f"{key}:{other}" in tags for other in LEFT_RIGHT):
        return None, key
    if direction and (value in _FAR_SIDE) == (int(own) == direction):
        return None, key
    return value, key


def _along(tags: Tags, side: str, usual: Direction, findings: Findings) -> Direction:
    """Return the direction of a bicycle lane; `usual` unless a tag says otherwise."""
    text = next((tags[f"{name}:oneway"] for name in names_of_side("cycleway", side) if f"{name}:oneway" in tags), "")
    if text in NO_VALUES:
        findings.append((Kind.REPAIRED, _CODE, "a bicycle lane for both directions is written with one"))
    # ``yes`` only says that it has one direction.
    return Direction.BACKWARD if text in REVERSE else usual


def _with_cycle_lane(
    groups: LaneGroups, lane: _CycleLane, tags: Tags, direction: int, rule: Rule, findings: Findings
) -> LaneGroups:
    """Add one bicycle lane at its edge of the carriageway."""
    side, runs, width = lane
    outer = near_side(runs, rule) == side
    if not outer and (groups.both_ways or groups.of(-runs)):
        # OpenDRIVE has no place for it beyond the lanes of the other direction.
        runs, outer = Direction(-runs), True
        words = "a bicycle lane against the traffic beside it is written as running with it"
        findings.append((Kind.REPAIRED, _CODE, words))
    slots = groups.of(runs)
    at_end = outer == (rule is Rule.RIGHT_HAND)
    edge = slots[-1 if at_end else 0] if slots else None
    slot = Slot(LaneType.BIKING, width=width, beside=True)
    if edge is not None and outer and not edge.turns and motor_lanes(slots) == _tagged(tags, runs, direction) + 1:
        # Lists such as ``turn:lanes`` count the bicycle lane, ``lanes`` does not.
        slot = replace(edge, type=LaneType.BIKING, width=edge.width or width)
        slots = slots[:-1] if at_end else slots[1:]
    return groups.with_slots(runs, (*slots, slot) if at_end else (slot, *slots))


def _tagged(tags: Tags, runs: Direction, direction: int) -> int:
    """Return the tagged number of lanes for cars of a direction, -1 if there is none."""
    if direction and direction != runs:
        return -1
    key = "lanes" if direction else f"lanes:{SIDES[runs.value]}"
    return parse_count(tags.get(key, ""))[0] or -1


def _with_bus_lanes(groups: LaneGroups, tags: Tags, direction: int, rule: Rule, findings: Findings) -> LaneGroups:
    """Reserve outer lanes for buses unless lists say which lanes are theirs."""
    for runs in _BOTH:
        slots = groups.of(runs)
        if not motor_lanes(slots) or any(slot.type is LaneType.BUS for slot in slots):
            continue
        at_near, at_far = _bus_lanes(tags, runs, direction, rule, findings)
        # ``lanes`` counts the lanes of ``lanes:psv``; those of ``busway`` it often leaves out.
        room = "lanes" not in tags or not any(key.startswith("lanes:") and key in tags for key in BUS_TAGS)
        for count, at_end in ((at_near, rule is Rule.RIGHT_HAND), (at_far, rule is Rule.LEFT_HAND)):
            if count:
                slots = _reserve_lanes(slots, count, at_end, room, findings)
        groups = groups.with_slots(runs, slots)
    return groups


def _reserve_lanes(
    slots: tuple[Slot, ...], count: int, at_end: bool, room: bool, findings: Findings
) -> tuple[Slot, ...]:
    """Give outer lanes to buses but leave one for cars; add missing bus lanes if there is `room`."""
    own = list(slots if at_end else slots[::-1])
    for place in reversed(range(len(own))):
        cars = sum(slot.type is LaneType.DRIVING for slot in own)
        if count and cars > 1 and own[place].type is LaneType.DRIVING:
            own[place] = replace(own[place], type=LaneType.BUS)
            count -= 1
    if count and room:
        own += [Slot(LaneType.BUS, beside=True)] * count
        findings.append((Kind.GUESSED, "bus-lane", "a bus lane that the number of lanes has no room for is added"))
    elif count:
        findings.append((Kind.DROPPED, "bus-lane", "as many bus lanes as lanes, the innermost is kept open to cars"))
    return tuple(own if at_end else own[::-1])


def _bus_lanes(tags: Tags, runs: Direction, direction: int, rule: Rule, findings: Findings) -> tuple[int, int]:
    """Return the numbers of bus lanes at the near side and at the far side of a direction."""
    for user in ("psv", "bus"):
        own = _count(tags, f"lanes:{user}:{SIDES[runs.value]}")
        total = _count(tags, f"lanes:{user}")
        if own:
            return own, 0
        if total and direction == runs:
            return total, 0
        if total and not direction:
            if total % 2 and runs is Direction.FORWARD:
                findings.append((Kind.GUESSED, "bus-lane", "bus lanes without directions, the odd one runs forward"))
            return (total + (runs is Direction.FORWARD)) // 2, 0
    if direction and direction != runs:
        return 0, 0
    near = near_side(runs, rule)
    far = LEFT_RIGHT[near == LEFT_RIGHT[0]]
    at_near = side_value(tags, "busway", near, direction, runs)[0] in _LANES
    at_far = bool(direction) and side_value(tags, "busway", far, direction, Direction(-runs))[0] in _LANES
    return int(at_near), int(at_far)


def _count(tags: Tags, key: str) -> int:
    """Read a number of lanes; 0 if there is none."""
    count = parse_count(tags.get(key, ""))[0] or 0
    return count if count <= LANES_PLAUSIBLE_MAX else 0


def contraflow_bus_lane(tags: Tags, direction: int) -> bool:
    """Whether tags of the whole way give a one-way road a contraflow bus lane."""
    against = SIDES[-direction]
    against_traffic = any(tags.get(f"busway{key}") in _AGAINST for key in SIDE_KEYS)
    return against_traffic or any(_count(tags, f"lanes:{user}:{against}") for user in ("psv", "bus"))
