"""Which values of ``turn:lanes`` lead to which side. One turns back across the far side of traffic."""

from __future__ import annotations

from typing import Final

_LEFT: Final = frozenset({"left", "slight_left", "sharp_left"})
_RIGHT: Final = frozenset({"right", "slight_right", "sharp_right"})
_BACK: Final = frozenset({"reverse"})


def to_left(left_hand: bool) -> frozenset[str]:
    """Return the values that lead to the left, with traffic on the left or not."""
    return _LEFT if left_hand else _LEFT | _BACK


def to_right(left_hand: bool) -> frozenset[str]:
    """Return the values that lead to the right, with traffic on the left or not."""
    return _RIGHT | _BACK if left_hand else _RIGHT
