"""Areas side by side: outlines in one local frame, and which of them a conversion is for."""

from __future__ import annotations

from dataclasses import dataclass

from osm2xodr.model.shared import FloatArray, IntArray, LocalFrame, freeze_arrays


@dataclass(frozen=True, slots=True)
class Outline:
    """What an area covers."""

    # Corners (n, 2) of closed rings, local x, y, m, the first not repeated at the end. A point is inside if an odd
    # number of them goes round it, so that holes and parts are rings as well.
    rings: tuple[FloatArray, ...]


@dataclass(frozen=True, slots=True)
class Partition:
    """Areas that are converted one by one and fit together."""

    frame: LocalFrame  # Of all of them
    names: tuple[str, ...]  # Unique
    outlines: tuple[Outline, ...]  # What each covers. Where several cover a place, it belongs to the first of them.
    # Id of each area's first road; those of its roads and junctions lie below the next greater one
    first_ids: tuple[int, ...]
    own: int  # Index of the area that is converted


@dataclass(frozen=True, slots=True, eq=False)
class Borders:
    """Which area each piece of road belongs to: index into `Partition.names`, -1 outside of all."""

    partition: Partition  # The areas
    # (roads outside junctions + 1,) Index of each road's first piece; the last entry is the number of pieces. Every
    # road has at least one.
    piece_start: IntArray
    piece_s: FloatArray  # (pieces,) Where each piece begins along its road, m; 0 for the first one
    piece_area: IntArray  # (pieces,) Its area; that of neighbouring pieces of a road differs
    # (junctions,) The area of each junction of `RoadMap.junctions`. The pieces of roads that touch it are of the same
    # area.
    junction_area: IntArray

    def __post_init__(self) -> None:
        freeze_arrays(self)


@dataclass(frozen=True, slots=True)
class BorderEnd:
    """The end of a road that goes on in a neighbouring area."""

    road: int  # Id of the road
    at_start: bool  # Whether it is the road's start
    neighbour: str  # Name of the area that it goes on in; empty where there is none
    # The reference line there, local, m
    x: float
    y: float
    z: float
    hdg: float  # Of the reference line along s, rad
    osm_way_ids: tuple[int, ...]  # Of the road that was cut
