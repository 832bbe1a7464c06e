"""Widths of strips at cross sections become few records."""

from __future__ import annotations

from typing import Final

import numpy as np

from osm2xodr.curves import ranks
from osm2xodr.model import BoolArray, Cubic, FloatArray, IntArray

# Decimals of the places and widths of records, m.
_DECIMALS: Final = 3
# Between strips, m: keeps their places apart on one axis.
_APART: Final = 1.0


def width_records(
    strip: IntArray, s: FloatArray, width: FloatArray, count: int, tolerance: float
) -> list[tuple[Cubic, ...]]:
    """Return the widths of strips as linear records that miss no given width by more than a tolerance, m.

    `strip` (n,), ascending, is the strip, 0 … count - 1, that a width, m, at s belongs to; s ascends from 0. Widths
    that are less than those before and behind them become the lesser of these.
    """
    width = _without_dips(strip, width)
    last = np.append(np.diff(strip) > 0, True)
    # At the end of a road up, so that no width falls below 0 before it.
    s = np.where(last, np.ceil(s * 10**_DECIMALS) / 10**_DECIMALS, np.round(s, _DECIMALS))
    width = np.round(width, _DECIMALS)
    keep = _needed(strip, s, width, tolerance)
    strip, s, width = strip[keep], s[keep], width[keep]
    begins = np.flatnonzero(np.diff(strip) == 0)
    slope = (width[begins + 1] - width[begins]) / (s[begins + 1] - s[begins])
    out: list[list[Cubic]] = [[] for _ in range(count)]
    rows = zip(strip[begins].tolist(), s[begins].tolist(), width[begins].tolist(), slope.tolist(), strict=True)
    for k, at, value, rise in rows:
        before = out[k][-1] if out[k] else None
        if before is None or not (value == rise == before.a == before.b == 0.0):
            out[k].append(Cubic(at, value, rise))
    return [tuple(item) for item in out]


def _without_dips(strip: IntArray, width: FloatArray) -> FloatArray:
    """Raise widths between two larger ones: cells show single rays too short, and esmini 3.6 may never load teeth.

    Its search for points of lanes (``CheckAndAddOSIPoint`` in ``RoadManager.cpp``) does not end at some of them.
    """
    out = width.copy()
    within = np.flatnonzero((strip[1:-1] == strip[:-2]) & (strip[1:-1] == strip[2:])) + 1
    out[within] = np.maximum(width[within], np.minimum(width[within - 1], width[within + 1]))
    return out


def _needed(strip: IntArray, s: FloatArray, width: FloatArray, tolerance: float) -> BoolArray:
    """Say which widths are needed, so that straight lines between them are near all others, (n,).

    In each round every other one of each strip is tried, odd and even ones in turn: no strip changes another one.
    """
    ends = np.diff(strip, prepend=-1) > 0
    ends[:-1] |= ends[1:]
    ends[-1:] = True
    # All strips one behind the other on one axis.
    begin = np.flatnonzero(np.diff(strip, prepend=-1))
    size = s[np.append(begin[1:], len(s)) - 1] + _APART
    axis = s + np.repeat(np.cumsum(size) - size, np.diff(np.append(begin, len(s))))
    keep = np.ones(len(s), bool)
    failed, phase = 0, 1
    while failed < 2:
        kept = np.flatnonzero(keep)
        candidate = (ranks(np.bincount(strip[kept])) % 2 == phase) & ~ends[kept]
        trial = kept[~candidate]
        off = np.abs(np.interp(axis, axis[trial], width[trial]) - width) > tolerance
        # The interval between trial places that each place lies in: one is tried within each.
        interval = np.searchsorted(trial, np.arange(len(s)), side="right") - 1
        bad = np.bincount(interval[off], minlength=len(trial)) > 0
        good = ~bad[interval[kept[candidate]]]
        keep[kept[candidate][good]] = False
        failed = 0 if good.any() else failed + 1
        phase = 1 - phase
    return keep
