"""Which elements of roads are read, and what each of them is by where it stands.

Children of an element that is not named here are not looked at.
"""

from __future__ import annotations

from enum import IntEnum, auto
from functools import cache
from typing import Final

import numpy as np
from numpy.typing import NDArray


class Role(IntEnum):
    """What an element is to the reader."""

    IGNORED = 0  # Nobody looks at it
    UNKNOWN = auto()  # It does not belong where it stands, or may stand anywhere
    ROOT = auto()
    TREE = auto()  # A child of the root that is read as a tree
    ROAD = auto()
    LINK = auto()
    PREDECESSOR = auto()
    SUCCESSOR = auto()
    TYPE = auto()
    TYPE_SPEED = auto()
    PLAN_VIEW = auto()
    GEOMETRY = auto()
    LINE = auto()
    ARC = auto()
    SPIRAL = auto()
    POLY3 = auto()
    PARAM_POLY3 = auto()
    ELEVATION_PROFILE = auto()
    ELEVATION = auto()
    LATERAL_PROFILE = auto()
    SUPERELEVATION = auto()
    LATERAL_SHAPE = auto()
    LANES = auto()
    LANE_OFFSET = auto()
    SECTION = auto()
    LEFT = auto()
    CENTER = auto()
    RIGHT = auto()
    LANE = auto()
    LANE_LINK = auto()
    LANE_PREDECESSOR = auto()
    LANE_SUCCESSOR = auto()
    WIDTH = auto()
    BORDER = auto()
    MARK = auto()
    LANE_SPEED = auto()
    HEIGHT = auto()
    OBJECTS = auto()
    SIGNALS = auto()
    USER_DATA = auto()


_SIDE: Final = {"lane": Role.LANE}
# The children of elements whose children are looked at: IGNORED ones are known, and not read. All others are UNKNOWN.
_CHILDREN: Final[dict[Role, dict[str, Role]]] = {
    Role.ROAD: {
        "link": Role.LINK,
        "type": Role.TYPE,
        "planView": Role.PLAN_VIEW,
        "elevationProfile": Role.ELEVATION_PROFILE,
        "lateralProfile": Role.LATERAL_PROFILE,
        "lanes": Role.LANES,
        "objects": Role.OBJECTS,
        "signals": Role.SIGNALS,
        "userData": Role.USER_DATA,
        "surface": Role.IGNORED,
        "railroad": Role.IGNORED,
    },
    Role.LINK: {"predecessor": Role.PREDECESSOR, "successor": Role.SUCCESSOR, "neighbor": Role.IGNORED},
    Role.TYPE: {"speed": Role.TYPE_SPEED},
    Role.PLAN_VIEW: {"geometry": Role.GEOMETRY},
    Role.GEOMETRY: {
        "line": Role.LINE,
        "arc": Role.ARC,
        "spiral": Role.SPIRAL,
        "poly3": Role.POLY3,
        "paramPoly3": Role.PARAM_POLY3,
    },
    Role.ELEVATION_PROFILE: {"elevation": Role.ELEVATION},
    Role.LATERAL_PROFILE: {
        "superelevation": Role.SUPERELEVATION,
        "shape": Role.LATERAL_SHAPE,
        "crossfall": Role.IGNORED,
        "crossSectionSurface": Role.IGNORED,
    },
    Role.LANES: {"laneOffset": Role.LANE_OFFSET, "laneSection": Role.SECTION},
    Role.SECTION: {"left": Role.LEFT, "center": Role.CENTER, "right": Role.RIGHT},
    **dict.fromkeys((Role.LEFT, Role.CENTER, Role.RIGHT), _SIDE),
    Role.LANE: {
        "width": Role.WIDTH,
        "border": Role.BORDER,
        "link": Role.LANE_LINK,
        "roadMark": Role.MARK,
        "speed": Role.LANE_SPEED,
        "height": Role.HEIGHT,
        **dict.fromkeys(("material", "access", "rule", "visibility"), Role.IGNORED),
    },
    Role.LANE_LINK: {"predecessor": Role.LANE_PREDECESSOR, "successor": Role.LANE_SUCCESSOR},
}
# Names of elements that are told by them; all others are numbered behind these.
TAGS: Final = tuple(dict.fromkeys(["road", *(name for names in _CHILDREN.values() for name in names)]))
# Elements that a road has only once.
ONCE: Final = (
    *(Role.LINK, Role.PLAN_VIEW, Role.ELEVATION_PROFILE, Role.LATERAL_PROFILE, Role.LANES),
    *(Role.OBJECTS, Role.SIGNALS),
)


@cache
def roles_below() -> NDArray[np.int8]:
    """Return the role of an element by that of its parent and its number in `TAGS`, or behind, (roles, tags + 1)."""
    out = np.full((len(Role), len(TAGS) + 1), Role.IGNORED, np.int8)
    out[Role.ROOT] = Role.TREE
    out[Role.ROOT, TAGS.index("road")] = Role.ROAD
    for role, children in _CHILDREN.items():
        out[role] = Role.UNKNOWN
        for name, child in children.items():
            out[role, TAGS.index(name)] = child
    out.flags.writeable = False
    return out
