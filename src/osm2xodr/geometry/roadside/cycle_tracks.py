"""Cycle tracks lead straight on through junctions, whatever lies between them and the carriageway on either arm."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from typing import Final

import numpy as np

from osm2xodr.curves import ranks, unique_counts, unique_rows, wrapped
from osm2xodr.geometry.connections import ConnectingRoads
from osm2xodr.geometry.defaults import STRAIGHT_ON
from osm2xodr.geometry.junctions import RoadParts, end_poses
from osm2xodr.geometry.lanes import end_lanes
from osm2xodr.geometry.roadside.corner_lanes import strips_at_end
from osm2xodr.geometry.roadside.corner_pairs import Corners, Walks
from osm2xodr.geometry.roadside.corner_strips import Sidewalk
from osm2xodr.geometry.roadside.sidewalk_corners import draw_corners
from osm2xodr.geometry.roadside.strips import Margins
from osm2xodr.model import FloatArray, IntArray, LaneType, Rule

# Strips that end at junctions where nothing leads them on.
_ENDING: Final = frozenset({LaneType.BIKING, LaneType.PARKING, LaneType.RESTRICTED})

_Link = tuple[int, int, int, int]  # Road end and lane id that a lane through a junction comes from, and leads to


def with_cycle_tracks(
    corners: ConnectingRoads, parts: RoadParts, margins: Sequence[Margins], cars: ConnectingRoads, rule: Rule
) -> ConnectingRoads:
    """Return sidewalks round corners, and cycle tracks that lead straight on past side streets, by junction.

    Tracks are low there, as cars cross them. Lanes for bicycles on the carriageway lead on to tracks, too, and tracks
    to these; how lanes lead on to lanes is among the roads of `cars`.
    """
    tracks = _straight_on(parts, margins, cars, _linked(cars, corners), rule)
    if tracks is None:
        return corners
    many = 2 * len(parts.length)
    arms, of_cars = (
        np.minimum(rows.entry, rows.exit) * many + np.maximum(rows.entry, rows.exit) for rows in (tracks, cars)
    )
    every = corners
    for rows in _one_pair_of_each_junction(tracks.junction, arms):
        # All others cross the tracks.
        beside = cars.chosen(np.flatnonzero(np.isin(of_cars, arms[rows])))
        drawn, _, good = draw_corners(tracks.chosen(rows), cars, beside, parts, rule)
        every = every.joined(drawn.chosen(good))
    return every.chosen(np.argsort(every.junction, kind="stable"))


def _one_pair_of_each_junction(junction: IntArray, arms: IntArray) -> Iterator[IntArray]:
    """Yield rows in turn, those of one pair of arms of each junction at a time."""
    pairs = unique_rows(np.column_stack([junction, arms]))
    turn = ranks(unique_counts(pairs.values[:, 0])[1])[pairs.inverse]
    for k in range(int(turn.max()) + 1):
        yield np.flatnonzero(turn == k)


def ends_of_strips(
    parts: RoadParts, margins: Sequence[Margins], cars: ConnectingRoads, corners: ConnectingRoads
) -> Iterator[tuple[int, int]]:
    """Yield road ends and sides (left 1, right -1) at which tracks or parking end that have nothing outside of them.

    No sidewalk leads the kerb of such parking round a corner.
    """
    linked = {
        place for one, lane, other, beyond in _linked(cars, corners) for place in ((one, lane), (other, beyond))
    }
    for end in np.union1d(cars.entry, cars.exit).tolist():
        beside = margins[end // 2]
        for side in (1, -1) if beside else ():
            strips = beside[-(end % 2)].strips(side)
            if strips and strips[-1].type in _ENDING:
                lane, _ = strips_at_end(parts, beside, end, side)[-1]
                if (end, lane) not in linked:
                    yield end, side


def _linked(cars: ConnectingRoads, corners: ConnectingRoads) -> set[_Link]:
    """Return what lanes for bicycles link already."""
    out: set[_Link] = set()
    for rows in (cars, corners):
        columns = (column.tolist() for column in (rows.entry, rows.entry_lane, rows.exit, rows.exit_lane))
        for one, lane, other, lane_beyond, kind, inner in zip(*columns, rows.lane_type, rows.inner, strict=True):
            if kind is LaneType.BIKING:
                out.add((one, lane, other, lane_beyond))
            for item in inner:
                if item.type is LaneType.BIKING and item.entry_lane is not None and item.exit_lane is not None:
                    out.add((one, item.entry_lane, other, item.exit_lane))
    return out


def _straight_on(
    parts: RoadParts, margins: Sequence[Margins], cars: ConnectingRoads, linked: set[_Link], rule: Rule
) -> Corners | None:
    """Return the cycle tracks that have one straight ahead and do not lead there yet."""
    found: list[tuple[int, int, int, Sidewalk, Sidewalk, tuple[int, ...]]] = []
    arms: dict[int, set[int]] = defaultdict(set)
    end_junction = parts.end_junction.ravel()
    for end in np.union1d(cars.entry, cars.exit).tolist():
        arms[int(end_junction[end])].add(end)
    for one, other in _straight_pairs(parts, cars):
        ways_in = _cycle_lanes(parts, margins[one // 2], one, rule, True)
        # Most roads have none.
        ways_out = _cycle_lanes(parts, margins[other // 2], other, rule, False) if ways_in else []
        junction = int(end_junction[one])
        for first, second in zip(ways_in, ways_out, strict=False):
            lane_to_lane = not any(_is_track(parts, end, walk) for end, walk in ((one, first), (other, second)))
            if not lane_to_lane and (one, first.lane, other, second.lane) not in linked:
                passed = tuple(sorted(arms[junction] - {one, other}))
                found.append((junction, one, other, first, second, passed))
    if not found:
        return None
    *ends, first_of, second_of, passed_of = zip(*found, strict=True)
    junction_of, entry, exit_ = (np.array(column, np.int64) for column in ends)
    return Corners(junction_of, entry, exit_, Walks.of(first_of), Walks.of(second_of), passed_of)


def _straight_pairs(parts: RoadParts, cars: ConnectingRoads) -> Iterable[tuple[int, int]]:
    """Return the arms with one straight ahead, each with the straightest: that to which cars drive from there.

    Beside one-way streets tracks also lead against the cars, from where these leave to where they come from.
    """
    rows = np.flatnonzero(cars.for_vehicles() & (cars.entry != cars.exit))
    entry, exit_ = cars.entry[rows], cars.exit[rows]
    turn = np.abs(wrapped(_outwards(parts, exit_) - _outwards(parts, entry) - np.pi))
    ahead: dict[int, tuple[float, int]] = {}
    against: dict[int, tuple[float, int]] = {}
    for one, other, angle in zip(entry.tolist(), exit_.tolist(), turn.round(6).tolist(), strict=True):
        if angle < STRAIGHT_ON:
            ahead[one] = min(ahead.get(one, (angle, other)), (angle, other))
            against[other] = min(against.get(other, (angle, one)), (angle, one))
    return [(one, other) for one, (_, other) in sorted((against | ahead).items())]


def _outwards(parts: RoadParts, ends: IntArray) -> FloatArray:
    """Return the headings away from the junction at road ends, rad."""
    return np.asarray(end_poses(parts, ends)[2] + np.where(ends % 2 == 1, np.pi, 0.0))


def _cycle_lanes(parts: RoadParts, margins: Margins, end: int, rule: Rule, into: bool) -> list[Sidewalk]:
    """Return the lanes for bicycles and cycle tracks into a junction (or out of it), outwards."""
    section = parts.at_end(end).section
    along = into == (end % 2 == 1)
    some = any(spec.type is LaneType.BIKING for spec in (*section.left, *section.right))
    lanes = [item for item in end_lanes(section, rule, along) if item.spec.type is LaneType.BIKING] if some else []
    out = [Sidewalk(item.id, item.t, item.spec.width, 0.0, (), LaneType.BIKING) for item in lanes]
    side = -1 if along == (rule is Rule.RIGHT_HAND) else 1
    t = section.left_edge if side > 0 else section.right_edge
    for lane, strip in strips_at_end(parts, margins, end, side):
        if strip.type is LaneType.BIKING:
            out.append(Sidewalk(lane, t + side * strip.width / 2, strip.width, strip.height, (), LaneType.BIKING))
        t += side * strip.width
    return out


def _is_track(parts: RoadParts, end: int, walk: Sidewalk) -> bool:
    """Whether a lane for bicycles at a road end lies beside the carriageway."""
    section = parts.at_end(end).section
    return abs(walk.lane) > len(section.left if walk.lane > 0 else section.right)
