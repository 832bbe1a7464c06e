"""Units of height."""

from __future__ import annotations

from types import MappingProxyType
from typing import Final

from pyproj import CRS

# The international foot is 0.3048 m by definition (1959), that of the US survey 1200/3937 m.
FOOT: Final = 0.3048
US_SURVEY_FOOT: Final = 1200.0 / 3937.0

_METRES: Final = MappingProxyType(
    {
        **dict.fromkeys(("m", "metre", "metres", "meter", "meters", "mtr"), 1.0),
        **dict.fromkeys(("dm", "decimetre", "decimeter", "decimetres", "decimeters"), 0.1),
        **dict.fromkeys(("cm", "centimetre", "centimeter", "centimetres", "centimeters"), 0.01),
        **dict.fromkeys(("mm", "millimetre", "millimeter", "millimetres", "millimeters"), 0.001),
        **dict.fromkeys(("km", "kilometre", "kilometer", "kilometres", "kilometers"), 1000.0),
        **dict.fromkeys(
            ("ft", "foot", "feet", "international foot", "international feet", "foot international"), FOOT
        ),
        **dict.fromkeys(
            (
                "us-ft",
                "us ft",
                "ftus",
                "sft",
                "us survey foot",
                "us survey feet",
                "us foot",
                "us feet",
                "survey foot",
            ),
            US_SURVEY_FOOT,
        ),
        **dict.fromkeys(("foot us", "u.s. survey foot", "u.s. survey feet", "us_survey_foot"), US_SURVEY_FOOT),
        **dict.fromkeys(("yd", "yard", "yards"), 3.0 * FOOT),
        **dict.fromkeys(("fathom", "fathoms"), 6.0 * FOOT),
    }
)


def metres_per(unit: str) -> float | None:
    """Return the metres in a unit of length as rasters name it, None if the name is not known."""
    return _METRES.get(unit.strip().strip("[]()").replace("_", " ").casefold())


def vertical_unit(crs: CRS) -> tuple[str, float] | None:
    """Return name and metres of the unit of a CRS's heights, None if it has none."""
    vertical = [part for part in crs.sub_crs_list if part.is_vertical]
    axes = vertical[0].axis_info if vertical else crs.axis_info[2:3]
    return (axes[0].unit_name, axes[0].unit_conversion_factor) if axes else None


def horizontal_crs(crs: CRS) -> CRS:
    """Return the CRS without its heights."""
    plain = next((part for part in crs.sub_crs_list if not part.is_vertical), crs) if crs.is_compound else crs
    return plain.to_2d()
