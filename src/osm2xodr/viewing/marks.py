"""Road marks, by the borders that they stand on."""

from __future__ import annotations

from typing import Any

import numpy as np

from osm2xodr.model import IntArray
from osm2xodr.opendrive import OpenDrive
from osm2xodr.viewing.scene import Scene

_STYLES = {"none": 0, "": 0, "solid": 1, "broken": 2, "botts dots": 2, "broken broken": 2, "broken solid": 1}
_MARK_COLOURS = {"yellow": "#e8b400", "orange": "#e08a00", "red": "#d03a32", "blue": "#4f8fd0", "green": "#4aa564"}


def border_marks(file: OpenDrive, scene: Scene) -> tuple[list[list[Any]], IntArray]:
    """Return kinds of road marks and the kind of each border of strips.

    A lane's mark stands on its outer border, the centre lane's on the one between left and right.

    Returns
    -------
    kinds
        Name, 0 for none or 1 for solid or 2 for broken, colour.
    kind : (borders,)
        Of each border of each strip, from left to right, one strip after the other.
    """
    lanes = file.lanes
    kinds: dict[tuple[str, str], int] = {("none", ""): 0}
    code = np.array(
        [kinds.setdefault(pair, len(kinds)) for pair in zip(lanes.mark, lanes.mark_color, strict=True)], np.int64
    )
    strip = np.repeat(np.arange(len(scene.strip_road)), np.diff(scene.lane_start) + 1)
    first = scene.lane_start[:-1] + np.arange(len(scene.strip_road))
    rank = np.arange(len(strip)) - first[strip]
    left = np.bincount(
        np.repeat(np.arange(len(scene.strip_road)), np.diff(scene.lane_start)),
        weights=lanes.id[scene.lane] > 0,
        minlength=len(scene.strip_road),
    ).astype(np.int64)
    out = np.zeros(len(strip), np.int64)
    centre = rank == left[strip]
    has_centre = centre & (scene.centre[strip] >= 0)
    out[has_centre] = code[scene.centre[strip[has_centre]]]
    side = np.flatnonzero(~centre)
    out[side] = code[scene.lane[scene.lane_start[strip[side]] + rank[side] - (rank[side] > left[strip[side]])]]
    rows = [[name, _STYLES.get(name, 1), _MARK_COLOURS.get(colour, "#ffffff")] for name, colour in kinds]
    return rows, out
