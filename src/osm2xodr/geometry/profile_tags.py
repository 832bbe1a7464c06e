"""Heights that OSM's tags give, at their places along roads."""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Iterable

import numpy as np

from osm2xodr.curves import lengths, pose
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.geometry import defaults
from osm2xodr.model import FloatArray, IntArray, PlanView, Street, StreetNetwork

# A number, and its unit if it is not metres; what else there may be (two values, a range, a datum) is no height.
_ELE = re.compile(r"([+-]?\d+(?:\.\d+)?)\s*(m|ft|feet)?", re.IGNORECASE)
_FOOT = 0.3048
# Distance of the places along a road among which the nearest to a node is looked for, m.
_STEP = 2.0


def parse_ele(text: str) -> float | None:
    """Return the metres that a value of ``ele`` means, None if it means none."""
    match = _ELE.fullmatch(text.strip())
    if match is None:
        return None
    unit = (match[2] or "m").lower()
    z = float(match[1]) * (1.0 if unit == "m" else _FOOT)
    low, high = defaults.ELE_PLAUSIBLE
    return z if low <= z <= high else None


def tagged_heights(
    network: StreetNetwork, plan_view: PlanView, street: IntArray, diagnostics: Diagnostics
) -> tuple[IntArray, FloatArray, FloatArray]:
    """Return the heights that ``ele`` of nodes gives: road, place along it, m, and height, m.

    Where roads end short of a node, as at junctions, their nearest place stands for it.

    Parameters
    ----------
    network
        Streets and the tags of their nodes.
    plan_view
        Reference lines of the R roads.
    street : (R,)
        Street that each road is a part of.
    diagnostics
        Where values that are no heights are told.
    """
    heights: dict[int, float] = {}
    for node, tags in sorted(network.node_tags.items()):
        if "ele" in tags:
            z = parse_ele(tags["ele"])
            if z is None:
                diagnostics.dropped(
                    "ele", f"node/{node}", f"ele '{tags['ele']}' is no height in metres, it is ignored"
                )
            else:
                heights[node] = z
    roads_of = defaultdict(list)
    for road, owner in enumerate(street.tolist()):
        roads_of[owner].append(road)
    length = lengths(plan_view).tolist()
    nearest: dict[int, tuple[float, int, float]] = {}
    for item, k in _nodes(network, heights):
        node = int(item.node_ids[k])
        for road in roads_of[item.id]:
            s, distance = _nearest(plan_view, road, length[road], *item.points[k].tolist())
            found = (distance, road, s)
            nearest[node] = min(nearest.get(node, found), found)
    places = [(road, s, heights[node]) for node, (_, road, s) in sorted(nearest.items())]
    table = np.array(places, np.float64).reshape(-1, 3)
    return table[:, 0].astype(np.int64), table[:, 1], table[:, 2]


def _nodes(network: StreetNetwork, wanted: Iterable[int]) -> list[tuple[Street, int]]:
    """Return the streets that pass wanted nodes, and the places of these among their nodes."""
    count = np.array([len(item.node_ids) for item in network.streets], np.int64)
    first = np.cumsum(count) - count
    every = np.concatenate([np.zeros(0, np.int64), *(item.node_ids for item in network.streets)])
    found = np.flatnonzero(np.isin(every, np.array(list(wanted), np.int64)))
    owner = np.searchsorted(first, found, side="right") - 1
    return [
        (network.streets[k], place) for k, place in zip(owner.tolist(), (found - first[owner]).tolist(), strict=True)
    ]


def _nearest(plan_view: PlanView, road: int, length: float, x: float, y: float) -> tuple[float, float]:
    """Return where a road of a length is nearest to a place, and how near, m."""
    s = np.linspace(0.0, length, int(np.ceil(length / _STEP)) + 1)
    px, py, _ = pose(plan_view, np.full(len(s), road), s)
    distance = np.hypot(px - x, py - y)
    k = int(np.argmin(distance))
    return float(s[k]), float(distance[k])
