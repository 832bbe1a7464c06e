"""Corrections of what is read of a map: `elements` left out, kept and changed, and the `keys` that say so."""

from __future__ import annotations

from osm2xodr.osmParsing.corrections.elements import (
    correct_nodes,
    correct_relations,
    correct_ways,
    keep_way,
    kept_ways,
)
from osm2xodr.osmParsing.corrections.keys import CORRECTION_KEYS, drops_relation, node_correction, way_correction

__all__ = [
    "CORRECTION_KEYS",
    "correct_nodes",
    "correct_relations",
    "correct_ways",
    "drops_relation",
    "keep_way",
    "kept_ways",
    "node_correction",
    "way_correction",
]
