"""Rules of junctions and of ways on: connections, lanes that lead nowhere."""

from __future__ import annotations

from typing import Final

from osm2xodr.checking import defaults
from osm2xodr.checking.rules.rule import Rule, Severity

_ERROR, _WARNING, _INFO = Severity.ERROR, Severity.WARNING, Severity.INFO

JUNCTION_RULES: Final = (
    Rule(
        "junction-empty",
        _WARNING,
        "A junction has no connection.",
        "junction {other} has no connection",
        "Remove the junction, or write its connections.",
    ),
    Rule(
        "connecting-road",
        _ERROR,
        "A connection's connecting road is missing or not in the file.",
        "{other}",
        "Name a road of the file.",
        "CARLA and esmini do not load the file; netconvert warns.",
        ("carla", "esmini", "sumo"),
    ),
    Rule(
        "incoming-road",
        _ERROR,
        "A connection's incoming road is missing or not in the file.",
        "{other}",
        "Name a road of the file.",
        "netconvert writes no net; esmini reports an error.",
        ("esmini", "sumo"),
    ),
    Rule(
        "incoming-elsewhere",
        _ERROR,
        "A connection's incoming road does not end at the junction.",
        "{other}, but the road does not end there",
        "Name the junction as the road's predecessor or successor.",
    ),
    Rule(
        "connecting-elsewhere",
        _ERROR,
        "A connection's connecting road belongs to another junction or to none.",
        "{other}, but the road does not belong to it",
        "Write the junction's id as the road's junction.",
    ),
    Rule(
        "open-connecting-road",
        _WARNING,
        "A connecting road has no predecessor or no successor.",
        "the connecting road has no {other}",
        "Write both roads that it joins.",
        "esmini warns, and routes end there.",
        ("esmini",),
    ),
    Rule(
        "connection-without-link",
        _ERROR,
        "The connecting road does not name the incoming road at the end where they touch.",
        "{other}, but the connecting road names another neighbour there",
        "Write the incoming road as the connecting road's predecessor or successor.",
    ),
    Rule(
        "connection-without-lanes",
        _ERROR,
        "A connection has no laneLink.",
        "{other} has no laneLink",
        "Write which lanes it joins.",
        "esmini takes the lanes for dead ends.",
        ("esmini",),
    ),
    Rule(
        "connection-lane",
        _ERROR,
        "A laneLink names a lane that is not there.",
        "{other}, which is not there",
        "Name lanes that touch the junction.",
    ),
    Rule(
        "connection-without-id",
        _ERROR,
        "A connection has no id.",
        "{other} has no id",
        "Number connections.",
        "CARLA loses connections; netconvert writes no net.",
        ("carla", "sumo"),
    ),
    Rule(
        "dead-lane",
        _WARNING,
        "Traffic on a lane cannot go on at a junction, though the road does end there.",
        "no connection of junction {other} takes traffic on from this lane",
        "Add a connection or a laneLink, or end the lane before.",
        "Cars stop there: CARLA's and SUMO's traffic is stuck or removed.",
        ("carla", "esmini", "sumo"),
    ),
    Rule(
        "dead-end-junction",
        _INFO,
        "Traffic cannot go on at a junction, since no other road leads out of it: the road is a dead end.",
        "no road but this one leads out of junction {other}",
        "See whether a one-way street or a ban is missing or wrong in the data.",
        "Cars stop there, as at the end of any street without a loop.",
        ("carla", "sumo"),
    ),
    Rule(
        "lane-ends",
        _WARNING,
        "A lane ends at full width where the road goes on, and no lane beside it goes on either.",
        "the lane ends {value} wide without a successor, nor does any lane beside it have one",
        "Link it to the lane that goes on, or let it taper.",
        limit=defaults.CHECK_TAPERED,
        unit="m",
        source="half of a shoe: nobody drives there",
    ),
    Rule(
        "unfed-lane",
        _INFO,
        "No lane leads to a driving lane that leaves a junction.",
        "no connection of junction {other} leads into this lane",
        "Add a connection, or begin the lane behind the junction.",
        "CARLA has no waypoints there.",
        ("carla",),
    ),
    Rule(
        "conflicting-phase",
        _WARNING,
        "A junction's controller shows green at once to ways through it that cross or end on one lane.",
        "controller {other}",
        "Put signals of ways that cross into controllers of their own, unless drivers who turn wait for the others.",
    ),
)
