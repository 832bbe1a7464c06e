"""Speed limits in the units that signs use."""

from __future__ import annotations

import math
from typing import Final

from osm2xodr.xodrWriter.formatting import number

# Written as the limit of a lane that has none on a road that has one: ``lane/speed@max`` knows no "no limit".
# A choice: beyond what road vehicles reach.
_NO_LIMIT_KMH: Final = 400

_KMH: Final = 3.6  # km/h per m/s
_MPH: Final = 1.0 / 0.44704  # international miles per hour per m/s

# How close to a whole number of a unit a speed must be to have been meant in it. 30 mph is 48.28 km/h; no usual limit
# in mph lies this close to a whole number of km/h.
_WHOLE: Final = 0.005


def _attributes(speed: float) -> str:
    """Return ``max`` and ``unit`` of a finite speed (m/s): km/h or mph, whichever makes it whole, else km/h."""
    kmh, mph = speed * _KMH, speed * _MPH
    if abs(kmh - round(kmh)) <= _WHOLE:
        return f'max="{round(kmh)}" unit="km/h"'
    if abs(mph - round(mph)) <= _WHOLE:
        return f'max="{round(mph)}" unit="mph"'
    return f'max="{number(round(kmh, 3))}" unit="km/h"'


def road_speed_attributes(speed: float) -> str:
    """Return the attributes of ``type/speed`` for a speed in m/s; infinity is no limit."""
    return 'max="no limit"' if math.isinf(speed) else _attributes(speed)


def lane_speed_attributes(speed: float) -> str:
    """Return the attributes of ``lane/speed``, but for its ``sOffset``, for a speed in m/s; infinity is no limit."""
    return f'max="{_NO_LIMIT_KMH}" unit="km/h"' if math.isinf(speed) else _attributes(speed)
