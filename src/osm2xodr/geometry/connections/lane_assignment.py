"""Which lane leads to which lane through a junction.

Lanes count from 0 at the left, as their drivers see them; turns are changes of heading in radians, positive to the
left. The near side is the one that traffic keeps to: right with right-hand traffic.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from typing import Final

from osm2xodr.defaults import LEAST_TURN_BACK
from osm2xodr.geometry.defaults import STRAIGHT_ON, U_TURN_RADIUS
from osm2xodr.geometry.lanes import left_turns, right_turns
from osm2xodr.model import LaneSpec, LaneType
from osm2xodr.system import record

# The turn that each value of turn:lanes stands for, degrees, by the pictures on the OSM wiki page Key:turn.
_ANGLE: Final = {
    "reverse": 180.0,
    "sharp_left": 135.0,
    "left": 90.0,
    "slight_left": 35.0,
    "through": 0.0,
    "slight_right": -35.0,
    "right": -90.0,
    "sharp_right": -135.0,
}
_SET_APART: Final = (LaneType.BUS, LaneType.TAXI, LaneType.BIKING)
# Turns above this are to a side where a value of turn:lanes asks for one, rad (10 degrees). A choice.
_TO_A_SIDE: Final = math.radians(10.0)
# Arms that turn by less than this into one exit merge side by side, rad (35 degrees, as ``slight_left``). A choice.
_MERGING: Final = math.radians(35.0)


@record
class LaneMovement:
    """A movement between two arms, as lanes see it."""

    # Keys of the arms (any integers)
    entry: int
    exit: int
    turn: float  # Change of heading, left positive, rad
    # For each entry lane, where its middle lies left of the exit's reference line when looking along the exit, m: it
    # says which exit lane lies ahead
    lateral: tuple[float, ...]
    # (entry lane, exit lane) of all its links where a connectivity relation names them
    stated: tuple[tuple[int, int], ...] | None = None


@record
class ArmLanes:
    """Lanes of one arm in one direction of travel, left to right; `t` in the drivers' frame (left positive), m."""

    specs: tuple[LaneSpec, ...]
    t: tuple[float, ...]


LaneLink = tuple[int, int, int]
"""(index of the movement, entry lane, exit lane)."""


def assign_lanes(
    movements: Sequence[LaneMovement], entries: dict[int, ArmLanes], exits: dict[int, ArmLanes], near_side_left: bool
) -> list[LaneLink]:
    """Assign lanes to all movements of one junction; `entries` and `exits` are lanes by arm.

    Every movement gets a lane, every lane of an entry with movements gets a movement, every lane of an exit that is
    reached at all gets a lane that feeds it. Movements whose links a relation names get these and no others.
    """
    if have_one_lane(entries, exits):
        return [(k, 0, 0) for k in range(len(movements))]
    served: dict[int, list[int]] = {}
    links: list[LaneLink] = []
    for entry in sorted({item.entry for item in movements}):
        specs = entries[entry].specs
        leaving = [k for k, item in enumerate(movements) if item.entry == entry]
        leaving.sort(key=lambda k: -movements[k].turn)
        turns = [movements[k].turn for k in leaving]
        capacity = [len(_for_cars(exits[movements[k].exit].specs)) for k in leaving]
        served |= zip(leaving, lanes_per_movement(specs, turns, capacity, near_side_left), strict=True)
        straight = min(leaving, key=lambda k: _straightness(movements[k].turn, near_side_left))
        if abs(movements[straight].turn) < STRAIGHT_ON:
            apart = _set_apart(specs, exits[movements[straight].exit].specs, near_side_left)
            if movements[straight].stated is not None:
                apart = [pair for pair in apart if specs[pair[0]].type is LaneType.BIKING]
            links += [(straight, *pair) for pair in apart]
        else:
            links += _buses_round_corners(specs, leaving, movements, exits, near_side_left)
    for exit_ in sorted({item.exit for item in movements}):
        arriving = [k for k, item in enumerate(movements) if item.exit == exit_]
        links += _into_exit(arriving, movements, served, exits[exit_], entries, near_side_left)
    return sorted(set(links))


def have_one_lane(entries: dict[int, ArmLanes], exits: dict[int, ArmLanes]) -> bool:
    """Whether all arms of a junction have one lane for cars and no other: lane 0 then leads to lane 0."""
    arms = (*entries.values(), *exits.values())
    return all(len(arm.specs) == 1 and arm.specs[0].type is LaneType.DRIVING for arm in arms)


def u_turn_lanes(lateral: Sequence[float], entry: ArmLanes, exit_: ArmLanes, near_side_left: bool) -> tuple[int, int]:
    """Return the lanes of a U-turn: the innermost one, and the innermost one that cars reach from there.

    `lateral` is as in `LaneMovement`. Where all lanes are too near, the outermost one is taken.
    """
    ins, outs = _for_cars(entry.specs), _for_cars(exit_.specs)
    if near_side_left:
        ins, outs = ins[::-1], outs[::-1]
    reached = [k for k in outs if abs(lateral[ins[0]] - exit_.t[k]) >= 2 * U_TURN_RADIUS]
    return ins[0], (reached or outs[-1:])[0]


def lead_on_against_cars(
    entry: Sequence[LaneSpec], exit_: Sequence[LaneSpec], kind: Collection[LaneType], near_side_left: bool
) -> list[tuple[int, int]]:
    """Link lanes of some types where no car may go: to their like, else to lanes for cars."""
    return [
        (one, other)
        for one, other in _set_apart(entry, exit_, near_side_left, alone=True)
        if entry[one].type in kind and exit_[other].type in (entry[one].type, LaneType.DRIVING)
    ]


def _set_apart(
    entry: Sequence[LaneSpec], exit_: Sequence[LaneSpec], near_side_left: bool, *, alone: bool = False
) -> list[tuple[int, int]]:
    """Link the lanes set apart for buses, taxis and bicycles: to their like, buses else to cars' lanes.

    An entry with no other lanes than those of one kind has lanes for all. Where they are `alone`, no car may go.
    """
    pairs: list[tuple[int, int]] = []
    for kind in _SET_APART:
        ins = [k for k, spec in enumerate(entry) if spec.type is kind]
        outs = [k for k, spec in enumerate(exit_) if spec.type is kind]
        if not near_side_left:
            ins, outs = ins[::-1], outs[::-1]
        pairs += zip(ins, outs, strict=False)
        if alone or (kind is not LaneType.BIKING and len(ins) != len(entry)):
            usable = _for_cars(exit_)
            middle = (len(entry) - 1) / 2
            for k in ins[len(outs) :]:
                at_left = k < middle or (k == middle and not near_side_left)
                pairs.append((k, usable[0] if at_left else usable[-1]))
    return pairs


def _buses_round_corners(
    entry: Sequence[LaneSpec],
    leaving: Sequence[int],
    movements: Sequence[LaneMovement],
    exits: dict[int, ArmLanes],
    near_side_left: bool,
) -> list[LaneLink]:
    """Link the lanes for buses and taxis of an entry that no movement leads straight on from.

    `leaving` are the movements of the entry from left to right.
    """
    ways = [k for k in leaving if abs(movements[k].turn) < LEAST_TURN_BACK] or leaving
    middle = (len(entry) - 1) / 2
    links: list[LaneLink] = []
    for way, at_left in ((ways[0], True), (ways[-1], False)):
        if movements[way].stated is None:
            links += [
                (way, one, other)
                for one, other in _set_apart(entry, exits[movements[way].exit].specs, near_side_left)
                if entry[one].type is not LaneType.BIKING
                and at_left == (one < middle or (one == middle and not near_side_left))
            ]
    return links


def _straightness(turn: float, near_side_left: bool) -> tuple[float, float]:
    """Return a key by which the straightest turn comes first; of two, the one to the far side."""
    return abs(turn), turn if near_side_left else -turn


def _for_cars(specs: Sequence[LaneSpec]) -> list[int]:
    """Return the lanes for cars; all lanes where there is none."""
    found = [k for k, spec in enumerate(specs) if spec.type is LaneType.DRIVING]
    return found or list(range(len(specs)))


def lanes_per_movement(
    specs: Sequence[LaneSpec], turns: Sequence[float], capacity: Sequence[int], near_side_left: bool = False
) -> list[list[int]]:
    """Return for each movement, sorted from left to right, the entry lanes that serve it.

    `specs` are the entry's lanes, `turns` and `capacity` the turn of each movement and the lanes of its exit.
    """
    lanes = _for_cars(specs)
    if len(turns) == 1:
        return [lanes]
    marked = [specs[k].turns & _ANGLE.keys() for k in lanes]
    if any(marked):
        chosen = _by_marks(marked, turns, near_side_left)
    else:
        chosen = _by_habit(len(lanes), turns, capacity, near_side_left)
    return [[lanes[k] for k in numbers] for numbers in chosen]


def _by_marks(marked: Sequence[frozenset[str]], turns: Sequence[float], near_side_left: bool) -> list[list[int]]:
    """Follow turn:lanes; a movement that it names nowhere gets a lane beside its neighbours', so that none cross."""
    straight = min(range(len(turns)), key=lambda m: _straightness(turns[m], near_side_left))
    chosen: list[set[int]] = [set() for _ in turns]
    for lane, values in enumerate(marked):
        for value in sorted(values) or ["through"]:
            chosen[_meant(value, turns, straight, near_side_left)].add(lane)
    for m, lanes in enumerate(chosen):
        if not lanes:
            left = [max(found) for found in chosen[:m] if found]
            right = [min(found) for found in chosen[m + 1 :] if found]
            from_right = not left or (near_side_left and bool(right))
            lanes.add(min(right) if from_right else max(left))
    return [sorted(lanes) for lanes in chosen]


def _meant(value: str, turns: Sequence[float], straight: int, near_side_left: bool) -> int:
    """Return the movement that a value of turn:lanes means; ``reverse`` turns back across the far side."""
    if value == "through":
        return straight
    left = value in left_turns(near_side_left)
    sign = 1.0 if left else -1.0
    target = sign * abs(math.radians(_ANGLE[value]))
    beyond_straight = sign * turns[straight] > _TO_A_SIDE
    found = [
        m
        for m, turn in enumerate(turns)
        if sign * turn > _TO_A_SIDE and (beyond_straight or (m < straight if left else m > straight))
    ]
    return min(found, key=lambda m: abs(turns[m] - target)) if found else 0 if left else len(turns) - 1


def _by_habit(n: int, turns: Sequence[float], capacity: Sequence[int], near_side_left: bool) -> list[list[int]]:
    """Share out n unmarked lanes: turns from the outer lanes, straight on from all."""
    everything = list(range(n))
    ahead = [m for m, turn in enumerate(turns) if abs(turn) < STRAIGHT_ON]
    if len(ahead) >= 2 and n >= 2:
        return _fork(n, turns, capacity, ahead, near_side_left)
    if ahead:
        straight = min(ahead, key=lambda m: _straightness(turns[m], near_side_left))
        return [[0] if m < straight else everything if m == straight else [n - 1] for m in range(len(turns))]
    left = [m for m, turn in enumerate(turns) if turn > 0]
    if not left or len(left) == len(turns):
        return _fork(n, turns, capacity, list(range(len(turns))), near_side_left)
    lefts, rights = everything[: (n + 1) // 2], everything[n // 2 :]
    return [lefts if turn > 0 else rights for turn in turns]


def _fork(
    n: int, turns: Sequence[float], capacity: Sequence[int], ahead: Sequence[int], near_side_left: bool
) -> list[list[int]]:
    """Share out lanes where the street splits into the branches `ahead`, so that no lane crosses another.

    Where there are lanes for all branches, each gets its own, side by side; spare lanes go to the larger one of two
    branches, or to the one on the far side. Where lanes are too few, the straightest branch takes as many as its exit
    has, and the lane at its edge is shared with the next branch. Other movements use the outermost lane.
    """
    wanted = {m: min(n, max(capacity[m], 1)) for m in ahead}
    straight = min(ahead, key=lambda m: _straightness(turns[m], near_side_left))
    spare = n - sum(wanted.values())
    if spare >= 0:
        far = ahead[-1] if near_side_left else ahead[0]
        most = max(ahead, key=lambda m: (wanted[m], m == far)) if len(ahead) == 2 else straight
        wanted[most] += spare
        starts = [sum(wanted[m] for m in ahead[:k]) for k in range(len(ahead))]
    elif len(ahead) == 2:
        other = ahead[0] + ahead[1] - straight
        wanted[other] = max(min(wanted[other], n + 1 - wanted[straight]), 1)
        starts = [0, n - wanted[ahead[1]]]
    else:
        wanted = {m: n if m == straight else 1 for m in ahead}
        starts = [0 if m <= straight else n - 1 for m in ahead]
    out = [[0] if m < ahead[0] else [n - 1] for m in range(len(turns))]
    for m, start in zip(ahead, starts, strict=True):
        out[m] = list(range(start, start + wanted[m]))
    return out


def _into_exit(
    arriving: Sequence[int],
    movements: Sequence[LaneMovement],
    served: dict[int, list[int]],
    exit_lanes: ArmLanes,
    entries: dict[int, ArmLanes],
    near_side_left: bool,
) -> list[LaneLink]:
    """Choose the exit lanes of all movements into one exit, and feed the lanes that nothing leads to."""
    usable = _for_cars(exit_lanes.specs)
    n = len(usable)
    links: list[LaneLink] = [(k, *pair) for k in arriving for pair in movements[k].stated or ()]
    arriving = [k for k in arriving if movements[k].stated is None]
    merging = [k for k in arriving if abs(movements[k].turn) < _MERGING]
    blocks = _merge_offsets(merging, movements, served, n, near_side_left)
    for k in arriving:
        lanes = served[k]
        entry = entries[movements[k].entry].specs
        offset = blocks[k] if k in blocks else _offset(movements[k], lanes, entry, exit_lanes, usable, near_side_left)
        links += [(k, lane, usable[min(max(r + offset, 0), n - 1)]) for r, lane in enumerate(lanes)]
    fed = {lane for _, _, lane in links}
    unfed = [lane for lane in usable if lane not in fed]
    if unfed and arriving:

        def rank(k: int) -> tuple[bool, int, float, float]:
            turn = movements[k].turn
            return abs(turn) > STRAIGHT_ON, -len(served[k]), *_straightness(turn, near_side_left)

        main = min(arriving, key=rank)
        targets = sorted((to, lane) for k, lane, to in links if k == main)
        for lane in unfed:
            nearest = min(targets, key=lambda pair: (abs(pair[0] - lane), pair))
            links.append((main, nearest[1], lane))
    return links


def _merge_offsets(
    merging: Sequence[int],
    movements: Sequence[LaneMovement],
    served: dict[int, list[int]],
    n: int,
    near_side_left: bool,
) -> dict[int, int]:
    """Give each of several arms that run straight into one exit its own lanes, from left to right.

    The first keeps to the left, the last to the right, those between to the far side.
    """
    if len(merging) < 2:
        return {}
    side_by_side = sorted(
        merging, key=lambda k: -sum(movements[k].lateral[lane] for lane in served[k]) / len(served[k])
    )
    counts = [len(served[k]) for k in side_by_side]
    out: dict[int, int] = {}
    taken = 0
    for place, (k, count) in enumerate(zip(side_by_side, counts, strict=True)):
        to_come = sum(counts[place + 1 :])
        if place == 0:
            out[k] = 0
        elif not to_come:
            out[k] = n - count
        else:
            out[k] = max(n - count - to_come, 0) if near_side_left else min(taken, n - count)
        taken += count
    return out


def _offset(
    movement: LaneMovement,
    lanes: Sequence[int],
    entry: Sequence[LaneSpec],
    exit_lanes: ArmLanes,
    usable: Sequence[int],
    near_side_left: bool,
) -> int:
    """Return by how much exit lanes count higher than entry lanes: 0 keeps left, n - k keeps right.

    Straight on, lanes avoid pockets for turns that are not theirs, and shift aside as little as they can.
    """
    slack = len(usable) - len(lanes)
    if slack == 0 or movement.turn > STRAIGHT_ON:
        return 0
    if movement.turn < -STRAIGHT_ON:
        return slack
    candidates = range(min(slack, 0), max(slack, 0) + 1)

    def misfit(offset: int) -> tuple[int, float]:
        wrong, shift = 0, 0.0
        for r, lane in enumerate(lanes):
            to = usable[min(max(r + offset, 0), len(usable) - 1)]
            side = _side(exit_lanes.specs[to], near_side_left)
            wrong += slack > 0 and side != 0 and side != _side(entry[lane], near_side_left)
            shift += abs(movement.lateral[lane] - exit_lanes.t[to])
        return wrong, round(shift, 2)

    prefer_high = near_side_left == (slack > 0)
    return min(candidates, key=lambda offset: (misfit(offset), -offset if prefer_high else offset))


def _side(spec: LaneSpec, near_side_left: bool) -> int:
    """Return 1 for a lane for turns to the left alone, -1 for one for turns to the right alone, 0 for others."""
    own = spec.turns & _ANGLE.keys()
    if not own:
        return 0
    return 1 if own <= left_turns(near_side_left) else -1 if own <= right_turns(near_side_left) else 0
