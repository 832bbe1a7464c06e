"""Draw one place of the sample as each step of a conversion leaves it: the pictures of docs/how_it_works.md.

Makes ``docs/images/stages``. Needs the extra ``docs``.

    python tools/draw_stages.py [-o FOLDER]
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import matplotlib as mpl
import numpy as np
from draw_map import (
    DPI,
    FILL,
    GREEN,
    PALE,
    RED,
    SIDES,
    SIZE,
    THROUGH,
    draw_arrow,
    draw_furniture,
    draw_marks,
    fill_lanes,
    legend,
    reference_line,
    save_picture,
    width_at,
)

import osm2xodr
from osm2xodr.curves import lengths, pose
from osm2xodr.curves.cubics import cubic_value
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.geometry import RoadOptions
from osm2xodr.geometry.plan_view import FittedStreets
from osm2xodr.geometry.road_plan import plan_roads
from osm2xodr.model import FloatArray, LaneType, Road, RoadMap, StreetNetwork, Surface
from osm2xodr.osmParsing import parse_osm
from osm2xodr.pipeline import PipelineOptions
from osm2xodr.projection import offline
from osm2xodr.reporting import Conversion
from osm2xodr.surface import SurfaceOptions, points_along, read_surface

mpl.use("Agg")
from matplotlib.axes import Axes

ROOT = Path(__file__).parents[1]
SAMPLE = ROOT / "data" / "samples" / "andorra_ordino"
TARGET = ROOT / "docs" / "images" / "stages"
# The place: west, south, east, north, local, m: a roundabout and the streets before it. The ground is shown of more.
BOX = (2178.0, 672.0, 2338.0, 792.0)
GROUND = (1500.0, 100.0, 2900.0, 1150.0)
GREY, BLUE, SAND = "#9aa0a8", "#1d5fa8", "#f0d9b5"
HIGHWAYS = {"primary": RED, "tertiary": "#c98a1e", "residential": BLUE, "service": GREY}


@dataclass(frozen=True)
class Stages:
    """What the steps of a conversion of the sample hand on."""

    network: StreetNetwork
    surface: Surface
    fitted: FittedStreets
    result: Conversion

    @property
    def road_map(self) -> RoadMap:
        """The finished roads."""
        return self.result.road_map

    def roads(self, *, inside: bool) -> Iterator[tuple[int, Road]]:
        """Yield index and road of those inside or outside junctions that come near the place."""
        for index, road in enumerate(self.road_map.roads):
            if (road.junction is not None) is inside and _is_near(reference_line(self.road_map.plan_view, index)):
                yield index, road


def run() -> Stages:
    """Convert the sample step by step."""
    options, unheard = PipelineOptions(SAMPLE / "area.osm", (SAMPLE / "dem.tif",)), Diagnostics()
    network = parse_osm(options.area, options.parse, unheard)
    with offline():
        surface = read_surface(options.dems, network.frame, *points_along(network.streets), SurfaceOptions(), unheard)
    plan = plan_roads(network, RoadOptions(), unheard)
    return Stages(network, surface, plan.fitted, osm2xodr.convert(options.area, options.dems))


# ---------------------------------------------------------------- the pictures


def osm(axes: Axes, stages: Stages) -> None:
    """Draw streets as OSM has them: straight from node to node, with tags."""
    labelled = set[str]()
    for street in stages.network.streets:
        attributes = street.pieces[0][1]
        axes.plot(
            *street.points.T, color=HIGHWAYS.get(attributes.highway, GREY), lw=1.6, marker="o", ms=3.5, zorder=2
        )
        middle = street.points[len(street.points) // 2]
        if attributes.highway not in labelled and attributes.osm_way_id and _is_near(middle[None], -25.0):
            labelled.add(attributes.highway)
            name = f"\nname={attributes.name}" if attributes.name else ""
            axes.annotate(
                f"way {attributes.osm_way_id}\nhighway={attributes.highway}{name}", middle, (12, -30),
                textcoords="offset points", fontsize=8, zorder=5, bbox={"fc": "white", "ec": GREY, "lw": 0.5},
            )  # fmt: skip
    for item in stages.network.intersections:
        axes.plot(item.x, item.y, "s", color="black", ms=5, zorder=3)
    legend(axes, {f"highway={name}": color for name, color in HIGHWAYS.items()} | {"where streets meet": "black"})


def ground(axes: Axes, stages: Stages) -> None:
    """Draw the height of the ground around the place."""
    west, south, east, north = GROUND
    step = 10.0
    x, y = np.meshgrid(np.arange(west, east + 1.0, step), np.arange(south, north + 1.0, step))
    with offline():
        z = stages.surface.heights(x.ravel(), y.ravel())[0].reshape(x.shape)
    slope_y, slope_x = np.gradient(z, step)
    light = (1.0 + 0.6 * (slope_x - slope_y)) / np.sqrt(1.0 + slope_x**2 + slope_y**2)
    axes.imshow(light, extent=(west, east, south, north), origin="lower", cmap="gray", vmin=-0.6, vmax=1.4)
    levels = np.arange(1000.0, 2000.0, 25.0)
    lines = axes.contour(x, y, z, levels=levels, colors="#f2c14e", linewidths=0.7)
    axes.clabel(lines, levels[::2], fontsize=8, fmt="%.0f m")
    for street in stages.network.streets:
        axes.plot(*street.points.T, color="white", lw=1.0)
    w, s, e, n = BOX
    axes.plot([w, e, e, w, w], [s, s, n, n, s], color=RED, lw=1.8)
    axes.set(xlim=(west, east), ylim=(south, north))


def plan_view(axes: Axes, stages: Stages) -> None:
    """Draw the curves that were fitted to streets, by their kind."""
    view = stages.fitted.plan_view
    owner = np.repeat(np.arange(len(view.start) - 1), np.diff(view.start))
    for k, length in enumerate(view.length.tolist()):
        s = view.s[k] + np.linspace(0.0, length, max(2, math.ceil(length)))
        x, y, _ = pose(view, np.full(len(s), owner[k]), s)
        color = BLUE if view.rate[k] else RED if view.curvature[k] else GREEN
        axes.plot(x, y, color=color, lw=2.4, solid_capstyle="butt", zorder=2)
    for street in stages.network.streets:
        axes.plot(*street.points.T, "o", color="black", ms=3, zorder=3)
    legend(axes, {"line": GREEN, "arc": RED, "spiral": BLUE, "node of OSM": "black"})


def lanes(axes: Axes, stages: Stages) -> None:
    """Draw the lanes of carriageways, and where their lane sections begin."""
    _fill(axes, stages, FILL)
    view = stages.road_map.plan_view
    for index, road in stages.roads(inside=False):
        axes.plot(*reference_line(view, index).T, color="black", lw=0.8, zorder=4)
        for section in road.lane_sections:
            axes.plot(*_across(stages.road_map, index, road, section.s).T, color=RED, lw=2.0, zorder=5)
    legend(axes, {"lane": FILL[LaneType.DRIVING], "reference line": "black", "start of a lane section": RED})


def junctions(axes: Axes, stages: Stages) -> None:
    """Draw where roads end, and what they leave to junctions."""
    _fill(axes, stages, FILL)
    faces: dict[int, list[FloatArray]] = {}
    length = lengths(stages.road_map.plan_view)
    for index, road in stages.roads(inside=False):
        for link, s in ((road.predecessor, 0.0), (road.successor, float(length[index]))):
            if link is not None and link.to_junction:
                faces.setdefault(link.id, []).append(_across(stages.road_map, index, road, s))
    for ends in faces.values():
        corners = np.concatenate(ends)
        x, y = (corners - corners.mean(axis=0)).T
        axes.fill(*corners[np.argsort(np.arctan2(y, x))].T, color=SAND, lw=0, zorder=1)
        for end in ends:
            axes.plot(*end.T, color=RED, lw=2.4, zorder=4)
    legend(axes, {"road": FILL[LaneType.DRIVING], "its end": RED, "junction": SAND})


def through(axes: Axes, stages: Stages) -> None:
    """Draw the roads through junctions."""
    _fill(axes, stages, PALE)
    for index, road in stages.roads(inside=True):
        if all(lane.type not in FILL for lane in road.lane_sections[0].lanes):
            continue
        color = THROUGH[(road.predecessor.id if road.predecessor else 0) % len(THROUGH)]
        draw_arrow(axes, reference_line(stages.road_map.plan_view, index), color, 1.4)


def sides(axes: Axes, stages: Stages) -> None:
    """Draw what lies beside carriageways, and the floor of junctions."""
    colors = FILL | SIDES
    _fill(axes, stages, colors, inside=True)
    _fill(axes, stages, colors)
    legend(axes, {kind.value: colors[kind] for kind in (LaneType.DRIVING, LaneType.SIDEWALK, LaneType.BORDER)})


def heights(axes: Axes, stages: Stages) -> None:
    """Draw the profile of the longest road at the place, through the heights of the ground."""
    view = stages.road_map.plan_view
    length = lengths(view)
    index = max((index for index, _ in stages.roads(inside=False)), key=lambda index: float(length[index]))
    s = np.arange(0.0, float(length[index]), 2.0)
    curve = np.full(len(s), index)
    x, y, _ = pose(view, curve, s)
    with offline():
        below = stages.surface.heights(x, y)[0]
    z = cubic_value(stages.road_map.elevation, curve, s)
    axes.plot(s, below, color="#7a5a2a", lw=1.2, ls="--", label="ground, from the elevation model")
    axes.plot(s, z, color=BLUE, lw=2.2, label="road")
    axes.set(xlabel="s, m", ylabel="height, m", title=stages.road_map.roads[index].name)
    axes.grid(lw=0.3)
    axes.legend(loc="upper right")


def furniture(axes: Axes, stages: Stages) -> None:
    """Draw marks, signs and objects."""
    pale = dict.fromkeys(FILL, "#a5abb3") | dict.fromkeys(SIDES, "#ece7da")
    _fill(axes, stages, pale, inside=True)
    _fill(axes, stages, pale)
    road_map = stages.road_map
    for index, road in stages.roads(inside=False):
        draw_marks(axes, road_map, index, road)
    draw_furniture(axes, road_map)
    legend(axes, {"sign": RED, "crossing, painted area": GREEN, "mark": "white"})


PICTURES: Mapping[str, Callable[[Axes, Stages], None]] = {
    "01_osm": osm,
    "02_ground": ground,
    "03_plan_view": plan_view,
    "04_lanes": lanes,
    "05_junctions": junctions,
    "06_through": through,
    "07_sides": sides,
    "08_heights": heights,
    "09_furniture": furniture,
}
LAST = "10_file"

# ---------------------------------------------------------------- parts of them


def _is_near(points: FloatArray, margin: float = 20.0) -> bool:
    """Say whether one of some points (n, 2) lies in the place or up to a margin, m, around it."""
    west, south, east, north = BOX
    x, y = points.T
    inside = (x > west - margin) & (x < east + margin) & (y > south - margin) & (y < north + margin)
    return bool(inside.any())


def _fill(axes: Axes, stages: Stages, colors: Mapping[LaneType, str], *, inside: bool = False) -> None:
    """Fill lanes of some types of the roads at the place."""
    fill_lanes(axes, stages.road_map, stages.roads(inside=inside), colors)


def _across(road_map: RoadMap, index: int, road: Road, s: float) -> FloatArray:
    """Return the edges (2, 2) of a road's carriageway at s, m."""
    section = [item for item in road.lane_sections if item.s <= s + 1e-6][-1]
    curve, at = np.array([index]), np.array([s])
    offset = float(cubic_value(road_map.lane_offset, curve, at)[0])
    x, y, hdg = (float(item[0]) for item in pose(road_map.plan_view, curve, at))
    found = []
    for side in (1, -1):
        own = [lane for lane in section.lanes if lane.id * side > 0 and lane.type in FILL]
        t = offset + side * sum(float(width_at(lane.widths, at - section.s)[0]) for lane in own)
        found.append((x - t * math.sin(hdg), y + t * math.cos(hdg)))
    return np.array(found)


def draw(folder: Path) -> None:
    """Write all pictures to a folder."""
    stages = run()
    folder.mkdir(parents=True, exist_ok=True)
    for name, picture in PICTURES.items():
        box = None if picture is heights else BOX
        save_picture(folder / f"{name}.png", picture, stages, box)
    with TemporaryDirectory() as temporary:
        made = Path(temporary) / "ordino.xodr"
        stages.result.write(made)
        width = round(SIZE[0] * DPI)
        osm2xodr.render(made, folder / f"{LAST}.png", bbox_xy=BOX, width=width)


def main() -> None:
    """Draw the pictures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-o", "--output", type=Path, default=TARGET)
    draw(parser.parse_args().output)


if __name__ == "__main__":
    main()
