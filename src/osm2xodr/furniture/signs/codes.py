"""The numbers that countries give their traffic signs, and what they mean.

What a sign means is said in this package's own words, the keys of ``codes.json``. Readers differ in which
numbers they know. CARLA (``SignalType.cpp``) compares type alone with the numbers of the German StVO and takes the
value of a speed limit from the subtype. esmini has a list for each country (``resources/traffic_signals``), of which
only the German one has more than a few signs, and looks for type and subtype joined. So the German numbers, with the
country that they are of, are what both know.
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Final

# Whose numbers are written unless a reader wants those of the country itself.
COMMON: Final = "DE"
NO_SUBTYPE: Final = "-1"
_VALUE: Final = r"(\d+(?:[.,]\d+)?)"
# VzKat before 2017: 274-53 is a limit of 30 km/h.
_OLD_GERMAN_SPEEDS: Final = range(51, 60)


@dataclass(frozen=True, slots=True)
class SignCode:
    """Type, subtype and country as OpenDRIVE wants them."""

    type: str
    subtype: str
    country: str


@dataclass(frozen=True, slots=True)
class _Catalogue:
    """The signs of a country: templates by meaning, meanings by code, templates with values, supplementary plates."""

    templates: Mapping[str, str]
    meanings: Mapping[str, str]
    valued: tuple[tuple[re.Pattern[str], str, float], ...]
    supplementary: re.Pattern[str] | None


@cache
def _catalogues() -> Mapping[str, _Catalogue]:
    text = Path(__file__).with_name("codes.json").read_text(encoding="utf-8")
    return {country: _catalogue(item) for country, item in json.loads(text)["countries"].items()}


def _catalogue(item: Mapping[str, Mapping[str, str]]) -> _Catalogue:
    templates = item["codes"]
    meanings: dict[str, str] = {}
    valued: list[tuple[re.Pattern[str], str, float]] = []
    for meaning, template in templates.items():
        if "{" not in template:
            meanings[_plain(template)] = meaning
            continue
        before, after = re.split(r"\{.*\}", template)
        factor = 10.0 if "{tens}" in template else 1.0
        valued.append((re.compile(re.escape(_plain(before)) + _VALUE + re.escape(after)), meaning, factor))
        if not after:
            meanings[_plain(before.removesuffix("-"))] = meaning
    meanings.update({_plain(code): meaning for code, meaning in item.get("also", {}).items()})
    pattern = str(item.get("supplementary", ""))
    return _Catalogue(templates, meanings, tuple(valued), re.compile(pattern) if pattern else None)


def _plain(code: str) -> str:
    """Return a code as all its spellings have it: ``A01``, ``A-1`` and ``a1`` are one."""
    return re.sub(r"^([A-Z]+)[ -]?0*(?=\d)", r"\1", code.strip().upper())


def countries() -> tuple[str, ...]:
    """Return the countries whose signs are known, ISO 3166-1 alpha-2."""
    return tuple(_catalogues())


def meanings() -> frozenset[str]:
    """Return all that signs can mean."""
    return frozenset(meaning for item in _catalogues().values() for meaning in item.templates)


def meaning_of(country: str, code: str) -> tuple[str, float | None]:
    """Return what a country's code means, empty where that is not known, and the value that it names.

    Parameters
    ----------
    country
        ISO 3166-1 alpha-2.
    code
        Without the country, without a value in brackets.
    """
    catalogue = _catalogues().get(country)
    if catalogue is None:
        return "", None
    plain = _plain(code)
    if plain in catalogue.meanings:
        return catalogue.meanings[plain], None
    for pattern, meaning, factor in catalogue.valued:
        found = pattern.fullmatch(plain)
        if found:
            return meaning, _shown(country, float(found[1].replace(",", ".")), factor)
    # A number behind the hyphen that the table does not have is a variant of the same sign, such as its mirror image.
    return catalogue.meanings.get(re.sub(r"(?<=\d)-\d+$", "", plain), ""), None


def _shown(country: str, number: float, factor: float) -> float:
    if country == "DE" and number in _OLD_GERMAN_SPEEDS:
        return (number - 50.0) * 10.0
    # Tens are also written out.
    return number * factor if number * factor <= 200.0 else number


def is_supplementary(country: str, code: str) -> bool:
    """Whether a country's code is of a plate that only adds to the sign above it."""
    catalogue = _catalogues().get(country)
    pattern = catalogue.supplementary if catalogue else None
    return pattern is not None and pattern.fullmatch(code.strip().upper()) is not None


def code_of(
    meaning: str, value: float | None, country: str, *, own_codes: bool, value_in_subtype: bool
) -> SignCode | None:
    """Return the code to write for a sign; None where the meaning has none.

    Parameters
    ----------
    meaning, value
        What it means, and the number on it.
    country
        Where it stands; empty where that is not known.
    own_codes
        Whether the numbers of the country itself are wanted where they are known, else the common ones.
    value_in_subtype
        Whether the common numbers have the value of the sign as their subtype.
    """
    owner = country if own_codes and meaning in _templates(country) else COMMON
    template = _templates(owner).get(meaning)
    if template is None:
        return None
    if "{" in template:
        return _with_value(template, value, owner, in_subtype=value_in_subtype or own_codes)
    kind, _, variant = template.partition("-") if owner == COMMON else (template, "", "")
    return SignCode(kind, variant or NO_SUBTYPE, owner)


def _templates(country: str) -> Mapping[str, str]:
    catalogue = _catalogues().get(country)
    return catalogue.templates if catalogue else {}


def _with_value(template: str, value: float | None, country: str, *, in_subtype: bool) -> SignCode:
    before, after = re.split(r"\{.*\}", template)
    kind = before.removesuffix("-")
    if value is None:
        return SignCode(kind, NO_SUBTYPE, country)
    number = f"{value / 10.0 if '{tens}' in template else value:g}"
    if after:
        return SignCode(f"{before}{number}{after}", NO_SUBTYPE, country)
    return SignCode(kind, number if in_subtype else NO_SUBTYPE, country)
