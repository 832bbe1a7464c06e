"""Rules about junctions: their connections, and lanes that lead nowhere."""

from __future__ import annotations

from typing import Final

from osm2xodr.checking import defaults
from osm2xodr.checking.rules.rule import Limit, error, note, warning

JUNCTION_RULES: Final = (
    warning(
        "junction-empty",
        "A junction has no connection.",
        "junction {other} has no connection",
        "Remove the junction, or write its connections.",
    ),
    error(
        "connecting-road",
        "The connecting road of a connection is missing or not in the file.",
        "{other}",
        "Name a road of the file.",
        "CARLA and esmini do not load the file; netconvert warns.",
        ("carla", "esmini", "sumo"),
    ),
    error(
        "incoming-road",
        "The incoming road of a connection is missing or not in the file.",
        "{other}",
        "Name a road of the file.",
        "netconvert writes no network; esmini reports an error.",
        ("esmini", "sumo"),
    ),
    error(
        "incoming-elsewhere",
        "The incoming road of a connection does not end at the junction.",
        "the road is the incoming road of {other}, but does not end there",
        "Write the junction as the road's predecessor or successor.",
    ),
    error(
        "connecting-elsewhere",
        "The connecting road of a connection belongs to another junction or to none.",
        "the road is the connecting road of {other}, but does not belong to that junction",
        "Write the junction's id as the road's junction.",
    ),
    warning(
        "open-connecting-road",
        "A connecting road has no predecessor or no successor.",
        "the connecting road has no {other}",
        "Write both roads that it joins.",
        "esmini warns, and routes end there.",
        ("esmini",),
    ),
    error(
        "connection-without-link",
        "The connecting road does not name the incoming road at the end where they touch.",
        "the road is the connecting road of {other}, but does not name the incoming road there",
        "Write the incoming road as the connecting road's predecessor or successor.",
    ),
    error(
        "connection-without-lanes",
        "A connection has no laneLink.",
        "{other} has no laneLink",
        "Write which lanes it joins.",
        "esmini treats the lanes as dead ends.",
        ("esmini",),
    ),
    error(
        "connection-lane",
        "A laneLink names a lane that does not exist.",
        "{other}, which does not exist",
        "Name lanes that touch the junction.",
    ),
    error(
        "connection-without-id",
        "A connection has no id.",
        "{other} has no id",
        "Number the connections.",
        "CARLA loses connections; netconvert writes no network.",
        ("carla", "sumo"),
    ),
    warning(
        "dead-lane",
        "Traffic on a lane reaches a junction and cannot go on, although other roads lead out of it.",
        "no connection of junction {other} takes traffic on from this lane",
        "Add a connection or a laneLink, or end the lane before the junction.",
        "Cars stop there: in CARLA and SUMO traffic is stuck or removed.",
        ("carla", "esmini", "sumo"),
    ),
    note(
        "dead-end-junction",
        "Traffic reaches a junction and cannot go on because no other road leads out of it: the road is a dead end.",
        "no road but this one leads out of junction {other}",
        "Check whether a one-way street or a turn restriction is missing or wrong in the data.",
        "Cars stop there, as at the end of any street without a loop.",
        ("carla", "sumo"),
    ),
    warning(
        "lane-ends",
        "A lane ends at full width although the road goes on, and no lane beside it goes on either.",
        "the lane ends {value} wide and has no successor, nor does any lane beside it",
        "Link it to the lane that goes on, or let it taper.",
        limit=Limit(defaults.TAPERED_WIDTH, "m", "half of a shoe: nobody drives there"),
    ),
    note(
        "unfed-lane",
        "No lane leads to a driving lane that leaves a junction.",
        "no connection of junction {other} leads into this lane",
        "Add a connection, or begin the lane after the junction.",
        "CARLA has no waypoints there.",
        ("carla",),
    ),
    warning(
        "conflicting-phase",
        "A controller of a junction shows green at the same time to movements that cross or end on the same lane.",
        "controller {other}",
        "Give signals of crossing movements separate controllers, unless turning drivers are to yield to the others.",
    ),
)
