"""A sound OpenDRIVE file: a T junction with a street that goes on behind one of its arms, and ways to damage it."""

from __future__ import annotations

import math
from collections.abc import Sequence

from lxml import etree

HALF_PI = math.pi / 2
ARC = 10 * HALF_PI
Tree = etree._Element

_HEADER = """<header revMajor="1" revMinor="6" name="T" date="2024-05-01" north="0" south="-60" east="100" west="-60">
<geoReference><![CDATA[+proj=tmerc +lat_0=49 +lon_0=11 +k=1 +x_0=0 +y_0=0 +datum=WGS84 +units=m]]></geoReference>
</header>"""

_MARK = '<roadMark sOffset="0" type="solid" weight="standard" color="standard" width="0.12" laneChange="none"/>'
_FLAT = '<elevation s="0" a="10" b="0" c="0" d="0"/>'
# From 12 m to 10 m over 50 m with level ends, in two records.
_DOWN = '<elevation s="0" a="12" b="0" c="-0.0016" d="0"/><elevation s="25" a="11" b="-0.08" c="0.0016" d="0"/>'


def _lane(lane_id: int, before: int | None, after: int | None, kind: str = "driving") -> str:
    links = "" if before is None else f'<predecessor id="{before}"/>'
    links += "" if after is None else f'<successor id="{after}"/>'
    width = "" if lane_id == 0 else '<width sOffset="0" a="3.5" b="0" c="0" d="0"/>'
    return f'<lane id="{lane_id}" type="{kind}" level="false"><link>{links}</link>{width}{_MARK}</lane>'


def _section(s: float, left: Sequence[str], right: Sequence[str]) -> str:
    sides = (f"<left>{''.join(left)}</left>" if left else "", f"<right>{''.join(right)}</right>" if right else "")
    return f'<laneSection s="{s}">{sides[0]}<center>{_lane(0, None, None, "none")}</center>{sides[1]}</laneSection>'


def _two_lanes(s: float, links: tuple[int | None, int | None] = (None, None), *, linked: bool = False) -> str:
    """Return a section with a lane each way; `linked` lanes go on before (0) or behind (1) as `links` says."""
    before, after = links if linked else (None, None)
    sides = [_lane(lane, lane if before else None, lane if after else None) for lane in (1, -1)]
    return _section(s, sides[:1], sides[1:])


def _road(
    road_id: int,
    length: float,
    junction: int,
    link: str,
    geometry: str,
    elevation: str,
    lanes: str,
    more: str = "",
) -> str:
    return f"""<road id="{road_id}" name="" length="{length!r}" junction="{junction}" rule="RHT">
<link>{link}</link>
<type s="0" type="town"><speed max="50" unit="km/h"/></type>
<planView>{geometry}</planView>
<elevationProfile>{elevation}</elevationProfile>
<lateralProfile><superelevation s="0" a="0" b="0" c="0" d="0"/></lateralProfile>
<lanes><laneOffset s="0" a="0" b="0" c="0" d="0"/>{lanes}</lanes>
{more}
</road>"""


def _geometry(x: float, y: float, hdg: float, length: float, curvature: float = 0.0, s: float = 0.0) -> str:
    shape = f'<arc curvature="{curvature!r}"/>' if curvature else "<line/>"
    return f'<geometry s="{s!r}" x="{x!r}" y="{y!r}" hdg="{hdg!r}" length="{length!r}">{shape}</geometry>'


def _link(tag: str, kind: str, number: int, contact: str = "") -> str:
    said = f' contactPoint="{contact}"' if contact else ""
    return f'<{tag} elementType="{kind}" elementId="{number}"{said}/>'


_SIGNALS = """<signals>
<signal id="900" name="" s="45" t="-4" dynamic="yes" orientation="+" zOffset="3" type="1000001" subtype="-1"
 country="OpenDRIVE" value="-1"><validity fromLane="-1" toLane="-1"/></signal>
</signals>"""
_OBJECTS = """<objects>
<object id="901" type="crosswalk" name="" s="47" t="0" zOffset="0" orientation="none" hdg="0" length="3" width="7"
 height="0"><outline id="0"><cornerLocal u="-1.5" v="-3.5" z="0" height="0"/>
<cornerLocal u="1.5" v="-3.5" z="0" height="0"/><cornerLocal u="1.5" v="3.5" z="0" height="0"/>
<cornerLocal u="-1.5" v="3.5" z="0" height="0"/><cornerLocal u="-1.5" v="-3.5" z="0" height="0"/></outline></object>
</objects>"""

# Connecting roads: incoming road, its end, its lane; outgoing road, its end, its lane; start; curvature, length.
_WAYS = (
    (10, (1, "end", -1), (2, "start", -1), (-10.0, 0.0, 0.0), 0.0, 20.0),
    (11, (2, "start", 1), (1, "end", 1), (10.0, 0.0, math.pi), 0.0, 20.0),
    (12, (1, "end", -1), (3, "end", 1), (-10.0, 0.0, 0.0), -0.1, ARC),
    (13, (3, "end", -1), (2, "start", -1), (0.0, -10.0, HALF_PI), -0.1, ARC),
    (14, (3, "end", -1), (1, "end", 1), (0.0, -10.0, HALF_PI), 0.1, ARC),
    (15, (2, "start", 1), (3, "end", 1), (10.0, 0.0, math.pi), 0.1, ARC),
)


def sound_map() -> str:
    """Return the text of the file: roads 1 to 4, connecting roads 10 to 15, junction 100."""
    to_junction = _link("successor", "junction", 100)
    second = [_lane(1, 1, 1)], [_lane(-1, -1, -1)]
    first = [_lane(1, None, 1)], [_lane(-1, None, -1)]
    roads = [
        _road(
            1,
            50.0,
            -1,
            to_junction,
            _geometry(-60.0, 0.0, 0.0, 30.0) + _geometry(-30.0, 0.0, 0.0, 20.0, s=30.0),
            _DOWN,
            _two_lanes(0),
            _OBJECTS + _SIGNALS,
        ),
        _road(
            2,
            50.0,
            -1,
            _link("predecessor", "junction", 100) + _link("successor", "road", 4, "start"),
            _geometry(10.0, 0.0, 0.0, 50.0),
            _FLAT,
            _section(0, *first) + _section(25, *second),
        ),
        _road(3, 50.0, -1, to_junction, _geometry(0.0, -60.0, HALF_PI, 50.0), _FLAT, _two_lanes(0)),
        _road(
            4,
            40.0,
            -1,
            _link("predecessor", "road", 2, "end"),
            _geometry(60.0, 0.0, 0.0, 40.0),
            _FLAT,
            _two_lanes(0, (1, None), linked=True),
        ),
    ]
    connections = []
    for number, (road_id, come, go, start, curvature, length) in enumerate(_WAYS):
        link = _link("predecessor", "road", come[0], come[1]) + _link("successor", "road", go[0], go[1])
        lanes = _section(0, (), [_lane(-1, come[2], go[2])])
        roads.append(_road(road_id, length, 100, link, _geometry(*start, length, curvature), _FLAT, lanes))
        connections.append(
            f'<connection id="{number}" incomingRoad="{come[0]}" connectingRoad="{road_id}" contactPoint="start">'
            f'<laneLink from="{come[2]}" to="-1"/></connection>'
        )
    controller = '<controller id="800" name=""><control signalId="900" type=""/></controller>'
    junction = f"""<junction id="100" name="" type="default">{"".join(connections)}
<priority high="1" low="3"/><controller id="800" type=""/></junction>"""
    return f'<?xml version="1.0" encoding="UTF-8"?>\n<OpenDRIVE>\n{_HEADER}\n' + "\n".join(
        [*roads, controller, junction, "</OpenDRIVE>\n"]
    )


def sound_tree() -> Tree:
    """Return the file as a tree, to be damaged."""
    return etree.fromstring(sound_map().encode(), etree.XMLParser(strip_cdata=False))


def road(tree: Tree, number: int) -> Tree:
    """Return a road."""
    return one(tree, f"road[@id='{number}']")


def one(tree: Tree, path: str) -> Tree:
    """Return the first element at a path, which must be there."""
    found = tree.find(path)
    assert found is not None, path
    return found
