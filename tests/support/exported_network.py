"""A small network to export: two roads, a junction, a signal and two objects."""

from __future__ import annotations

from pathlib import Path

from xodr_text import cubics, document, geometry, lane, read_text, road, section

from osm2xodr.opendrive.tables import OpenDrive

# 100 m, of which the first 50 m have a lane that opens out from nothing, then a cycle lane.
LANES = section(0.0, lane(1, (0, 3.0)), lane(-1, (0, 3.0)) + lane(-2, (0, 0.0, 0.04))) + section(
    50.0, lane(1, (0, 3.0)), lane(-1, (0, 3.0)) + lane(-2, (0, 2.0), kind="biking")
)
FURNITURE = (
    '<objects><object id="c" type="crosswalk" s="10" t="0" hdg="0"><outline>'
    '<cornerLocal u="-1" v="-3" z="0" height="0"/><cornerLocal u="-1" v="3" z="0" height="0"/>'
    '<cornerLocal u="1" v="3" z="0" height="0"/><cornerLocal u="1" v="-3" z="0" height="0"/></outline></object>'
    '<object id="tree" type="tree" s="20" t="6" zOffset="0.5"/></objects>'
    '<signals><signal id="x" s="30" t="-6" zOffset="3" type="274" value="50"/></signals>'
)


def network(folder: Path, *, x: float = 0.0) -> OpenDrive:
    curve = geometry("<line/>", 50.0, x=x) + geometry('<arc curvature="0.02"/>', 50.0, 50.0, 50.0 + x)
    roads = [
        road("1", curve, lanes=LANES, more=FURNITURE, elevation=cubics("elevation", (0, 100.0, 0.02))),
        road("2", geometry("<line/>", 20.0, x=200.0 + x), 20.0, junction="9"),
    ]
    connection = '<connection id="0" incomingRoad="1" connectingRoad="2" contactPoint="start"/>'
    return read_text(folder, document(*roads, f'<junction id="9" name="J">{connection}</junction>'))
