"""The scene in 3D: all that `osm2xodr.exporting` makes of a file, as meshes of the page.

A page must stay small and quick: meshes have whole centimetres, the ground its coarsest level of detail, and long
networks are made of longer pieces.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np

from osm2xodr.curves import unique_all
from osm2xodr.defaults import SAMPLE_STEP, SAMPLE_TOLERANCE
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.errors import InputError
from osm2xodr.model import FloatArray, IntArray, Surroundings
from osm2xodr.opendrive import Frame, OpenDrive
from osm2xodr.viewing.options import ReportOptions
from osm2xodr.viewing.page.packing import Packed, quantised
from osm2xodr.viewing.scene import Scene

# Roads, m, connecting ones as well: up to the first length scenes are as fine as those that are exported, and made
# without being asked for; up to the second one pieces of curves are longer. Choices: a page of some 10 and 60 MB.
FINE_TO: Final = 250_000.0
MOST: Final = 2_500_000.0
# The rectangle around roads, m², likewise: cells of the ground take some 2 MB of memory per km².
_AREA: Final = 5e8
_MOST_AREA: Final = 2.5e9
# It extends this far beyond the roads, m, as ground does at both sides.
_AROUND: Final = 200.0
_COARSE_TOLERANCE: Final = 0.2
_COARSE_STEP: Final = 40.0
# Borders of tiles are corners of the ground, m: there are no tiles in a page.
_TILE: Final = 1e5
# Whole numbers of the page's meshes, m.
_STEP: Final = 0.01

Height = Callable[[FloatArray, FloatArray], FloatArray]


@dataclass(frozen=True, eq=False)
class Bodies:
    """Meshes, each of one layer and one material."""

    # Rows of layer, material, colour (#rrggbb), roughness, number of vertices, and of triangles
    meshes: list[list[Any]] = field(default_factory=list)
    arrays: dict[str, Packed] = field(default_factory=dict)
    notes: tuple[str, ...] = ()  # Sentences about what the scene has not


def bodies_of(
    file: OpenDrive,
    options: ReportOptions,
    height: Height | None,
    frame: Frame | None,
    drawn: Scene,
    origin: tuple[float, float],
    diagnostics: Diagnostics,
) -> Bodies:
    """Return the scene of a file, without any mesh if there is none, and why.

    Parameters
    ----------
    file
        The road network.
    options
        Whether there is to be a scene, and the file with its buildings.
    height
        The ground's height at inertial x, y (n,), m; None without elevation model.
    frame
        Where the file lies on Earth; None if that is unknown: there are no buildings then.
    drawn
        What is drawn of the file on the map.
    origin
        What is subtracted from inertial x and y on the page, m.
    diagnostics
        Receives that no scene can be made of a damaged file.

    Raises
    ------
    InputError
        A scene is asked for that cannot be made, or the file with buildings cannot be read.
    """
    if options.scene is False:
        return Bodies()
    length = float(np.nansum(np.where(np.isfinite(file.roads.length), file.roads.length, 0.0)))
    if why := _obstacle(length, _area(drawn), asked=options.scene is True):
        if options.scene:
            raise InputError(f"{file.path}: {why}")
        return Bodies(notes=(f"The view in 3D has lanes alone: {why}",))
    surroundings = None
    if options.osm is not None and frame is not None:
        from osm2xodr.osmParsing import read_surroundings

        surroundings = read_surroundings(options.osm), frame
    try:
        return _built(file, length, height, surroundings, origin)
    except Exception as error:
        # A file may be damaged in ways that nobody foresaw, and the rest of the page needs no scene.
        why = str(error) if isinstance(error, InputError) else f"{type(error).__name__}: {error}"
        if options.scene:
            raise InputError(f"{file.path}: no scene can be made of it ({why})") from error
        diagnostics.note("no-scene", "", f"the view in 3D has lanes alone: no scene can be made of the file ({why})")
        return Bodies()


def _built(
    file: OpenDrive,
    length: float,
    height: Height | None,
    surroundings: tuple[Surroundings, Frame] | None,
    origin: tuple[float, float],
) -> Bodies:
    """Return the meshes of a file with roads of a length, m."""
    from osm2xodr.exporting import make_scene, material_of

    form = (SAMPLE_TOLERANCE, SAMPLE_STEP) if length <= FINE_TO else (_COARSE_TOLERANCE, _COARSE_STEP)
    scene = make_scene(file, *form, height, surroundings, _TILE, coarse_ground=True)
    found: dict[tuple[str, str], list[tuple[FloatArray, IntArray]]] = {}
    for part, layer in zip(scene.parts, scene.layers, strict=True):
        found.setdefault((layer, part.material), []).append((part.vertices, part.faces))
    meshes, places, corners = [], [], []
    for (layer, material), pieces in sorted(found.items()):
        vertices, faces = _joined(pieces)
        places.append(vertices)
        corners.append(faces)
        look = material_of(material)
        meshes.append([layer, material, look.colour, look.roughness, len(vertices), len(faces)])
    x, y, z = np.concatenate(places).T
    arrays = {
        "body_x": quantised(x - origin[0], _STEP),
        "body_y": quantised(y - origin[1], _STEP),
        "body_z": quantised(z, _STEP),
        "body_face": np.concatenate(corners).ravel().astype(np.int32),
    }
    return Bodies(meshes, arrays, tuple(f"View in 3D: {note}." for note in scene.notes))


def _area(drawn: Scene) -> float:
    """Return the area of the rectangle around all roads, m²; 0 without any."""
    if not len(drawn.x):
        return 0.0
    return (float(np.ptp(drawn.x)) + _AROUND) * (float(np.ptp(drawn.y)) + _AROUND)


def _obstacle(length: float, area: float, *, asked: bool) -> str:
    """Return why there is no scene of so many roads, m, in so large an area, m²; empty if there is."""
    if not (length > 0.0 and area > 0.0):
        return "there is no road that can be drawn."
    size = f"{length / 1000.0:,.0f} km of roads in an area of {area / 1e6:,.0f} km²"
    if length > MOST or area > _MOST_AREA:
        return f"{size} are too much for one page; crop the file first, or use osm2xodr export --scene."
    if (length > FINE_TO or area > _AREA) and not asked:
        return f"{size} take long; ask for them with --scene."
    return ""


def _joined(pieces: list[tuple[FloatArray, IntArray]]) -> tuple[FloatArray, IntArray]:
    """Return vertices and triangles of several meshes as those of one, vertices in the order of their first use."""
    first = np.cumsum([0, *(len(vertices) for vertices, _ in pieces)])
    faces = np.concatenate([rows + at for (_, rows), at in zip(pieces, first[:-1].tolist(), strict=True)])
    used, begin, number, _ = unique_all(faces)
    order = np.argsort(begin, kind="stable")
    rank = np.empty(len(order), np.int64)
    rank[order] = np.arange(len(order))
    vertices = np.concatenate([vertices for vertices, _ in pieces])[used[order]]
    return vertices, rank[number].reshape(-1, 3)
