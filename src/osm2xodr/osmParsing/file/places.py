"""Where elements of an OSM file are, whatever they are."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import numpy as np

from osm2xodr import projection
from osm2xodr.model import FloatArray, LocalFrame
from osm2xodr.osmParsing.file.file_format import open_osm_file
from osm2xodr.osmParsing.file.reader import read_nodes, read_refs


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
    wanted = np.array([ref for item in refs.values() for ref in item], np.int64)
    nodes = read_nodes(file, np.unique(wanted))
    xy = np.column_stack(projection.to_local(frame, nodes.lon_deg, nodes.lat_deg))
    known = np.isin(wanted, nodes.ids)
    place = np.searchsorted(nodes.ids, wanted)
    owner = np.repeat(np.arange(len(refs)), [len(item) for item in refs.values()])[known]
    border = np.searchsorted(owner, np.arange(1, len(refs)))
    rows = np.split(place[known], border)
    return {osm_id: xy[found] for osm_id, found in zip(refs, rows, strict=True) if len(found)}
