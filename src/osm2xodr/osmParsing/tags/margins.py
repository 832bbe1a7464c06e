"""What lies beside a road's carriageway as its tags say: parking, shoulders, bicycle tracks, verges, sidewalks.

From the carriageway's edge outwards: cars that park on it, the shoulder, cars that park beyond it, a strip and the
bicycle track, a verge, the sidewalk. A verge takes the place of the strip before a track.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Final

from osm2xodr.diagnostics import Kind
from osm2xodr.model import Direction, LaneType, MarginSpec, Rule
from osm2xodr.osmParsing.defaults import SHOULDER_WIDTH, SHOULDER_WIDTH_OTHER, SIDEWALK_WIDTH, VERGE_WIDTH
from osm2xodr.osmParsing.tags.beside_lanes import CYCLE_TAGS, near_side
from osm2xodr.osmParsing.tags.cycle_tracks import TRACK_TAGS, Track, read_track, unknown_cycleways
from osm2xodr.osmParsing.tags.lane_lists import Findings
from osm2xodr.osmParsing.tags.parking import (
    HALF_ON_KERB,
    LANE,
    ON_KERB,
    PARKING_TAGS,
    SHOULDER,
    STREET_SIDE,
    Parking,
    read_parking,
)
from osm2xodr.osmParsing.tags.sides import LEFT_RIGHT, YES, keys_of_sides, names_of_side, sides_of, width_of_side
from osm2xodr.osmParsing.tags.sidewalks import (
    KERB_TAGS,
    SIDEWALK_TAGS,
    kerb_height,
    sidewalk_sides,
    sidewalk_width,
    verge_sides,
    verge_width,
)

_SHOULDER_TAGS: Final = keys_of_sides("shoulder", "", ":width")
# All tags that this module and those below it look at.
MARGIN_TAGS: Final = (*SIDEWALK_TAGS, *KERB_TAGS, *PARKING_TAGS, *CYCLE_TAGS, *TRACK_TAGS, *_SHOULDER_TAGS)
# Ways without any of these have nothing beside them; the other tags only say how it is.
_MAKERS: Final = frozenset(
    {
        *(key for name in ("sidewalk", "verge", "shoulder", "cycleway") for key in keys_of_sides(name, "")),
        *("footway", *(f"{key}:{side}" for key in ("parking", "parking:lane") for side in (*LEFT_RIGHT, "both"))),
    }
)


@dataclass(frozen=True, slots=True)
class Margins:
    """What lies beside a carriageway, left and right seen along the way."""

    # From the carriageway's edge outwards
    left: tuple[MarginSpec, ...] = ()
    right: tuple[MarginSpec, ...] = ()
    # How much of that is part of the carriageway where OSM gives its width, m
    parking_left: float = 0.0
    parking_right: float = 0.0


NOTHING: Final = Margins()


@dataclass(frozen=True, slots=True)
class _Side:
    """What one side of a way has."""

    parking: Parking | None
    shoulder: float | None
    track: Track | None
    verge: float | None
    sidewalk: float | None
    kerb: float


def read_margins(tags: Mapping[str, str], direction: int, rule: Rule, findings: Findings) -> Margins:
    """Read what lies beside a way's carriageway.

    Parameters
    ----------
    tags
        Of the way: ``highway`` and those of `MARGIN_TAGS` that it has.
    direction
        1 or -1 if it is one-way for cars along or against its order of nodes, else 0.
    rule
        The side that traffic drives on.
    findings
        What was guessed, mended or ignored is added.
    """
    if _MAKERS.isdisjoint(tags):
        return NOTHING
    unknown_cycleways(tags, findings)
    sidewalks, verges = sidewalk_sides(tags, findings), verge_sides(tags, findings)
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
        shoulder = verge = sidewalk = None
        if has_shoulder:
            usual = SHOULDER_WIDTH.get(tags["highway"], SHOULDER_WIDTH_OTHER)
            names = names_of_side("shoulder", side, ":width")
            shoulder = _known(width_of_side(tags, names, "shoulder", findings), usual, "shoulders", guessed)
        if side in verges:
            verge = _known(verge_width(tags, side, findings), VERGE_WIDTH, "verges", guessed)
        if side in sidewalks:
            sidewalk = _known(sidewalk_width(tags, side, findings), SIDEWALK_WIDTH, "sidewalks", guessed)
        kerb = kerb_height(tags, side, findings) if (parking or track or sidewalk) else 0.0
        strips = _strips(_Side(parking, shoulder, track, verge, sidewalk, kerb))
        found[side] = strips, parking.on_carriageway if parking else 0.0
    if guessed:
        findings.append((Kind.GUESSED, "margin-width", f"no width given, {', '.join(sorted(guessed))} assumed"))
    (left, parking_left), (right, parking_right) = found["left"], found["right"]
    return Margins(_shared(left), _shared(right), parking_left, parking_right)


def _known(width: float | None, usual: float, what: str, guessed: set[str]) -> float:
    if width is None:
        guessed.add(f"{what} of {usual:g} m")
        return usual
    return width


def _strips(side: _Side) -> tuple[MarginSpec, ...]:
    """Put what a side has into its order from the carriageway's edge outwards."""
    strips: list[MarginSpec] = []
    parking, kerb = side.parking, side.kerb
    if parking and parking.place in (LANE, HALF_ON_KERB):
        # Of cars that stand half on the kerb one strip is made, as high as the carriageway.
        strips.append(MarginSpec(LaneType.PARKING, parking.width))
    if side.shoulder is not None:
        strips.append(MarginSpec(LaneType.SHOULDER, side.shoulder))
    if parking and parking.place in (STREET_SIDE, ON_KERB):
        height = kerb if parking.place == ON_KERB else 0.0
        strips.append(MarginSpec(LaneType.PARKING, parking.width, height=height))
    track = side.track
    if track:
        height = kerb if track.raised else 0.0
        gap = track.gap if side.verge is None else side.verge
        if gap > 0.0:
            strips.append(MarginSpec(LaneType.BORDER, gap, height=height))
        strips.append(MarginSpec(LaneType.BIKING, track.width, track.runs, height))
        if track.gap_beyond > 0.0 and side.sidewalk is not None:
            strips.append(MarginSpec(LaneType.BORDER, track.gap_beyond, height=height))
    elif side.verge is not None:
        strips.append(MarginSpec(LaneType.BORDER, side.verge, height=kerb if side.sidewalk is not None else 0.0))
    if side.sidewalk is not None:
        strips.append(MarginSpec(LaneType.SIDEWALK, side.sidewalk, height=kerb))
    return tuple(strips)


@lru_cache(maxsize=4096)
def _shared(strips: tuple[MarginSpec, ...]) -> tuple[MarginSpec, ...]:
    """Return one and the same tuple for all equal ones."""
    return strips


@lru_cache(maxsize=4096)
def seen_backwards(strips: tuple[MarginSpec, ...]) -> tuple[MarginSpec, ...]:
    """Return what lies on a side as it is seen against the way: the order from the edge outwards stays."""
    return tuple(replace(strip, direction=Direction(-strip.direction)) for strip in strips)
