"""Rules about where roads lie: plan view, lanes, heights, surfaces."""

from __future__ import annotations

from typing import Final

from osm2xodr.checking import defaults
from osm2xodr.checking.rules.rule import Limit, error, note, warning
from osm2xodr.defaults import CONNECTING_RADIUS

_GAP: Final = Limit(defaults.GAP, "m", "ASAM's checker: 0.01 m where lanes touch", error=defaults.GAP_ERROR)
# Sums of lengths, m.
_LENGTH: Final = Limit(0.01, "m", "rounding of many lengths")
# Turn of the heading at one place: an error above what a car can steer within its own length, a choice.
_KINK: Final = Limit(1.0, "deg", "at 50 km/h a car is 0.24 m off its line after a second", error=10.0)
# Step of the grade at one place: an error is a break on which low cars hit the ground. Choices.
_GRADE: Final = Limit(0.5, "%", "a car pitches by 0.3 degrees; a choice", error=8.0)

GEOMETRY_RULES: Final = (
    warning(
        "record-gap",
        "A plan-view record does not begin where the previous one ends.",
        "the record begins {value} away from the end of the previous one",
        "Start each record at the computed end of the previous one.",
        limit=_GAP,
    ),
    warning(
        "record-kink",
        "The heading jumps from one plan-view record to the next.",
        "the heading jumps by {value}",
        "Fit curves that share their tangents.",
        limit=_KINK,
    ),
    error(
        "record-s",
        "The s of a plan-view record is not where the previous one ends, or the first is not 0.",
        "the record's s is wrong by {value}",
        "Write the sum of the lengths before it.",
        limit=_LENGTH,
    ),
    warning(
        "record-length",
        "The stated length of a paramPoly3 is not the length of its curve.",
        "the stated length differs from that of the curve by {value}",
        "Write the length along the curve.",
        "Readers disagree on where such a road lies: by 0.45 m where 0.5 m in 20 m are wrong.",
        ("carla", "esmini", "libopendrive"),
        Limit(0.001, "m", "ASAM's checker: 0.001 m", error=defaults.GAP_ERROR),
    ),
    error(
        "road-length",
        "The length of a road is not the sum of the lengths of its records.",
        "the road's length differs from the sum of its records by {value}",
        "Write the sum.",
        limit=_LENGTH,
    ),
    error(
        "zero-length",
        "A road or a plan-view record has no length.",
        "{other} has the length {value}",
        "Leave it out.",
        "CARLA does not load the file (s <= road->GetLength()); esmini leaves the lane out.",
        ("carla", "esmini"),
        Limit(0.0, "m"),
    ),
    note(
        "short-record",
        "A road or a plan-view record is shorter than 1 cm.",
        "{other} is only {value} long",
        "Join it to its neighbour.",
        "RoadRunner rounds lengths to 1 cm to get rid of such records.",
        ("roadrunner",),
        Limit(0.01, "m", "RoadRunner's rounding"),
    ),
    note(
        "start-tangent",
        "A paramPoly3 or poly3 does not start in the direction of its stated heading.",
        "the curve starts {value} off its hdg",
        "Rotate the record's frame so that bV is 0.",
        limit=Limit(1.0, "deg", "as for kinks"),
    ),
    warning(
        "lane-gap",
        "Where two roads meet, the middle of a driving lane is not where the middle of its linked lane is.",
        "the middle of the lane ends {value} away from the middle of {other}",
        "Let linked lanes meet: check reference lines, lane offsets and widths.",
        "Vehicles jump.",
        ("carla", "esmini", "sumo"),
        _GAP,
    ),
    warning(
        "lane-edge-gap",
        "Where two roads meet, an edge of a driving lane does not meet the edge of its linked lane.",
        "an edge of the lane ends {value} away from the edge of {other}",
        "Let widths taper instead of jump.",
        limit=_GAP,
    ),
    warning(
        "lane-height-step",
        "Where two roads meet, linked driving lanes differ in height.",
        "the lane ends {value} above or below {other}",
        "Let elevation and superelevation of both roads agree.",
        "Vehicles jump and bounce.",
        ("carla", "esmini"),
        _GAP,
    ),
    warning(
        "link-kink",
        "Where two roads meet, linked driving lanes differ in heading.",
        "the heading jumps by {value} to {other}",
        "Let both roads share their tangent.",
        limit=_KINK,
    ),
    warning(
        "link-grade-step",
        "Where two roads meet, linked driving lanes differ in grade.",
        "the grade jumps by {value} to {other}",
        "Let both profiles share their tangent.",
        "Vehicles hit the ground or take off.",
        ("carla", "esmini"),
        _GRADE,
    ),
    note(
        "side-lane-gap",
        "Where two roads meet, a lane that is not for driving differs in an edge or in height from its linked lane.",
        "an edge of the lane ends {value} away from the edge of {other}",
        "Let linked lanes meet.",
        limit=Limit(defaults.GAP, "m", "as for driving lanes"),
    ),
    warning(
        "section-gap",
        "An edge of a lane jumps from one lane section to the next.",
        "an edge of the lane jumps by {value} to lane {other}",
        "Let widths and the lane offset continue.",
        limit=_GAP,
    ),
    warning(
        "lane-offset-step",
        "The lane offset jumps within a lane section.",
        "the lane offset jumps by {value}",
        "Let the lane offset continue, or begin a lane section there.",
        limit=_GAP,
    ),
    warning(
        "width-step",
        "The width of a lane jumps within its section.",
        "the width jumps by {value}",
        "Let the width taper.",
        limit=_GAP,
    ),
    error(
        "negative-width",
        "A lane has a negative width.",
        "the width of the lane is {value} below 0",
        "Let the width end at 0.",
        limit=Limit(1e-6, "m", "ASAM's checker: 1e-6 m"),
    ),
    warning(
        "folded-lane",
        "The border of a lane lies beyond the centre of the curve: the lane folds over itself.",
        "the border lies {value} beyond the centre of the curve",
        "Use a larger radius or a narrower lane, or put the reference line on the inner side.",
        "esmini hung forever on one such road with elevation; meshes are torn.",
        ("esmini", "carla"),
        Limit(0.0, "m", "geometry"),
    ),
    note(
        "tight-curve",
        "The middle of a driving lane turns more sharply than a car can.",
        "the middle of the lane has a radius of {value}",
        "Use a larger radius.",
        "Vehicles leave the lane.",
        ("carla", "esmini", "sumo"),
        Limit(CONNECTING_RADIUS, "m", "DIN 70020: half of a turning circle less half of the car"),
    ),
    warning(
        "height-step",
        "The elevation jumps from one record to the next.",
        "the elevation jumps by {value}",
        "Start each record at the height where the previous one ends.",
        "Vehicles jump and bounce.",
        ("carla", "esmini"),
        _GAP,
    ),
    warning(
        "grade-step",
        "The grade jumps from one elevation record to the next.",
        "the grade jumps by {value}",
        "Use cubics that share their tangents.",
        "Vehicles hit the ground or take off.",
        ("carla", "esmini"),
        _GRADE,
    ),
    warning(
        "superelevation-step",
        "The superelevation jumps from one record to the next.",
        "the superelevation jumps by {value}",
        "Start each record where the previous one ends.",
        limit=Limit(1.0, "deg", "as for kinks", error=10.0),
    ),
    warning(
        "grade-excess",
        "A road is steeper than any street that cars use.",
        "the grade reaches {value}",
        "Check the heights: surface models contain roofs and trees, and bridges need heights of their own.",
        limit=Limit(35.0, "%", "Baldwin Street, Dunedin: 34.8 %", error=100.0),
    ),
    note(
        "grade-steep",
        "A road is steeper than all but a few streets.",
        "the grade reaches {value}",
        "Check the heights.",
        limit=Limit(15.0, "%", "few streets are steeper"),
    ),
    warning(
        "junction-surface",
        "Connecting roads of a junction overlap at different heights.",
        "its surface is {value} above or below that of {other}",
        "Let all connecting roads of a junction share one surface.",
        "Vehicles are blocked by the edge of the higher road.",
        ("carla", "esmini"),
        Limit(0.12, "m", "half of a low kerb; a choice", error=0.3),
    ),
    warning(
        "overlap",
        "Carriageways of two roads outside of junctions overlap at the same height.",
        "{value} of its carriageway also belong to {other}",
        "Make the roads narrower, move them apart, or join them in a junction.",
        "Vehicles collide with oncoming ones.",
        ("carla", "esmini"),
        Limit(8.0, "m²", "the area of a car; a choice"),
    ),
)
