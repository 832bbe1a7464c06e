"""Bicycle tracks beside a road, from its own tags (``cycleway=track``); bicycle lanes are in `beside_lanes`.

Tracks mapped as ways of their own (``separate``) are handled in `osm2xodr.osmParsing.roadside`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from osm2xodr.diagnostics import Kind
from osm2xodr.model import Direction, Rule
from osm2xodr.osmParsing.defaults import (
    CYCLE_TRACK_GAP,
    CYCLE_TRACK_GAP_PARKING,
    CYCLE_TRACK_WIDTH,
    CYCLE_TRACK_WIDTH_BOTH,
    MARGIN_WIDTH_MAX,
)
from osm2xodr.osmParsing.tags.access import NO_VALUES
from osm2xodr.osmParsing.tags.beside_lanes import REVERSE, near_side, side_value
from osm2xodr.osmParsing.tags.sides import LEFT_RIGHT, SIDE_KEYS, keys_of_sides, names_of_side, width_of_side
from osm2xodr.osmParsing.tags.values import Findings, Tags, add_once, parse_length

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
_CODE: Final = "cycle-track"


@dataclass(frozen=True, slots=True)
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
            findings.append((Kind.DROPPED, _CODE, f"cycleway{key}={value} is not known and is ignored"))


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
        add_once(findings, Kind.DROPPED, _CODE, f"{key}={value} on a two-way road is ignored")
        return None
    runs = _runs(tags, side, direction, own, value, key)
    width_keys = [name for end in (":width", ":est_width") for name in names_of_side("cycleway", side, end)]
    width = width_of_side(tags, width_keys, _CODE, findings)
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
            findings.append((Kind.DROPPED, _CODE, f"{name}{end}={text} is not the width of a strip and is ignored"))
    return None


def _level(tags: Tags, side: str, inner: str) -> bool:
    """Whether a track is level with the carriageway, only separated by something that stands there."""
    separations = names_of_side("cycleway", side, ":separation")
    names = (f"{name}{end}" for name in separations for end in (f":{inner}", ":both", ""))
    parts = {part.strip() for part in next((tags[name] for name in names if name in tags), "").split(";")}
    return bool(parts & _ON_CARRIAGEWAY) and "kerb" not in parts
