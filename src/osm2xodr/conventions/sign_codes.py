"""The numbers that countries give their traffic signs, and what they mean: the keys of ``sign_codes.json``.

Readers know different numbers: CARLA (``SignalType.cpp``) compares the type alone with the German ones and takes a
speed limit from the subtype; esmini (``resources/traffic_signals``) looks up type and subtype joined in a list for
each country, of which only the German one has more than a few signs. So both know German numbers with ``DE``.
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Final

# The country whose numbers are written unless a reader wants those of the country where the sign stands.
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
    """The signs of a country."""

    templates: Mapping[str, str]  # Codes by meaning; ``{}`` stands for the value on the sign, ``{tens}`` for a tenth
    meanings: Mapping[str, str]  # Meanings by code, of codes without a value
    valued: tuple[tuple[re.Pattern[str], str, float], ...]  # (pattern of a code with a value, meaning, factor)
    supplementary: re.Pattern[str] | None  # Codes of plates that add to the sign above them


_EMPTY: Final = _Catalogue({}, {}, (), None)


@cache
def _catalogues() -> Mapping[str, _Catalogue]:
    text = Path(__file__).with_name("sign_codes.json").read_text(encoding="utf-8")
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
    """Normalise the spelling of a code: ``A01``, ``A-1`` and ``a1`` are the same."""
    return re.sub(r"^([A-Z]+)[ -]?0*(?=\d)", r"\1", code.strip().upper())


@cache
def sign_meanings() -> frozenset[str]:
    """Return all meanings of signs."""
    return frozenset(meaning for item in _catalogues().values() for meaning in item.templates)


def sign_meaning(country: str, code: str) -> tuple[str, float | None]:
    """Return the meaning of a country's code, empty where it is not known, and the value that the code contains.

    `country` is ISO 3166-1 alpha-2; `code` has neither the country nor a value in brackets.
    """
    catalogue, plain = _catalogues().get(country, _EMPTY), _plain(code)
    if plain in catalogue.meanings:
        return catalogue.meanings[plain], None
    for pattern, meaning, factor in catalogue.valued:
        found = pattern.fullmatch(plain)
        if found:
            return meaning, _value_shown(country, float(found[1].replace(",", ".")), factor)
    # An unknown number behind the hyphen is a variant of the same sign, such as its mirror image.
    return catalogue.meanings.get(re.sub(r"(?<=\d)-\d+$", "", plain), ""), None


def _value_shown(country: str, number: float, factor: float) -> float:
    if country == "DE" and number in _OLD_GERMAN_SPEEDS:
        return (number - 50.0) * 10.0
    # Codes with tens are also found with the whole number.
    return number * factor if number * factor <= 200.0 else number


def is_supplementary(country: str, code: str) -> bool:
    """Return whether a country's code is that of a plate that only adds to the sign above it."""
    pattern = _catalogues().get(country, _EMPTY).supplementary
    return pattern is not None and pattern.fullmatch(code.strip().upper()) is not None


def sign_code(
    meaning: str, value: float | None, country: str, *, own_codes: bool, value_in_subtype: bool
) -> SignCode | None:
    """Return the code to write for a sign with a meaning and a number on it; None where the meaning has none.

    `country` is where it stands, empty where that is not known. `own_codes` prefers its own numbers to the common
    ones; `value_in_subtype` makes the value on the sign the subtype of common numbers.
    """
    own = own_codes and meaning in _catalogues().get(country, _EMPTY).templates
    owner = country if own else COMMON
    template = _catalogues()[owner].templates.get(meaning)
    if template is None:
        return None
    if "{" in template:
        return _with_value(template, value, owner, in_subtype=value_in_subtype or own_codes)
    kind, _, variant = template.partition("-") if owner == COMMON else (template, "", "")
    return SignCode(kind, variant or NO_SUBTYPE, owner)


def _with_value(template: str, value: float | None, country: str, *, in_subtype: bool) -> SignCode:
    before, after = re.split(r"\{.*\}", template)
    kind = before.removesuffix("-")
    if value is None:
        return SignCode(kind, NO_SUBTYPE, country)
    number = f"{value / 10.0 if '{tens}' in template else value:g}"
    if after:
        return SignCode(f"{before}{number}{after}", NO_SUBTYPE, country)
    # esmini finds a sign with a value and the subtype -1 under no name.
    return SignCode(kind, number if in_subtype else "", country)
