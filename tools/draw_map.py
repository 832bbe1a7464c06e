"""Draw places of a converted area from above: carriageways with their lanes, and the ways through junctions.

Makes the pictures of ``docs/images``. Needs the extra ``docs``.

    python tools/draw_map.py area.osm -o junction.png --at 47.5675,12.9210 --radius 40
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from io import BytesIO
from pathlib import Path
from typing import TypeVar

import matplotlib as mpl
import numpy as np

from osm2xodr.curves.cubics import cubic_value
from osm2xodr.curves.plan_views import lengths
from osm2xodr.curves.records import pose
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.model import Cubic, FloatArray, LaneType, PlanView, Road, RoadMap, RoadObject, Signal, Street
from osm2xodr.osmParsing import parse_osm
from osm2xodr.pipeline import PipelineOptions, convert
from osm2xodr.projection import to_local

mpl.use("Agg")
from matplotlib import pyplot as plt
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from PIL import Image

# What a picture is of.
Drawn = TypeVar("Drawn")
STEP = 0.5
FILL = {
    LaneType.DRIVING: "#82878f",
    LaneType.BIDIRECTIONAL: "#a58fb8",
    LaneType.BUS: "#c98a6b",
    LaneType.TAXI: "#c9ab6b",
    LaneType.BIKING: "#7fae86",
}
SIDES = {LaneType.SIDEWALK: "#d9c6a0", LaneType.BORDER: "#b8c0a6", LaneType.SHOULDER: "#c6c6da"}
# Of the pictures of steps: inches, and dots per inch.
SIZE, DPI = (8.0, 6.0), 100
COLOURS = 256
RED, GREEN = "#b3451e", "#1f7a4d"
BROKEN = (0, (8, 8))
PALE = dict.fromkeys(FILL, "#c4c8cd")
THROUGH = ("#1d5fa8", "#b3451e", "#1f7a4d", "#7a3d99", "#a07d10", "#0f7f8a", "#a3205f", "#4a5a1a")


def width_at(widths: Sequence[Cubic], ds: FloatArray) -> FloatArray:
    """Return a lane's width at ds (n,) from its section's start, m."""
    out = np.zeros_like(ds)
    for item in widths:
        u = ds - item.s
        out = np.where(u >= -1e-9, item.a + u * (item.b + u * (item.c + u * item.d)), out)
    return out


def lane_bands(road_map: RoadMap, index: int, road: Road) -> Iterator[tuple[LaneType, int, FloatArray, FloatArray]]:
    """Yield type, id, inner and outer edge (n, 2) of every lane in every lane section of a road."""
    length = float(lengths(road_map.plan_view)[index])
    for k, section in enumerate(road.lane_sections):
        end = road.lane_sections[k + 1].s if k + 1 < len(road.lane_sections) else length
        s = np.linspace(section.s, end, max(2, math.ceil((end - section.s) / STEP) + 1))
        curve = np.full(len(s), index)
        x, y, hdg = pose(road_map.plan_view, curve, s)
        across = np.column_stack([-np.sin(hdg), np.cos(hdg)])
        offset = cubic_value(road_map.lane_offset, curve, s)
        for side in (1, -1):
            t = offset.copy()
            for lane in sorted((item for item in section.lanes if item.id * side > 0), key=lambda item: abs(item.id)):
                outer = t + side * width_at(lane.widths, s - section.s)
                place = np.column_stack([x, y])
                yield lane.type, lane.id, place + t[:, None] * across, place + outer[:, None] * across
                t = outer


def reference_line(view: PlanView, index: int) -> FloatArray:
    """Return points (n, 2) of a reference line, m."""
    length = float(lengths(view)[index])
    s = np.linspace(0.0, length, max(2, math.ceil(length)))
    x, y, _ = pose(view, np.full(len(s), index), s)
    return np.column_stack([x, y])


def lane_marks(road_map: RoadMap, index: int, road: Road) -> Iterator[tuple[str, FloatArray]]:
    """Yield type and line (n, 2) of the marks of a road's lanes."""
    length = float(lengths(road_map.plan_view)[index])
    for k, section in enumerate(road.lane_sections):
        end = road.lane_sections[k + 1].s if k + 1 < len(road.lane_sections) else length
        s = np.linspace(section.s, end, max(2, math.ceil(end - section.s)))
        curve = np.full(len(s), index)
        x, y, hdg = pose(road_map.plan_view, curve, s)
        offset = cubic_value(road_map.lane_offset, curve, s)
        for lane in section.lanes:
            if lane.road_mark is None or lane.road_mark.type == "none" or not (lane.id == 0 or lane.type in FILL):
                continue
            nearer = [item for item in section.lanes if item.id * lane.id > 0 and abs(item.id) <= abs(lane.id)]
            t = offset + math.copysign(1, lane.id) * sum(
                (width_at(item.widths, s - section.s) for item in nearer), 0.0 * s
            )
            yield lane.road_mark.type, np.column_stack([x - t * np.sin(hdg), y + t * np.cos(hdg)])


def draw_marks(axes: Axes, road_map: RoadMap, index: int, road: Road) -> None:
    """Draw the marks of a road's lanes."""
    for kind, edge in lane_marks(road_map, index, road):
        axes.plot(*edge.T, color="white", lw=2.0, ls=BROKEN if "broken" in kind else "-", zorder=4)


def draw_furniture(axes: Axes, road_map: RoadMap, *, names: bool = True) -> None:
    """Draw objects with an outline, and signals, perhaps with their names."""
    place = {road.id: index for index, road in enumerate(road_map.roads)}
    for thing in road_map.furniture.objects:
        middle, hdg = _place(road_map, place[thing.road], thing)
        turn = hdg + thing.hdg
        ring = np.array([corner[:2] for corner in thing.outline]).reshape(-1, 2)
        if len(ring):
            turned = ring @ np.array([[math.cos(turn), math.sin(turn)], [-math.sin(turn), math.cos(turn)]])
            axes.fill(*(middle + turned).T, color=GREEN, lw=0, alpha=0.7, zorder=5)
    for signal in road_map.furniture.signals:
        spot, _ = _place(road_map, place[signal.road], signal)
        if _is_shown(axes, spot):
            axes.plot(*spot, "o", color=RED, ms=6, zorder=6)
            name = signal.name.replace("_", " ") if names else ""
            axes.annotate(name, (spot[0], spot[1]), (6, 4), textcoords="offset points", fontsize=8, zorder=7)


def _place(road_map: RoadMap, index: int, thing: RoadObject | Signal) -> tuple[FloatArray, float]:
    """Return where a thing on a road is, (2,), m, and the road's heading there, rad."""
    x, y, hdg = (float(item[0]) for item in pose(road_map.plan_view, np.array([index]), np.array([thing.s])))
    return np.array([x - thing.t * math.sin(hdg), y + thing.t * math.cos(hdg)]), hdg


def _is_shown(axes: Axes, spot: FloatArray) -> bool:
    """Say whether a place is within the picture."""
    (west, east), (south, north) = axes.get_xlim(), axes.get_ylim()
    return bool(west < spot[0] < east and south < spot[1] < north)


def legend(axes: Axes, colors: Mapping[str, str]) -> None:
    """Say in a corner what colours mean."""
    handles = [Line2D([], [], color=color, lw=5, label=label) for label, color in colors.items()]
    axes.legend(
        handles=handles, loc="lower left", fontsize=8, facecolor="#e4e6e9" if "white" in colors.values() else None
    )


def draw_arrow(axes: Axes, line: FloatArray, color: str, width: float) -> None:
    """Draw a line with a tip at its end."""
    axes.plot(*line.T, color=color, lw=width, zorder=5)
    arrow = {"arrowstyle": "-|>", "color": color, "lw": width}
    axes.annotate("", line[-1], line[max(len(line) - 3, 0)], arrowprops=arrow, zorder=6)


def fill_lanes(
    axes: Axes,
    road_map: RoadMap,
    roads: Iterable[tuple[int, Road]],
    colors: Mapping[LaneType, str],
    *,
    linked: bool | None = None,
    edge: str | None = None,
) -> None:
    """Fill lanes of some types of some roads, by their indices; perhaps only those that are linked, or are not."""
    for index, road in roads:
        above = 2 if road.junction is None else 1
        joined = {lane.id for lane in road.lane_sections[0].lanes if lane.predecessor is not None}
        for kind, number, inner, outer in lane_bands(road_map, index, road):
            if kind in colors and (linked is None or (number in joined) is linked):
                ring = np.vstack([inner, outer[::-1]])
                axes.fill(*ring.T, color=colors[kind], lw=0, zorder=above)
                if edge:
                    axes.plot(*ring.T, color=edge, lw=0.6, zorder=above + 1)


def save_picture(
    path: Path,
    picture: Callable[[Axes, Drawn], None],
    drawn: Drawn,
    box: tuple[float, float, float, float] | None = None,
) -> None:
    """Draw a picture of something, if it is a map that of a box: west, south, east, north, m.

    It has few colours: a quarter of the size.
    """
    figure, axes = plt.subplots(figsize=SIZE)
    if box is not None:
        west, south, east, north = box
        axes.set(xlim=(west, east), ylim=(south, north), aspect="equal")
        axes.set_axis_off()
    picture(axes, drawn)
    figure.tight_layout(pad=0.4)
    large = BytesIO()
    figure.savefig(large, dpi=DPI)
    plt.close(figure)
    small = Image.open(large).convert("RGB").quantize(COLOURS, Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE)
    small.save(path, optimize=True)


def draw(
    axes: Axes, road_map: RoadMap, streets: Sequence[Street], centre: tuple[float, float], radius: float
) -> None:
    """Draw what lies within `radius` of `centre`, m."""
    near = [
        k
        for k in range(len(road_map.roads))
        if (np.hypot(*(reference_line(road_map.plan_view, k) - np.array(centre)).T) < 1.6 * radius).any()
    ]
    for k in sorted(near, key=lambda k: road_map.roads[k].junction is None):
        road = road_map.roads[k]
        for kind, _, inner, outer in lane_bands(road_map, k, road):
            ring = np.vstack([inner, outer[::-1]])
            inside = road.junction is not None
            axes.fill(
                *ring.T, color="#a9adb3" if inside else FILL.get(kind, "#c9c9c0"), lw=0, zorder=1 if inside else 2
            )
            if not inside:
                axes.plot(*outer.T, color="white", lw=0.8, zorder=3)
                axes.plot(*inner.T, color="white", lw=0.5, ls=(0, (6, 6)), zorder=3)
                continue
            middle = (inner + outer) / 2
            color = THROUGH[(road.predecessor.id if road.predecessor else 0) % len(THROUGH)]
            axes.plot(*middle.T, color=color, lw=1.1, zorder=5)
            tip, before = middle[-1], middle[max(len(middle) - 4, 0)]
            axes.annotate("", tip, before, arrowprops={"arrowstyle": "-|>", "color": color, "lw": 0.8}, zorder=6)
    for street in streets:
        axes.plot(*street.points.T, color="black", lw=0.5, ls=":", zorder=7)
    axes.set(
        xlim=(centre[0] - radius, centre[0] + radius), ylim=(centre[1] - radius, centre[1] + radius), aspect="equal"
    )
    axes.set_xticks([])
    axes.set_yticks([])


def main() -> None:
    """Convert the area and draw its places."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("area", type=Path)
    parser.add_argument("-o", "--output", type=Path, required=True)
    parser.add_argument("--at", required=True, help="latitude,longitude, WGS 84 degrees; several with ;")
    parser.add_argument("--radius", type=float, default=40.0, help="m")
    parser.add_argument("--size", type=float, default=8.0, help="of each picture, inches")
    options = parser.parse_args()
    road_map = convert(PipelineOptions(options.area), Diagnostics()).road_map
    network = parse_osm(options.area, PipelineOptions(options.area).parse, Diagnostics())
    places = [tuple(float(word) for word in place.split(",")) for place in options.at.split(";")]
    figure, all_axes = plt.subplots(1, len(places), figsize=(options.size * len(places), options.size), squeeze=False)
    for axes, (lat, lon) in zip(all_axes[0], places, strict=True):
        x, y = to_local(road_map.frame, np.array([lon]), np.array([lat]))
        draw(axes, road_map, network.streets, (float(x[0]), float(y[0])), options.radius)
    figure.tight_layout(pad=0.3)
    figure.savefig(options.output, dpi=100)


if __name__ == "__main__":
    main()
