"""Traffic signs on nodes and ways (OSM wiki, Key:traffic_sign). Pure functions."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import lru_cache
from typing import Final

from osm2xodr.conventions import find_country, is_supplementary, sign_meaning, sign_meanings
from osm2xodr.model import Facing, FacingSigns, Sign, SignFace, SignPost, StreetAttributes
from osm2xodr.osmParsing.tags.values import Tags

SIGN_KEYS: Final = ("traffic_sign", "traffic_sign:forward", "traffic_sign:backward", "traffic_sign:both")
_ALONG: Final = {"forward": True, "backward": False}
_DEGREES: Final = re.compile(r"\d+(?:\.\d+)?")
_COMPASS_POINTS: Final = (
    *("N", "NNE", "NE", "ENE", "E", "ESE", "SE", "SSE"),
    *("S", "SSW", "SW", "WSW", "W", "WNW", "NW", "NNW"),
)

# OSM's words whose meaning has another name in the table of codes.
_WORDS: Final = {
    **{f"max{what}": f"max_{what}" for what in ("height", "width", "length", "weight")},
    **dict.fromkeys(("yield", "giveway"), "give_way"),
    **dict.fromkeys(("pedestrian_crossing", "crossing"), "crosswalk"),
    **dict.fromkeys(("speed_limit", "max_speed"), "maxspeed"),
    "maxaxleload": "max_axle_load",
    "overtaking": "no_overtaking",
    "oneway": "one_way",
    "traffic_signals": "signals_ahead",
    "school": "children",
    "noexit": "dead_end",
    "city_limit_begin": "city_limit",
}
# Values of ``hazard`` (OSM wiki, Key:hazard).
_HAZARDS: Final = {
    **dict.fromkeys(("animal_crossing", "animals", "wild_animals", "deer"), "animals"),
    **dict.fromkeys(("bump", "dip", "bumps"), "bumps"),
    **dict.fromkeys(("children", "school_zone"), "children"),
    **dict.fromkeys(("cyclists", "bicycles"), "bicycles"),
    **dict.fromkeys(("narrow", "road_narrows"), "road_narrows"),
    **dict.fromkeys(("slippery", "slippery_road"), "slippery"),
    "pedestrians": "pedestrians",
    "queues_likely": "queues",
    "side_winds": "side_wind",
    "traffic_signals": "signals_ahead",
}
# Words that do not say which sign it is, or that it does not regulate traffic.
_VAGUE: Final = frozenset({"", "yes", "no", "none", "variable", "information", "street_name_sign", "id", "unknown"})
# The tag with the number on a sign, and the unit of numbers without one, by meaning; empty for that of speed limits.
_VALUE_TAGS: Final = {
    **dict.fromkeys(("maxspeed", "maxspeed_zone"), ("maxspeed", "")),
    "minspeed": ("minspeed", ""),
    "advisory_speed": ("maxspeed:advisory", ""),
    **{f"max_{what}": (f"max{what}", "m") for what in ("height", "width", "length")},
    "max_weight": ("maxweight", "t"),
    "max_axle_load": ("maxaxleload", "t"),
}
# Meanings of signs with a speed.
_SPEEDS: Final = frozenset(
    f"{kind}{end}" for kind in ("maxspeed", "maxspeed_zone", "minspeed", "advisory_speed") for end in ("", "_end")
)
_ITEM: Final = re.compile(r"\s*(?:([A-Za-z]{2})(?:-[A-Za-z]{1,3})?\s*:)?\s*(.*?)\s*", re.DOTALL)
_IN_BRACKETS: Final = re.compile(r"([^\[\]]*?)\s*\[(.*)\]")
_NUMBER: Final = re.compile(r"(\d+(?:[.,]\d+)?)\s*(mph|km/h|kmh|t|m)?")


def read_facing(text: str, *, compass_points: bool = False) -> Facing:
    """Read a value of ``direction``: ``forward``, ``backward``, ``both``, degrees, or compass points if wanted."""
    place = text.strip().upper() if compass_points else text
    azimuth = float(place) if _DEGREES.fullmatch(place) else None
    if compass_points and place in _COMPASS_POINTS:
        azimuth = _COMPASS_POINTS.index(place) * 360.0 / len(_COMPASS_POINTS)
    return Facing(_ALONG.get(text), text == "both", azimuth)


def read_sign_post(tags: Tags, country: str) -> SignPost:
    """Read all signs of a node in a country (ISO 3166-1 alpha-2)."""
    highway = tags.get("highway", "")
    return SignPost(
        tuple(
            FacingSigns(read_facing(word, compass_points=True), read_faces(text, tags, country, word))
            for word, text in directed_values(tags)
        ),
        read_facing(_direction(tags), compass_points=True),
        Sign(highway) if highway in ("stop", "give_way") else None,
        tags.get("city_limit", ""),
    )


def with_speed_zones(attributes: Sequence[StreetAttributes], country: str) -> list[StreetAttributes]:
    """Mark the ways whose traffic signs say that their limit is that of a zone."""
    return [replace(item, speed_zone=True) if _is_zone(item.traffic_sign, country) else item for item in attributes]


@lru_cache(maxsize=1024)
def _is_zone(text: str, country: str) -> bool:
    return bool(text) and any(face.meaning == "maxspeed_zone" for face in read_faces(text, {}, country))


def _direction(tags: Tags) -> str:
    return tags.get("traffic_sign:direction") or tags.get("direction", "")


def directed_values(tags: Tags) -> Iterator[tuple[str, str]]:
    """Yield (direction, empty where unknown, and value) of each tag that names signs."""
    for key in SIGN_KEYS:
        if key in tags:
            yield _direction(tags) if key == "traffic_sign" else key.removeprefix("traffic_sign:"), tags[key]


def read_faces(text: str, tags: Tags, country: str, direction: str = "") -> tuple[SignFace, ...]:
    """Read a value of ``traffic_sign``; empty where it names no sign.

    Commas separate signs on one pole, semicolons those that stand apart; a country's prefix holds for what follows.
    All tags of the node say what is written on the signs, those for the direction of the value first.
    """
    out: list[SignFace] = []
    owner = ""
    for group in _split(text, ";"):
        for place, item in enumerate(_split(group, ",")):
            found = _ITEM.fullmatch(item)
            if found is None or found[2].lower() in _VAGUE:
                continue
            owner = (found[1] or owner).upper()
            face = _face(found[2], owner, country, first=place == 0)
            out.append(_completed(face, tags, country, direction))
    return tuple(out)


def _split(text: str, mark: str) -> list[str]:
    """Split at a mark outside quotes and brackets."""
    out, depth, quoted = [""], 0, False
    for sign in text:
        quoted ^= sign == '"'
        depth += (sign == "[") - (sign == "]")
        if sign == mark and not quoted and depth <= 0:
            out.append("")
        else:
            out[-1] += sign
    return out


def _face(text: str, owner: str, country: str, *, first: bool) -> SignFace:
    if text.startswith('"'):
        return SignFace("", text=text.strip('"'), supplementary=not first)
    bracket = _IN_BRACKETS.fullmatch(text)
    name, written = (bracket[1], bracket[2]) if bracket else (text, "")
    word = name.lower().replace(" ", "_")
    word = _WORDS.get(word, word)
    if not owner and word in sign_meanings():
        value, unit, rest = _read_value(written)
        return SignFace(word, value=value, unit=unit, text=rest)
    of_whom = owner or country
    meaning, value = sign_meaning(of_whom, name)
    if not owner and not meaning:
        return SignFace("", text=name, supplementary=not first)
    in_bracket, unit, rest = _read_value(written)
    value = value if in_bracket is None else in_bracket
    adds = not meaning and is_supplementary(of_whom, name)
    return SignFace(meaning, of_whom, name, value, unit, rest, adds)


def _read_value(text: str) -> tuple[float | None, str, str]:
    """Read what is in brackets: a number and its unit, or else text."""
    found = _NUMBER.fullmatch(text.strip().lower())
    if found is None:
        return None, "", text.strip().strip('"')
    return float(found[1].replace(",", ".")), (found[2] or "").replace("kmh", "km/h"), ""


def _completed(face: SignFace, tags: Tags, country: str, direction: str) -> SignFace:
    """Add what other tags say: the number on the sign, its unit, the name of the town, the kind of hazard."""
    meaning, value, unit, text = face.meaning, face.value, face.unit, face.text
    if meaning == "hazard":
        meaning = _HAZARDS.get(tags.get("hazard", ""), meaning)
    key, usual = _VALUE_TAGS.get(meaning, ("", ""))
    if value is None and key:
        value, unit, _ = _read_value(tags.get(f"{key}:{direction}") or tags.get(key, ""))
    if value is not None and not unit:
        unit = find_country(face.country or country).speed_unit if meaning in _SPEEDS else usual
    if meaning in ("city_limit", "city_limit_end"):
        text = text or tags.get("name", "")
    return SignFace(meaning, face.country, face.code, value, unit, text, face.supplementary)
