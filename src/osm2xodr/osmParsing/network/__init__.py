"""From ways to streets and intersections, turn restrictions and lane connectivity.

Ways are cut where streets may meet (`pieces`), joined between intersections and given attributes (`streets`); one
direction is found where it changes with time; `relations` say how one may drive from one to another; `country` finds
the country, its driving side, and limits where none is given.
"""

from __future__ import annotations

from osm2xodr.osmParsing.network.country import find_place as find_place, with_default_speeds as with_default_speeds
from osm2xodr.osmParsing.network.pieces import (
    Pieces as Pieces,
    cut_at_shared_nodes as cut_at_shared_nodes,
    cut_gaps as cut_gaps,
    join_same_places as join_same_places,
    leave_out_crowds as leave_out_crowds,
    leave_out_far_nodes as leave_out_far_nodes,
    make_lines as make_lines,
    most_met as most_met,
    sparse_streets as sparse_streets,
    with_one_flow as with_one_flow,
)
from osm2xodr.osmParsing.network.relations import (
    read_connectivities as read_connectivities,
    read_restrictions as read_restrictions,
)
from osm2xodr.osmParsing.network.streets import (
    make_streets as make_streets,
    report_head_on as report_head_on,
    tags_on_streets as tags_on_streets,
)
