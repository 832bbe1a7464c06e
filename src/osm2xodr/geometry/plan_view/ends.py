"""The ends of streets as flat arrays: what junctions need to know of the streets that meet in them.

Street end number 2 k is the start of street k, number 2 k + 1 its end. Seen from a junction, an end runs outwards:
its distance u grows away from the junction, its left is left of the outward direction.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from osm2xodr.curves import (
    arctan2,
    find_record,
    heading_at,
    hypot,
    lengths,
    pose,
    running_lengths,
    starts,
    sum_before,
)
from osm2xodr.geometry.defaults import ARM_REACH, ARM_REACH_MOTORWAY, FAST_HIGHWAYS
from osm2xodr.geometry.lanes import CrossSection
from osm2xodr.geometry.plan_view import defaults
from osm2xodr.model import BoolArray, Direction, FloatArray, IntArray, PlanView, StreetNetwork, Structure


@dataclass(frozen=True, slots=True, eq=False)
class StreetEnds:
    """All ends of all streets."""

    plan_view: PlanView  # Curves of the streets
    length: FloatArray  # (ends,) Length of the end's street, m
    node: IntArray  # (ends,) Intersection that it lies at; -1 for rings without one
    # (ends,) Edges of the carriageway left (positive) and right (negative) of the outward direction, m
    left: FloatArray
    right: FloatArray
    hdg: FloatArray  # (ends,) Outward heading at the node, rad
    # (ends,) Whether cars drive on it into the junction, and out of it
    enters: BoolArray
    leaves: BoolArray
    kerb: FloatArray  # (ends,) Radius that its corners should have, m
    reach: FloatArray  # (ends,) How far along it its junction may reach, m
    # (ends,) Part of a roundabout; on a bridge or in a tunnel; OSM's layer
    roundabout: BoolArray
    raised: BoolArray
    layer: IntArray
    aside: FloatArray  # (ends,) How far left of the line of OSM, in the outward direction, the end's curve lies, m
    lines: PlanView  # OSM's lines of the streets
    # (streets + 1,) Where the pieces of each street begin; (pieces,) where each begins along it, m, and its level:
    # equal numbers for equal layers and structures
    piece_start: IntArray
    piece_s: FloatArray
    piece_level: IntArray

    def levels(self, end: IntArray, u: FloatArray) -> IntArray:
        """Return the level at distances u from the node along ends, both (n,), m."""
        place = np.where(end % 2 == 1, self.length[end] - u, u)
        return self.piece_level[find_record(self.piece_start, self.piece_s, end // 2, place)]


def street_ends(
    network: StreetNetwork,
    plan: PlanView,
    sections: tuple[tuple[CrossSection, CrossSection], ...],
    aside: FloatArray | None = None,
) -> StreetEnds:
    """Collect the ends of all streets; `sections` are those at each street's start and end.

    `aside` (streets,) is how far left of the lines of OSM the curves lie, m; 0 if left out.
    """
    streets = network.streets
    length = np.repeat(lengths(plan), 2)
    end = np.arange(2 * len(streets))
    at_end = end % 2 == 1
    hdg = heading_at(plan, end // 2, np.where(at_end, length, 0.0)) + np.where(at_end, np.pi, 0.0)
    attributes = [piece[1] for street in streets for piece in (street.pieces[0], street.pieces[-1])]
    left_edge = np.array([section.left_edge for pair in sections for section in pair])
    right_edge = np.array([section.right_edge for pair in sections for section in pair])
    directions = [item.car_directions() for item in attributes]
    forward = np.array([Direction.FORWARD in item for item in directions], bool)
    backward = np.array([Direction.BACKWARD in item for item in directions], bool)
    highway = [item.highway for item in attributes]
    return StreetEnds(
        plan_view=plan,
        length=length,
        node=np.array([node for street in streets for node in (street.start, street.end)], np.int64),
        left=np.where(at_end, -right_edge, left_edge),
        right=np.where(at_end, -left_edge, right_edge),
        hdg=hdg,
        enters=np.where(at_end, forward, backward),
        leaves=np.where(at_end, backward, forward),
        kerb=np.array([defaults.KERB_RADIUS.get(h, defaults.KERB_RADIUS_OTHER) for h in highway]),
        reach=np.array([ARM_REACH_MOTORWAY if h in FAST_HIGHWAYS else ARM_REACH for h in highway]),
        roundabout=np.array([item.roundabout for item in attributes], bool),
        raised=np.array([item.structure is not Structure.GROUND for item in attributes], bool),
        layer=np.array([item.layer for item in attributes], np.int64),
        aside=np.zeros(len(end)) if aside is None else np.repeat(aside, 2) * np.where(at_end, -1.0, 1.0),
        lines=_straight_lines([street.points for street in streets]),
        piece_start=starts([len(street.pieces) for street in streets]),
        piece_s=_piece_places(network, length[0::2]),
        piece_level=np.array(
            [3 * item.layer + item.structure.value for street in streets for _, item in street.pieces], np.int64
        ),
    )


def _piece_places(network: StreetNetwork, length: FloatArray) -> FloatArray:
    """Return where the pieces of streets begin along curves of this length, (streets,), m."""
    out: list[float] = []
    for street, size in zip(network.streets, length.tolist(), strict=True):
        if len(street.pieces) == 1:
            out.append(0.0)
            continue
        chainage = running_lengths(street.points)
        out += (chainage[[first for first, _ in street.pieces]] * (size / chainage[-1])).tolist()
    return np.array(out)


def _straight_lines(polylines: list[FloatArray]) -> PlanView:
    """Return polylines as curves, of a straight line from each of their points to the next."""
    points, start = np.concatenate(polylines), starts([len(item) for item in polylines])
    begins = np.delete(np.arange(len(points)), start[1:] - 1)
    x, y = points[begins].T
    dx, dy = (points[begins + 1] - points[begins]).T
    size, start = hypot(dx, dy), start - np.arange(len(start))
    return PlanView(start, sum_before(size, start), x, y, arctan2(dy, dx), size, np.zeros(len(size)))


def outward_pose(ends: StreetEnds, end: IntArray, u: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return x, y and outward heading at distance u from the node along ends, all (n,)."""
    at_end = end % 2 == 1
    s = np.where(at_end, ends.length[end] - u, u)
    x, y, hdg = pose(ends.plan_view, end // 2, s)
    return x, y, hdg + np.where(at_end, np.pi, 0.0)
