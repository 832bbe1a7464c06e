"""The file with the frame and the outlines of areas side by side.

``osm2xodr batch --shared-frame`` writes it, ``osm2xodr convert --frame`` reads it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Any, Final

import numpy as np

from osm2xodr.batching.areas import PlannedArea
from osm2xodr.errors import InputError
from osm2xodr.model import Outline, Partition
from osm2xodr.projection import make_frame
from osm2xodr.system import parse_json

# Version of the layout; goes up when a field is removed or changes its meaning.
_FORMAT: Final = 1
# Ids of roads and junctions that each area may use; a choice.
_IDS_PER_AREA: Final = 100_000


def shared_frame(planned: Sequence[PlannedArea]) -> dict[str, Any]:
    """Return the contents of the file; `InputError` says that there are more areas than ids for their roads."""
    frame = planned[0].frame
    assert frame is not None
    areas = []
    for item in sorted(planned, key=lambda item: item.area.name):
        assert item.outline is not None
        first = 1 + _IDS_PER_AREA * item.number
        # Several readers keep ids as numbers of 32 bits.
        if first + _IDS_PER_AREA > 2**31:
            raise InputError(
                "there are too many areas for --shared-frame to give ids; choose larger ones, or a smaller map"
            )
        rings = [ring.tolist() for ring in item.outline.rings]
        block = {} if item.block is None else {"block": item.block.name}
        areas.append({"name": item.area.name, "first_id": first, "rings": rings, **block})
    return {"format": _FORMAT, "lat_0_deg": frame.lat_0_deg, "lon_0_deg": frame.lon_0_deg, "areas": areas}


def read_partition(path: Path, own: str, *, in_block: bool = False) -> Partition:
    """Read how areas lie side by side; `own` is the name of the area that is converted, `in_block` with its block.

    The file is JSON: ``format``, the frame's origin ``lat_0_deg`` and ``lon_0_deg``, and ``areas``, each with its
    ``name``, ``first_id``, ``rings`` of local x, y, m, and perhaps the name of its ``block``. Raises `InputError` if
    it cannot be read, is of another kind, or does not have the area or a block of it.
    """
    try:
        found = path.stat()
        partition, blocks = _read(path, found.st_size, found.st_mtime_ns)
    except (OSError, UnicodeDecodeError) as error:
        why = error.strerror if isinstance(error, OSError) and error.strerror else "it is not UTF-8"
        raise InputError(f"{path} cannot be read: {why.lower()}; give the file that the batch wrote") from error
    except (ValueError, KeyError, TypeError, IndexError, OverflowError) as error:
        raise InputError(
            f"{path} does not say how areas lie side by side; give the file that osm2xodr batch --shared-frame wrote"
        ) from error
    if own not in partition.names:
        raise InputError(
            f"{path} has no area {own!r}, after which the map is named; give the map of one of its areas"
        )
    index = partition.names.index(own)
    if not in_block:
        return replace(partition, own=index)
    if not blocks[index]:
        raise InputError(f"{path}: area {own!r} is in no block; give its own map, without --tile")
    block = tuple(k for k, name in enumerate(blocks) if name == blocks[index])
    return replace(partition, own=index, block=block)


# Kept, because a process converts many areas of a batch, and the file of a country takes a while to read.
@lru_cache(maxsize=1)
def _read(path: Path, size: int, mtime_ns: int) -> tuple[Partition, tuple[str, ...]]:
    """Read the areas, as the partition of the first one, and the name of the block of each, "" for none.

    What is wrong with the file raises one of the errors that `read_partition` catches.
    """
    table = parse_json(path.read_text(encoding="utf-8"))
    if table["format"] != _FORMAT:
        raise InputError(
            f"{path} has format {table['format']}, and this version reads {_FORMAT}; run the batch again"
        )
    areas = table["areas"]
    names = tuple(str(area["name"]) for area in areas)
    outlines = tuple(
        Outline(tuple(np.array(ring, np.float64).reshape(-1, 2) for ring in area["rings"])) for area in areas
    )
    rings = [ring for outline in outlines for ring in outline.rings]
    if not all(len(ring) > 2 and np.isfinite(ring).all() for ring in rings):
        raise ValueError
    if not all(outline.rings for outline in outlines):
        raise ValueError
    frame = make_frame(float(table["lat_0_deg"]), float(table["lon_0_deg"]))
    first_ids = tuple(int(area["first_id"]) for area in areas)
    blocks = tuple(str(area.get("block", "")) for area in areas)
    return Partition(frame, names, outlines, first_ids, 0), blocks
