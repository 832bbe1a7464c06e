"""Cuts areas out of one map, with all that shapes roads at the borders between them."""

from __future__ import annotations

from osm2xodr.batching.cutting.cuts import bounds_of as bounds_of, cut_areas as cut_areas
