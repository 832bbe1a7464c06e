"""Sidewalks, verges and kerbs that tags of a road name.

Sidewalks that OSM maps as ways of their own (``separate``) are not made here.
"""

from __future__ import annotations

from typing import Final

from osm2xodr.defaults import KERB_HEIGHT, KERB_HEIGHT_MAX
from osm2xodr.diagnostics import Kind
from osm2xodr.osmParsing.tags.lane_lists import Findings
from osm2xodr.osmParsing.tags.sides import SIDE_KEYS, YES, Tags, keys_of_sides, names_of_side, sides_of, width_of_side
from osm2xodr.osmParsing.tags.values import parse_length

# The second is a slip that is in use.
_OLD_WIDTHS: Final = (":width", ".width")
KERB_TAGS: Final = (*keys_of_sides("kerb", "", ":height"), *(f"sidewalk{side}:kerb" for side in SIDE_KEYS))
SIDEWALK_TAGS: Final = (
    *keys_of_sides("sidewalk", "", ":width", ":est_width"),
    *keys_of_sides("verge", "", ":width"),
    *("footway", *(f"footway:{side}{end}" for side in ("left", "right", "both") for end in _OLD_WIDTHS)),
)
_SIDEWALK: Final = "sidewalk"
_VERGE: Final = "verge"
_KERB: Final = "kerb"


def sidewalk_sides(tags: Tags, findings: Findings) -> frozenset[str]:
    """Return the sides of a way that have a sidewalk of its own.

    ``footway=both`` and the like is the old way of writing ``sidewalk`` (OSM wiki, Key:footway).
    """
    sides = sides_of(tags, "sidewalk", _SIDEWALK, findings)
    if "footway" in tags:
        sides = sides_of({"footway": tags["footway"]}, "footway", _SIDEWALK, findings) | sides
    return frozenset(side for side, state in sides.items() if state == YES)


def sidewalk_width(tags: Tags, side: str, findings: Findings) -> float | None:
    """Return the width that tags give the sidewalk on a side, m."""
    names = [name for end in (":width", ":est_width") for name in names_of_side("sidewalk", side, end)]
    old = [name for end in _OLD_WIDTHS for name in names_of_side("footway", side, end)[:2]]
    return width_of_side(tags, (*names, *old), _SIDEWALK, findings)


def verge_sides(tags: Tags, findings: Findings) -> frozenset[str]:
    """Return the sides of a way that have a verge."""
    sides = sides_of(tags, "verge", _VERGE, findings)
    return frozenset(side for side, state in sides.items() if state == YES)


def verge_width(tags: Tags, side: str, findings: Findings) -> float | None:
    """Return the width that tags give the verge on a side, m."""
    return width_of_side(tags, names_of_side("verge", side, ":width"), _VERGE, findings)


def kerb_height(tags: Tags, side: str, findings: Findings) -> float:
    """Return how high the kerb on a side is, m; that of a raised one where tags do not say."""
    for name in names_of_side("kerb", side, ":height"):
        if name in tags:
            height = parse_length(tags[name])
            if height is not None and height <= KERB_HEIGHT_MAX:
                return height
            _ignored(name, tags[name], findings)
    for name in (*names_of_side("sidewalk", side, ":kerb"), *names_of_side("kerb", side)):
        if name in tags:
            height = KERB_HEIGHT.get(tags[name])
            if height is not None:
                return height
            _ignored(name, tags[name], findings)
    return KERB_HEIGHT["raised"]


def _ignored(name: str, value: str, findings: Findings) -> None:
    said = (Kind.DROPPED, _KERB, f"{name}={value} is no kerb that is known and is ignored")
    if said not in findings:
        findings.append(said)
