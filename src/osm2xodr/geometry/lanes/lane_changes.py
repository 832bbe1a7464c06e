"""What changes where the lanes of a road change, and how much room that takes."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from functools import lru_cache
from typing import Final

from osm2xodr.curves import cube_root
from osm2xodr.geometry import defaults
from osm2xodr.geometry.lanes.cross_sections import CrossSection, lanes_of
from osm2xodr.geometry.lanes.lane_connectivity import COUNTED_LANES, StatedLanes
from osm2xodr.geometry.lanes.lane_matching import match_lanes
from osm2xodr.model import Direction, LaneSpec, Rule
from osm2xodr.system import record

# So many changes are remembered: the same few occur all over a network, and several times while its roads are cut.
_REMEMBERED: Final = 4096
# Lanes that shift to the side by less keep their place, m.
_NO_SHIFT: Final = 0.01


@record
class LaneChange:
    """What changes where one stretch ends and the next begins."""

    pairs: Mapping[int, int]  # Ids of the lanes that continue: before, after
    at_once: int  # How many lanes of one direction open, or end
    more: int  # How many lanes open less those that end
    width: float  # The largest change of a lane's width; lanes open from 0 and end at 0, m
    # The smallest and the largest shift to the side of lanes that continue, m
    least_shift: float
    shift: float
    aside: float  # How far these shift to the left in the mean, m
    beside: bool  # Whether all lanes that continue lie beside each other before and after
    speed: float | None  # Of the faster of the two stretches, m/s

    @property
    def is_slow(self) -> bool:
        """Whether the limit is a low one."""
        return _is_slow(self.speed)

    @property
    def steepest(self) -> float:
        """The shortest length of a lane's taper in multiples of its width."""
        return defaults.SLOW_TAPER_RATIO if self.is_slow else defaults.STEEPEST_TAPER

    @property
    def least(self) -> float:
        """The shortest length over which it should take place, m."""
        return max(self.to_open, 2 * self.steepest * self.least_shift)

    @property
    def to_open(self) -> float:
        """The shortest length over which lanes should open, end and widen, m."""
        return self.steepest * self.width + defaults.LANES_OPEN_APART * max(self.at_once - 1, 0)

    @property
    def wanted(self) -> float:
        """The length over which it takes place where there is room, m."""
        one_by_one = taper_ratio(self.speed) * self.width * (max(self.at_once, 1) + 1) / 2
        # Where no lane opens or ends nothing says where lanes begin to move: they do so gently.
        longest = max(self.least, one_by_one, 0.0 if self.at_once else self.gentle)
        return max(longest, defaults.SHORTEST_TAPER) if longest else 0.0

    @property
    def gentle(self) -> float:
        """The length over which lanes that continue shift to the side where there is room, m; 0 if they do not."""
        if not self.beside or self.shift < _NO_SHIFT:
            return 0.0
        speed = defaults.TOWN_SPEED if self.speed is None else self.speed
        return min(speed, defaults.SHIFT_SPEED) * _shift_time(self.shift)


@lru_cache(maxsize=_REMEMBERED)
def _shift_time(shift: float) -> float:
    """Return how long a gentle shift to the side takes, s, by its size, m."""
    return float(cube_root(32 * shift / defaults.SHIFT_JERK))


def taper_ratio(speed: float | None) -> float:
    """Return the length of a taper in multiples of the width that it opens, at a speed in m/s."""
    if _is_slow(speed):
        return defaults.SLOW_TAPER_RATIO
    known = defaults.TOWN_SPEED if speed is None else speed
    share = (known - defaults.TOWN_SPEED) / (defaults.FAST_SPEED - defaults.TOWN_SPEED)
    return defaults.TAPER_RATIO + min(max(share, 0.0), 1.0) * (defaults.TAPER_RATIO_FAST - defaults.TAPER_RATIO)


def _is_slow(speed: float | None) -> bool:
    return speed is not None and speed <= defaults.SLOW_SPEED


def lane_change(
    before: CrossSection,
    after: CrossSection,
    rule: Rule,
    speed: float | None = None,
    stated: Mapping[Direction, StatedLanes] | None = None,
) -> LaneChange:
    """Return what changes from one cross-section to the next, at a speed in m/s."""
    if stated:
        return _change(before, after, match_lanes(before, after, rule, stated), speed)
    return _unstated_change(before, after, rule, speed)


@lru_cache(maxsize=_REMEMBERED)
def _unstated_change(before: CrossSection, after: CrossSection, rule: Rule, speed: float | None) -> LaneChange:
    """Return what changes where no relation says which lanes continue."""
    return _change(before, after, match_lanes(before, after, rule), speed)


def _change(before: CrossSection, after: CrossSection, matched: Mapping[int, int], speed: float | None) -> LaneChange:
    """Return what changes where these lanes continue."""
    pairs = _without_crossings(matched, before)
    old, new = _lanes(before), _lanes(after)
    ending = [lane for lane in old if lane not in pairs]
    opening = [lane for lane in new if lane not in pairs.values()]
    widths = [old[lane][0] for lane in ending] + [new[lane][0] for lane in opening]
    widths += [abs(old[one][0] - new[other][0]) for one, other in pairs.items()]
    aside = [new[other][1] - old[one][1] for one, other in pairs.items()]
    shifts = [abs(item) for item in aside]
    groups = [[old[lane][2] for lane in ending], [new[lane][2] for lane in opening]]
    return LaneChange(
        pairs,
        max(group.count(direction) for group in groups for direction in Direction),
        len(opening) - len(ending),
        max(widths, default=0.0),
        min(shifts, default=0.0),
        max(shifts, default=0.0),
        sum(aside) / max(len(aside), 1),
        _is_row(old, pairs) and _is_row(new, pairs.values()),
        speed,
    )


def _is_row(lanes: Collection[int], some: Collection[int]) -> bool:
    """Say whether some of the lanes of a cross-section, by their ids, lie beside each other."""
    place = {lane: k for k, lane in enumerate(sorted(lanes))}
    found = [place[lane] for lane in some]
    return bool(found) and max(found) - min(found) == len(found) - 1


def _lanes(section: CrossSection) -> dict[int, tuple[float, float, Direction]]:
    """Return the width, t of the middle, m, and the direction of lanes by their ids."""
    return {
        lane.id: (lane.spec.width, lane.t, direction)
        for direction in Direction
        for lane in lanes_of(section, direction, True)
    }


def _without_crossings(pairs: Mapping[int, int], before: CrossSection) -> dict[int, int]:
    """Leave out lanes for bicycles that would change places with lanes for cars: they end, and open anew."""
    out = dict(pairs)
    cars = {lane.id for direction in Direction for lane in lanes_of(before, direction, True) if _counts(lane.spec)}
    for one in sorted(set(pairs) - cars):
        if any((one < a) != (pairs[one] < b) for a, b in out.items() if a != one):
            del out[one]
    return out


def _counts(spec: LaneSpec) -> bool:
    return spec.type in COUNTED_LANES


def room_for_tapers(length: float) -> float:
    """Return how much of a road of some length may be taken by changes of its lanes, m."""
    return max(length - 2 * defaults.STEADY_END, length / 2)
