"""From roads as they were laid out to what the elevation solve is asked."""

from __future__ import annotations

import numpy as np

from osm2xodr.diagnostics import Diagnostics
from osm2xodr.geometry.connections import ConnectingRoads
from osm2xodr.geometry.heights import ConnectorProblem, ProfileProblem
from osm2xodr.geometry.junctions import JunctionLayout, RoadParts
from osm2xodr.geometry.margins import inner_width
from osm2xodr.geometry.plan_view import FittedStreets
from osm2xodr.geometry.profile_tags import tagged_heights
from osm2xodr.model import LaneType, StreetAttributes, StreetNetwork


def profile_problem(
    network: StreetNetwork,
    fitted: FittedStreets,
    layout: JunctionLayout,
    parts: RoadParts,
    diagnostics: Diagnostics,
) -> ProfileProblem:
    """Ask for the heights of all roads: their spans carry structure, class and grade tags.

    Roads get the ids 1, 2, 3 … that they have in OpenDRIVE.
    """
    spans: list[tuple[float, StreetAttributes]] = []
    middle: list[float] = []
    count: list[int] = []
    for k, street in enumerate(parts.street.tolist()):
        begin, end = float(parts.begin[k]), float(parts.begin[k] + parts.length[k])
        pieces = fitted.pieces[street]
        here = [
            piece
            for i, piece in enumerate(pieces)
            if piece[0] < end and (i + 1 == len(pieces) or pieces[i + 1][0] > begin)
        ] or [pieces[-1]]
        spans += [(max(s - begin, 0.0) if i else 0.0, attributes) for i, (s, attributes, _) in enumerate(here)]
        middle += [(section.left_edge + section.right_edge) / 2 for _, _, section in here]
        count.append(len(here))
    places = [[(network.intersections[n].x, network.intersections[n].y) for n in nodes] for nodes in layout.nodes]
    xy = np.array([np.mean(group, axis=0) if len(group) > 1 else group[0] for group in places]).reshape(-1, 2)
    names: dict[str, int] = {}
    ele_road, ele_s, ele_z = tagged_heights(network, parts.plan_view, parts.street, diagnostics)
    return ProfileProblem(
        plan_view=parts.plan_view,
        end_junction=parts.end_junction,
        end_link=parts.end_link,
        junction_xy=xy,
        span_start=np.concatenate([[0], np.cumsum(count)]).astype(np.int64),
        span_s=np.array([s for s, _ in spans]),
        span_structure=np.array([a.structure.value for _, a in spans], np.int64),
        span_layer=np.array([a.layer for _, a in spans], np.int64),
        span_highway=tuple(a.highway for _, a in spans),
        span_grade=np.array([np.nan if a.grade is None else a.grade for _, a in spans]),
        span_way=np.array([a.osm_way_id for _, a in spans], np.int64),
        span_name=np.array(
            [names.setdefault(a.ref or a.name, len(names)) if a.ref or a.name else -1 for _, a in spans]
        ),
        span_oneway=np.array([_oneway(a) for _, a in spans], np.int64),
        span_width=np.array([sum(lane.width for lane in a.lanes_ltr) for _, a in spans]),
        span_middle=np.array(middle),
        ele_road=ele_road,
        ele_s=ele_s,
        ele_z=ele_z,
        road_id=np.arange(1, len(parts.length) + 1, dtype=np.int64),
    )


def _oneway(attributes: StreetAttributes) -> int:
    """Return 1 where all traffic runs along the street, -1 where all runs against it, 0 else."""
    directions = attributes.car_directions()
    return next(iter(directions)).value if len(directions) == 1 else 0


def connector_problem(connecting: ConnectingRoads) -> ConnectorProblem:
    """Ask for the heights of all connecting roads; those of sidewalks follow what cars drive on."""
    aside = np.maximum(np.abs(connecting.entry_aside), np.abs(connecting.exit_aside))
    # A sidewalk that goes its own way runs along its middle, with all that lies inside of it at one side.
    aside = np.where(aside > 0.0, aside, np.maximum(*inner_width(connecting)))
    return ConnectorProblem(
        plan_view=connecting.plan_view,
        junction=connecting.junction,
        start_end=connecting.entry,
        end_end=connecting.exit,
        start_t=connecting.entry_t,
        end_t=connecting.exit_t,
        half_width=np.minimum(connecting.entry_width, connecting.exit_width) / 2 + aside,
        beside=np.array([kind is LaneType.SIDEWALK for kind in connecting.lane_type], bool),
    )
