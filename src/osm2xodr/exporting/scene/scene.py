"""All parts of a scene, made in order."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from osm2xodr.diagnostics import counted
from osm2xodr.errors import InputError
from osm2xodr.exporting.mesh import file_origin
from osm2xodr.exporting.scene.buildings import building_parts
from osm2xodr.exporting.scene.ground import build_ground
from osm2xodr.exporting.scene.levels import settled
from osm2xodr.exporting.scene.meshes import Meshes, SurfaceHeights, has_area
from osm2xodr.exporting.scene.model import Level, Part, RoadSurface, lane_part
from osm2xodr.exporting.scene.roads import rim_of, road_surface
from osm2xodr.exporting.scene.things import mark_parts, object_parts, signal_parts, structure_parts
from osm2xodr.exporting.scene.water import WaterShapes, water_shapes
from osm2xodr.model import FloatArray, Surroundings
from osm2xodr.opendrive import Frame, OpenDrive, refuse_crowds
from osm2xodr.system import record

Height = Callable[[FloatArray, FloatArray], FloatArray]

LAYERS: Final = ("roads", "marks", "objects", "signals", "structures", "ground", "buildings")


@record(eq=False)
class Scene:
    """Everything there is to see."""

    parts: tuple[Part, ...]
    layers: tuple[str, ...]  # What each part belongs to: one of `LAYERS`
    origin: tuple[float, float, float]  # Inertial x, y, z that files count from, m
    notes: tuple[str, ...]  # Sentences about what the scene has not


def make_scene(
    file: OpenDrive,
    tolerance: float,
    step: float,
    height: Height | None,
    surroundings: tuple[Surroundings, Frame] | None,
    tile: float,
    *,
    coarse_ground: bool = False,
) -> Scene:
    """Return the scene of a file.

    Parameters
    ----------
    file
        The road network.
    tolerance, step
        How far straight pieces may lie from curves, and how long they are at most, m.
    height
        Heights of the ground (n,), m, at inertial x, y (n,), m, NaN where unknown; None without elevation model: the
        ground is a strip beside roads then, and bridges have no piers.
    surroundings
        Buildings and water, and what turns their places into inertial ones; None for none.
    tile
        Width of tiles, m.
    coarse_ground
        Whether the ground has its coarsest level of detail alone.

    Raises
    ------
    InputError
        No lane has a surface, or roads are too many or too wide in one place.
    """
    refuse_crowds(file)
    surface, passage = settled(road_surface(file, tolerance, step), height)
    water = None
    if surroundings is not None:
        on_land = surface.vertices[surface.faces[surface.level == Level.GROUND]].mean(1)
        water = water_shapes(surroundings[0].water, surroundings[1], surface.vertices, on_land)
    ground = build_ground(surface, rim_of(surface), height, tile, water, coarsest_alone=coarse_ground)
    heights = SurfaceHeights(surface)
    found: dict[str, Sequence[Part]] = {
        "roads": surface_parts(surface),
        "marks": mark_parts(file, heights, tolerance, step),
        "objects": object_parts(file, heights),
        "signals": signal_parts(file),
        "structures": structure_parts(file, surface, heights, None if height is None else ground.heights),
        "ground": ground.parts,
    }
    notes = []
    if ground.unknown > 0:
        notes.append(f"no elevation model knows {ground.unknown:,.0f} m² around roads: there is no ground there")
    if ground.interpolated > 0:
        notes.append(
            f"no elevation model knows {ground.interpolated:,.0f} m² of the ground: its height is interpolated"
        )
    if surroundings is not None and water is not None:
        notes += _open_water(water, surroundings[0].water.unclosed)
        built = building_parts(surroundings[0].buildings, surroundings[1], surface, passage, ground)
        found["buildings"] = built.parts
        notes.append(_sentence(built.ids))
    sound = [(clean, layer) for layer, parts in found.items() for part in parts if len((clean := _sound(part)).faces)]
    if not sound:
        raise InputError(f"{file.path} has no lane with a surface; osm2xodr check lists what is wrong with it")
    kept, layers = zip(*sound, strict=True)
    return Scene(kept, layers, file_origin(surface.vertices), tuple(notes))


def _open_water(water: WaterShapes, unclosed: Sequence[str]) -> list[str]:
    """Return what is to say about water whose outline is not whole in the file, or not closed at all."""
    open_ones = "water whose outline is not whole in the OSM file"
    return [
        f"{what}: {', '.join(ids)}"
        for ids, what in (
            (water.closed, f"{open_ones}, closed along the side of the area"),
            (water.left_out, f"{open_ones}, left out as it is not clear on which side of its shores it is"),
            (unclosed, f"not closed, though tagged as areas of water, and left out ({len(unclosed):,})"),
        )
        if ids
    ]


def _sentence(ids: Mapping[str, Sequence[str]]) -> str:
    """Return what is to say about buildings, by the OSM ids of those that something befell."""
    words = {
        "guessed": "of a guessed height",
        "flat": "with a flat roof instead of their own",
        "clipped": "cut where roads are",
        "repaired": "of repaired outlines",
    }
    gone = {"on_roads": "on roads", "off_ground": "where there is no ground"}
    drawn, left_out = len(ids.get("drawn", ())), sum(len(ids.get(key, ())) for key in gone)
    message = counted(drawn, "building") if drawn or not left_out else f"none of {counted(left_out, 'building')}"
    rest = [f"{len(ids[key]):,} {text}" for key, text in words.items() if ids.get(key)]
    lost = [f"{len(ids[key]):,} {text}" for key, text in gone.items() if ids.get(key)]
    parts = [": " + ", ".join(rest) if rest else "", "; left out: " + ", ".join(lost) if lost else ""]
    return message + "".join(parts)


def surface_parts(surface: RoadSurface) -> list[Part]:
    """Return the surface of roads as a part for each name and material."""
    meshes = Meshes()
    for k, kind in enumerate(surface.kinds):
        used, faces = np.unique(surface.faces[surface.kind == k], return_inverse=True)
        meshes.add(*lane_part(kind), surface.vertices[used], surface.uv[used], faces.reshape(-1, 3))
    return meshes.parts()


def _sound(part: Part) -> Part:
    """Return a part without triangles that have no area."""
    kept = np.flatnonzero(has_area(part.vertices, part.faces))
    detail = None if part.detail is None else part.detail[kept]
    return part if len(kept) == len(part.faces) else replace(part, faces=part.faces[kept], detail=detail)
