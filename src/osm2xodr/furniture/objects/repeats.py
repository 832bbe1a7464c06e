"""Objects that go on along a road."""

from __future__ import annotations

from osm2xodr.furniture.objects.roadside_runs import Strip
from osm2xodr.furniture.world import World
from osm2xodr.model import ObjectRepeat, RoadObject


def along_road(
    world: World,
    strip: Strip,
    words: tuple[str, str, str],
    edges: tuple[float, float],
    size: tuple[float, float],
    distance: float,
    osm_id: str,
) -> RoadObject:
    """Make an object that goes on along a strip of road.

    Parameters
    ----------
    world
        The roads.
    strip
        From where to where.
    words
        Type, subtype and name.
    edges
        t of its middle at the start and at the end, m.
    size
        Width and height, m.
    distance
        Between round copies, m; 0 for one thing that goes on.
    osm_id
        What it comes from.
    """
    kind, subtype, name = words
    width, height = size
    return RoadObject(
        id=world.ids.thing(),
        road=world.road_map.roads[strip.road].id,
        type=kind,
        subtype=subtype,
        name=name,
        s=strip.s,
        t=edges[0],
        length=0.0 if distance else strip.length,
        width=0.0 if distance else width,
        height=height,
        radius=0.5 * width if distance else 0.0,
        repeat=ObjectRepeat(strip.s, strip.length, distance, *edges, width, height),
        osm_id=osm_id,
    )
