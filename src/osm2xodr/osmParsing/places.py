"""Where elements of an OSM file are, whatever they are."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import numpy as np

from osm2xodr import projection
from osm2xodr.model import FloatArray, LocalFrame
from osm2xodr.osmParsing.file_format import open_osm_file
from osm2xodr.osmParsing.reader import read_nodes, read_refs


def element_places(path: Path, frame: LocalFrame, osm_ids: Iterable[str]) -> dict[str, FloatArray]:
    """Return the places of the nodes that elements consist of.

    Parameters
    ----------
    path
        OSM file.
    frame
        Local frame.
    osm_ids
        ``node/1``, ``way/2``, ``relation/3`` ...

    Returns
    -------
    dict
        Local x, y, (n, 2), m, n >= 1; without elements of which the file has no node.

    Raises
    ------
    InputError
        The file cannot be read.
    """
    file = open_osm_file(path)
    numbers: dict[str, set[int]] = {"node": set(), "way": set(), "relation": set()}
    for osm_id in osm_ids:
        kind, _, number = osm_id.partition("/")
        numbers[kind].add(int(number))
    refs = {f"node/{number}": [number] for number in sorted(numbers["node"])}
    refs |= read_refs(file, numbers["way"], numbers["relation"])
    if not refs:
        return {}
    nodes = read_nodes(file, np.unique(np.concatenate([np.array(item, np.int64) for item in refs.values()])))
    xy = np.column_stack(projection.to_local(frame, nodes.lon_deg, nodes.lat_deg))
    found = {}
    for osm_id, of_element in refs.items():
        rows = np.flatnonzero(np.isin(nodes.ids, of_element))
        if len(rows):
            found[osm_id] = xy[rows]
    return found
