"""Tags about the sides of a way: ``key=both``, ``key:left=yes``, ``key:both:width=2`` and the like.

A key that names a side takes precedence over ``key:both``, and that over the key alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from osm2xodr.diagnostics import Kind
from osm2xodr.osmParsing.defaults import MARGIN_WIDTH_MAX, MARGIN_WIDTH_MIN
from osm2xodr.osmParsing.tags.values import Findings, Tags, first_width

LEFT_RIGHT: Final = ("left", "right")
SIDE_KEYS: Final = ("", ":both", ":left", ":right")

# What a side can have; ``APART`` is mapped as a way or an area of its own.
YES: Final = "yes"
NO: Final = "no"
APART: Final = "separate"
# OSM's words for them.
_WORDS: Final = {"yes": YES, "no": NO, "none": NO, "separate": APART}


def keys_of_sides(key: str, *endings: str) -> tuple[str, ...]:
    """Return a key with each of its sides and each ending (``""`` for none)."""
    return tuple(f"{key}{side}{ending}" for side in SIDE_KEYS for ending in endings)


def names_of_side(key: str, side: str, ending: str = "") -> tuple[str, str, str]:
    """Return the keys that apply to one side, the most specific first."""
    return f"{key}:{side}{ending}", f"{key}:both{ending}", f"{key}{ending}"


def sides_of(tags: Tags, key: str, code: str, findings: Findings, yes: Sequence[str] = LEFT_RIGHT) -> dict[str, str]:
    """Read what the sides of a way have: `YES`, `NO` or `APART` for ``left`` and ``right``, if a tag mentions it.

    `key` has no side (``sidewalk``); `yes` are the sides that its value ``yes`` means. Values that are not known or
    contradict each other are added to `findings` with `code`.
    """
    stated: dict[str, list[str]] = {side: [] for side in LEFT_RIGHT}
    for end, about in ((":left", ("left",)), (":right", ("right",)), (":both", LEFT_RIGHT), ("", LEFT_RIGHT)):
        name = f"{key}{end}"
        value = tags.get(name)
        if value is None:
            continue
        read = _read(value, about, yes if not end else about)
        if read is None:
            findings.append((Kind.DROPPED, code, f"{name}={value} is not known or contradicts itself and is ignored"))
            continue
        if not end and value == "yes":
            where = "both sides" if len(yes) > 1 else f"the {yes[0]}"
            findings.append((Kind.GUESSED, code, f"{name}=yes names no side, taken to mean {where}"))
        for side, state in read.items():
            stated[side].append(state)
    if any({YES, NO} <= set(states) for states in stated.values()):
        words = f"tags of {key} contradict each other, the most specific one is taken"
        findings.append((Kind.REPAIRED, code, words))
    return {side: states[0] for side, states in stated.items() if states}


def _read(value: str, about: Sequence[str], yes: Sequence[str]) -> dict[str, str] | None:
    """Return what one value says about the sides that its key applies to; None if it is not known."""
    rest = NO
    named: set[str] = set()
    for part in value.split(";"):
        word = part.strip().lower()
        if word in {"yes", "both"} and (word == "both" or len(about) == 1 or set(yes) == set(about)):
            named.update(about)
        elif word == "yes":
            named.update(yes)
        elif word in about:
            named.add(word)
        elif word in _WORDS:
            rest = _WORDS[word]
        else:
            return None
    if named and rest is NO and any(part.strip().lower() in {"no", "none"} for part in value.split(";")):
        return None
    return {side: YES if side in named else rest for side in about}


def width_of_side(tags: Tags, keys: Sequence[str], code: str, findings: Findings) -> float | None:
    """Return the width of a strip beside a road from the first of some keys with a valid one, m; None if none has."""
    return first_width(tags, keys, (MARGIN_WIDTH_MIN, MARGIN_WIDTH_MAX), code, "a strip beside a road", findings)
