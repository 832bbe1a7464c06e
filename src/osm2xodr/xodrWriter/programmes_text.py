"""Signal programmes as SUMO's netconvert reads them beside an OpenDRIVE file (``--tllogic-files``).

They name edges and lanes that netconvert makes of roads (``NIImporter_OpenDrive.cpp``, measured with 1.28). Road 7
is edge ``-7`` along its reference line and ``7`` against it, with ``#0``, ``#1`` … for its lane sections where there
are several, and lanes count from the outermost, 0. It cuts sections further where a lane becomes wider or narrower
than 1.8 m, and roads that lead back to their own junction in the middle.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import lru_cache
from itertools import pairwise
from typing import Final

from osm2xodr.conventions import PROGRAMMES_HEAD
from osm2xodr.curves import lengths
from osm2xodr.model import Cubic, Lane, LaneSection, Road, RoadMap, SignalLink, SignalPhase
from osm2xodr.xodrWriter.formatting import Words, number

# What SUMO's documentation of its options says: ``opendrive.min-width``, ``opendrive.curve-resolution``; and the
# program's ``POSITION_EPS``. All m.
_LEAST_WIDTH: Final = 1.8
_SHORTEST_CUT: Final = 2.0
_SAME_PLACE: Final = 0.1
# Its programmes whose green ends, within limits, when no vehicle that is detected has lost time.
_BY_DETECTORS: Final = "delay_based"
# Types of lanes that become lanes of its network.
_IMPORTED: Final = frozenset({"driving", "bidirectional", "restricted", "parking", "stop", "entry", "exit"})


def programmes_text(road_map: RoadMap, words: Words) -> str:
    """Return the programmes of a road map as a ``tllogic`` file; empty if it has none."""
    programmes = road_map.furniture.programmes
    if not programmes:
        return ""
    edges = _Edges(road_map, words)
    logics, connections = [], []
    for item in programmes:
        named = edges.connections(item.links)
        phases = "".join(_phase(phase, named) for phase in item.phases)
        kind, light, far = "static", item.junction, item.detector_range
        if far:
            kind, phases = _BY_DETECTORS, f'  <param key="detectorRange" value="{number(far)}"/>\n{phases}'
        logics.append(f' <tlLogic id="{light}" type="{kind}" programID="0" offset="0">\n{phases} </tlLogic>\n')
        ends = enumerate(named.values())
        connections += [f' <connection {text} tl="{light}" linkIndex="{k}"/>\n' for k, text in ends]
    return f"{PROGRAMMES_HEAD}<tlLogics>\n{''.join((*logics, *connections))}</tlLogics>\n"


def _phase(phase: SignalPhase, links: Iterable[int]) -> str:
    state = "".join(phase.state[n] for n in links)
    limits = "" if phase.range is None else f' minDur="{number(phase.range[0])}" maxDur="{number(phase.range[1])}"'
    return f'  <phase duration="{number(phase.duration)}"{limits} state="{state}"/>\n'


class _Edges:
    """Names edges and lanes."""

    def __init__(self, road_map: RoadMap, words: Words) -> None:
        self._roads = {road.id: k for k, road in enumerate(road_map.roads)}
        self._map = road_map
        self._lengths = lengths(road_map.plan_view)
        self._words = words
        self._sections = lru_cache(maxsize=None)(self._count_sections)

    def connections(self, links: Sequence[SignalLink]) -> dict[int, str]:
        """Return the attributes that name the ends of links in SUMO, by index of the link.

        Where several lanes of a road lead to one lane it keeps one of them: that of the connecting road whose id
        comes first as a text, but for ways from lanes for some, which are closed there (`shared_exits`).
        """

        def order(item: tuple[int, SignalLink]) -> tuple[bool, str, int]:
            n, link = item
            return self._for_some(link), str(link.connecting_road), n

        found: dict[tuple[str, str, int], int] = {}
        lanes: dict[int, int] = {}
        for n, link in sorted(enumerate(links), key=order):
            before = self._lane(link.road, link.at_end, link.lane)
            after = self._lane(link.exit_road, not link.exit_at_start, link.exit_lane)
            if before is not None and after is not None:
                edge = self._edge(link.road, link.at_end, along=link.at_end)
                exit_edge = self._edge(link.exit_road, not link.exit_at_start, along=link.exit_at_start)
                lanes.setdefault(found.setdefault((edge, exit_edge, after), n), before)
        places = {n: place for place, n in found.items()}
        return {
            n: f'from="{edge}" to="{exit_edge}" fromLane="{lanes[n]}" toLane="{after}"'
            for n, (edge, exit_edge, after) in sorted(places.items())
        }

    def _edge(self, road: int, at_end: bool, *, along: bool) -> str:
        count = self._sections(road)
        section = f"#{count - 1 if at_end else 0}" if count > 1 else ""
        return f"{'-' if along else ''}{road}{section}"

    def _for_some(self, link: SignalLink) -> bool:
        """Whether a link begins on a lane that is not for all."""
        lanes = self._lanes(link.road, link.at_end)
        return any(item.id == link.lane and self._words.lane_users(item.type.value) for item in lanes)

    def _lanes(self, road: int, at_end: bool) -> tuple[Lane, ...]:
        return self._map.roads[self._roads[road]].lane_sections[-1 if at_end else 0].lanes

    def _lane(self, road: int, at_end: bool, lane: int) -> int | None:
        """Return the index of a lane at an end of a road; None where SUMO has none."""
        side = [item for item in self._imported(self._lanes(road, at_end)) if item.id * lane > 0]
        ids = sorted((item.id for item in side), key=abs, reverse=True)
        return ids.index(lane) if lane in ids else None

    def _imported(self, lanes: Iterable[Lane]) -> list[Lane]:
        return [item for item in lanes if item.id and self._words.lane_type(item.type.value) in _IMPORTED]

    def _count_sections(self, road_id: int) -> int:
        """Return how many pieces netconvert makes of a road."""
        index = self._roads[road_id]
        road, length = self._map.roads[index], float(self._lengths[index])
        sections = [item for k, item in enumerate(road.lane_sections) if not k or _apart(road.lane_sections, k)]
        starts = [item.s for item in sections]
        if len(sections) == 1 and _is_loop(road):
            sections, starts = [sections[0], sections[0]], [0.0, 0.5 * length]
        count = len(sections)
        for section, (start, end) in zip(sections, pairwise([*starts, length]), strict=True):
            at = sorted(
                s
                for item in self._imported(section.lanes)
                if self._words.lane_type(item.type.value) != "restricted"
                for s in _cuts(item.widths, section.s, end)
            )
            last = start
            for s in at:
                if s - last >= _SHORTEST_CUT and end - s >= _SHORTEST_CUT:
                    count, last = count + 1, s
        return count


def _apart(sections: Sequence[LaneSection], k: int) -> bool:
    return abs(sections[k].s - sections[k - 1].s) >= _SAME_PLACE


def _is_loop(road: Road) -> bool:
    ends = [(link.to_junction, link.id) for link in (road.predecessor, road.successor) if link is not None]
    return len(ends) == 2 and ends[0] == ends[1] and ends[0][0]


def _cuts(widths: Sequence[Cubic], start: float, end: float) -> list[float]:
    """Return where a lane of a section is cut, s on the road, m: near where it has the least width."""
    out = []
    s, width = widths[0].s, widths[0].at(0.0)
    for k, item in enumerate(widths):
        until = widths[k + 1].s if k + 1 < len(widths) else end - start
        then = item.at(until - item.s)
        if width < _LEAST_WIDTH < then or width > _LEAST_WIDTH > then:
            at = s + (until - s) / abs(then - width) * abs(_LEAST_WIDTH - width)
            step = -_SAME_PLACE if width < _LEAST_WIDTH else _SAME_PLACE
            while s <= at <= until and item.at(at - item.s) > _LEAST_WIDTH:
                at += step
            out.append(start + min(max(at, s), until))
        s, width = until, then
    return out
