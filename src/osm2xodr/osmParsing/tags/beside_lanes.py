"""Bicycle and bus lanes, and bicycle tracks, given by tags of the whole way: ``cycleway``, ``busway``, ``lanes:psv``.

``lanes`` counts bus lanes but not bicycle lanes of the carriageway (OSM wiki, Key:lanes). Where lists give either
lane by lane (``bicycle:lanes``, ``bus:lanes``), the lists decide and nothing is added. Tracks mapped as ways of their
own (``separate``) are handled in `osm2xodr.osmParsing.roadside`.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Final

from osm2xodr.diagnostics import Kind
from osm2xodr.model import Direction, LaneType, Rule
from osm2xodr.osmParsing.defaults import (
    CYCLE_TRACK_GAP,
    CYCLE_TRACK_GAP_PARKING,
    CYCLE_TRACK_WIDTH,
    CYCLE_TRACK_WIDTH_BOTH,
    LANES_PLAUSIBLE_MAX,
    MARGIN_WIDTH_MAX,
    TAGGED_LANE_WIDTH_MAX,
    TAGGED_LANE_WIDTH_MIN,
)
from osm2xodr.osmParsing.tags.access import NO_VALUES
from osm2xodr.osmParsing.tags.lane_counts import SIDES, LaneGroups
from osm2xodr.osmParsing.tags.lane_lists import Slot, motor_lanes
from osm2xodr.osmParsing.tags.values import (
    LEFT_RIGHT,
    SIDE_KEYS,
    Findings,
    Tags,
    add_once,
    first_width,
    keys_of_sides,
    names_of_side,
    parse_count,
    parse_length,
    width_of_side,
)
from osm2xodr.system import record

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
_LANE_CODE: Final = "cycle-lane"
# A bicycle lane: its side of the way, its direction along it, its width where OSM gives it, m.
_CycleLane = tuple[str, Direction, float | None]

_SEPARATION: Final = tuple(f":{what}{side}" for what in ("separation", "buffer") for side in SIDE_KEYS)
# In addition to those of `beside_lanes`.
TRACK_TAGS: Final = keys_of_sides("cycleway", *_SEPARATION)

_TRACK: Final = "track"
_OPPOSITE: Final = "opposite_track"
# OSM wiki, Key:cycleway: all values in use, most of which mean no track.
_KNOWN: Final = frozenset(
    {
        *("no", "none", "yes", "separate", "lane", "track", "opposite", "opposite_lane", "opposite_track"),
        *("shared_lane", "shared", "share_busway", "opposite_share_busway", "share_sidewalk", "buffered_lane"),
        *("soft_lane", "shoulder", "sidepath", "sidewalk", "crossing", "link", "asl", "use_sidepath", "advisory"),
        *("exclusive", "shared_track", "traffic_island", "both", "unmarked_lane"),
    }
)
# Separations that stand on the carriageway, so that the track is level with it (OSM wiki, Key:separation).
_ON_CARRIAGEWAY: Final = frozenset(
    {
        *("bollard", "flex_post", "vertical_panel", "bump", "planter", "jersey_barrier", "parking_lane", "studs"),
        *("solid_line", "dashed_line", "double_line", "fence", "railing", "cone", "car_parking", "structure"),
    }
)
_TRACK_CODE: Final = "cycle-track"


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
    width = first_width(tags, keys, (TAGGED_LANE_WIDTH_MIN, TAGGED_LANE_WIDTH_MAX), _LANE_CODE, "a lane", findings)
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
        findings.append((Kind.REPAIRED, _LANE_CODE, "a bicycle lane for both directions is written with one"))
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
        findings.append((Kind.REPAIRED, _LANE_CODE, words))
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


@record
class Track:
    """A bicycle track on one side of a way."""

    runs: Direction  # Its direction along the way
    width: float  # m
    gap: float  # Width of the strip between the carriageway and the track, m
    gap_beyond: float  # Width of the strip on its outer side, m; 0 where none is tagged
    raised: bool  # Whether it lies behind a kerb
    width_given: bool  # Whether OSM gives `width`
    gap_given: bool  # Whether OSM gives `gap`


def report_unknown_cycleways(tags: Tags, findings: Findings) -> None:
    """Report values of ``cycleway`` that are not known."""
    for key in SIDE_KEYS:
        value = tags.get(f"cycleway{key}")
        if value is not None and value not in _KNOWN:
            findings.append((Kind.DROPPED, _TRACK_CODE, f"cycleway{key}={value} is not known and is ignored"))


def read_track(tags: Tags, side: str, direction: int, rule: Rule, parking: bool, findings: Findings) -> Track | None:
    """Return the bicycle track on a side (``left`` or ``right``) of a way; None if there is none.

    `direction` is 1 or -1 if the way is one-way for cars along or against its order of nodes, else 0; `parking` says
    that cars park between the carriageway's lanes and the track.
    """
    own = Direction.FORWARD if near_side(Direction.FORWARD, rule) == side else Direction.BACKWARD
    value, key = side_value(tags, "cycleway", side, direction, own)
    if value not in (_TRACK, _OPPOSITE):
        return None
    if value == _OPPOSITE and not direction:
        add_once(findings, Kind.DROPPED, _TRACK_CODE, f"{key}={value} on a two-way road is ignored")
        return None
    runs = _runs(tags, side, direction, own, value, key)
    width_keys = [name for end in (":width", ":est_width") for name in names_of_side("cycleway", side, end)]
    width = width_of_side(tags, width_keys, _TRACK_CODE, findings)
    # ``separation`` and ``buffer`` name sides as cyclists see them.
    seen_forward = (runs or own) is Direction.FORWARD
    far = LEFT_RIGHT[side == LEFT_RIGHT[0]]
    inner, outer = (far, side) if seen_forward else (side, far)
    gap = _gap(tags, side, (f":{inner}", ":both", ""), findings)
    beyond = _gap(tags, side, (f":{outer}", ":both"), findings)
    usual = CYCLE_TRACK_WIDTH_BOTH if runs is Direction.BOTH else CYCLE_TRACK_WIDTH
    return Track(
        runs=runs,
        width=width or usual,
        gap=(CYCLE_TRACK_GAP_PARKING if parking else CYCLE_TRACK_GAP) if gap is None else gap,
        gap_beyond=beyond or 0.0,
        raised=not _level(tags, side, inner),
        width_given=width is not None,
        gap_given=gap is not None,
    )


def _runs(tags: Tags, side: str, direction: int, own: Direction, value: str, key: str) -> Direction:
    text = next((tags[name] for name in names_of_side("cycleway", side, ":oneway") if name in tags), "")
    if text in NO_VALUES:
        return Direction.BOTH
    if text in REVERSE:
        return Direction.BACKWARD
    if not direction:
        return own
    far = own == -direction
    against = value == _OPPOSITE or (far and key != "cycleway" and tags.get("oneway:bicycle") in NO_VALUES)
    return Direction(-direction if against else direction)


def _gap(tags: Tags, side: str, ends: tuple[str, ...], findings: Findings) -> float | None:
    """Return the width of the buffer on one side of a track, m; None if it is not tagged."""
    for name in names_of_side("cycleway", side, ":buffer"):
        for end in ends:
            text = tags.get(f"{name}{end}")
            if text is None or text == "yes":
                continue
            width = 0.0 if text in NO_VALUES else parse_length(text)
            if width is not None and width <= MARGIN_WIDTH_MAX:
                return width
            findings.append(
                (Kind.DROPPED, _TRACK_CODE, f"{name}{end}={text} is not the width of a strip and is ignored")
            )
    return None


def _level(tags: Tags, side: str, inner: str) -> bool:
    """Whether a track is level with the carriageway, only separated by something that stands there."""
    separations = names_of_side("cycleway", side, ":separation")
    names = (f"{name}{end}" for name in separations for end in (f":{inner}", ":both", ""))
    parts = {part.strip() for part in next((tags[name] for name in names if name in tags), "").split(";")}
    return bool(parts & _ON_CARRIAGEWAY) and "kerb" not in parts
