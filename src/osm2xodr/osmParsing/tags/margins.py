"""Strips beside a road's carriageway, from its tags: parking, shoulders, bicycle tracks, verges, sidewalks.

From the edge of the carriageway outwards: parking on it, the shoulder, parking beyond it, a gap and the bicycle
track, a verge, the sidewalk. A verge replaces the gap before a track. Sidewalks mapped as ways of their own
(``separate``) are handled in `osm2xodr.osmParsing.roadside`.

Of parking the newer tagging scheme (``parking:right=lane``) takes precedence over the older one
(``parking:lane:right=parallel``), keys for one side over those for both (OSM wiki, Street parking). Parking mapped as
an area of its own (``separate``) is not part of the road.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from typing import Final

from osm2xodr.defaults import KERB_HEIGHT, KERB_HEIGHT_MAX
from osm2xodr.diagnostics import Kind
from osm2xodr.model import Direction, LaneType, MarginSpec, Rule
from osm2xodr.osmParsing.defaults import (
    PARKING_WIDTH,
    PARKING_WIDTH_LEAST,
    SHOULDER_WIDTH,
    SHOULDER_WIDTH_OTHER,
    SIDEWALK_WIDTH,
    VERGE_WIDTH,
)
from osm2xodr.osmParsing.tags.beside_lanes import (
    CYCLE_TAGS,
    TRACK_TAGS,
    Track,
    near_side,
    read_track,
    report_unknown_cycleways,
)
from osm2xodr.osmParsing.tags.values import (
    LEFT_RIGHT,
    SIDE_KEYS,
    YES,
    Findings,
    Tags,
    add_once,
    keys_of_sides,
    names_of_side,
    parse_length,
    sides_of,
    width_of_side,
)
from osm2xodr.system import record

# The second is a common typing error.
_OLD_WIDTHS: Final = (":width", ".width")
_KERB_TAGS: Final = (*keys_of_sides("kerb", "", ":height"), *(f"sidewalk{side}:kerb" for side in SIDE_KEYS))
_SIDEWALK_TAGS: Final = (
    *keys_of_sides("sidewalk", "", ":width", ":est_width"),
    *keys_of_sides("verge", "", ":width"),
    *("footway", *(f"footway:{side}{end}" for side in ("left", "right", "both") for end in _OLD_WIDTHS)),
)
_SHOULDER_TAGS: Final = keys_of_sides("shoulder", "", ":width")
# Tags that say where people walk along a way, sidewalks or none.
_ON_FOOT_TAGS: Final = (*keys_of_sides("sidewalk", ""), "footway", "foot")

_OLD: Final = "parking:lane"
_NEW: Final = "parking"
_SIDES: Final = ("left", "right", "both")
# Orientation of parked cars by OSM's value; the last two are older still.
_ORIENTATIONS: Final = {
    **{value: value for value in ("parallel", "diagonal", "perpendicular")},
    "inline": "parallel",
    "orthogonal": "perpendicular",
}
# Values of the older key for parking of unknown orientation.
_UNORIENTED: Final = frozenset({"marked", "yes"})
PARKING_TAGS: Final = tuple(
    key
    for side in _SIDES
    for key in (
        *(f"{_NEW}:{side}{ending}" for ending in ("", ":orientation", ":width")),
        *(f"{_OLD}:{side}{ending}" for ending in ("", ":width")),
        *(f"{_OLD}:{side}:{value}" for value in (*_ORIENTATIONS, *sorted(_UNORIENTED))),
    )
)

# All tags that margins are read from.
MARGIN_TAGS: Final = ("foot", *_SIDEWALK_TAGS, *_KERB_TAGS, *PARKING_TAGS, *CYCLE_TAGS, *TRACK_TAGS, *_SHOULDER_TAGS)
# Ways without any of these have no margins; the other tags only describe them.
_DECIDING_TAGS: Final = frozenset(
    {
        *(key for name in ("sidewalk", "verge", "shoulder", "cycleway") for key in keys_of_sides(name, "")),
        *("footway", *(f"{key}:{side}" for key in ("parking", "parking:lane") for side in (*LEFT_RIGHT, "both"))),
    }
)

LANE: Final = "lane"
HALF_ON_KERB: Final = "half_on_kerb"
ON_KERB: Final = "on_kerb"
STREET_SIDE: Final = "street_side"
SHOULDER: Final = "shoulder"
# Where cars stand, by the value in either scheme.
_PLACES: Final = {
    **{place: place for place in (LANE, HALF_ON_KERB, ON_KERB, STREET_SIDE, SHOULDER)},
    **dict.fromkeys(("on_street", "painted_area_only"), LANE),
    "lay_by": STREET_SIDE,
}
# No parking, or none that is part of the road.
_NO_PARKING: Final = frozenset(
    {"no", "none", "separate", "no_parking", "no_stopping", "no_standing", "fire_lane", "not_applicable"}
)
_PARKING_CODE: Final = "parking"


@record
class Margins:
    """Strips on the left and right of a carriageway, seen along the way."""

    # From the carriageway's edge outwards
    left: tuple[MarginSpec, ...] = ()
    right: tuple[MarginSpec, ...] = ()
    # Width of the parking that is part of the carriageway as ``width`` measures it, m
    parking_left: float = 0.0
    parking_right: float = 0.0


NOTHING: Final = Margins()


def read_margins(tags: Tags, direction: int, rule: Rule, findings: Findings) -> Margins:
    """Read the margins of a way from its tags (``highway`` and `MARGIN_TAGS`).

    `direction` is 1 or -1 if the way is one-way for cars along or against its order of nodes, else 0.
    """
    if _DECIDING_TAGS.isdisjoint(tags):
        return NOTHING
    report_unknown_cycleways(tags, findings)
    sidewalks = _sidewalk_sides(tags, findings)
    verges = [side for side, state in sides_of(tags, "verge", "verge", findings).items() if state == YES]
    # Without a side, shoulders of one-way roads are on the near side (OSM wiki, Key:shoulder).
    near = (near_side(Direction(direction), rule),) if direction else LEFT_RIGHT
    shoulders = sides_of(tags, "shoulder", "shoulder", findings, near)
    guessed: set[str] = set()
    found: dict[str, tuple[tuple[MarginSpec, ...], float]] = {}
    for side in LEFT_RIGHT:
        parking = read_parking(tags, side, findings)
        has_shoulder = shoulders.get(side) == YES
        if parking and parking.place == SHOULDER:
            has_shoulder, parking = True, None
        if parking and not parking.given:
            guessed.add(f"parking of {parking.width:g} m")
        track = read_track(tags, side, direction, rule, parking is not None, findings)
        if track and not track.width_given:
            guessed.add(f"cycle tracks of {track.width:g} m")
        if track and not track.gap_given and side not in verges:
            guessed.add(f"{track.gap:g} m before cycle tracks")
        shoulder = verge = sidewalk = 0.0
        if has_shoulder:
            usual = SHOULDER_WIDTH.get(tags["highway"], SHOULDER_WIDTH_OTHER)
            width = width_of_side(tags, names_of_side("shoulder", side, ":width"), "shoulder", findings)
            shoulder = _known(width, usual, "shoulders", guessed)
        if side in verges:
            width = width_of_side(tags, names_of_side("verge", side, ":width"), "verge", findings)
            verge = _known(width, VERGE_WIDTH, "verges", guessed)
        if side in sidewalks:
            sidewalk = _known(_sidewalk_width(tags, side, findings), SIDEWALK_WIDTH, "sidewalks", guessed)
        kerb = kerb_height(tags, side, findings) if (parking or track or sidewalk) else 0.0
        strips = _strips(parking, shoulder, track, verge, sidewalk, kerb)
        found[side] = strips, parking.on_carriageway if parking else 0.0
    if guessed:
        findings.append((Kind.GUESSED, "margin-width", f"no width given, {', '.join(sorted(guessed))} assumed"))
    (left, parking_left), (right, parking_right) = found["left"], found["right"]
    return Margins(_shared(left), _shared(right), parking_left, parking_right)


def with_free_room(margins: Margins, room: tuple[float, float], findings: Findings) -> Margins:
    """Return margins with the room, left and right, m, that cars parked before and behind leave beside a way."""
    left, right = room
    if not left and not right:
        return margins
    places = " and ".join(f"{wide:g} m on the {side}" for wide, side in ((left, "left"), (right, "right")) if wide)
    findings.append((Kind.NOTE, "parking", f"parking pauses: {places} stay free, so that the kerb runs straight on"))
    return Margins(
        _shared(((MarginSpec(LaneType.RESTRICTED, left),) if left else ()) + margins.left),
        _shared(((MarginSpec(LaneType.RESTRICTED, right),) if right else ()) + margins.right),
        margins.parking_left + left,
        margins.parking_right + right,
    )


def with_rest(margins: Margins, rest: float, parks: bool, findings: Findings) -> Margins:
    """Return margins with what lanes leave between the kerbs on either side, m.

    It is for parking where cars park, or may park (`parks`) and fit, else a shoulder.
    """
    if not rest:
        return margins
    kind = LaneType.PARKING if parks and rest >= PARKING_WIDTH_LEAST else LaneType.SHOULDER
    what = f"{'parking' if kind is LaneType.PARKING else 'shoulders'} of {rest:g} m assumed on both sides"
    findings.append((Kind.GUESSED, "margin-width", f"the carriageway is wider than its lanes: {what}"))
    left, right = (_with_first(MarginSpec(kind, rest), strips) for strips in (margins.left, margins.right))
    return Margins(left, right, margins.parking_left + rest, margins.parking_right + rest)


def with_parking(margins: Margins, width: float, why: str, findings: Findings) -> Margins:
    """Return margins with parking of a width, m, next to the lanes on both sides."""
    findings.append((Kind.GUESSED, "parking", f"no parking tagged, {width:g} m of it assumed on both sides {why}"))
    strip = MarginSpec(LaneType.PARKING, width)
    left, right = (_with_first(strip, strips) for strips in (margins.left, margins.right))
    return Margins(left, right, margins.parking_left + width, margins.parking_right + width)


def _with_first(strip: MarginSpec, strips: tuple[MarginSpec, ...]) -> tuple[MarginSpec, ...]:
    """Return the strips of a side with another one next to the lanes; parking there becomes wider instead."""
    if strips and strips[0].type is LaneType.PARKING:
        wider = replace(strips[0], width=round(strips[0].width + strip.width, 3))
        return _shared((wider, *strips[1:]))
    return _shared((strip, *strips))


def tells_of_sidewalks(tags: Tags) -> bool:
    """Whether the tags of a way say anything of people on foot: sidewalks, none, or where else they walk."""
    return not tags.keys().isdisjoint(_ON_FOOT_TAGS)


def tells_of_shoulders(tags: Tags) -> bool:
    """Whether the tags of a way say anything of shoulders."""
    return not tags.keys().isdisjoint(_SHOULDER_TAGS)


def _known(width: float | None, usual: float, what: str, guessed: set[str]) -> float:
    if width is None:
        guessed.add(f"{what} of {usual:g} m")
        return usual
    return width


def _strips(
    parking: Parking | None, shoulder: float, track: Track | None, verge: float, sidewalk: float, kerb: float
) -> tuple[MarginSpec, ...]:
    """Return the strips of a side in their order from the carriageway's edge outwards.

    Widths and the height of the kerb are in m; widths are 0 where there is no such strip.
    """
    strips: list[MarginSpec] = []
    if parking and parking.place in (LANE, HALF_ON_KERB):
        # Parking half on the kerb becomes one strip, level with the carriageway.
        strips.append(MarginSpec(LaneType.PARKING, parking.width))
    if shoulder:
        strips.append(MarginSpec(LaneType.SHOULDER, shoulder))
    if parking and parking.place in (STREET_SIDE, ON_KERB):
        height = kerb if parking.place == ON_KERB else 0.0
        strips.append(MarginSpec(LaneType.PARKING, parking.width, height=height))
    if track:
        height = kerb if track.raised else 0.0
        if gap := verge or track.gap:
            strips.append(MarginSpec(LaneType.BORDER, gap, height=height))
        strips.append(MarginSpec(LaneType.BIKING, track.width, track.runs, height))
        if track.gap_beyond and sidewalk:
            strips.append(MarginSpec(LaneType.BORDER, track.gap_beyond, height=height))
    elif verge:
        strips.append(MarginSpec(LaneType.BORDER, verge, height=kerb if sidewalk else 0.0))
    if sidewalk:
        strips.append(MarginSpec(LaneType.SIDEWALK, sidewalk, height=kerb))
    return tuple(strips)


def _sidewalk_sides(tags: Tags, findings: Findings) -> frozenset[str]:
    """Return the sides of a way with a sidewalk; ``footway=both`` and the like is older tagging (OSM wiki)."""
    sides = sides_of(tags, "sidewalk", "sidewalk", findings)
    if "footway" in tags:
        sides = sides_of({"footway": tags["footway"]}, "footway", "sidewalk", findings) | sides
    return frozenset(side for side, state in sides.items() if state == YES)


def _sidewalk_width(tags: Tags, side: str, findings: Findings) -> float | None:
    """Return the tagged width of the sidewalk on a side, m."""
    names = [name for end in (":width", ":est_width") for name in names_of_side("sidewalk", side, end)]
    old = [name for end in _OLD_WIDTHS for name in names_of_side("footway", side, end)[:2]]
    return width_of_side(tags, (*names, *old), "sidewalk", findings)


def kerb_height(tags: Tags, side: str, findings: Findings) -> float:
    """Return the height of the kerb on a side (``left`` or ``right``) of a way, m; a raised kerb's if untagged.

    What cannot be used is added to `findings`.
    """
    heights = names_of_side("kerb", side, ":height")
    for name in (*heights, *names_of_side("sidewalk", side, ":kerb"), *names_of_side("kerb", side)):
        if name in tags:
            height = parse_length(tags[name]) if name in heights else KERB_HEIGHT.get(tags[name])
            if height is not None and height <= KERB_HEIGHT_MAX:
                return height
            add_once(findings, Kind.DROPPED, "kerb", f"{name}={tags[name]} is not a known kerb and is ignored")
    return KERB_HEIGHT["raised"]


@lru_cache(maxsize=4096)
def _shared(strips: tuple[MarginSpec, ...]) -> tuple[MarginSpec, ...]:
    """Return one shared tuple for all equal ones, to save memory."""
    return strips


@lru_cache(maxsize=4096)
def seen_backwards(strips: tuple[MarginSpec, ...]) -> tuple[MarginSpec, ...]:
    """Return the strips of a side as seen against the way: they keep their order from the edge outwards."""
    return tuple(replace(strip, direction=Direction(-strip.direction)) for strip in strips)


@record
class Parking:
    """Parking on one side of a way."""

    place: str  # `LANE`, `HALF_ON_KERB`, `ON_KERB`, `STREET_SIDE` or `SHOULDER`
    width: float  # Of the strip, m
    given: bool  # Whether OSM gives the width

    @property
    def on_carriageway(self) -> float:
        """How much of the strip is part of the carriageway that ``width`` measures, m."""
        return self.width * {LANE: 1.0, HALF_ON_KERB: 0.5}.get(self.place, 0.0)


def read_parking(tags: Tags, side: str, findings: Findings) -> Parking | None:
    """Return the parking on a side (``left`` or ``right``) of a way; None if there is none.

    Findings that concern both sides are added once.
    """
    new = _newer(tags, side, findings)
    old = _older(tags, side, findings)
    if new is None and old is None:
        return None
    if new is not None and old is not None and (new[0] == "") != (old[0] == ""):
        words = "parking:lane contradicts the newer tags of parking, which are taken"
        add_once(findings, Kind.REPAIRED, _PARKING_CODE, words)
    place, orientation = new or old or ("", "")
    if not place:
        return None
    if new and not orientation and old:
        orientation = old[1]
    if not orientation:
        add_once(findings, Kind.GUESSED, _PARKING_CODE, "no orientation of parking given, parallel assumed")
    keys = [f"{key}:{name}:width" for key in (_NEW, _OLD) for name in (side, "both")]
    width = width_of_side(tags, keys, _PARKING_CODE, findings)
    return Parking(place, width or PARKING_WIDTH[orientation or "parallel"], width is not None)


def _newer(tags: Tags, side: str, findings: Findings) -> tuple[str, str] | None:
    """Return place and orientation in the newer scheme, "" for none; None where it is not used."""
    for name in (f"{_NEW}:{side}", f"{_NEW}:both"):
        value = _first(tags, name, (*_PLACES, *_NO_PARKING, "yes"), findings)
        if value is None:
            continue
        if value in _NO_PARKING:
            return "", ""
        if value == "yes":
            words = f"{name}=yes does not say where cars stand, on the carriageway assumed"
            add_once(findings, Kind.GUESSED, _PARKING_CODE, words)
        names = (f"{_NEW}:{side}:orientation", f"{_NEW}:both:orientation")
        orientation = next((found for key in names if (found := _first(tags, key, _ORIENTATIONS, findings))), "")
        return _PLACES.get(value, LANE), _ORIENTATIONS.get(orientation, "")
    return None


def _older(tags: Tags, side: str, findings: Findings) -> tuple[str, str] | None:
    """Return place and orientation in the older scheme, "" for none; None where it is not used."""
    for name in (f"{_OLD}:{side}", f"{_OLD}:both"):
        value = _first(tags, name, (*_ORIENTATIONS, *_NO_PARKING, *_UNORIENTED), findings)
        if value is None:
            continue
        if value in _NO_PARKING:
            return "", ""
        names = (f"{_OLD}:{side}:{value}", f"{_OLD}:both:{value}")
        place = next((found for key in names if (found := _first(tags, key, _PLACES, findings))), "lane")
        return _PLACES[place], _ORIENTATIONS.get(value, "")
    return None


def _first(tags: Tags, name: str, known: Sequence[str] | dict[str, str], findings: Findings) -> str | None:
    """Return the value of a tag, of several the first known one; None if there is none."""
    text = tags.get(name)
    if text is None:
        return None
    value = next((part.strip() for part in text.split(";") if part.strip() in known), None)
    if value is None:
        add_once(findings, Kind.DROPPED, _PARKING_CODE, f"{name}={text} is not known and is ignored")
    elif value != text:
        add_once(findings, Kind.GUESSED, _PARKING_CODE, f"{name}={text} taken for {value}")
    return value
