"""Lists of values lane by lane (``turn:lanes``, ``width:lanes``, ``access:lanes`` …) for one direction of a street.

Values are separated by bars, from left to right as the drivers of that direction see them (OSM wiki, Lanes). Lists
include all lanes, also those for bicycles, while ``lanes`` counts only lanes wide enough for cars.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from typing import Final

from osm2xodr.diagnostics import Kind
from osm2xodr.model import Access, LaneType
from osm2xodr.osmParsing.defaults import (
    LANE_WIDTH_MAX,
    LANES_PLAUSIBLE_MAX,
    NARROW_LANE,
    TAGGED_LANE_WIDTH_MAX,
    TAGGED_LANE_WIDTH_MIN,
)
from osm2xodr.osmParsing.tags.access import CAR_KEYS, CLOSED_VALUES, KEPT_FOR_HOV
from osm2xodr.osmParsing.tags.values import Findings, Tags, lowest_speed, parse_length
from osm2xodr.system import record

MOTOR_LANES: Final = frozenset({LaneType.DRIVING, LaneType.BUS, LaneType.TAXI})
DIRECTIONS: Final = ("", ":forward", ":backward", ":both_ways")

# Lists that say who may use lanes, and lists of other properties.
_USER_LISTS: Final = (*CAR_KEYS, "bus", "psv", "taxi", "bicycle", "cycleway", "hov")
_OTHER_LISTS: Final = ("turn", "width", "change", "maxspeed")
LIST_TAGS: Final = tuple(f"{name}:lanes{way}" for name in (*_OTHER_LISTS, *_USER_LISTS) for way in DIRECTIONS)
TURN_TAGS: Final = tuple(f"turn{way}" for way in DIRECTIONS)
CHANGE_TAGS: Final = tuple(f"change{way}" for way in DIRECTIONS)

_ALLOWED: Final = frozenset({"yes", "designated", "permissive", "official", "only"})
# Values of car keys that reserve a lane for buses and for bicycles.
_FOR_BUSES: Final = frozenset({"psv", "bus"})
_FOR_BICYCLES: Final = frozenset({"bicycle", "bicycles", "cyclist"})
# Values of ``cycleway:lanes`` that reserve a lane for bicycles.
_CYCLE_LANES: Final = frozenset({"lane", "exclusive", "advisory"})

# OSM wiki, Key:change.
_CHANGES: Final = frozenset({"yes", "no", "not_left", "not_right", "only_left", "only_right"})
# OSM wiki, Key:turn.
_TURNS: Final = frozenset(
    {
        *("left", "slight_left", "sharp_left", "through", "right", "slight_right", "sharp_right", "reverse"),
        *("merge_to_left", "merge_to_right", "slide_left", "slide_right"),
    }
)


@record
class Slot:
    """One lane."""

    type: LaneType = LaneType.DRIVING  # Who may use it
    turns: frozenset[str] = frozenset()  # Its arrows
    width: float | None = None  # m, where OSM gives it
    beside: bool = False  # Whether it is in addition to the lanes that lists and ``placement`` count
    change: str = ""  # Whether its drivers may leave it: value of ``change``; empty where OSM says nothing
    access: Access = Access.ALL  # Which cars may drive on it
    speed: float | None = None  # Its own limit, m/s; None where OSM gives none


def motor_lanes(slots: Sequence[Slot]) -> int:
    """Count the lanes that ``lanes`` counts."""
    return sum(slot.type in MOTOR_LANES for slot in slots)


def read_turns(text: str, findings: Findings) -> frozenset[str]:
    """Read the arrows of one lane; empty for ``none``."""
    turns = frozenset(part.strip() for part in text.split(";")) - {"", "none"}
    for unknown in sorted(turns - _TURNS):
        findings.append((Kind.DROPPED, "turn", f"{unknown!r} is not a direction of a turn and is ignored"))
    return turns & _TURNS


def read_change(text: str, findings: Findings) -> str:
    """Read one lane's value of ``change``; empty where it says nothing."""
    if not text or text in _CHANGES:
        return text
    if text != "none":
        findings.append((Kind.DROPPED, "change", f"{text!r} says nothing about changing lanes and is ignored"))
    return ""


def read_slots(tags: Tags, directions: Sequence[str], tagged: int, findings: Findings) -> tuple[Slot, ...]:
    """Read all lists of one direction: its lanes from left to right as drivers see them; empty without lists.

    `directions` are the endings of keys to look for, in order of precedence. `tagged` is the number of lanes for cars
    that OSM gives elsewhere, 0 if it does not; it decides where lists can be read in two ways.
    """
    lists = _lists(tags, directions, findings)
    if not lists:
        return ()
    # The most frequent length, lists of users first.
    deciding = [len(lists[name]) for name in _USER_LISTS if name in lists]
    lengths = Counter(deciding or [len(values) for values in lists.values()])
    count = max(lengths, key=lambda length: (lengths[length], length == tagged, length))
    fitting = {name: lists[name] for name in _USER_LISTS if len(lists.get(name, ())) == count}
    users = [{name: values[place] for name, values in fitting.items()} for place in range(count)]
    types = _types(users, tagged)
    slots = [Slot(kind, access=_access(own)) for kind, own in zip(types, users, strict=True)]
    # Lists describe all lanes, or only those for cars.
    motor = [place for place, kind in enumerate(types) if kind in MOTOR_LANES]
    for name, values in lists.items():
        places = next((some for some in (range(count), motor) if len(some) == len(values)), ())
        if not places:
            text = "|".join(values)
            findings.append((Kind.DROPPED, "lane-lists", f"{name}:lanes={text} does not fit {count} lanes, ignored"))
            continue
        for place, value in zip(places, values, strict=True):
            if name == "turn":
                slots[place] = replace(slots[place], turns=read_turns(value, findings))
            elif name == "change":
                slots[place] = replace(slots[place], change=read_change(value, findings))
            elif name == "width":
                slots[place] = replace(slots[place], width=_width(value, findings))
            elif name == "maxspeed":
                slots[place] = replace(slots[place], speed=_speed(value, findings))
    if set(lists) == {"width"}:
        _mark_narrow(slots, tagged, findings)
    return tuple(slots)


def _mark_narrow(slots: list[Slot], tagged: int, findings: Findings) -> None:
    """Where there are more widths than lanes for cars, make bicycle lanes of those too narrow for cars, in place."""
    surplus = len(slots) - tagged
    narrow = sorted(range(len(slots)), key=lambda place: slots[place].width or LANE_WIDTH_MAX)[: max(surplus, 0)]
    if 0 < surplus < len(slots) and all((slots[place].width or LANE_WIDTH_MAX) < NARROW_LANE for place in narrow):
        for place in narrow:
            slots[place] = replace(slots[place], type=LaneType.BIKING)
        findings.append((Kind.GUESSED, "lane-lists", "more widths than lanes, the narrow ones are for bicycles"))


def _lists(tags: Tags, directions: Sequence[str], findings: Findings) -> dict[str, list[str]]:
    lists: dict[str, list[str]] = {}
    for name in (*_OTHER_LISTS, *_USER_LISTS):
        for direction in directions:
            value = tags.get(f"{name}:lanes{direction}")
            if value is None and name == "turn" and "|" in tags.get(f"turn{direction}", ""):
                value = tags[f"turn{direction}"]  # a common slip
            if value is not None:
                values = [part.strip() for part in value.split("|")]
                if len(values) <= LANES_PLAUSIBLE_MAX:
                    lists[name] = values
                else:
                    words = f"{name}:lanes{direction} names {len(values)} lanes, more than any road has, ignored"
                    findings.append((Kind.DROPPED, "lane-lists", words))
                break
    return lists


def _types(users: Sequence[Tags], tagged: int) -> list[LaneType]:
    types = [_type(own) for own in users]
    if LaneType.BIKING in types and len(types) == tagged and not any(name in users[0] for name in CAR_KEYS):
        # Bicycles are named for a lane, but nothing keeps cars out, and `lanes` counts it.
        return [LaneType.DRIVING if kind is LaneType.BIKING else kind for kind in types]
    return types


def _type(users: Tags) -> LaneType:
    """Return who may use one lane, given its values by list."""
    car = next((users[name] for name in CAR_KEYS if users.get(name)), "")
    buses = users.get("bus") or users.get("psv") or ""
    taxis = users.get("taxi", "")
    bicycles = "designated" if users.get("cycleway") in _CYCLE_LANES else users.get("bicycle", "")
    others = ((buses, LaneType.BUS), (taxis, LaneType.TAXI), (bicycles, LaneType.BIKING))
    if _access(users) is Access.HOV:
        return LaneType.DRIVING
    if not car:
        return next((kind for value, kind in others if value == "designated"), LaneType.DRIVING)
    if car in _FOR_BUSES:
        return LaneType.BUS
    if car in _FOR_BICYCLES:
        return LaneType.BIKING
    if car not in CLOSED_VALUES:
        return LaneType.DRIVING
    return next((kind for value, kind in others if value in _ALLOWED), LaneType.NONE)


def _access(users: Tags) -> Access:
    """Return which cars may use one lane, if cars may, given its values by list."""
    car = next((users[name] for name in CAR_KEYS if users.get(name)), "")
    known = _ALLOWED if car in CLOSED_VALUES else KEPT_FOR_HOV
    return Access.HOV if car == "hov" or users.get("hov") in known else Access.ALL


def _speed(text: str, findings: Findings) -> float | None:
    speed, exact = lowest_speed(text)
    if speed is None and text:
        findings.append((Kind.DROPPED, "speed", f"{text!r} in maxspeed:lanes gives no fixed speed and is ignored"))
    elif not exact:
        findings.append((Kind.GUESSED, "speed", f"{text!r} in maxspeed:lanes has several, the lowest is taken"))
    return speed


def _width(text: str, findings: Findings) -> float | None:
    if not text:
        return None
    width = parse_length(text)
    if width is None or not TAGGED_LANE_WIDTH_MIN <= width <= TAGGED_LANE_WIDTH_MAX:
        words = f"{text!r} in width:lanes is not the width of a lane and is ignored"
        findings.append((Kind.DROPPED, "lane-width", words))
        return None
    return width
