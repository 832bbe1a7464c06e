"""Figures of a road network."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import field

import numpy as np

from osm2xodr.curves import lengths as curve_lengths
from osm2xodr.model import CubicProfile, FloatArray, RoadMap, Stretches
from osm2xodr.system import record


@record
class Statistics:
    """Figures of a road network."""

    # Numbers of roads outside of junctions, of roads through them, of junctions
    roads: int
    connecting_roads: int
    junctions: int
    # Lengths of reference lines, m
    road_length: float
    connecting_length: float
    # Heights of reference lines, m
    lowest: float
    highest: float
    # Share of the length of all roads, those through junctions among them, on which an elevation model has a height
    # at the reference line; None without one
    dem_coverage: float | None
    # Figures of the stages geometry and furniture, by name
    further: Mapping[str, float] = field(default_factory=dict)


def summarize(road_map: RoadMap) -> Statistics:
    """Count and measure a road network."""
    lengths = curve_lengths(road_map.plan_view)
    inside = np.array([road.junction is not None for road in road_map.roads], dtype=np.bool_)
    lowest, highest = profile_range(road_map.elevation, lengths)
    return Statistics(
        int(np.count_nonzero(~inside)),
        int(np.count_nonzero(inside)),
        len(road_map.junctions),
        float(lengths[~inside].sum()),
        float(lengths[inside].sum()),
        lowest,
        highest,
        coverage(road_map.unmeasured, lengths),
        {**road_map.statistics, **road_map.furniture.statistics},
    )


def coverage(unmeasured: Stretches | None, lengths: FloatArray) -> float | None:
    """Return the share of roads of these lengths, (roads,), m, that is measured; None if none can be."""
    if unmeasured is None:
        return None
    return 1.0 - unmeasured.total(lengths) / float(lengths.sum())


def profile_range(profile: CubicProfile, lengths: FloatArray) -> tuple[float, float]:
    """Return the least and the greatest value of piecewise cubics on curves of `lengths` (curves,), m."""
    end = np.append(profile.s[1:], 0.0)
    filled = np.diff(profile.start) > 0
    end[profile.start[1:][filled] - 1] = lengths[filled]
    span = np.maximum(end - profile.s, 0.0)
    # Where the slope b + 2 c ds + 3 d ds^2 is 0, by the form of the quadratic formula that no small d upsets.
    root = np.sqrt(np.maximum(profile.c**2 - 3.0 * profile.b * profile.d, 0.0))
    q = -(profile.c + np.copysign(root, profile.c))
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        extremes = [q / (3.0 * profile.d), profile.b / q]
    values = []
    for ds in (np.zeros_like(span), span, *extremes):
        inside = np.clip(np.nan_to_num(ds, nan=0.0, posinf=0.0, neginf=0.0), 0.0, span)
        values.append(profile.a + inside * (profile.b + inside * (profile.c + inside * profile.d)))
    every = np.concatenate(values)
    return float(every.min()), float(every.max())
