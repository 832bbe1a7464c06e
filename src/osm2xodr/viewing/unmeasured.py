"""Where a file says that the heights of its roads were not measured."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np

from osm2xodr.curves import starts
from osm2xodr.defaults import UNMEASURED_HEIGHTS
from osm2xodr.model import Stretches
from osm2xodr.opendrive import OpenDrive


def unmeasured(file: OpenDrive) -> Stretches:
    """Return the stretches of roads without measured heights, as their ``<userData>`` says.

    Only files that osm2xodr wrote say so; what cannot be read says nothing.
    """
    found: list[list[tuple[float, float]]] = [[] for _ in file.roads.id]
    for (road, code), text in file.provenance.items():
        if code == UNMEASURED_HEIGHTS and road >= 0:
            found[road] = _pairs(text, float(file.roads.length[road]))
    rows = np.array([pair for pairs in found for pair in pairs], np.float64).reshape(-1, 2)
    return Stretches(starts([len(pairs) for pairs in found]), rows[:, 0].copy(), rows[:, 1].copy())


def unmeasured_share(file: OpenDrive) -> tuple[float, float]:
    """Return the length of roads without measured heights, m, and their share of the length of all roads."""
    lengths = np.where(file.roads.length > 0.0, file.roads.length, 0.0)
    length = unmeasured(file).total(lengths)
    return length, length / max(float(lengths.sum()), 1.0) if math.isfinite(length) else 0.0


def _pairs(text: str, length: float) -> list[tuple[float, float]]:
    """Return begin and end of stretches on a road, m; none if the text is anything else."""
    try:
        values = [float(word) for word in text.split()]
    except ValueError:
        return []
    # Comparisons with NaN are false.
    rising = all(a < b for a, b in pairwise(values))
    if len(values) % 2 or not rising or not values or not 0.0 <= values[0] <= values[-1] <= length + 1.0:
        return []
    return list(zip(values[::2], values[1::2], strict=True))
