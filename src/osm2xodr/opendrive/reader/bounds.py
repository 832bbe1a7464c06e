"""What no road network has: a small file that claims it would take hours and gigabytes."""

from __future__ import annotations

from typing import Final

import numpy as np

from osm2xodr.curves import owners
from osm2xodr.errors import InputError
from osm2xodr.model import FloatArray, IntArray
from osm2xodr.opendrive.tables import OpenDrive, Shape

# Longest road, m. A choice: no drivable way is as long as this without a junction.
_LONGEST: Final = 1e6
# Most lanes of a section, a choice: ten times those of a wide toll plaza.
_LANES: Final = 500
# Most that a record of the plan view turns, rad, a choice: 160 full circles, where ramps of car parks have a dozen.
_TURN: Final = 1e3
# Most records of the plan view that are alike, a choice: a few roads may share one. Their overlaps grow with the
# square of their number.
_ALIKE: Final = 200
# Most length for each record of the plan view, m, in files of more than the length below, m. Choices: 100,000 km are
# the roads of a country.
_PER_RECORD: Final = 1e4
_COUNTRY: Final = 1e8


def check_bounds(file: OpenDrive) -> None:
    """Raise `InputError`, with the road, if a file has roads that are too long, too wide or too bent to be true."""
    roads, plan = file.roads, file.plan_view
    with np.errstate(invalid="ignore", over="ignore"):
        _refuse(file, np.arange(len(roads.length)), roads.length, _LONGEST, "is {:g} m long")
        of = owners(plan.start)
        _refuse(file, of, plan.length, _LONGEST, "has a <geometry> of {:g} m")
        bent = np.where(np.isin(plan.shape, (Shape.ARC, Shape.SPIRAL)), 1.0, 0.0)
        sharpest = np.fmax(np.abs(plan.parameters[:, 0]), np.abs(plan.parameters[:, 1]))
        _refuse(file, of, bent * np.abs(sharpest * plan.length), _TURN, "has a <geometry> that turns by {:g} rad")
        if np.nansum(plan.length) > max(_COUNTRY, _PER_RECORD * len(of)):
            _refuse(file, of, plan.length, _PER_RECORD, "has, as others, a <geometry> of {:g} m")
        records = np.column_stack([plan.x, plan.y, plan.hdg, plan.length, np.nan_to_num(plan.parameters)])
        _, alike, counts = np.unique(records, axis=0, return_inverse=True, return_counts=True)
    _refuse(file, of, counts[alike.ravel()].astype(np.float64), _ALIKE, "has a <geometry> that {:,.0f} roads have")
    lanes = np.diff(file.lanes.start).astype(np.float64)
    _refuse(file, file.sections.road, lanes, _LANES, "has a <laneSection> of {:,.0f} lanes")


def _refuse(file: OpenDrive, road: IntArray, value: FloatArray, most: float, words: str) -> None:
    """Refuse the first road with a value above a bound."""
    over = np.flatnonzero(value > most)
    if len(over):
        k = int(over[0])
        place = f"road {file.roads.id[int(road[k])]!r} (line {file.roads.line[int(road[k])]})"
        what = words.format(float(value[k]))
        raise InputError(f"{file.path}: {place} {what}; a sound file can have {most:g} at most")
