"""Which of two surfaces covers the other where they lie on each other: what scenes and pictures share."""

from __future__ import annotations

from typing import Final

# Surfaces farther apart in height belong to different levels, m; traffic needs 4 m (`CLEARANCE_LEAST`), and roads
# that meet are closer. A choice between both.
LEVEL_APART: Final = 1.5
# Lane types in the order in which they cover each other: what is driven on shows, what lies beside it gives way. All
# others are driven on.
_COVERED: Final = ("tram", "rail", "stop", "parking", "biking", "shoulder", "walking", "sidewalk", "curb")
_LAST: Final = ("median", "border", "none", "")


def rank_of(kind: str) -> int:
    """Return the place of a type of lanes in the order in which they cover each other; 0 covers all."""
    if kind in _COVERED:
        return 1 + _COVERED.index(kind)
    return 1 + len(_COVERED) + _LAST.index(kind) if kind in _LAST else 0
