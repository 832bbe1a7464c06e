"""Blocks of areas side by side: laid out once, and cut apart one area after the other."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from osm2xodr.curves import inside_outline, repeated
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.model import FloatArray, IntArray, Outline, Partition, RoadMap, Surface

if TYPE_CHECKING:
    from osm2xodr.surface import DemSummary


@dataclass(frozen=True, slots=True, eq=False)
class ElementPlaces:
    """Where the elements are that something was found about."""

    osm_ids: tuple[str, ...]  # Elements of which the map has a node
    element: IntArray  # (places,) Index of the element that has a place
    xy: FloatArray  # (places, 2) Local x, y, m

    @classmethod
    def of(cls, places: dict[str, FloatArray]) -> ElementPlaces:
        """Return the places (n, 2) of elements."""
        element = repeated([len(xy) for xy in places.values()])
        return cls(tuple(places), element, np.concatenate([np.zeros((0, 2)), *places.values()]))

    def outside(self, outline: Outline) -> set[str]:
        """Return the elements without a place in an area."""
        inside = np.zeros(len(self.osm_ids), np.bool_)
        inside[self.element[inside_outline(outline, *self.xy.T)]] = True
        return {self.osm_ids[k] for k in np.flatnonzero(~inside).tolist()}


@dataclass(frozen=True, slots=True, eq=False)
class Layout:
    """The roads of an area or block with all that is on them, and its surroundings, if any."""

    road_map: RoadMap
    surface: Surface  # The ground
    models: tuple[DemSummary, ...]  # What the elevation models are
    diagnostics: Diagnostics  # What was found
    places: ElementPlaces | None = None  # Of what was found; None for an area by itself


class Layouts:
    """Keeps the last block that was laid out, for the other areas of it."""

    def __init__(self) -> None:
        self._key: tuple[Any, ...] = ()
        self._layout: Layout | None = None

    @property
    def full(self) -> bool:
        """Whether a block is kept."""
        return self._layout is not None

    def clear(self) -> None:
        """Keep none."""
        self._key, self._layout = (), None

    def get(
        self, options: object, partition: Partition, files: Sequence[Path], lay_out: Callable[[], Layout]
    ) -> Layout:
        """Return the layout of the block of an area: the kept one, or a new one, which is then kept.

        It is the same block if its areas, the `options` of the conversion and `files` have not changed.
        """
        areas = [partition.outlines[k] for k in partition.together()]
        rings = tuple(ring.tobytes() for outline in areas for ring in outline.rings)
        key = (options, partition.frame, partition.names, partition.together(), rings, _times(files))
        if self._layout is None or key != self._key:
            # Two of them need not have room.
            self.clear()
            self._layout, self._key = lay_out(), key
        return self._layout


def _times(files: Sequence[Path]) -> tuple[tuple[Path, int, int], ...]:
    """Return size, bytes, and time of change, ns, of files."""
    found = ((path, path.stat()) for path in files if path.exists())
    return tuple((path, item.st_size, item.st_mtime_ns) for path, item in found)
