"""Reads the file that says how areas lie side by side, which `osm2xodr batch --shared-frame` writes."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any, Final

import numpy as np

from osm2xodr.errors import InputError
from osm2xodr.model import Outline, Partition
from osm2xodr.projection import make_frame

# The layout of the file; goes up when a field changes its meaning or goes.
PARTITION_FORMAT: Final = 1


def read_partition(path: Path, own: str) -> Partition:
    """Read how areas lie side by side.

    Parameters
    ----------
    path
        JSON: ``format``, the frame's origin ``lat_0_deg`` and ``lon_0_deg``, and ``areas``, each with its ``name``,
        ``first_id`` and ``rings`` of local x, y, m.
    own
        Name of the area that is converted.

    Raises
    ------
    InputError
        It cannot be read, is no such file, or does not have the area.
    """
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        why = error.strerror if isinstance(error, OSError) and error.strerror else "it is not UTF-8"
        raise InputError(f"{path} cannot be read: {why.lower()}; give the file that the batch wrote") from error
    try:
        table = json.loads(text)
        if table["format"] != PARTITION_FORMAT:
            raise InputError(
                f"{path} has format {table['format']}, and this version reads {PARTITION_FORMAT}; run the batch again"
            )
        return _partition(table, path, own)
    except (ValueError, KeyError, TypeError, IndexError, RecursionError) as error:
        raise InputError(
            f"{path} does not say how areas lie side by side; give the file that osm2xodr batch --shared-frame wrote"
        ) from error


def _partition(table: dict[str, Any], path: Path, own: str) -> Partition:
    areas = table["areas"]
    names = tuple(str(area["name"]) for area in areas)
    if own not in names:
        raise InputError(
            f"{path} has no area {own!r}, after which the map is named; give the map of one of its areas"
        )
    outlines = tuple(
        Outline(tuple(np.array(ring, np.float64).reshape(-1, 2) for ring in area["rings"])) for area in areas
    )
    if not all(len(ring) > 2 and np.isfinite(ring).all() for outline in outlines for ring in outline.rings):
        raise ValueError
    if not all(outline.rings for outline in outlines):
        raise ValueError
    frame = make_frame(float(table["lat_0_deg"]), float(table["lon_0_deg"]))
    first_ids = tuple(int(area["first_id"]) for area in areas)
    return Partition(frame, names, outlines, first_ids, names.index(own))
