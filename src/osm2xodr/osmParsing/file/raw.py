"""Elements of OSM files as they are there."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from osm2xodr.model import FloatArray, IntArray


@dataclass(frozen=True, slots=True)
class RawWay:
    """A way as in the file; `refs` are ids of nodes, `tags` those that were asked for."""

    id: int
    refs: Sequence[int]
    tags: Mapping[str, str]


@dataclass(frozen=True, slots=True)
class RawMember:
    """A member of a relation; `type` is ``node``, ``way`` or ``relation``."""

    type: str
    ref: int
    role: str


@dataclass(frozen=True, slots=True)
class RawRelation:
    """A relation as in the file."""

    id: int
    members: tuple[RawMember, ...]
    tags: Mapping[str, str]


@dataclass(frozen=True, slots=True, eq=False)
class RawNodes:
    """Nodes that are in the file, in ascending id."""

    # (n,) Ids, and positions, degrees, WGS 84
    ids: IntArray
    lon_deg: FloatArray
    lat_deg: FloatArray
    tags: Mapping[int, Mapping[str, str]]  # Tags of nodes that have any, in ascending id
