"""Ways that turn back, one by one: where they run, the ground that they need, and which of them costs least."""

from __future__ import annotations

import math
from typing import Final

from osm2xodr.curves import spirals, trigonometry
from osm2xodr.geometry.connections.defaults import NEAR_ENDS, OWN_TARMAC, PAVEMENT_CELL
from osm2xodr.geometry.defaults import CAR_WIDTH
from osm2xodr.model import FloatArray, IntArray

_CELL: Final = PAVEMENT_CELL
_HALF_OF_THEM: Final = 2.0**19
# Numbers of squares have so many bits beside those of their junction.
SQUARE_BITS: Final = 40
_SQUARE_BITS: Final = SQUARE_BITS
# So many places across lanes are looked at on each side of their middle.
_OFFSETS: Final = 2
# What ways cost, m² of tarmac: each m² of their own beyond `_OWN` once more so much; each metre that oncoming cars
# lack. Choices.
_OWN: Final = OWN_TARMAC
_PER_OWN_BEYOND: Final = 5.0
_PER_MEETING: Final = 40.0
_MEET: Final = NEAR_ENDS
# Ways there and back keep a margin of 0.2 m more apart: they are compared at places.
_APART: Final = CAR_WIDTH + 0.2


def _square(junction: int, x: float, y: float) -> int:
    """Return a number for each square of a junction; areas are up to 250 km wide."""
    column, line = int(x / _CELL + _HALF_OF_THEM), int(y / _CELL + _HALF_OF_THEM)
    return (junction << _SQUARE_BITS) | (column << 20) | line


def squares_across(
    junction: IntArray, places: FloatArray, width: FloatArray, steps: FloatArray, out: IntArray
) -> None:
    """Write the squares at steps across lanes, as shares of their width, (n, steps); `places` are (3, n)."""
    for k in range(len(junction)):
        sine, cosine = trigonometry.sine_cosine(float(places[2, k]))
        for i in range(len(steps)):
            t = float(width[k]) * float(steps[i])
            out[k, i] = _square(junction[k], float(places[0, k]) - t * sine, float(places[1, k]) + t * cosine)


def _is_paved(paved: IntArray, square: int) -> bool:
    """Say whether a square is among those that are paved, in ascending order."""
    first, left = 0, len(paved)
    while left > 1:
        half = left >> 1
        if paved[first + half] <= square:
            first += half
        left -= half
    return left == 1 and paved[first] == square


def own_tarmac(
    places: FloatArray, length: float, entry_width: float, exit_width: float, junction: int, paved: IntArray
) -> float:
    """Return how much ground a way of a length, m, needs that nothing else paves, m².

    `places`, (3, k), are poses in the middles of k equal parts of it.
    """
    count, own = places.shape[1], 0.0
    for k in range(count):
        share = (k + 0.5) / count
        width = entry_width * (1.0 - share) + exit_width * share
        sine, cosine = trigonometry.sine_cosine(float(places[2, k]))
        bare = 0
        for i in range(-_OFFSETS, _OFFSETS + 1):
            t = 0.5 * width * i / _OFFSETS
            square = _square(junction, float(places[0, k]) - t * sine, float(places[1, k]) + t * cosine)
            bare += not _is_paved(paved, square)
        own += bare * width
    return own * length / (count * (2 * _OFFSETS + 1))


def cost_of_ground(own: float) -> float:
    """Return what tarmac of its own, m², costs a way."""
    return own + _PER_OWN_BEYOND * max(own - _OWN, 0.0)


def places_on_way(
    begin: FloatArray, length: FloatArray, curvature: FloatArray, way: int, margin: float, out: FloatArray
) -> None:
    """Write poses at even steps along one of the ways from a pose, (3, k), but for a share of it at both ends.

    Its pieces, (ways, pieces), are lines and arcs; some may have no length.
    """
    pieces, count = length.shape[1], out.shape[1]
    ahead = 0.0
    for i in range(pieces):
        ahead += float(length[way, i])
    step = (1.0 - 2.0 * margin) / (count - 1)
    x, y, hdg = float(begin[0]), float(begin[1]), float(begin[2])
    behind = 0.0
    i = 0
    for k in range(count):
        s = (margin + k * step) * ahead
        while i < pieces - 1 and s >= behind + float(length[way, i]):
            x, y, hdg = spirals.end(x, y, hdg, float(curvature[way, i]), 0.0, float(length[way, i]))
            behind += float(length[way, i])
            i += 1
        out[0, k], out[1, k], out[2, k] = spirals.end(x, y, hdg, float(curvature[way, i]), 0.0, s - behind)


def cost_of_meeting(places: FloatArray, beside: FloatArray) -> float:
    """Return what it costs that a way comes too near to that back, by x and y of places on both, (2, n)."""
    least = _APART * _APART
    for k in range(places.shape[1]):
        for i in range(beside.shape[1]):
            dx, dy = float(places[0, k]) - float(beside[0, i]), float(places[1, k]) - float(beside[1, i])
            least = min(least, dx * dx + dy * dy)
    return _PER_MEETING * (_APART - math.sqrt(least))


def rounded(cost: float) -> float:
    """Return a cost with as many digits as decide."""
    return math.floor(cost * 1000.0 + 0.5) / 1000.0


def cheapest_way(
    best: float,
    begin: FloatArray,
    length: FloatArray,
    curvature: FloatArray,
    bounds: FloatArray,
    ground: FloatArray,
    entry_width: float,
    exit_width: float,
    junction: int,
    paved: IntArray,
    beside: FloatArray,
    places: FloatArray,
) -> int:
    """Return the way of those from a pose that costs less than `best` and least, -1 without any.

    `bounds`, (ways,), are what they cost but for ground and meetings, in ascending order; what they cost by the
    `ground` is found where it is needed and below 0. `beside`, (2, k), are places on the way back, if there is one;
    `places` is overwritten.
    """
    found = -1
    for way in range(len(bounds)):
        if bounds[way] >= best:
            break
        if ground[way] < 0.0:
            whole = 0.0
            for i in range(length.shape[1]):
                whole += float(length[way, i])
            places_on_way(begin, length, curvature, way, 0.5 / places.shape[1], places)
            ground[way] = cost_of_ground(own_tarmac(places, whole, entry_width, exit_width, junction, paved))
        cost = float(bounds[way]) + float(ground[way])
        if beside.shape[1] and rounded(cost) < best:
            places_on_way(begin, length, curvature, way, _MEET, places)
            cost += cost_of_meeting(places, beside)
        if rounded(cost) < best:
            best, found = rounded(cost), way
    return found
