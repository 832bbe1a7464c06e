"""Signal programmes: which movements through a junction with lights are green together, and for how long.

OpenStreetMap has none of this. In the groups of `osm2xodr.furniture.lights.phases` nobody ever meets anybody. Here
drivers who turn across oncoming traffic yield to it within the green, as at most real lights: each stage of a
programme is for arms of which at most such turns meet. Green lasts as long as vehicles that it lets go lose time,
within limits.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import combinations
from typing import Final

import numpy as np

from osm2xodr.furniture import defaults
from osm2xodr.furniture.lights.heads import THROUGH, Head, turn_of
from osm2xodr.furniture.lights.phases import Phases, grouped
from osm2xodr.furniture.world import Approach, Movement, World
from osm2xodr.model import BoolArray, Rule, SignalLink, SignalPhase, SignalProgramme

# The letters of `osm2xodr.model.SignalPhase`.
_GO_FIRST: Final = "G"
_YIELD: Final = "g"
_YELLOW: Final = "y"
_RED: Final = "r"
_NO_LIGHT: Final = "o"
_GREEN: Final = _GO_FIRST + _YIELD


def junction_programmes(
    world: World,
    approaches: Sequence[Approach],
    heads: Sequence[Head],
    members: Mapping[int, Sequence[int]],
    phases: Phases,
) -> list[SignalProgramme]:
    """Make the programmes of junctions; `members` are the heads of each, by its id."""
    out = []
    for junction, rows in sorted(members.items()):
        stages = _Stages(world, heads, rows, phases)
        green = stages.greens()
        lit = {(heads[k].approach, movement): n for n, (k, movement) in enumerate(stages.movements)}
        links: dict[SignalLink, int] = {}
        for k, approach in enumerate(approaches):
            for movement in approach.movements if approach.junction == junction else ():
                links.setdefault(_link(approach, movement), lit.get((k, movement), -1))
        states = ["".join(_NO_LIGHT if n < 0 else stage[n] for n in links.values()) for stage in green]
        detectors = defaults.DETECTOR_RANGE if len(states) > 1 else 0.0
        out.append(SignalProgramme(junction, tuple(links), tuple(_phases(states)), detectors))
    return out


def _link(approach: Approach, movement: Movement) -> SignalLink:
    return SignalLink(
        movement.connecting_road,
        approach.road,
        approach.at_end,
        movement.entry_lane,
        movement.exit_road,
        movement.exit_at_start,
        movement.exit_lane,
    )


class _Stages:
    """The stages of one junction."""

    def __init__(self, world: World, heads: Sequence[Head], rows: Sequence[int], phases: Phases) -> None:
        owners, movements, self._meet = phases.meeting(rows)
        self.movements = list(zip(owners, movements, strict=True))  # Each with its head
        self._heads = rows
        self._owner = owners
        self._arms = list(dict.fromkeys(heads[k].approach for k in owners))
        self._arm = np.array([self._arms.index(heads[k].approach) for k in owners], np.int64)
        # Whether a movement turns across oncoming traffic: to the side on which that drives.
        far = 1.0 if world.road_map.rule is Rule.RIGHT_HAND else -1.0
        self._across = np.array([turn_of(item) != THROUGH and item.turn * far > 0.0 for item in movements], bool)
        first = {self._arms.index(heads[k].approach): k for k in reversed(rows)}
        self._opposite = {
            (one, other): off
            for one, other in combinations(range(len(self._arms)), 2)
            if (off := phases.opposite(first[one], first[other])) is not None
        }

    def greens(self) -> list[list[str]]:
        """Return what each movement shows in each stage."""
        pairs = sorted(self._opposite, key=lambda pair: (round(self._opposite[pair], 6), pair))
        stage_of = grouped(self._apart(), range(len(self._arms)), pairs)
        out = []
        for stage in dict.fromkeys(stage_of):
            green = np.array([stage_of[arm] == stage for arm in self._arm.tolist()], bool)
            out.append(self._letters(self._with_free(green)))
        return out

    def _apart(self) -> BoolArray:
        """Return which arms can never be green together, (n, n)."""
        out = np.zeros((len(self._arms), len(self._arms)), bool)
        for i, j in np.argwhere(self._meet).tolist():
            one, other = int(self._arm[i]), int(self._arm[j])
            facing = (min(one, other), max(one, other)) in self._opposite
            if one != other and not (facing and (self._across[i] or self._across[j])):
                out[one, other] = out[other, one] = True
        return out

    def _with_free(self, green: BoolArray) -> BoolArray:
        """Return which movements are green when the heads whose movements meet none of these are green as well."""
        out = green.copy()
        owner = np.array(self._owner, np.int64)
        for head in self._heads:
            own = owner == head
            if not out[own].any() and not self._meet[np.ix_(own, out)].any():
                out |= own
        return out

    def _letters(self, green: BoolArray) -> list[str]:
        """Return the letter of each movement; those that turn across yield to those that they meet."""
        others = green[None, :] & self._meet & (self._arm[:, None] != self._arm[None, :])
        yields = self._across & others.any(axis=1)
        letters = np.where(green, np.where(yields, _YIELD, _GO_FIRST), _RED)
        out: list[str] = letters.tolist()
        return out


def _phases(stages: Sequence[str]) -> list[SignalPhase]:
    """Return the phases of stages: green, yellow where it ends, and red for all that do not go on."""
    between = defaults.YELLOW_TIME + defaults.RED_TIME
    if len(stages) == 1:
        # Cars wait for people only.
        stages = (stages[0], "".join(letter if letter == _NO_LIGHT else _RED for letter in stages[0]))
        times = [defaults.CYCLE_TIME - between - defaults.PEOPLE_TIME, defaults.PEOPLE_TIME]
        limits = None
    else:
        limits = defaults.GREEN_TIMES
        times = [max(defaults.CYCLE_TIME / len(stages) - between, limits[0])] * len(stages)
    out = []
    for k, (stage, time) in enumerate(zip(stages, times, strict=True)):
        then = stages[(k + 1) % len(stages)]
        ends = [now in _GREEN and letter == _RED for now, letter in zip(stage, then, strict=True)]
        out.append(SignalPhase(stage, time, limits))
        for letter, pause in ((_YELLOW, defaults.YELLOW_TIME), (_RED, defaults.RED_TIME)) if any(ends) else ():
            shown = (letter if end else now for now, end in zip(stage, ends, strict=True))
            out.append(SignalPhase("".join(shown), pause))
    return out
