"""Buildings, in words of OpenStreetMap."""

from __future__ import annotations

from dataclasses import dataclass

from osm2xodr.model.shared import FloatArray, freeze_arrays


@dataclass(frozen=True, slots=True, eq=False)
class Building:
    """A building or a part of one: an area, and what its tags say of its heights; None where they say nothing."""

    osm_id: str  # ``way/1`` or ``relation/2``
    outline: FloatArray  # (n, 2) Longitude and latitude, degrees, WGS 84; the last corner is not the first one again
    holes: tuple[FloatArray, ...]  # Courtyards, likewise
    kind: str  # Value of ``building`` or ``building:part``
    is_part: bool  # Whether it is a part of a building, which has an outline of its own
    # Above the ground, m
    height: float | None = None  # Of the ridge
    min_height: float | None = None  # Of the lowest storey's floor
    levels: float | None = None  # Storeys above the ground without those in the roof
    min_level: float | None = None  # Storeys left out at the bottom
    roof_shape: str = ""  # Value of ``roof:shape``
    roof_height: float | None = None  # From eaves to ridge, m
    roof_levels: float | None = None  # Storeys in the roof
    ridge_across: bool = False  # Whether the ridge runs along the shorter side

    def __post_init__(self) -> None:
        freeze_arrays(self)
        for hole in self.holes:
            hole.flags.writeable = False
