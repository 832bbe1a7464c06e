"""A small network to look at: a street, a bend in a tunnel, a junction, signals, a crossing, and a hostile name."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from xodr_text import HEADER, LINE, cubics, document, geometry, lane, read_text, road, section

from osm2xodr.opendrive.space import frame_of
from osm2xodr.opendrive.tables import OpenDrive

HOSTILE = "</script><script>window.owned=1</script><img src=x onerror='window.owned=2'>"

_STREET = section(
    0.0,
    lane(2, (0, 2.0), kind="sidewalk") + lane(1, (0, 3.5)),
    lane(-1, (0, 3.5), (60, 3.5, 0.05)),
    '<lane id="0" type="none"><roadMark sOffset="0" type="broken" color="white"/></lane>',
)
_SIGNALS = (
    '<signals><signal id="5" name="light" s="110" t="-6" zOffset="3" type="1000001" subtype="-1" dynamic="yes"'
    ' orientation="+"/></signals>'
)
_CROSSING = (
    '<objects><object id="9" type="crosswalk" name="crossing" s="100" t="0" zOffset="0" hdg="0"><outlines><outline>'
    '<cornerLocal u="-2" v="-5" z="0"/><cornerLocal u="2" v="-5" z="0"/>'
    '<cornerLocal u="2" v="5" z="0"/><cornerLocal u="-2" v="5" z="0"/></outline></outlines></object></objects>'
)
_TUNNEL = '<objects><tunnel id="8" s="20" length="40" type="standard" name="Hill"/></objects>'
_JUNCTION = (
    '<junction id="7" name="Corner"><connection id="0" incomingRoad="1" connectingRoad="3" contactPoint="start">'
    '<laneLink from="-1" to="-1"/></connection></junction>'
)


def hostile(text: str) -> str:
    """Return text as an attribute's value."""
    return text.replace("&", "&amp;").replace("<", "&lt;").replace('"', "&quot;")


def viewed_text(name: str = HOSTILE) -> str:
    """Return the document."""
    speed = '<type s="0" type="town"><speed max="50" unit="km/h"/></type>'
    street = road(
        "1",
        length=120.0,
        lanes=_STREET,
        link='<successor elementType="junction" elementId="7"/>',
        elevation=cubics("elevation", (0, 10.0, 0.05)),
        more=_CROSSING + _SIGNALS,
    )
    street = street.replace('name=""', f'name="{hostile(name)}"').replace("<planView>", speed + "<planView>", 1)
    bend = road(
        "2",
        geometry('<arc curvature="0.01"/>', 80.0, x=140.0),
        80.0,
        link='<predecessor elementType="junction" elementId="7"/>',
        elevation=cubics("elevation", (0, 16.0, 0.0, 0.001)),
        lateral=cubics("superelevation", (0, 0.02)),
        more=_TUNNEL,
    )
    through = road(
        "3",
        geometry(LINE, 20.0, x=120.0),
        20.0,
        lanes=section(0.0, right=lane(-1, (0, 3.5))),
        junction="7",
        link='<predecessor elementType="road" elementId="1" contactPoint="end"/>'
        '<successor elementType="road" elementId="2" contactPoint="start"/>',
        elevation=cubics("elevation", (0, 16.0)),
    )
    header = HEADER.replace("<header ", f'<header name="{hostile(name)}" ')
    return document(street, bend, through, _JUNCTION, header=header)


def viewed_file(folder: Path, name: str = HOSTILE) -> OpenDrive:
    """Write the document and read it."""
    return read_text(folder, viewed_text(name))


def write_ways(folder: Path, file: OpenDrive, ways: Mapping[int, tuple[str, Sequence[tuple[float, float]]]]) -> Path:
    """Write ways, each with its tags as XML and points in x and y of a file, as OSM."""
    frame, reason = frame_of(file.header)
    assert frame is not None, reason
    nodes, lines = [], []
    for way, (tags, points) in ways.items():
        x, y = np.array(points, np.float64).T
        lon, lat = frame.to_geographic(x, y)
        refs = [100 * way + k for k in range(len(points))]
        nodes += [f'<node id="{ref}" lat="{b:.9f}" lon="{a:.9f}"/>' for ref, a, b in zip(refs, lon, lat, strict=True)]
        lines.append(f'<way id="{way}">' + "".join(f'<nd ref="{ref}"/>' for ref in refs) + tags + "</way>")
    path = folder / "area.osm"
    path.write_text('<osm version="0.6">' + "".join(nodes + lines) + "</osm>", encoding="utf-8")
    return path
