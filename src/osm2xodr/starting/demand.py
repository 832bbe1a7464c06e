"""Traffic for SUMO: trips between the places where roads of each class have theirs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Final

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import dijkstra

from osm2xodr.curves import sorted_unique
from osm2xodr.model import FloatArray, IntArray
from osm2xodr.osmParsing import HIGHWAYS, class_of, open_osm_file, read_ways
from osm2xodr.starting.request import Request
from osm2xodr.starting.sumo_network import SumoNetwork

# Vehicles per day, both ways, by class of road. Choices, of the order of the low ends that FHWA's Highway Functional
# Classification Concepts, Criteria and Procedures (2013, section 3) has for towns; its tables were not at hand.
_VEHICLES_PER_DAY: Final[Mapping[str, float]] = MappingProxyType(
    {"motorway": 35_000.0, "trunk": 13_000.0, "primary": 7_000.0, "secondary": 3_000.0, "tertiary": 1_100.0}
)
_LOCAL_VEHICLES_PER_DAY: Final = 80.0
# Share of a day's traffic in one hour, as nearly all of it flows within 16 of the 24.
_ONE_HOUR: Final = 1.0 / 16.0
# Cars set out within a quarter of an hour, the time for which traffic engineers count.
_DEMAND_S: Final = 900.0
# So many at least, so that something moves in the smallest of areas, and at most: of 3,000 in the interchange of
# Portland 15 are taken out of jams, of 1,500 four.
_LEAST_TRIPS: Final = 60
_MOST_TRIPS: Final = 1_500
# Shorter trips than these are walked, m; in smaller areas shorter ones than this share of the longest.
_SHORTEST_M: Final = 300.0
_SHORTEST_SHARE: Final = 0.3
# Edges on which no car has room to set out, m.
_LEAST_EDGE: Final = 10.0
# Steps of the sequence with the least discrepancy in two dimensions, powers of the root of x^3 = x + 1 (M. Roberts,
# The unreasonable effectiveness of quasirandom sequences, 2018): places as even as can be without any chance.
_PLASTIC: Final = 1.324717957244746
# Origins whose ways are searched for at a time.
_BLOCK: Final = 64


@dataclass(frozen=True, slots=True)
class Trip:
    """A car that goes from one edge to another."""

    depart_s: float
    origin: str
    destination: str


def make_trips(network: SumoNetwork, request: Request) -> list[Trip]:
    """Return the cars of a quarter of an hour, in the order in which they set out."""
    hourly = _hourly(network, request)
    leaving = np.where(network.entrances, hourly.through, hourly.local)
    arriving = np.where(network.exits, hourly.through, hourly.local)
    if not len(network.id) or not leaving.any() or not arriving.any():
        return []
    count = int(np.clip(leaving.sum() * _DEMAND_S / 3600.0, _LEAST_TRIPS, _MOST_TRIPS))
    k = np.arange(1, count + 1)
    origins = _drawn(leaving, (k / _PLASTIC) % 1.0)
    pairs = zip(origins.tolist(), _destinations(network, origins, arriving), strict=True)
    return [Trip(_DEMAND_S / count * n, network.id[a], network.id[b]) for n, (a, b) in enumerate(pairs)]


@dataclass(frozen=True, eq=False)
class _Hourly:
    """Vehicles per hour and direction of each edge."""

    through: FloatArray  # Where it leads into the area or out of it
    local: FloatArray  # Elsewhere


def _hourly(network: SumoNetwork, request: Request) -> _Hourly:
    source = open_osm_file(request.area)
    ways, _ = read_ways(source, HIGHWAYS, {"highway"})
    classes = {way.id: class_of(way.tags).removesuffix("_link") for way in ways}
    daily = {
        str(road.id): max(
            (_VEHICLES_PER_DAY.get(classes.get(way, ""), _LOCAL_VEHICLES_PER_DAY) for way in road.osm_way_ids),
            default=_LOCAL_VEHICLES_PER_DAY,
        )
        for road in request.conversion.road_map.roads
    }
    share = 0.5 * _ONE_HOUR
    through = share * np.array([daily.get(road, _LOCAL_VEHICLES_PER_DAY) for road in network.road])
    through[network.length < _LEAST_EDGE] = 0.0
    local = np.where(through > share * _LOCAL_VEHICLES_PER_DAY, 0.0, through)
    return _Hourly(through, local)


def _drawn(weight: FloatArray, share: FloatArray) -> IntArray:
    """Return the items at shares, 0 to 1, of the sum of all weights."""
    total = np.cumsum(weight)
    found: IntArray = np.minimum(np.searchsorted(total, share * total[-1], side="right"), len(weight) - 1)
    return found


def _destinations(network: SumoNetwork, origins: IntArray, weight: FloatArray) -> list[int]:
    """Return where cars from each edge go: to its end, where no other place can be reached."""
    count = len(network.id)
    metres = csr_matrix((network.length[network.end], (network.start, network.end)), shape=(count, count))
    out: list[int] = origins.tolist()
    places = sorted_unique(origins)
    for at in range(0, len(places), _BLOCK):
        block = places[at : at + _BLOCK]
        for place, far in zip(block.tolist(), dijkstra(metres, indices=block), strict=True):
            there = np.isfinite(far) & (weight > 0.0)
            there[place] = False
            if not there.any():
                continue
            shortest = min(_SHORTEST_M, _SHORTEST_SHARE * float(far[there].max()))
            wanted = np.where(there & (far >= shortest), weight, 0.0)
            for k in np.flatnonzero(origins == place).tolist():
                out[k] = int(_drawn(wanted, np.array([((k + 1) / _PLASTIC**2) % 1.0]))[0])
    return out
