"""What the tags of a node say about the traffic signs there (OSM wiki, Key:traffic_sign)."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Final

from osm2xodr.conventions import find_country
from osm2xodr.furniture.signs.codes import is_supplementary, meaning_of, meanings

# Words of OSM for which this package has another.
_WORDS: Final = {
    "yield": "give_way",
    "giveway": "give_way",
    "overtaking": "no_overtaking",
    "maxheight": "max_height",
    "maxwidth": "max_width",
    "maxlength": "max_length",
    "maxweight": "max_weight",
    "maxaxleload": "max_axle_load",
    "oneway": "one_way",
    "pedestrian_crossing": "crosswalk",
    "crossing": "crosswalk",
    "traffic_signals": "signals_ahead",
    "school": "children",
    "speed_limit": "maxspeed",
    "max_speed": "maxspeed",
    "noexit": "dead_end",
    "city_limit_begin": "city_limit",
}
# Values of ``hazard`` (OSM wiki, Key:hazard).
_HAZARDS: Final = {
    "animal_crossing": "animals",
    "animals": "animals",
    "wild_animals": "animals",
    "deer": "animals",
    "bump": "bumps",
    "dip": "bumps",
    "bumps": "bumps",
    "children": "children",
    "school_zone": "children",
    "cyclists": "bicycles",
    "bicycles": "bicycles",
    "pedestrians": "pedestrians",
    "narrow": "road_narrows",
    "road_narrows": "road_narrows",
    "queues_likely": "queues",
    "slippery": "slippery",
    "slippery_road": "slippery",
    "side_winds": "side_wind",
    "traffic_signals": "signals_ahead",
}
# Words that say that there is a sign, but not which, or that it is none that rules traffic.
_VAGUE: Final = frozenset({"", "yes", "no", "none", "variable", "information", "street_name_sign", "id", "unknown"})
# Tags that hold the number on a sign, and its unit unless they say.
_VALUE_TAGS: Final = {
    "maxspeed": ("maxspeed", ""),
    "maxspeed_zone": ("maxspeed", ""),
    "minspeed": ("minspeed", ""),
    "advisory_speed": ("maxspeed:advisory", ""),
    "max_height": ("maxheight", "m"),
    "max_width": ("maxwidth", "m"),
    "max_length": ("maxlength", "m"),
    "max_weight": ("maxweight", "t"),
    "max_axle_load": ("maxaxleload", "t"),
}
SPEEDS: Final = frozenset(
    {
        "maxspeed",
        "maxspeed_end",
        "maxspeed_zone",
        "maxspeed_zone_end",
        "minspeed",
        "minspeed_end",
        "advisory_speed",
        "advisory_speed_end",
    }
)
_ITEM: Final = re.compile(r"\s*(?:([A-Za-z]{2})(?:-[A-Za-z]{1,3})?\s*:)?\s*(.*?)\s*", re.DOTALL)
_IN_BRACKETS: Final = re.compile(r"([^\[\]]*?)\s*\[(.*)\]")
_NUMBER: Final = re.compile(r"(\d+(?:[.,]\d+)?)\s*(mph|km/h|kmh|t|m)?")


@dataclass(frozen=True, slots=True)
class SignFace:
    """One sign or plate."""

    meaning: str  # In this package's words; empty where it is not known
    # As tagged; empty where OSM says it in words
    country: str = ""
    code: str = ""
    # What is written on it: a speed, a height …; None and empty where nothing is
    value: float | None = None
    unit: str = ""
    text: str = ""  # Further words on it
    supplementary: bool = False  # Whether it adds to the sign above it
    osm_id: str = ""  # What it comes from, where that is not what its pole comes from


# Units of speed limits, each per m/s.
IN_UNIT: Final = {"km/h": 3.6, "mph": 1.0 / 0.44704}
# Limits are one up to this, m/s: rounding of a unit.
SAME_LIMIT: Final = 0.1


def speed_unit(country: str) -> str:
    """Return the unit of speed limits in a country."""
    return find_country(country).speed_unit


def directed_values(tags: Mapping[str, str]) -> Iterator[tuple[str, str]]:
    """Yield what each of the tags about signs says: the direction it is for (empty for unknown), and its value."""
    if "traffic_sign" in tags:
        yield tags.get("traffic_sign:direction") or tags.get("direction", ""), tags["traffic_sign"]
    for word in ("forward", "backward", "both"):
        if f"traffic_sign:{word}" in tags:
            yield word, tags[f"traffic_sign:{word}"]


def read_faces(text: str, tags: Mapping[str, str], country: str, direction: str = "") -> tuple[SignFace, ...]:
    """Read a value of ``traffic_sign``; empty where it names no sign.

    Signs on one pole are separated by commas, those that stand apart by semicolons; a country holds for what follows.

    Parameters
    ----------
    text
        The value.
    tags
        All tags of the node, for what is written on the signs.
    country
        Where it stands.
    direction
        The direction that the value is for, ``forward`` or ``backward``; tags for it go first.
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
    if not owner and word in meanings():
        value, unit, rest = _read_value(written)
        return SignFace(word, value=value, unit=unit, text=rest)
    of_whom = owner or country
    meaning, value = meaning_of(of_whom, name)
    if not owner and not meaning:
        return SignFace("", text=name, supplementary=not first)
    in_bracket, unit, rest = _read_value(written)
    value = value if in_bracket is None else in_bracket
    adds = not meaning and is_supplementary(of_whom, name)
    return SignFace(meaning, of_whom, name, value, unit, rest, adds)


def _read_value(text: str) -> tuple[float | None, str, str]:
    """Read what is in brackets: a number, its unit, and what is no number."""
    found = _NUMBER.fullmatch(text.strip().lower())
    if found is None:
        return None, "", text.strip().strip('"')
    return float(found[1].replace(",", ".")), (found[2] or "").replace("kmh", "km/h"), ""


def _completed(face: SignFace, tags: Mapping[str, str], country: str, direction: str) -> SignFace:
    """Add what other tags say: the number on the sign, its unit, the town's name, which danger."""
    meaning, value, unit, text = face.meaning, face.value, face.unit, face.text
    if meaning == "hazard":
        meaning = _HAZARDS.get(tags.get("hazard", ""), meaning)
    key, usual = _VALUE_TAGS.get(meaning, ("", ""))
    if value is None and key:
        value, unit, _ = _read_value(tags.get(f"{key}:{direction}") or tags.get(key, ""))
    if value is not None and not unit:
        unit = speed_unit(face.country or country) if meaning in SPEEDS else usual
    if meaning in ("city_limit", "city_limit_end"):
        text = text or tags.get("name", "")
    return SignFace(meaning, face.country, face.code, value, unit, text, face.supplementary)
