"""Where the roads of a file are."""

from __future__ import annotations

import re
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from osm2xodr.batch.areas import RingDeg
from osm2xodr.model import LocalFrame
from osm2xodr.projection import to_geographic


def road_bounds(xodr: Path) -> tuple[RingDeg, ...]:
    """Return the bounds that the header of a file written by osm2xodr states, corners in degrees; none if unknown."""
    try:
        # Opened here, because Python before 3.13 leaves it open where reading stops early.
        with xodr.open("rb") as stream:
            for _, element in ElementTree.iterparse(stream, ("end",)):
                if element.tag == "header":
                    return (_ring(element),)
    except (OSError, ElementTree.ParseError, ValueError):
        pass
    return ()


def _ring(header: ElementTree.Element) -> RingDeg:
    proj = re.sub(r"\s*\+(?:geoidgrids|vunits)=\S+", "", header.findtext("geoReference", "")).strip()
    west, south, east, north = (float(header.get(side, "")) for side in ("west", "south", "east", "north"))
    x, y = np.array([west, east, east, west]), np.array([south, south, north, north])
    lon, lat = to_geographic(LocalFrame(proj, 0.0, 0.0), x, y)
    return tuple(zip(np.round(lon, 7).tolist(), np.round(lat, 7).tolist(), strict=True))
