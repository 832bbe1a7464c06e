"""Untagged speed limits: what the law says for the kind of road, or for the built-up area that a way lies in."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Final

from osm2xodr.conventions import SPEED_UNITS, Country
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.model import LaneType, Street, StreetAttributes
from osm2xodr.osmParsing.defaults import TOWN_SPEED_MAX_KMH
from osm2xodr.osmParsing.tags.values import Tags, parse_speed

# Tags that show a built-up area: street lamps and sidewalks.
_SIDEWALK_TAGS: Final = ("sidewalk", "sidewalk:both", "sidewalk:left", "sidewalk:right")
EVIDENCE_TAGS: Final = ("lit", *_SIDEWALK_TAGS)
_UNLIT: Final = frozenset({"no", "disused", "limited"})
_NO_SIDEWALK: Final = frozenset({"no", "none"})
# The law's kinds of roads by highway value, the most specific first; residential streets are in built-up areas.
_BY_CLASS: Final[Mapping[str, tuple[str, ...]]] = {
    "motorway": ("motorway",),
    "living_street": ("living_street",),
    "residential": ("residential", "urban"),
}
# Roads with the limit of built-up areas where there are street lamps or sidewalks: not roads built for speed, whose
# junctions are lit anywhere, nor service roads and tracks, on which nobody drives as fast.
_MAY_BE_URBAN: Final = frozenset(
    f"{name}{link}" for name in ("primary", "secondary", "tertiary") for link in ("", "_link")
) | {"unclassified", "road", "busway"}

# Tags whose values, such as ``DE:urban``, say where a way is, the surest first (OSM wiki, Key:source:maxspeed).
_PLACE_TAGS: Final = ("zone:traffic", "maxspeed:type", "source:maxspeed", "zone:maxspeed", "maxspeed")
_URBAN: Final = re.compile(r"[A-Z-]+:\s*(urban|nsl_restricted|(zone:?)?\d+$|living_street)|zone", re.IGNORECASE)
_RURAL: Final = re.compile(r"[A-Z-]+:\s*(rural|trunk|motorway|motorroad|nsl_single|nsl_dual)", re.IGNORECASE)
BUILT_UP_TAGS: Final = (*_PLACE_TAGS, *EVIDENCE_TAGS, "motorroad")


def legal_speed(tags: Tags, country: Country) -> float | None:
    """Return the legal limit of a way without a tagged one, m/s.

    Infinity where there is none; None where the kind of road cannot be determined or the law is not known.
    """
    highway = tags["highway"]
    if not country.speeds:
        return None
    kinds = _BY_CLASS.get(highway)
    if kinds is None:
        return country.speeds.get("urban") if highway in _MAY_BE_URBAN and is_built_up(tags) else None
    return next((country.speeds[kind] for kind in kinds if kind in country.speeds), None)


def speed_guess(speed: float, country: Country) -> str:
    """Describe a limit (m/s) taken from the law, for diagnostics."""
    return f"no limit given, taken from the law of {country.code}: {limit_words(speed, country)}"


def limit_words(speed: float, country: Country) -> str:
    """Return a limit, m/s, as signs of a country have it."""
    return "none" if math.isinf(speed) else f"{speed / SPEED_UNITS[country.speed_unit]:.0f} {country.speed_unit}"


def with_urban_speeds(
    streets: Sequence[Street], tags: Mapping[int, Tags], country: Country, diagnostics: Diagnostics
) -> tuple[Street, ...]:
    """Give the limit of built-up areas to pieces of streets whose surroundings show that they lie in one.

    The evidence is a sidewalk mapped apart from the street, or an adjacent piece of the same street that lies in a
    built-up area, so that a street's limit does not come and go with the tags of its pieces. `tags` are those of ways
    by id; the diagnostics get each way that is given a limit.
    """
    urban = country.speeds.get("urban")
    if urban is None:
        return tuple(streets)
    changed: set[int] = set()
    out: list[Street] = []
    for street in streets:
        pieces = [attributes for _, attributes in street.pieces]
        open_pieces = [k for k, piece in enumerate(pieces) if _lacks_limit(piece)]
        if open_pieces:
            found = _urban_pieces(pieces, open_pieces, tags, country)
            if found:
                with_speed = [
                    (first, replace(piece, speed_forward=urban, speed_backward=urban) if k in found else piece)
                    for k, (first, piece) in enumerate(street.pieces)
                ]
                street = replace(street, pieces=tuple(with_speed))
                changed.update(pieces[k].osm_way_id for k in found)
        out.append(street)
    for way in sorted(changed):
        diagnostics.guessed("speed", f"way/{way}", speed_guess(urban, country))
    return tuple(out)


def _lacks_limit(piece: StreetAttributes) -> bool:
    """Whether a piece has no limit yet and may get that of built-up areas."""
    return piece.speed_forward is None and piece.speed_backward is None and piece.highway in _MAY_BE_URBAN


def _urban_pieces(
    pieces: Sequence[StreetAttributes],
    open_pieces: Sequence[int],
    tags: Mapping[int, Tags],
    country: Country,
) -> set[int]:
    """Return which of the pieces without a limit lie in a built-up area."""
    margins = {k: (*pieces[k].margin_left, *pieces[k].margin_right) for k in open_pieces}
    found = {k for k, strips in margins.items() if any(strip.type is LaneType.SIDEWALK for strip in strips)}
    if len(pieces) == 1:
        return found
    urban = {
        k
        for k, piece in enumerate(pieces)
        if piece.highway in _MAY_BE_URBAN and not _lacks_limit(piece) and not piece.speed_signed
        if legal_speed(tags[piece.osm_way_id], country) == piece.speed_forward == piece.speed_backward
    }
    for order in (open_pieces, open_pieces[::-1]):
        for k in order:
            if not {k - 1, k + 1}.isdisjoint(urban | found):
                found.add(k)
    return found


def is_built_up(tags: Tags) -> bool:
    """Whether a way has street lamps or a sidewalk."""
    has_sidewalk = any(key in tags and tags[key] not in _NO_SIDEWALK for key in _SIDEWALK_TAGS)
    return has_sidewalk or tags.get("lit", "no") not in _UNLIT


def in_town(tags: Tags, dense: bool) -> bool:
    """Whether a way lies in a built-up area: as tagged, else where there are lamps, sidewalks or dwellings.

    `dense` says whether residential streets lie densely around it.
    """
    for key in _PLACE_TAGS:
        if key in tags and (_URBAN.match(tags[key]) or _RURAL.match(tags[key])):
            return bool(_URBAN.match(tags[key]))
    if tags.get("motorroad") == "yes":
        return False
    return is_built_up(tags) or dense


def is_town_street(tags: Tags, dense: bool) -> bool:
    """Whether a way has the lanes of a street in town: by its limit, else by where it lies."""
    if tags["highway"].startswith("motorway") or tags.get("motorroad") == "yes":
        return False
    speed = parse_speed(tags.get("maxspeed", ""))
    return in_town(tags, dense) if speed is None else speed <= TOWN_SPEED_MAX_KMH / 3.6
