"""Traffic lights by their signal programmes: what each shows when, and those on the way of a car."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, partial
from itertools import accumulate
from typing import Final

import numpy as np

from osm2xodr.model import Furniture, Signal, SignalLink, SignalProgramme
from osm2xodr.starting.lanes import LaneNetwork, Path
from osm2xodr.starting.motion import Light

# A car stops this far before a junction with its reference point, the middle of the rear axle, m: a metre, and the
# length of a car before that point.
_STOP_BEFORE: Final = 5.0
# OpenDRIVE's type of lights for vehicles.
_LIGHT: Final = "1000001"
# What vehicles may go at.
_GO: Final = frozenset("Ggo")
# Letters of programmes in the order in which one of several ways of a light decides what it shows.
_RANKS: Final = "Ggyro"


@dataclass(frozen=True)
class Programme:
    """The programme of a junction's lights, with what each shows in each phase."""

    plan: SignalProgramme
    signals: dict[int, str]  # Letters of each light, a phase each, by the id of the signal

    @cached_property
    def ends(self) -> list[float]:
        """When each phase ends, s from the begin of the cycle."""
        return list(accumulate(phase.duration for phase in self.plan.phases))

    @property
    def cycle(self) -> float:
        """How long all phases take, s."""
        return self.ends[-1]

    def letter(self, link: int, time: float) -> str:
        """Return what a link of the programme shows at a time, s."""
        at = time % self.cycle
        k = next((k for k, end in enumerate(self.ends) if at < end), 0)
        return self.plan.phases[k].state[link]

    def next_green(self, link: int, time: float) -> float:
        """Return when a link may be used from a time on, s; the time itself if it is never shut."""
        begin = time - time % self.cycle
        starts = [0.0, *self.ends[:-1]]
        times = [begin + turn * self.cycle + start for turn in (0, 1) for start in starts]
        return next((at for at in times if at >= time and self.letter(link, at) in _GO), time)


def programmes_of(furniture: Furniture) -> list[Programme]:
    """Return the programmes of all junctions that have one."""
    lights = [item for item in furniture.signals if item.type == _LIGHT and item.validity]
    out = []
    for plan in furniture.programmes:
        shown = {}
        for light in lights:
            links = [k for k, link in enumerate(plan.links) if _governs(light, link)]
            if links:
                letters = (min((phase.state[k] for k in links), key=_RANKS.index) for phase in plan.phases)
                shown[light.id] = "".join(letters)
        out.append(Programme(plan, shown))
    return out


def _governs(light: Signal, link: SignalLink) -> bool:
    """Whether a light is for a way through a junction: it has the lane that this begins on."""
    here = light.road == link.road and (light.orientation == "+") == link.at_end
    return here and any(min(pair) <= link.lane <= max(pair) for pair in light.validity)


def lights_on(path: Path, network: LaneNetwork, programmes: list[Programme]) -> list[Light]:
    """Return the lights that a car passes on a path."""
    by_way = {
        (str(link.connecting_road), link.lane): (programme, k)
        for programme in programmes
        for k, link in enumerate(programme.plan.links)
    }
    out = []
    for n in range(1, len(path.nodes)):
        way, before = network.lane(path.nodes[n]), network.lane(path.nodes[n - 1])
        found = by_way.get((way[0], before[1]))
        if found is not None and network.in_junction[path.nodes[n]]:
            programme, link = found
            at = float(path.distance[np.searchsorted(path.node, n)]) - _STOP_BEFORE
            green = partial(_is_green, programme, link)
            out.append(Light(at, green, partial(programme.next_green, link)))
    return out


def _is_green(programme: Programme, link: int, time: float) -> bool:
    return programme.letter(link, time) in _GO
