"""How many lanes a way has in each direction.

Where tags disagree, the more specific one is taken: lists such as ``turn:lanes`` before counts by direction before
``lanes``, in which mappers often leave out short turn lanes. Missing counts are derived from those there are, else
assumed: one lane each way, more on one-way motorways. Every decision becomes a finding.
"""

from __future__ import annotations

import re
from dataclasses import replace
from typing import Final

from osm2xodr.diagnostics import Kind
from osm2xodr.model import LaneType
from osm2xodr.osmParsing.defaults import LANES_PLAUSIBLE_MAX, ONEWAY_LANES
from osm2xodr.osmParsing.tags.access import NO_VALUES
from osm2xodr.osmParsing.tags.lane_lists import Slot, motor_lanes, read_change, read_slots, read_turns
from osm2xodr.osmParsing.tags.values import Findings, Tags, parse_count
from osm2xodr.system import record

COUNT_TAGS: Final = ("lanes", "lanes:forward", "lanes:backward", "lanes:both_ways", "lanes:reversible")
# Tags that open one direction of a road to buses or bicycles alone, or close it to bicycles.
_USERS: Final = ("bus", "psv", "taxi", "bicycle")
USER_TAGS: Final = (
    "oneway:bus",
    "oneway:psv",
    "oneway:taxi",
    *(f"{user}:{way}" for user in _USERS for way in ("forward", "backward")),
)
_OPEN: Final = frozenset({"yes", "designated", "permissive", "official"})
# OSM's names of the directions along (1) and against (-1) a way.
SIDES: Final = {1: "forward", -1: "backward"}
_CODE: Final = "lane-count"
_SUM: Final = re.compile(r"\s*[1-9]\s*(\+\s*[1-9]\s*){1,2}", re.ASCII)


@record
class LaneGroups:
    """The lanes of a way by direction, each group from left to right as its drivers see it."""

    forward: tuple[Slot, ...] = ()  # Along the way's order of nodes
    backward: tuple[Slot, ...] = ()  # Against it
    both_ways: tuple[Slot, ...] = ()  # Between them, seen along the way
    shared: bool = False  # Whether both directions share the width of a single lane

    def of(self, direction: int) -> tuple[Slot, ...]:
        """Return the lanes along (1) or against (-1) the way."""
        return self.forward if direction > 0 else self.backward

    def with_slots(self, direction: int, slots: tuple[Slot, ...]) -> LaneGroups:
        """Return the groups with other lanes along (1) or against (-1) the way."""
        return replace(self, forward=slots) if direction > 0 else replace(self, backward=slots)


def lane_groups(
    tags: Tags, direction: int, findings: Findings, closed: int = 0, contraflow_bus: bool = False
) -> LaneGroups:
    """Reconcile all tags about the number and use of a way's lanes.

    `direction` is 1 or -1 if the way is one-way along or against its order of nodes, else 0; `closed` likewise if
    that direction of a two-way road is closed to cars. `contraflow_bus` says that a one-way road is known to have a
    bus lane against its direction.
    """
    if direction:
        return _oneway_groups(tags, direction, contraflow_bus, findings)
    if not closed:
        return _twoway_groups(tags, findings)
    if not _count(tags, f"lanes:{SIDES[closed]}", []) and _count(tags, "lanes", []) < 2:
        # The width of one lane, on which cars drive one way.
        return _oneway_groups(tags, -closed, contraflow_bus, findings)
    groups = _twoway_groups(tags, findings)
    return groups.with_slots(closed, _closed_to_cars(groups.of(closed), tags, closed))


def with_lanes_of_sums(tags: Tags, direction: int, findings: Findings) -> Tags:
    """Return tags with ``lanes=2+1`` as a number, on a two-way road also by direction: forward and backward.

    Of three numbers the one in the middle is that of lanes for both directions.
    """
    text = tags.get("lanes", "")
    if not _SUM.fullmatch(text):
        return tags
    counts = [int(part) for part in text.split("+")]
    ways = ("forward", "both_ways", "backward") if len(counts) == 3 else ("forward", "backward")
    by_way = {} if direction else {f"lanes:{way}": str(count) for way, count in zip(ways, counts, strict=True)}
    named = ", ".join(f"{key}={count}" for key, count in by_way.items()) or sum(counts)
    findings.append((Kind.GUESSED, _CODE, f"lanes={text} taken for {named}"))
    return {**by_way, **tags, "lanes": str(sum(counts))}


def _closed_to_cars(slots: tuple[Slot, ...], tags: Tags, closed: int) -> tuple[Slot, ...]:
    """Return the lanes of a direction closed to cars: for buses if they may use them, else for bicycles."""
    side = SIDES[closed]
    kind = LaneType.BIKING
    if any(tags.get(f"{user}:{side}") in _OPEN for user in ("bus", "psv")):
        kind = LaneType.BUS
    elif tags.get(f"bicycle:{side}") in NO_VALUES:
        kind = LaneType.NONE
    return tuple(replace(slot, type=kind) if slot.type is LaneType.DRIVING else slot for slot in slots)


def _oneway_groups(tags: Tags, direction: int, contraflow_bus: bool, findings: Findings) -> LaneGroups:
    side, other = SIDES[direction], SIDES[-direction]
    along, against = _count(tags, f"lanes:{side}", findings), _count(tags, f"lanes:{other}", findings)
    tagged = _count(tags, "lanes", findings) or along
    contraflow = _contraflow_slots(tags, other, against, contraflow_bus, findings)
    if contraflow:
        if "lanes" in tags:
            tagged = along or max(tagged - len(contraflow), 1)
        who = "taxis" if contraflow[0].type is LaneType.TAXI else "buses"
        words = f"a lane against the direction of a one-way road is kept for {who}"
        findings.append((Kind.NOTE, "contraflow", words))
    elif 0 < against < tagged:
        tagged = along or tagged - against
        findings.append((Kind.DROPPED, "contraflow", "lanes against the direction of a one-way road are left out"))
    elif any(tags.get(f"oneway:{user}") in NO_VALUES for user in ("bus", "psv", "taxi")):
        words = "buses or taxis may drive against the one-way (oneway:bus, psv or taxi=no), but have no lane for it"
        findings.append((Kind.DROPPED, "contraflow", words))
    slots = _oneway_slots(tags, side, tagged, findings)
    return LaneGroups(slots, contraflow) if direction > 0 else LaneGroups(contraflow, slots)


def _contraflow_slots(tags: Tags, side: str, tagged: int, known: bool, findings: Findings) -> tuple[Slot, ...]:
    """Return the lanes of buses, or of taxis alone, against the direction of a one-way road."""
    listed = read_slots(tags, (f":{side}",), tagged, findings)
    buses = tuple(slot for slot in listed if slot.type is LaneType.BUS)
    if buses:
        return buses
    opened = [
        user
        for user in ("bus", "psv", "taxi")
        if tags.get(f"oneway:{user}") in NO_VALUES or tags.get(f"{user}:{side}") in _OPEN
    ]
    # Of two lanes and more one is that of the buses, though nothing counts it apart.
    if known or (opened and (tagged or _count(tags, "lanes", []) > 1)):
        taxis = opened == ["taxi"] and not known
        return (Slot(LaneType.TAXI if taxis else LaneType.BUS),) * max(tagged, 1)
    return ()


def _oneway_slots(tags: Tags, side: str, tagged: int, findings: Findings) -> tuple[Slot, ...]:
    ways = ("", f":{side}")
    slots = read_slots(tags, ways, tagged, findings)
    if not tagged and not motor_lanes(slots):
        tagged = ONEWAY_LANES.get(tags["highway"], 1)
        findings.append((Kind.GUESSED, _CODE, f"no lanes given, {_lanes(tagged)} assumed"))
    turn = next((tags[f"turn{way}"] for way in ways if f"turn{way}" in tags), "")
    change = next((tags[f"change{way}"] for way in reversed(ways) if f"change{way}" in tags), "")
    return _with_common_tags(_fit(slots, tagged, findings), turn, change, findings)


def _twoway_groups(tags: Tags, findings: Findings) -> LaneGroups:
    total = _count(tags, "lanes", findings)
    if any(f"{name}:lanes" in tags for name in ("turn", "width", "change", "maxspeed")):
        findings.append((Kind.DROPPED, "lane-lists", "lists of lanes of a two-way road name no direction, ignored"))
    slots: list[tuple[Slot, ...]] = []
    for way in ("forward", "both_ways", "backward"):
        tagged = _count(tags, f"lanes:{way}", findings)
        if way == "both_ways":
            tagged = tagged or _count(tags, "lanes:reversible", findings)
        slots.append(_fit(read_slots(tags, (f":{way}",), tagged, findings), tagged, findings))
    forward, between, backward = (motor_lanes(group) for group in slots)
    shared = total == 1 and not between and forward <= 1 and backward <= 1
    if shared:
        findings.append((Kind.GUESSED, _CODE, "one lane for both directions, made two narrow ones"))
        forward = backward = 1
    else:
        forward, between, backward = _split(total, forward, between, backward, _odd_side(tags), findings)
    groups: dict[str, tuple[Slot, ...]] = {}
    for way, own, count in (
        ("forward", slots[0], forward),
        ("backward", slots[2], backward),
        ("both_ways", slots[1], between),
    ):
        turn = tags.get(f"turn:{way}", "") if way != "both_ways" else ""
        change = tags.get(f"change:{way}", tags.get("change", ""))
        groups[way] = _with_common_tags(_fit(own, count, findings), turn, change, findings) if count else ()
    return LaneGroups(**groups, shared=shared)


def _odd_side(tags: Tags) -> str:
    """Return the direction with more lanes for buses by their numbers; forward where they do not say."""
    buses = [
        max(parse_count(tags.get(f"lanes:{user}:{way}", ""))[0] or 0 for user in ("psv", "bus"))
        for way in ("forward", "backward")
    ]
    return "backward" if buses[1] > buses[0] else "forward"


def _split(
    total: int, forward: int, between: int, backward: int, odd: str, findings: Findings
) -> tuple[int, int, int]:
    """Divide the lanes of a two-way road into forward, both ways and backward; 0 stands for unknown.

    Where nothing else says, the `odd` lane runs in the direction of that name.
    """
    if not total:
        if not forward and not backward:
            findings.append((Kind.GUESSED, _CODE, "no lanes given, one each way assumed"))
        elif not forward or not backward:
            findings.append((Kind.GUESSED, _CODE, "lanes given for one direction, one the other way assumed"))
        return forward or 1, between, backward or 1
    if between and forward and backward and total == forward + backward:
        findings.append((Kind.DROPPED, _CODE, f"lanes={total} leaves no room for lanes for both directions"))
        between = 0
    rest = total - between
    if not forward and not backward:
        if rest % 2 and rest > 1:
            findings.append((Kind.GUESSED, _CODE, f"{total} lanes without directions, the odd one runs {odd}"))
        forward, backward = max((rest + 1) // 2, 1), max(rest // 2, 1)
        if odd == "backward":
            forward, backward = backward, forward
    elif not forward or not backward:
        forward = forward or max(rest - backward, 1)
        backward = backward or max(rest - forward, 1)
    elif rest == forward + backward + 1 and not between and forward == backward:
        between = 1
        findings.append((Kind.GUESSED, _CODE, f"{total} lanes, the one without a direction is for both"))
    named = forward + between + backward
    if named != total:
        findings.append((Kind.REPAIRED, _CODE, f"lanes={total} but the directions have {named}, which is taken"))
    return forward, between, backward


def _fit(slots: tuple[Slot, ...], tagged: int, findings: Findings) -> tuple[Slot, ...]:
    """Reconcile the lanes of the lists with a tagged number of lanes; 0 stands for unknown."""
    motor = motor_lanes(slots)
    if motor == tagged or not tagged:
        return slots
    if motor > tagged:
        # Short turn lanes are often listed but not counted.
        findings.append((Kind.REPAIRED, _CODE, f"{_lanes(tagged)} tagged, the {motor} named one by one are taken"))
        return slots
    if 0 < motor < tagged <= len(slots):
        findings.append((Kind.REPAIRED, _CODE, f"{_lanes(tagged)} tagged, but only {motor} of them for cars"))
        return slots
    if slots:
        findings.append((Kind.DROPPED, "lane-lists", f"lists name {_lanes(len(slots))} of {tagged}, ignored"))
    return (Slot(),) * tagged


def _with_common_tags(slots: tuple[Slot, ...], turn: str, change: str, findings: Findings) -> tuple[Slot, ...]:
    """Give the values of ``turn`` and ``change`` to all lanes of a direction unless some have one of their own."""
    if turn and "|" not in turn and not any(slot.turns for slot in slots):
        turns = read_turns(turn, findings)
        slots = tuple(replace(slot, turns=turns) for slot in slots)
    if change and not any(slot.change for slot in slots):
        stated = read_change(change, findings)
        slots = tuple(replace(slot, change=stated) for slot in slots)
    return slots


def _count(tags: Tags, key: str, findings: Findings) -> int:
    """Read a number of lanes; 0 if there is none."""
    text = tags.get(key)
    if text is None:
        return 0
    count, exact = parse_count(text)
    if count is None or count > LANES_PLAUSIBLE_MAX:
        if text != "0":
            findings.append((Kind.DROPPED, _CODE, f"{key}={text} is not a number of lanes and is ignored"))
        return 0
    if not exact:
        findings.append((Kind.GUESSED, _CODE, f"{key}={text} taken for {count}"))
    return count


def _lanes(count: int) -> str:
    return "1 lane" if count == 1 else f"{count} lanes"
