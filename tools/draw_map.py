"""Draw places of a converted area from above: carriageways with their lanes, and the ways through junctions.

Makes the pictures of ``docs/images``. Needs the extra ``docs``.

    python tools/draw_map.py area.osm -o junction.png --at 47.5675,12.9210 --radius 40
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterator, Sequence
from pathlib import Path

import matplotlib as mpl
import numpy as np

from osm2xodr.curves.cubics import cubic_value
from osm2xodr.curves.plan_views import lengths
from osm2xodr.curves.records import pose
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.model import Cubic, FloatArray, LaneType, Road, RoadMap, Street
from osm2xodr.osmParsing import parse_osm
from osm2xodr.pipeline import PipelineOptions, convert
from osm2xodr.projection import to_local

mpl.use("Agg")
from matplotlib import pyplot as plt
from matplotlib.axes import Axes

STEP = 0.5
FILL = {
    LaneType.DRIVING: "#82878f",
    LaneType.BIDIRECTIONAL: "#a58fb8",
    LaneType.BUS: "#c98a6b",
    LaneType.TAXI: "#c9ab6b",
    LaneType.BIKING: "#7fae86",
}
THROUGH = ("#1d5fa8", "#b3451e", "#1f7a4d", "#7a3d99", "#a07d10", "#0f7f8a", "#a3205f", "#4a5a1a")


def width_at(widths: Sequence[Cubic], ds: FloatArray) -> FloatArray:
    """Return a lane's width at ds (n,) from its section's start, m."""
    out = np.zeros_like(ds)
    for item in widths:
        u = ds - item.s
        out = np.where(u >= -1e-9, item.a + u * (item.b + u * (item.c + u * item.d)), out)
    return out


def lane_bands(road_map: RoadMap, index: int, road: Road) -> Iterator[tuple[LaneType, FloatArray, FloatArray]]:
    """Yield type, inner and outer edge (n, 2) of every lane in every lane section of a road."""
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
                yield lane.type, place + t[:, None] * across, place + outer[:, None] * across
                t = outer


def draw(
    axes: Axes, road_map: RoadMap, streets: Sequence[Street], centre: tuple[float, float], radius: float
) -> None:
    """Draw what lies within `radius` of `centre`, m."""
    near = [
        k
        for k in range(len(road_map.roads))
        if (np.hypot(*(_line(road_map, k) - np.array(centre)).T) < 1.6 * radius).any()
    ]
    for k in sorted(near, key=lambda k: road_map.roads[k].junction is None):
        road = road_map.roads[k]
        for kind, inner, outer in lane_bands(road_map, k, road):
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


def _line(road_map: RoadMap, index: int) -> FloatArray:
    length = float(lengths(road_map.plan_view)[index])
    s = np.linspace(0.0, length, max(2, int(length / 5) + 1))
    x, y, _ = pose(road_map.plan_view, np.full(len(s), index), s)
    return np.column_stack([x, y])


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
