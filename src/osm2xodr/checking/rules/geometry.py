"""Rules of where roads lie: plan view, lanes, heights, surfaces."""

from __future__ import annotations

from typing import Final

from osm2xodr.checking import defaults
from osm2xodr.checking.rules.rule import Rule, Severity
from osm2xodr.defaults import CONNECTING_RADIUS

# Turn of the heading in one place, degrees: a car at 50 km/h is 0.24 m beside its line after a second. An error above
# what the steering of a car takes up over its own length: a choice.
_CHECK_KINK: Final = 1.0
_CHECK_KINK_GRAVE: Final = 10.0
# Step of the grade in one place, %: a car pitches by 0.3 degrees at 0.5; an error is a break on which low cars
# ground. Choices.
_CHECK_GRADE_STEP: Final = 0.5
_CHECK_GRADE_STEP_GRAVE: Final = 8.0
# Grade, %: steeper than any street that cars use (Baldwin Street, Dunedin: 34.8), and than all but a few (15).
_CHECK_GRADE: Final = 35.0
_CHECK_GRADE_STEEP: Final = 15.0
# A lane's border folds where it is nearer to the centre of the curve than this, m.
_CHECK_FOLD: Final = 0.0

_ERROR, _WARNING, _INFO = Severity.ERROR, Severity.WARNING, Severity.INFO
_GAP = (defaults.CHECK_GAP, defaults.CHECK_GAP_GRAVE, "m", "ASAM's checker: 0.01 m at touching points")
_KINK = (_CHECK_KINK, _CHECK_KINK_GRAVE, "deg", "0.24 m beside the line a second later at 50 km/h")
_GRADE = (_CHECK_GRADE_STEP, _CHECK_GRADE_STEP_GRAVE, "%", "a car pitches by 0.3 degrees; a choice")


def _measured(
    name: str,
    meaning: str,
    text: str,
    remedy: str,
    scale: tuple[float, float | None, str, str],
    severity: Severity = _WARNING,
    suffers: str = "",
    readers: tuple[str, ...] = (),
) -> Rule:
    """Return a rule with a limit."""
    limit, grave, unit, source = scale
    return Rule(
        name, severity, meaning, text, remedy, suffers, readers, limit=limit, grave=grave, unit=unit, source=source
    )


GEOMETRY_RULES: Final = (
    _measured(
        "record-gap",
        "A plan-view record does not begin where the one before it ends.",
        "the record begins {value} beside the end of the one before",
        "Let each record start at the computed end of the one before.",
        _GAP,
    ),
    _measured(
        "record-kink",
        "The heading jumps from one plan-view record to the next.",
        "the heading jumps by {value}",
        "Fit curves with common tangents.",
        _KINK,
    ),
    _measured(
        "record-s",
        "A plan-view record's s is not where the one before it ends, or the first is not 0.",
        "the record's s is {value} off",
        "Write the sum of the lengths before it.",
        (defaults.CHECK_ROAD_LENGTH, None, "m", "rounding of many lengths"),
        _ERROR,
    ),
    _measured(
        "record-length",
        "The stated length of a paramPoly3 is not that of its curve.",
        "the stated length is {value} off the curve's own",
        "Write the length along the curve.",
        (defaults.CHECK_RECORD_LENGTH, defaults.CHECK_GAP_GRAVE, "m", "ASAM's checker: 0.001 m"),
        _WARNING,
        "Readers differ on where such a road lies: by 0.45 m at 0.5 m in 20 m.",
        ("carla", "esmini", "libopendrive"),
    ),
    _measured(
        "road-length",
        "The length of a road is not the sum of its records'.",
        "the road's length is {value} off the sum of its records",
        "Write the sum.",
        (defaults.CHECK_ROAD_LENGTH, None, "m", "rounding of many lengths"),
        _ERROR,
    ),
    Rule(
        "zero-length",
        _ERROR,
        "A road or a plan-view record has no length.",
        "{other} has the length {value}",
        "Leave it out.",
        "CARLA does not load the file (s <= road->GetLength()); esmini leaves the lane out.",
        ("carla", "esmini"),
        limit=0.0,
        unit="m",
    ),
    Rule(
        "short-record",
        _INFO,
        "A road or a plan-view record is shorter than 1 cm.",
        "{other} is only {value} long",
        "Join it to its neighbour.",
        "RoadRunner rounds lengths to 1 cm to be rid of such.",
        ("roadrunner",),
        limit=defaults.CHECK_SHORT,
        unit="m",
        source="RoadRunner's rounding",
    ),
    _measured(
        "start-tangent",
        "A paramPoly3 or poly3 does not start along its stated heading.",
        "the curve starts {value} off its hdg",
        "Turn the record's frame so that bV is 0.",
        (_CHECK_KINK, None, "deg", "as for kinks"),
        _INFO,
    ),
    _measured(
        "lane-gap",
        "The middle of a driving lane and of the lane it is linked to are not in one place where roads meet.",
        "the lane's middle ends {value} beside that of {other}",
        "Let linked lanes meet: reference lines, lane offsets and widths.",
        _GAP,
        _WARNING,
        "Vehicles jump.",
        ("carla", "esmini", "sumo"),
    ),
    _measured(
        "lane-edge-gap",
        "An edge of a driving lane does not meet that of the lane it is linked to where roads meet.",
        "an edge of the lane ends {value} beside that of {other}",
        "Let widths taper instead of jump.",
        _GAP,
    ),
    _measured(
        "lane-height-step",
        "Linked driving lanes differ in height where roads meet.",
        "the lane ends {value} above or below {other}",
        "Let elevation and superelevation of both roads agree.",
        _GAP,
        _WARNING,
        "Vehicles jump and bounce.",
        ("carla", "esmini"),
    ),
    _measured(
        "link-kink",
        "Linked driving lanes differ in heading where roads meet.",
        "the heading jumps by {value} to {other}",
        "Let both roads have a common tangent.",
        _KINK,
    ),
    _measured(
        "link-grade-step",
        "Linked driving lanes differ in grade where roads meet.",
        "the grade jumps by {value} to {other}",
        "Let both profiles have a common tangent.",
        _GRADE,
        _WARNING,
        "Vehicles hit the ground or take off.",
        ("carla", "esmini"),
    ),
    _measured(
        "side-lane-gap",
        "An edge of a lane that is not for driving, or its height, does not meet that of the lane it is linked to.",
        "an edge of the lane ends {value} beside that of {other}",
        "Let linked lanes meet.",
        (defaults.CHECK_GAP, None, "m", "as for lanes"),
        _INFO,
    ),
    _measured(
        "section-gap",
        "An edge of a lane jumps from one lane section to the next.",
        "an edge of the lane jumps by {value} to lane {other}",
        "Let widths and lane offset go on.",
        _GAP,
    ),
    _measured(
        "lane-offset-step",
        "The lane offset jumps within a lane section.",
        "the lane offset jumps by {value}",
        "Let lane offsets go on, or begin a lane section there.",
        _GAP,
    ),
    _measured(
        "width-step",
        "The width of a lane jumps within its section.",
        "the width jumps by {value}",
        "Let widths taper.",
        _GAP,
    ),
    _measured(
        "negative-width",
        "A lane has a negative width.",
        "the lane is {value} wide below 0",
        "Let widths end at 0.",
        (defaults.CHECK_ZERO_WIDTH, None, "m", "ASAM's checker: 1e-6 m"),
        _ERROR,
    ),
    _measured(
        "folded-lane",
        "A lane's border reaches over the centre of the curve: the lane folds over itself.",
        "the border reaches {value} beyond the centre of the curve",
        "Use a larger radius, a narrower lane, or lay the reference line on the inner side.",
        (_CHECK_FOLD, None, "m", "geometry"),
        _WARNING,
        "esmini hung for ever on one such road with elevation; meshes are torn.",
        ("esmini", "carla"),
    ),
    Rule(
        "tight-curve",
        _INFO,
        "The middle of a driving lane turns more sharply than a car can.",
        "the middle of the lane has a radius of {value}",
        "Use a larger radius.",
        "Vehicles leave the lane.",
        ("carla", "esmini", "sumo"),
        limit=CONNECTING_RADIUS,
        unit="m",
        source="DIN 70020: half of a turning circle less half of the car",
    ),
    _measured(
        "height-step",
        "The elevation jumps from one record to the next.",
        "the elevation jumps by {value}",
        "Let each record start at the height where the one before ends.",
        _GAP,
        _WARNING,
        "Vehicles jump and bounce.",
        ("carla", "esmini"),
    ),
    _measured(
        "grade-step",
        "The grade jumps from one elevation record to the next.",
        "the grade jumps by {value}",
        "Use cubics with common tangents.",
        _GRADE,
        _WARNING,
        "Vehicles hit the ground or take off.",
        ("carla", "esmini"),
    ),
    _measured(
        "superelevation-step",
        "The superelevation jumps from one record to the next.",
        "the superelevation jumps by {value}",
        "Let each record start where the one before ends.",
        (_CHECK_KINK, _CHECK_KINK_GRAVE, "deg", "as for kinks"),
    ),
    _measured(
        "grade-excess",
        "A road is steeper than any street that cars use.",
        "the grade reaches {value}",
        "Look at the heights: surface models show roofs and trees, bridges need their own.",
        (_CHECK_GRADE, 100.0, "%", "Baldwin Street, Dunedin: 34.8 %"),
    ),
    _measured(
        "grade-steep",
        "A road is steeper than all but a few streets.",
        "the grade reaches {value}",
        "Look at the heights.",
        (_CHECK_GRADE_STEEP, None, "%", "few streets are steeper"),
        _INFO,
    ),
    _measured(
        "junction-surface",
        "Connecting roads of a junction that lie over each other differ in height.",
        "its surface is {value} above or below that of {other}",
        "Let all connecting roads of a junction share one surface.",
        (defaults.CHECK_SURFACE, defaults.CHECK_SURFACE_GRAVE, "m", "half of a low kerb; a choice"),
        _WARNING,
        "Vehicles are blocked by the higher road's edge.",
        ("carla", "esmini"),
    ),
    Rule(
        "overlap",
        _WARNING,
        "Carriageways of two roads outside of junctions lie over each other at one height.",
        "{value} of its carriageway are also that of {other}",
        "Narrow the roads, lay them apart, or join them in a junction.",
        "Vehicles collide with oncoming ones.",
        ("carla", "esmini"),
        limit=defaults.CHECK_OVERLAP,
        unit="m²",
        source="a car's area; a choice",
    ),
)
