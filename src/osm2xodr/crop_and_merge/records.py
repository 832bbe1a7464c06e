"""Records along s, cut to a stretch: what held before it begins holds from its begin."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, Final

# Elements of lxml: its types are not needed at run time.
Element = Any

# Places closer together than this are one, m.
AT_ONE: Final = 1e-7


def number(element: Element, name: str, default: float = 0.0) -> float:
    """Return an attribute as a number; a default where it is missing or unreadable."""
    try:
        return float(element.get(name, default))
    except ValueError:
        return default


def put(element: Element, name: str, value: float) -> None:
    """Write a number into an attribute, to a billionth."""
    element.set(name, f"{round(value, 12) + 0.0:.15g}")


def remove(element: Element) -> None:
    """Remove an element from the document; the white space behind it goes as well."""
    parent = element.getparent()
    if parent is not None:
        parent.remove(element)


def lane_sections(road: Element) -> list[Element]:
    """Return the lane sections of a road, along s."""
    return sorted(road.findall("lanes/laneSection"), key=lambda item: number(item, "s"))


def cut_records(
    elements: Iterable[Element], begin: float, end: float, *, key: str = "s", cubic: bool = False
) -> None:
    """Cut records to a stretch, and let s count from its begin.

    Of several records at one s all are kept, but for cubics, of which the last one holds.
    """
    records = sorted(elements, key=lambda item: number(item, key))
    before = [number(item, key) for item in records if number(item, key) <= begin + AT_ONE]
    base = max(before, default=None)
    holding = [item for item in records if base is not None and number(item, key) == base]
    for k, item in enumerate(records):
        s = number(item, key)
        is_base = item in holding
        over = base is not None and s < base
        beyond = s >= end - AT_ONE and not is_base
        if over or beyond or (cubic and is_base and item is not holding[-1]):
            remove(item)
        elif is_base and begin - s > 0:
            if cubic:
                _begin_later(item, begin - s)
            put(item, key, 0.0)
        elif begin > 0 or k:
            put(item, key, s - begin if abs(s - begin) > AT_ONE else 0.0)


def _begin_later(item: Element, by: float) -> None:
    """Let a cubic a + b ds + c ds² + d ds³ begin later, by its Taylor series about the new begin."""
    a, b, c, d = (number(item, name) for name in "abcd")
    put(item, "a", a + by * (b + by * (c + by * d)))
    put(item, "b", b + by * (2 * c + 3 * by * d))
    put(item, "c", c + 3 * by * d)


def clip(element: Element, begin: float, end: float, *, s: str = "s", length: str = "length") -> bool:
    """Cut something that lies along s to a stretch, and let s count from its begin; False where nothing is left."""
    low = number(element, s)
    high = low + number(element, length)
    if (
        high < begin - AT_ONE
        or low > end + AT_ONE
        or (high - low > AT_ONE and min(high, end) - max(low, begin) < AT_ONE)
    ):
        return False
    put(element, s, max(low, begin) - begin)
    if element.get(length) is not None and (low < begin or high > end):
        put(element, length, min(high, end) - max(low, begin))
    return True
