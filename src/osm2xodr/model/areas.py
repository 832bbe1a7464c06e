"""Areas side by side: outlines in one local frame, and which of them a conversion is for."""

from __future__ import annotations

from dataclasses import dataclass

from osm2xodr.model.shared import FloatArray, IntArray, LocalFrame, freeze_arrays


@dataclass(frozen=True, slots=True)
class Outline:
    """The outline of an area."""

    # Corners (n, 2) of closed rings, local x, y, m, the first not repeated at the end. A point is inside if an odd
    # number of them goes round it, so that holes and parts are rings as well.
    rings: tuple[FloatArray, ...]


@dataclass(frozen=True, slots=True)
class Partition:
    """Areas that are converted one by one, so that the results fit together."""

    frame: LocalFrame  # Common to all
    names: tuple[str, ...]  # Unique
    outlines: tuple[Outline, ...]  # A place that several cover belongs to the first of them
    # Id of each area's first road; those of its roads and junctions lie below the next greater one
    first_ids: tuple[int, ...]
    own: int  # Index of the area that is converted


@dataclass(frozen=True, slots=True, eq=False)
class Borders:
    """The area of each piece of road: index into `Partition.names`, -1 outside of all."""

    partition: Partition
    # (roads outside junctions + 1,) Index of each road's first piece; the last entry is the number of pieces. Every
    # road has at least one.
    piece_start: IntArray
    piece_s: FloatArray  # (pieces,) Where each piece begins along its road, m; 0 for the first one
    piece_area: IntArray  # (pieces,) Its area, different from that of the next piece of the road
    # (junctions,) The area of each junction of `RoadMap.junctions`, the same as that of the pieces that touch it
    junction_area: IntArray

    def __post_init__(self) -> None:
        freeze_arrays(self)


@dataclass(frozen=True, slots=True)
class BorderEnd:
    """The end of a road that continues in a neighbouring area."""

    road: int  # Id of the road
    at_start: bool  # Whether it is the road's start
    neighbour: str  # Name of the area in which it continues; empty outside of all
    # The reference line there, local, m
    x: float
    y: float
    z: float
    hdg: float  # Of the reference line along s, rad
    osm_way_ids: tuple[int, ...]  # Of the road that was cut
