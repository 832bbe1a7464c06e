"""The area to fetch: a box or polygons."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np

from osm2xodr.batching import CutRequest, frame_around, read_polygons
from osm2xodr.errors import OptionError
from osm2xodr.model import Outline
from osm2xodr.projection import to_local

# Length of a degree of latitude, m (WGS 84, mean).
DEGREE: Final = 111_195.0

Box = tuple[float, float, float, float]
_Rings = tuple[tuple[tuple[float, float], ...], ...]


@dataclass(frozen=True, slots=True)
class Place:
    """An area on Earth."""

    box: Box  # West, south, east, north, degrees, WGS 84
    # Rings of (longitude, latitude), degrees, as in `Outline`; empty where the area is the box
    rings: _Rings = ()
    text: str = ""  # How the user named it, for the list of sources

    def cut_request(self, target: Path) -> CutRequest:
        """Return what cuts the area out of a map, into a file ``.osm.pbf``."""
        west, south, east, north = self.box
        rings = self.rings or (((west, south), (east, south), (east, north), (west, north)),)
        frame = frame_around(rings)
        outline = Outline(tuple(np.column_stack(to_local(frame, *np.array(ring).T)) for ring in rings))
        return CutRequest(self.text, target, frame, outline)


def widened(box: Box, margin: float) -> Box:
    """Return a box (west, south, east, north, degrees) with what lies up to a margin, m, around it."""
    west, south, east, north = box
    up = margin / DEGREE
    across = up / max(0.05, math.cos(math.radians(max(abs(south), abs(north)))))
    return max(-180.0, west - across), max(-90.0, south - up), min(180.0, east + across), min(90.0, north + up)


def is_box(box: Box) -> bool:
    """Whether west, south, east and north, degrees, are a box on Earth, on one side of the 180th meridian."""
    west, south, east, north = box
    return -180.0 <= west < east <= 180.0 and -90.0 < south < north < 90.0


def place_of_box(text: str) -> Place:
    """Return the area ``west,south,east,north``, degrees; `OptionError` says what is wrong with it."""
    form = "write west,south,east,north in degrees"
    try:
        west, south, east, north = (float(word) for word in text.split(","))
    except ValueError:
        raise OptionError(f"bbox {text} is not 4 numbers; {form}", "bbox") from None
    if not (-180.0 <= west <= 180.0 and -180.0 <= east <= 180.0 and -90.0 < south < 90.0 and -90.0 < north < 90.0):
        raise OptionError(f"bbox {text} is not on Earth; {form}", "bbox")
    if not (west < east and south < north):
        raise OptionError(f"bbox {text} is empty; {form}, areas on both sides of longitude 180 one by one", "bbox")
    return Place((west, south, east, north), text=f"bbox {west:.7g},{south:.7g},{east:.7g},{north:.7g}")


def place_of_file(path: Path) -> Place:
    """Return the area of all polygons of a GeoJSON file; `InputError` says what is wrong with it."""
    rings = tuple(ring for _, found in read_polygons(path) for ring in found)
    corners = np.array([corner for ring in rings for corner in ring])
    west, south = corners.min(axis=0).tolist()
    east, north = corners.max(axis=0).tolist()
    return Place((west, south, east, north), rings, f"the polygons of {path.name}")
