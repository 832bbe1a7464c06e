"""Streets so short that they lie within a junction are no roads of their own; those that nobody drives over are lost.

Streets within a junction live on in its connecting roads. Where it has none, because no road leads to it or none can
leave it, nothing is left of them, and that must be said.
"""

from __future__ import annotations

import numpy as np

from osm2xodr.diagnostics import Diagnostics
from osm2xodr.errors import InputError
from osm2xodr.geometry.junctions.clusters import JunctionLayout
from osm2xodr.model import IntArray, StreetNetwork


def refuse_without_roads(layout: JunctionLayout) -> None:
    """Refuse a network of which no street is left outside junctions.

    Raises
    ------
    InputError
        If there is none.
    """
    if layout.inner.all():
        raise InputError(
            "the streets lie within a few metres of each other, which leaves no road between their junctions; "
            "choose a larger area"
        )


def report_lost(network: StreetNetwork, layout: JunctionLayout, driven: IntArray, diagnostics: Diagnostics) -> None:
    """Say which streets lie within places that nobody drives through.

    Parameters
    ----------
    network, layout
        The streets and their junctions.
    driven
        Junctions that have connecting roads.
    diagnostics
        Where it is told.
    """
    # Rings, which start at no intersection, have -1 there.
    of_node = np.full(len(network.intersections) + 1, -1, np.int64)
    for junction in np.unique(driven).tolist():
        of_node[list(layout.nodes[junction])] = junction
    for street in np.flatnonzero(layout.inner).tolist():
        ends = network.streets[street].start, network.streets[street].end
        if of_node[list(ends)].max() >= 0:
            continue
        for way in dict.fromkeys(attributes.osm_way_id for _, attributes in network.streets[street].pieces):
            diagnostics.dropped(
                "within-junction",
                f"way/{way}",
                "it is shorter than any road, or lies within a junction that nobody drives through, and is left out",
            )
