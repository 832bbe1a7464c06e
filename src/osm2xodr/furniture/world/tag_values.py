"""Numbers in the tags of what stands on and beside roads."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Final

_METRES: Final = re.compile(r"(\d+(?:[.,]\d+)?)\s*(m|cm|mm|'|ft)?")
_UNIT: Final = {"m": 1.0, "cm": 0.01, "mm": 0.001, "'": 0.3048, "ft": 0.3048}


def length_of(tags: Mapping[str, str], key: str, most: float) -> float | None:
    """Return the value of a tag, m; None where it has none that is above 0 and not above the most that is believed.

    Numbers without a unit are metres.
    """
    found = _METRES.fullmatch(tags.get(key, "").strip())
    if found is None:
        return None
    value = float(found[1].replace(",", ".")) * _UNIT[found[2] or "m"]
    return value if 0.0 < value <= most else None
