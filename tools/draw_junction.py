"""Draw one junction as the steps that make it leave it: the pictures of docs/method/junctions.md.

Makes ``docs/images/junction``. Needs the extra ``docs``.

    python tools/draw_junction.py [-o FOLDER]
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from draw_map import (
    FILL,
    GREEN,
    PALE,
    RED,
    SIDES,
    THROUGH,
    draw_arrow,
    draw_furniture,
    draw_marks,
    fill_lanes,
    lane_bands,
    legend,
    reference_line,
    save_picture,
)
from matplotlib.axes import Axes

from osm2xodr.curves import pose
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.geometry import RoadOptions
from osm2xodr.geometry.road_plan import RoadPlan, plan_roads
from osm2xodr.model import BoundaryEdge, FloatArray, IntArray, Junction, LaneType, Road, RoadMap, StreetNetwork
from osm2xodr.osmParsing import parse_osm
from osm2xodr.pipeline import PipelineOptions, convert

ROOT = Path(__file__).parents[1]
# Two streets cross, one with its carriageways apart on one side only, in Seattle.
AREA = ROOT / "tests" / "golden" / "dual_carriageways_cross.osm"
TARGET = ROOT / "docs" / "images" / "junction"
NODE = 53092587
# Half the width and height that is shown, m, and how much of each arm is drawn beyond its end.
HALF = (44.0, 33.0)
ARM = 45.0
GREY, SAND = "#9aa0a8", "#f0d9b5"


@dataclass(frozen=True)
class Stages:
    """What the steps hand on, and which junction is drawn."""

    network: StreetNetwork
    plan: RoadPlan
    index: int
    road_map: RoadMap
    junction: Junction

    @property
    def ways(self) -> IntArray:
        """The connecting roads of the junction for cars and bicycles, by their rows."""
        return np.flatnonzero(self.plan.connecting.junction == self.index)

    def nodes(self) -> FloatArray:
        """Return where the nodes of the junction are, (n, 2), m."""
        return np.array([_place(self.network, node) for node in self.plan.layout.nodes[self.index]])

    def roads(self, *, inside: bool) -> Iterator[tuple[int, Road]]:
        """Yield index and road of those in this junction, or outside of all."""
        for index, road in enumerate(self.road_map.roads):
            if road.junction == (self.junction.id if inside else None):
                yield index, road


def run() -> Stages:
    """Convert the area step by step."""
    options, unheard = PipelineOptions(AREA, boundaries=True), Diagnostics()
    network = parse_osm(options.area, options.parse, unheard)
    plan = plan_roads(network, RoadOptions(), unheard)
    ids = [item.osm_node_id for item in network.intersections]
    index = next(k for k, nodes in enumerate(plan.layout.nodes) if NODE in [ids[node] for node in nodes])
    road_map = convert(options, unheard).road_map
    junction = next(item for item in road_map.junctions if NODE in item.osm_node_ids)
    return Stages(network, plan, index, road_map, junction)


# ---------------------------------------------------------------- the pictures


def nodes(axes: Axes, stages: Stages) -> None:
    """Draw streets as OSM has them, and which nodes and streets become one junction."""
    for street in stages.network.streets:
        axes.plot(*street.points.T, color=GREY, lw=1.6, marker="o", ms=3, zorder=2)
    for k in np.flatnonzero(stages.plan.layout.inner).tolist():
        axes.plot(*stages.network.streets[k].points.T, color=SAND, lw=22, solid_capstyle="round", zorder=1)
    axes.plot(*stages.nodes().T, "s", color=RED, ms=9, zorder=3)
    legend(axes, {"street": GREY, "node of the junction": RED, "street inside it": SAND})


def arms(axes: Axes, stages: Stages) -> None:
    """Draw the carriageways of arms up to their nodes, and where they are cut."""
    ends, trim = stages.plan.ends, stages.plan.layout.trim
    for end in stages.plan.layout.arms[stages.index]:
        u = np.arange(0.0, min(ARM + float(trim[end]), float(ends.length[end])), 0.5)
        left, right = _edges(stages.plan, end, u)
        axes.fill(*np.vstack([left, right[::-1]]).T, color=GREY, alpha=0.45, lw=0, zorder=1)
        across = _edges(stages.plan, end, trim[end : end + 1])
        axes.plot(*np.concatenate(across).T, color=RED, lw=3.0, zorder=3)
    axes.plot(*stages.nodes().T, "s", color="black", ms=6, zorder=4)
    legend(axes, {"carriageway of an arm": GREY, "where its road ends": RED, "node": "black"})


def movements(axes: Axes, stages: Stages) -> None:
    """Draw from which arm to which traffic may go."""
    _fill(axes, stages, PALE)
    roads = stages.plan.connecting
    for entry, exit_ in sorted({(int(roads.entry[k]), int(roads.exit[k])) for k in stages.ways}):
        of = stages.ways[(roads.entry[stages.ways] == entry) & (roads.exit[stages.ways] == exit_)]
        (begin, ahead), (end, behind) = (
            (places.mean(axis=0), _towards(hdg)) for places, hdg in zip(*_lane_ends(stages, of), strict=True)
        )
        reach = 0.4 * float(np.hypot(*(end - begin)))
        corners = np.array([begin, begin + reach * ahead, end - reach * behind, end])
        u = np.linspace(0.0, 1.0, 30)
        weights = np.array([(1 - u) ** 3, 3 * u * (1 - u) ** 2, 3 * u**2 * (1 - u), u**3])
        draw_arrow(axes, weights.T @ corners, _color(stages, entry), 2.0)


def links(axes: Axes, stages: Stages) -> None:
    """Draw which lane leads to which."""
    _fill(axes, stages, PALE)
    roads = stages.plan.connecting
    begin, end = _lane_ends(stages, stages.ways)[0]
    for k, first, last in zip(stages.ways.tolist(), begin, end, strict=True):
        draw_arrow(axes, np.array([first, last]), _color(stages, int(roads.entry[k])), 1.2)
        axes.plot(*first, "o", color=_color(stages, int(roads.entry[k])), ms=5, zorder=6)


def ways(axes: Axes, stages: Stages) -> None:
    """Draw the reference lines of connecting roads."""
    _fill(axes, stages, PALE)
    for k in stages.ways.tolist():
        line = reference_line(stages.plan.connecting.plan_view, k)
        draw_arrow(axes, line, _color(stages, int(stages.plan.connecting.entry[k])), 1.6)


def lanes(axes: Axes, stages: Stages) -> None:
    """Draw the lanes of connecting roads for cars and bicycles."""
    _fill(axes, stages, FILL)
    _fill(axes, stages, FILL, inside=True, edge="white")
    legend(axes, {"lane": FILL[LaneType.DRIVING], "edge of a lane through the junction": "white"})


def corners(axes: Axes, stages: Stages) -> None:
    """Draw sidewalks and verges round the corners."""
    _fill(axes, stages, PALE | SIDES)
    _fill(axes, stages, PALE | SIDES, inside=True, linked=True)
    legend(axes, {kind.value: SIDES[kind] for kind in (LaneType.SIDEWALK, LaneType.BORDER)})


def floor(axes: Axes, stages: Stages) -> None:
    """Draw the strips that close the gaps."""
    pale = PALE | dict.fromkeys(SIDES, "#ece7da")
    _fill(axes, stages, pale)
    _fill(axes, stages, pale, inside=True, linked=True)
    _fill(axes, stages, {LaneType.SHOULDER: RED, LaneType.BORDER: GREEN}, inside=True, linked=False)
    legend(axes, {"paved": RED, "not paved": GREEN})


def furniture(axes: Axes, stages: Stages) -> None:
    """Draw marks, crossings and lights."""
    pale = dict.fromkeys(FILL, "#a5abb3") | dict.fromkeys(SIDES, "#ece7da")
    _fill(axes, stages, pale)
    _fill(axes, stages, pale, inside=True)
    for inside in (False, True):
        for index, road in stages.roads(inside=inside):
            draw_marks(axes, stages.road_map, index, road)
    draw_furniture(axes, stages.road_map, names=False)
    legend(axes, {"mark": "white", "crossing, painted area": GREEN, "light, sign": RED})


def boundary(axes: Axes, stages: Stages) -> None:
    """Draw where the junction ends."""
    _fill(axes, stages, FILL | SIDES)
    _fill(axes, stages, FILL | SIDES, inside=True)
    index = {road.id: k for k, road in enumerate(stages.road_map.roads)}
    found = [
        _along(stages.road_map, index[item.road], item)
        for item in stages.junction.boundary
        if isinstance(item, BoundaryEdge)
    ]
    ring = np.concatenate([*found, found[0][:1]])
    axes.plot(*ring.T, color=RED, lw=2.6, zorder=5)
    legend(axes, {"boundary": RED})


PICTURES: Mapping[str, Callable[[Axes, Stages], None]] = {
    "01_nodes": nodes,
    "02_arms": arms,
    "03_movements": movements,
    "04_links": links,
    "05_ways": ways,
    "06_lanes": lanes,
    "07_corners": corners,
    "08_floor": floor,
    "09_furniture": furniture,
    "10_boundary": boundary,
}

# ---------------------------------------------------------------- parts of them


def _place(network: StreetNetwork, node: int) -> tuple[float, float]:
    return network.intersections[node].x, network.intersections[node].y


def _color(stages: Stages, entry: int) -> str:
    """Return the colour of what comes from an arm."""
    every = sorted(set(stages.plan.connecting.entry[stages.ways].tolist()))
    return THROUGH[every.index(entry) % len(THROUGH)]


def _edges(plan: RoadPlan, end: int, u: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the left and the right edge of a carriageway, (n, 2), m, at distances from its node."""
    ends, outwards = plan.ends, end % 2 == 0
    s = u if outwards else ends.length[end] - u
    x, y, hdg = pose(ends.plan_view, np.full(len(u), end // 2), s)
    sign = 1.0 if outwards else -1.0
    left, right = (
        np.column_stack([x - sign * t * np.sin(hdg), y + sign * t * np.cos(hdg)])
        for t in (float(ends.left[end]), float(ends.right[end]))
    )
    return left, right


def _lane_ends(stages: Stages, rows: IntArray) -> tuple[list[FloatArray], list[FloatArray]]:
    """Return the first and the last points of connecting roads, (n, 2), m, and the headings there, (n,), rad."""
    roads = stages.plan.connecting
    found = [pose(roads.plan_view, rows, s) for s in (np.zeros(len(rows)), roads.length[rows])]
    return [np.column_stack([x, y]) for x, y, _ in found], [hdg for _, _, hdg in found]


def _towards(hdg: FloatArray) -> FloatArray:
    """Return the mean of directions, (2,)."""
    return np.array([np.cos(hdg).mean(), np.sin(hdg).mean()])


def _fill(
    axes: Axes,
    stages: Stages,
    colors: Mapping[LaneType, str],
    *,
    inside: bool = False,
    linked: bool | None = None,
    edge: str | None = None,
) -> None:
    """Fill lanes of some types of the roads outside junctions, or of those in this one."""
    fill_lanes(axes, stages.road_map, stages.roads(inside=inside), colors, linked=linked, edge=edge)


def _along(road_map: RoadMap, index: int, item: BoundaryEdge) -> FloatArray:
    """Return the points (n, 2) of a segment of a boundary."""
    road = road_map.roads[index]
    wanted = item.lane or next(lane.id for lane in road.lane_sections[0].lanes if abs(lane.id) == 1)
    bands = [band for band in lane_bands(road_map, index, road) if band[1] == wanted]
    outer = np.concatenate([beyond if item.lane else inner for _, _, inner, beyond in bands])
    first, last = min(item.begin, item.end), max(item.begin, item.end)
    s = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(outer, axis=0).T))])
    middle = reference_line(road_map.plan_view, index)
    whole = float(np.hypot(*np.diff(middle, axis=0).T).sum())
    share = s / s[-1] * whole
    kept = outer[(share >= first - 0.5) & (share <= last + 0.5)]
    return np.asarray(kept if item.end > item.begin else kept[::-1])


def draw(folder: Path) -> None:
    """Write all pictures to a folder."""
    stages = run()
    folder.mkdir(parents=True, exist_ok=True)
    x, y = stages.nodes().mean(axis=0)
    box = (x - HALF[0], y - HALF[1], x + HALF[0], y + HALF[1])
    for name, picture in PICTURES.items():
        save_picture(folder / f"{name}.png", picture, stages, box)


def main() -> None:
    """Draw the pictures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-o", "--output", type=Path, default=TARGET)
    draw(parser.parse_args().output)


if __name__ == "__main__":
    main()
