"""What there is beside roads, and buildings, in words of OpenStreetMap."""

from __future__ import annotations

from dataclasses import field

from osm2xodr.model.shared import FloatArray, freeze_arrays
from osm2xodr.system import record


@record(eq=False)
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


@record(eq=False)
class WaterArea:
    """A lake, a river or a basin."""

    osm_id: str  # ``way/1`` or ``relation/2``
    outline: FloatArray  # (n, 2) Longitude and latitude, degrees, WGS 84; the last corner is not the first one again
    holes: tuple[FloatArray, ...]  # Islands, likewise

    def __post_init__(self) -> None:
        freeze_arrays(self)
        for hole in self.holes:
            hole.flags.writeable = False


@record(eq=False)
class OpenWater:
    """A lake, a river or a basin whose outline is not whole in the file."""

    osm_id: str  # ``way/1`` or ``relation/2``
    lines: tuple[FloatArray, ...]  # What there is of the outline, (n, 2), longitude and latitude, degrees, WGS 84
    holes: tuple[FloatArray, ...]  # Islands, likewise; the last corner is not the first one again

    def __post_init__(self) -> None:
        for line in (*self.lines, *self.holes):
            line.flags.writeable = False


@record(eq=False)
class Water:
    """All water of an area."""

    areas: tuple[WaterArea, ...] = ()
    open_areas: tuple[OpenWater, ...] = ()
    # The rectangle that the file was cut to, west, south, east, north, degrees; None where it is not known, or where
    # no area is open
    bounds: tuple[float, float, float, float] | None = None
    coastlines: tuple[FloatArray, ...] = ()  # (n, 2) Longitude and latitude, degrees, WGS 84; the sea is on the right
    unclosed: tuple[str, ...] = ()  # OSM ids of ways with the tags of areas that are lines

    def __post_init__(self) -> None:
        for line in self.coastlines:
            line.flags.writeable = False


@record(eq=False)
class Surroundings:
    """What a scene has beside its roads."""

    buildings: tuple[Building, ...] = ()
    water: Water = field(default_factory=Water)
