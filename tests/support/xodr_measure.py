"""Figures of an OpenDRIVE file that say whether it hangs together, each with the places it comes from."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from xodr_file import CAR_LANES, FloatArray, Junction, Link, Road, XodrFile


def turn(a: float, b: float) -> float:
    """Return the angle between two headings, rad, 0 to pi."""
    return abs((a - b + math.pi) % (2 * math.pi) - math.pi)


@dataclass(frozen=True)
class Figure:
    """A measured value and where it was measured."""

    value: float
    where: str


def above(figures: list[Figure], limit: float) -> list[str]:
    """Return the places above a limit (or not a number), worst first, for people to read."""
    bad = sorted((f for f in figures if not f.value <= limit), key=lambda f: (-f.value, f.where))
    return [f"{f.where}: {f.value:.3g}" for f in bad]


# ---------------------------------------------------------------- inside roads


def record_gaps(network: XodrFile) -> list[Figure]:
    """Distance between the end of a plan-view record and the start of the next, m."""
    return [
        Figure(math.hypot(float(x[0]) - b.x, float(y[0]) - b.y), f"road {road.id} at s={b.s:.2f}")
        for road in network.roads.values()
        for a, b in pairwise(road.geometries)
        for x, y, _ in [a.pose(np.array([a.s + a.length]))]
    ]


def record_kinks(network: XodrFile) -> list[Figure]:
    """Angle between the end of a plan-view record and the start of the next, rad."""
    return [
        Figure(turn(a.hdg + a.turn, b.hdg), f"road {road.id} at s={b.s:.2f}")
        for road in network.roads.values()
        for a, b in pairwise(road.geometries)
    ]


def length_errors(network: XodrFile) -> list[Figure]:
    """How far stated stations and lengths are from the sums of the records' lengths, m."""
    figures = []
    for road in network.roads.values():
        ends = np.cumsum([g.length for g in road.geometries])
        starts = np.array([g.s for g in road.geometries])
        off = max(float(np.abs(starts - np.r_[0.0, ends[:-1]]).max()), abs(float(ends[-1]) - road.length))
        figures.append(Figure(off, f"road {road.id}"))
    return figures


def shortest_records(network: XodrFile) -> list[Figure]:
    """Length of every plan-view record, m."""
    return [Figure(g.length, f"road {r.id} at s={g.s:.2f}") for r in network.roads.values() for g in r.geometries]


def profile_jumps(network: XodrFile) -> tuple[list[Figure], list[Figure]]:
    """Steps of height (m) and of grade between the elevation records of a road."""
    heights, grades = [], []
    for road in network.roads.values():
        records = road.elevation.records
        for (s, a, b, c, d), after in pairwise(records):
            ds, where = after[0] - s, f"road {road.id} at s={after[0]:.2f}"
            heights.append(Figure(abs(a + ds * (b + ds * (c + ds * d)) - after[1]), where))
            grades.append(Figure(abs(b + ds * (2 * c + ds * 3 * d) - after[2]), where))
    return heights, grades


def steepest_grades(network: XodrFile) -> list[Figure]:
    """Largest grade of each road, seen each metre."""
    figures = []
    for road in network.roads.values():
        s = np.linspace(0.0, road.length, max(2, math.ceil(road.length) + 1))
        figures.append(Figure(float(np.abs(road.elevation.slope(s)).max()), f"road {road.id}"))
    return figures


def narrowest_widths(network: XodrFile) -> list[Figure]:
    """Smallest width of each lane, m."""
    return [
        Figure(
            float(lane.width.value(np.linspace(0.0, section.end - section.s, 33)).min()), f"road {road.id} {lane.id}"
        )
        for road in network.roads.values()
        for section in road.sections
        for lane in section.lanes.values()
    ]


def section_gaps(network: XodrFile) -> list[Figure]:
    """Distance in t between the edges of a lane and those of the lane it names in the next section, m."""
    figures = []
    for road in network.roads.values():
        for a, b in pairwise(road.sections):
            s = np.array([b.s])
            before = float(road.lane_offset.value(s - 1e-7)[0]) - float(road.lane_offset.value(s)[0])
            for lane in a.lanes.values():
                for to in lane.successors:
                    edges = zip(a.edges(lane.id, s), b.edges(to, s), strict=True)
                    gap = max(abs(float(p[0]) + before - float(q[0])) for p, q in edges)
                    figures.append(Figure(gap, f"road {road.id} at s={b.s:.2f} lane {lane.id} to {to}"))
    return figures


def sections_past_the_end(network: XodrFile) -> list[str]:
    """Return roads whose last lane section ends beyond the road in floating point, which CARLA refuses to load."""
    return [
        f"road {road.id}: {last.s} + ({road.length} - {last.s}) > {road.length}"
        for road in network.roads.values()
        for last in [road.sections[-1]]
        if last.s + (road.length - last.s) > road.length
    ]


# ---------------------------------------------------------------- between roads


@dataclass(frozen=True)
class LaneStep:
    """A lane at a road's end and the lane beyond; True names the start of a road."""

    road: str
    at_start: bool
    lane: int
    beyond: str
    beyond_at_start: bool
    beyond_lane: int

    def __str__(self) -> str:
        ends = {True: "start", False: "end"}
        a = f"{self.road}:{ends[self.at_start]}:{self.lane}"
        return f"{a} to {self.beyond}:{ends[self.beyond_at_start]}:{self.beyond_lane}"


def links(road: Road) -> list[tuple[bool, Link]]:
    """Return a road's links, each with whether it is the one at its start."""
    return [(at_start, link) for at_start, link in ((True, road.predecessor), (False, road.successor)) if link]


def incoming_end(road: Road, junction: Junction, connecting: Road, contact_at_start: bool) -> bool:
    """Say with which end (True: start) a road lies at a connection; of two ends, with the nearer one."""
    ends = [
        at_start
        for at_start, link in links(road)
        if (link.element_type, link.element_id) == ("junction", junction.id)
    ]
    if len(ends) < 2:
        return ends[0]

    def place(r: Road, at_start: bool) -> FloatArray:
        return np.array([float(v[0]) for v in r.pose(np.array([0.0 if at_start else r.length]))[:2]])

    contact = place(connecting, contact_at_start)
    return min(ends, key=lambda at_start: float(np.hypot(*(place(road, at_start) - contact))))


def lane_steps(network: XodrFile) -> Iterator[LaneStep]:
    """Yield all lane links across the ends of roads: of the roads themselves, and the lane links of connections."""
    for road in network.roads.values():
        for at_start, link in links(road):
            if link.element_type == "road":
                for lane in road.section(at_start).lanes.values():
                    for to in lane.predecessors if at_start else lane.successors:
                        yield LaneStep(road.id, at_start, lane.id, link.element_id, link.contact_point == "start", to)
    for junction in network.junctions.values():
        for c in junction.connections:
            start = c.contact_point == "start"
            end = incoming_end(network.roads[c.incoming], junction, network.roads[c.connecting], start)
            for lane_id, to in c.lane_links:
                yield LaneStep(c.incoming, end, lane_id, c.connecting, start, to)


@dataclass(frozen=True)
class StepFigures:
    """What lies between the two sides of all lane links of car lanes."""

    centre: list[Figure]
    edge: list[Figure]
    height: list[Figure]
    heading: list[Figure]
    grade: list[Figure]


def step_figures(network: XodrFile) -> StepFigures:
    """Measure every lane link between lanes for cars: gaps in m, turns in rad, grades per traffic direction."""
    figures = StepFigures([], [], [], [], [])
    for step in lane_steps(network):
        a, b = network.roads[step.road], network.roads[step.beyond]
        if a.section(step.at_start).lanes[step.lane].type not in CAR_LANES:
            continue
        p, hdg_p, grade_p = a.lane_end(step.lane, step.at_start)
        q, hdg_q, grade_q = b.lane_end(step.beyond_lane, step.beyond_at_start)
        d, where = p - q, str(step)
        figures.centre.append(Figure(float(np.hypot(*d[:, :2].mean(0))), where))
        figures.edge.append(Figure(float(np.hypot(d[:, 0], d[:, 1]).max()), where))
        figures.height.append(Figure(float(np.abs(d[:, 2]).max()), where))
        figures.heading.append(Figure(turn(hdg_p, hdg_q), where))
        figures.grade.append(Figure(abs(grade_p - grade_q), where))
    return figures


def links_to_another_kind(network: XodrFile) -> list[str]:
    """Return the lane links between a lane for cars and one that is not for cars."""
    bad = []
    for road in network.roads.values():
        for a, b in pairwise(road.sections):
            for lane in a.lanes.values():
                kinds = [(to, b.lanes[to].type) for to in lane.successors if to in b.lanes]
                where = f"road {road.id} at s={b.s:.2f}: lane {lane.id} {lane.type}"
                bad += [
                    f"{where} to {to} {kind}" for to, kind in kinds if (kind in CAR_LANES) != (lane.type in CAR_LANES)
                ]
    for step in lane_steps(network):
        one = network.roads[step.road].section(step.at_start).lanes[step.lane].type
        other = network.roads[step.beyond].section(step.beyond_at_start).lanes[step.beyond_lane].type
        if (one in CAR_LANES) != (other in CAR_LANES):
            bad.append(f"{step}: {one} to {other}")
    return bad


# ---------------------------------------------------------------- references


def broken_references(network: XodrFile) -> list[str]:
    """Return everything that names something that is not there, or that is not named back."""
    bad = [
        f"id {i} is used {network.ids.count(i)} times" for i in sorted(set(network.ids)) if network.ids.count(i) > 1
    ]
    bad += [f"id {i} is not a number above 0" for i in network.ids if not (i.isdecimal() and int(i) > 0)]
    for road in network.roads.values():
        bad += [f"road {road.id}: {text}" for text in _road_faults(network, road)]
    for junction in network.junctions.values():
        bad += [f"junction {junction.id}: {text}" for text in _junction_faults(network, junction)]
    return bad


def _road_faults(network: XodrFile, road: Road) -> Iterator[str]:
    if road.connecting and road.junction not in network.junctions:
        yield f"belongs to junction {road.junction}, which is not there"
    for at_start, link in links(road):
        if link.element_type == "junction":
            if link.element_id not in network.junctions:
                yield f"names junction {link.element_id}, which is not there"
            elif not any(
                road.id in (c.incoming, *_ways_out(network, c.connecting))
                for c in network.junctions[link.element_id].connections
            ):
                yield f"names junction {link.element_id}, in which no connection touches it"
            continue
        beyond = network.roads.get(link.element_id)
        if beyond is None:
            yield f"names road {link.element_id}, which is not there"
            continue
        yield from _link_faults(road, at_start, link, beyond)
    for a, b in pairwise(road.sections):
        yield from (
            f"lane {i} names lane {to} at s={b.s}"
            for i, lane in a.lanes.items()
            for to in lane.successors
            if to not in b.lanes
        )
        yield from (
            f"lane {i} names lane {to} at s={b.s}"
            for i, lane in b.lanes.items()
            for to in lane.predecessors
            if to not in a.lanes
        )
        there = {(i, to) for i, lane in a.lanes.items() for to in lane.successors}
        back = {(to, i) for i, lane in b.lanes.items() for to in lane.predecessors}
        yield from (f"lanes {pair} at s={b.s} are linked one way only" for pair in sorted(there ^ back))


def _ways_out(network: XodrFile, connecting: str) -> list[str]:
    road = network.roads.get(connecting)
    return [] if road is None else [link.element_id for _, link in links(road) if link.element_type == "road"]


def _link_faults(road: Road, at_start: bool, link: Link, beyond: Road) -> Iterator[str]:
    touched = link.contact_point == "start"
    lanes = road.section(at_start).lanes
    steps = [(i, to) for i, lane in lanes.items() for to in (lane.predecessors if at_start else lane.successors)]
    yield from (
        f"lane {i} names lane {to} of road {beyond.id}" for i, to in steps if to not in beyond.section(touched).lanes
    )
    if road.connecting:
        return
    back = beyond.predecessor if touched else beyond.successor
    own = ("road", road.id, "start" if at_start else "end")
    if back is None or (back.element_type, back.element_id, back.contact_point) != own:
        yield f"its link to road {beyond.id} is not returned"
        return
    theirs = beyond.section(touched).lanes
    returned = {(to, i) for i, lane in theirs.items() for to in (lane.predecessors if touched else lane.successors)}
    yield from (f"lanes {pair} to road {beyond.id} are linked one way only" for pair in sorted(returned ^ set(steps)))


def _junction_faults(network: XodrFile, junction: Junction) -> Iterator[str]:
    ids = [c.id for c in junction.connections]
    if not ids or len(set(ids)) != len(ids):
        yield f"has connections {ids}"
    listed = {c.connecting for c in junction.connections}
    own = {r.id for r in network.roads.values() if r.junction == junction.id}
    yield from (
        f"road {i} belongs to it but is in no connection, or is in one but not its own" for i in sorted(listed ^ own)
    )
    for c in junction.connections:
        incoming, connecting = network.roads.get(c.incoming), network.roads.get(c.connecting)
        if incoming is None or connecting is None:
            yield f"connection {c.id} names roads {c.incoming} and {c.connecting}"
            continue
        ends = [at_start for at_start, link in links(incoming) if link == Link("junction", junction.id, None)]
        if not ends:
            yield f"incoming road {c.incoming} does not end in it"
            continue
        start = c.contact_point == "start"
        back = connecting.predecessor if start else connecting.successor
        if back is None or (back.element_type, back.element_id) != ("road", c.incoming):
            yield f"connecting road {c.connecting} does not name its incoming road {c.incoming}"
            continue
        end = back.contact_point == "start"
        lanes = connecting.section(start).lanes
        named = {(of, i) for i, lane in lanes.items() for of in (lane.predecessors if start else lane.successors)}
        if (
            end not in ends
            or set(c.lane_links) != named
            or not named <= {(i, j) for i in incoming.section(end).lanes for j in lanes}
        ):
            yield f"connection {c.id} links lanes {c.lane_links}, its road {c.connecting} {sorted(named)}"
