"""esmini: a scenario in OpenSCENARIO XML 1.2, with an ego and others on routes, and traffic lights that change.

Cars have a way to go each, and do not meet.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterator, Sequence
from typing import Final

import numpy as np

from osm2xodr.curves import sorted_unique
from osm2xodr.errors import InputError
from osm2xodr.model import FloatArray, IntArray
from osm2xodr.opendrive import read_xodr
from osm2xodr.starting.motion import (
    LaneNetwork,
    Motion,
    Path,
    Programme,
    lane_network,
    lights_on,
    path_along,
    plan_motion,
    programmes_of,
)
from osm2xodr.starting.request import FOLDER, XODR, Made, Request
from osm2xodr.system import record

_SCENARIO: Final = "start.xosc"
_EGO: Final = "Ego"
_CARS: Final = 6
# With more roads than these esmini 3.6 takes a minute and more to load them: 45 s with 2,900, 9 minutes with 10,000.
_MANY_ROADS: Final = 3_000
# How long the scenario takes, s: a cycle of traffic lights.
_SECONDS: Final = 90.0
# What esmini is told for each letter of a programme: lamps from the top, red, yellow, green.
_LAMPS: Final = {
    "G": "off;off;on",
    "g": "off;off;on",
    "y": "off;on;off",
    "r": "on;off;off",
    "o": "off;flashing;off",
}
# Waypoints lie this far within their roads, m, but in the middle of shorter ones.
_INSIDE: Final = 2.0
# OpenSCENARIO wants a time; without an option there is none, as the same input gives the same bytes.
_NO_DATE: Final = "1970-01-01"
# A car of the middle class: size and place of its middle from the middle of its rear axle, m.
_BOX: Final = {"length": 4.5, "width": 1.8, "height": 1.5}
_MIDDLE: Final = {"x": 1.4, "y": 0.0, "z": 0.75}
_AXLES: Final = {"FrontAxle": (0.5, 2.8), "RearAxle": (0.0, 0.0)}

# How long a way should be, m: about what a car covers at 50 km/h while it is watched.
_WAY: Final = 1_200.0
# A car sets out on a lane at least so long, so far from its begin, and at most so far from its end, m.
_ROOM: Final = 25.0
_FIRST: Final = 10.0
_LAST: Final = 60.0
# esmini 3.6 finds the way from one waypoint to the next among the 100 nearest roads (`RoadPath::Calculate`), and may
# count those for people.
_MOST_ROADS: Final = 50
# How many places are tried for the ego, and for all others.
_EGO_TRIES: Final = 48
_OTHER_TRIES: Final = 160
# The middles of cars are never nearer to each other than this, m: a length and a gap.
_APART: Final = 8.0
# When others set out, s, and how far they come at least, m: the first choices are those that leave most to see.
_CHOICES: Final = ((0.0, 300.0), (10.0, 200.0), (20.0, 150.0), (30.0, 100.0), (0.0, 0.0), (40.0, 0.0))
# How often their distance is looked at, s: at 100 km/h a car comes 7 m on.
_LOOK: Final = 0.25
# A light on the way is worth as much as this length of it, m, and a turn through a junction as that.
_LIGHT_WORTH: Final = 400.0
_TURN_WORTH: Final = 40.0


def make(request: Request) -> Made:
    """Write the scenario."""
    request.on_stage("making the scenario")
    network = lane_network(read_xodr(request.xodr))
    known = {item.attributes.get("id") for item in network.file.furniture if item.kind == "signal"}
    programmes = programmes_of(request.conversion.road_map.furniture)
    cars = choose_cars(network, programmes, _CARS, _SECONDS)
    if not cars:
        raise InputError(f"there is no lane in {request.name} that a car could set out on; choose a larger area")
    switched = [(item, {k: text for k, text in item.signals.items() if str(k) in known}) for item in programmes]
    root = _scenario(request, network, cars, switched)
    ET.indent(root, " ")
    text = ET.tostring(root, encoding="UTF-8", xml_declaration=True)
    (request.folder / _SCENARIO).write_bytes(text + b"\n")
    lights = sum(len(signals) for _, signals in switched)
    others = len(cars) - 1
    company = f" and {others} other {'car' if others == 1 else 'cars'}" if others else ", with room for no other car,"
    notes = [f"an ego{company} for {_SECONDS:.0f} s"]
    if lights:
        notes.append(f"{lights:,} traffic lights change, and the cars mind them; those for people stay dark")
    if (roads := len(network.file.roads.id)) > _MANY_ROADS:
        notes.append(f"esmini takes minutes to load {roads:,} roads; convert less with --bbox or --ways major")
    return Made(
        "Install [esmini](https://github.com/esmini/esmini/releases), 3.6 or later.",
        f"esmini --window 60 60 1280 720 --osc {FOLDER}/{_SCENARIO}",
        {_SCENARIO: "the scenario, ASAM OpenSCENARIO XML 1.2"},
        tuple(notes),
        {"Without a window": "`--headless --fixed_timestep 0.05` in place of `--window …` runs it without a window."},
    )


def _scenario(
    request: Request, network: LaneNetwork, cars: list[Car], lights: list[tuple[Programme, dict[int, str]]]
) -> ET.Element:
    """Return the document."""
    root = ET.Element("OpenSCENARIO")
    date = request.conversion.options.date or _NO_DATE
    head = {
        "revMajor": "1",
        "revMinor": "2",
        "date": date if "T" in date else f"{date}T00:00:00",
        "author": "osm2xodr",
        "description": f"{request.name}: © OpenStreetMap contributors, Open Database License 1.0 (ODbL)",
    }
    _add(root, "FileHeader", head)
    _add(root, "CatalogLocations")
    _add(_add(root, "RoadNetwork"), "LogicFile", {"filepath": XODR})
    entities = _add(root, "Entities")
    names = [_EGO, *(f"Car{k}" for k in range(1, len(cars)))]
    for name in names:
        _vehicle(_add(entities, "ScenarioObject", {"name": name}), name == _EGO)
    storyboard = _add(root, "Storyboard")
    actions = _add(_add(storyboard, "Init"), "Actions")
    for programme, signals in lights:
        for signal, letters in signals.items():
            if programme.ends:
                _show(_add(actions, "GlobalAction"), signal, letters[0])
    for name, car in zip(names, cars, strict=True):
        _initial(_add(actions, "Private", {"entityRef": name}), network, car, name)
    story = _add(storyboard, "Story", {"name": "Drive"})
    act = _add(story, "Act", {"name": "Traffic"})
    for name, car in zip(names, cars, strict=True):
        _drive(act, name, car)
    for programme, signals in lights:
        _switch(act, programme, signals)
    _after(_add(act, "StartTrigger"), 0.0)
    _after(_add(storyboard, "StopTrigger"), _SECONDS)
    return root


def _vehicle(parent: ET.Element, is_ego: bool) -> None:
    vehicle = _add(parent, "Vehicle", {"name": "ego" if is_ego else "car", "vehicleCategory": "car"})
    box = _add(vehicle, "BoundingBox")
    _add(box, "Center", _numbers(_MIDDLE))
    _add(box, "Dimensions", _numbers(_BOX))
    _add(vehicle, "Performance", _numbers({"maxSpeed": 60.0, "maxAcceleration": 10.0, "maxDeceleration": 10.0}))
    axles = _add(vehicle, "Axles")
    for name, (steering, x) in _AXLES.items():
        about = {"maxSteering": steering, "wheelDiameter": 0.65, "trackWidth": 1.6, "positionX": x, "positionZ": 0.32}
        _add(axles, name, _numbers(about))
    _add(vehicle, "Properties")


def _initial(private: ET.Element, network: LaneNetwork, car: Car, name: str) -> None:
    """Put a car on its lane, and give it its route and its first speed."""
    teleport = _add(_add(private, "PrivateAction"), "TeleportAction")
    places = list(_waypoints(network, car.path))
    _lane_position(teleport, *places[0])
    if len(places) > 1:
        routing = _add(_add(private, "PrivateAction"), "RoutingAction")
        route = _add(_add(routing, "AssignRouteAction"), "Route", {"name": f"{name}Route", "closed": "false"})
        for place in places:
            _lane_position(_add(route, "Waypoint", {"routeStrategy": "shortest"}), *place)
    speed = _add(_add(_add(private, "PrivateAction"), "LongitudinalAction"), "SpeedAction")
    shape = {"dynamicsShape": "step", "dynamicsDimension": "time", "value": "0"}
    _add(speed, "SpeedActionDynamics", shape)
    _add(_add(speed, "SpeedActionTarget"), "AbsoluteTargetSpeed", _numbers({"value": float(car.motion.speed[0])}))


def _waypoints(network: LaneNetwork, path: Path) -> Iterator[tuple[str, int, float]]:
    """Yield road, lane and s of the begin of a path, and of the end of each road after the first.

    esmini keeps one on each road, and looks for the way between them itself, by roads, whatever the lane: so ways
    through junctions have theirs, too.
    """
    yield (*network.lane(path.nodes[0]), float(path.s[0]))
    roads = [int(network.road[node]) for node in path.nodes]
    for k, node in enumerate(path.nodes):
        leaves = k + 1 == len(roads) or roads[k + 1] != roads[k]
        if leaves and any(road != roads[0] for road in roads[: k + 1]):
            low, high = network.section(node)
            room = min(_INSIDE, 0.5 * (high - low))
            yield (*network.lane(node), low + room if node % 2 else high - room)


def _lane_position(parent: ET.Element, road: str, lane: int, s: float) -> None:
    about = {"roadId": road, "laneId": str(lane), "s": f"{s:.3f}", "offset": "0"}
    _add(_add(parent, "Position"), "LanePosition", about)


def _drive(act: ET.Element, name: str, car: Car) -> None:
    """Let a car go as planned."""
    event = _event(act, f"{name}Drive", name)
    action = _add(_add(event, "Action", {"name": f"{name}Speed"}), "PrivateAction")
    profile = _add(_add(action, "LongitudinalAction"), "SpeedProfileAction", {"followingMode": "position"})
    for time, speed in car.motion.entries:
        _add(profile, "SpeedProfileEntry", _numbers({"time": time, "speed": speed}))
    _after(_add(event, "StartTrigger"), 0.0)


def _switch(act: ET.Element, programme: Programme, signals: dict[int, str]) -> None:
    """Let the lights of a junction change by their programme, phase by phase."""
    changing = {signal: text for signal, text in signals.items() if len(set(text)) > 1}
    if not changing:
        return
    junction = programme.plan.junction
    group = _add(act, "ManeuverGroup", {"maximumExecutionCount": "1", "name": f"Lights{junction}"})
    _add(group, "Actors", {"selectTriggeringEntities": "false"})
    maneuver = _add(group, "Maneuver", {"name": f"Lights{junction}Programme"})
    begins, k = 0.0, 0
    count = len(programme.ends)
    while (begins := begins + programme.plan.phases[k % count].duration) < _SECONDS:
        k += 1
        turned = [signal for signal, text in changing.items() if text[k % count] != text[(k - 1) % count]]
        if turned:
            about = {"name": f"Lights{junction}Phase{k}", "maximumExecutionCount": "1", "priority": "parallel"}
            event = _add(maneuver, "Event", about)
            for signal in turned:
                action = _add(event, "Action", {"name": f"Light{signal}Phase{k}"})
                _show(_add(action, "GlobalAction"), signal, changing[signal][k % count])
            _after(_add(event, "StartTrigger"), begins)


def _show(action: ET.Element, signal: int, letter: str) -> None:
    about = {"name": str(signal), "state": _LAMPS[letter]}
    signals = _add(_add(action, "InfrastructureAction"), "TrafficSignalAction")
    _add(signals, "TrafficSignalStateAction", about)


def _event(act: ET.Element, name: str, actor: str) -> ET.Element:
    """Add a group of one actor with one event."""
    group = _add(act, "ManeuverGroup", {"maximumExecutionCount": "1", "name": name})
    actors = _add(group, "Actors", {"selectTriggeringEntities": "false"})
    _add(actors, "EntityRef", {"entityRef": actor})
    maneuver = _add(group, "Maneuver", {"name": f"{name}Maneuver"})
    about = {"name": f"{name}Event", "maximumExecutionCount": "1", "priority": "parallel"}
    return _add(maneuver, "Event", about)


def _after(trigger: ET.Element, seconds: float) -> None:
    """Let a trigger pull after a time."""
    about = {"name": f"After{seconds:g}", "delay": "0", "conditionEdge": "none"}
    condition = _add(_add(trigger, "ConditionGroup"), "Condition", about)
    # Not at once: esmini ends what it does at the begin in its first step.
    rule = {"value": f"{seconds:g}", "rule": "greaterThan"}
    _add(_add(condition, "ByValueCondition"), "SimulationTimeCondition", rule)


def _add(parent: ET.Element, name: str, attributes: dict[str, str] | None = None) -> ET.Element:
    return ET.SubElement(parent, name, attributes or {})


def _numbers(values: dict[str, float]) -> dict[str, str]:
    return {name: f"{value:.3f}".rstrip("0").rstrip(".") for name, value in values.items()}


@record(eq=False)
class Car:
    """A car, the way that it takes, and how it goes along it."""

    path: Path
    motion: Motion
    lights: int  # How many are on its way


def choose_cars(network: LaneNetwork, programmes: list[Programme], count: int, seconds: float) -> list[Car]:
    """Return up to `count` cars that do not meet for a while, s; the first one is the ego."""
    places = _places(network)
    if not len(places):
        return []
    tried = places[np.unique(np.linspace(0, len(places) - 1, _EGO_TRIES).round().astype(np.int64))]
    cars = [_car(network, programmes, int(node)) for node in tried]
    ego = max(cars, key=_worth)
    around = _around(network, places, ego)
    times = np.arange(0.0, seconds, _LOOK)
    chosen, taken = [ego], [ego.path.at(ego.motion.distance(times))]
    for delay, least in _CHOICES:
        for node in around if len(chosen) < count else ():
            car = _car(network, programmes, node, delay)
            where = car.path.at(car.motion.distance(times))
            moves = float(car.motion.distance(times[-1:])[0]) >= least
            if moves and all(np.hypot(*(where - other).T).min() > _APART for other in taken):
                chosen.append(car)
                taken.append(where)
            if len(chosen) == count:
                break
    return chosen


def _places(network: LaneNetwork) -> IntArray:
    """Return the nodes at the ends of roads outside of junctions on which there is room to set out."""
    leaves = np.zeros(len(network.length), np.bool_)
    leaves[network.start[network.road[network.start] != network.road[network.end]]] = True
    nodes = network.nodes[~network.in_junction[network.nodes]]
    long: IntArray = nodes[network.length[nodes] >= _ROOM]
    at_ends: IntArray = long[leaves[long]]
    if len(at_ends):
        return at_ends
    return long if len(long) else network.nodes[network.length[network.nodes] > _FIRST]


def _around(network: LaneNetwork, places: IntArray, ego: Car) -> Sequence[int]:
    """Return nodes by how far they are from where the ego sets out."""
    sections = [network.section(int(node)) for node in places]
    middles = np.array(
        [
            network.middle(int(node), np.array([0.5 * (low + high)]))[0][0, :2]
            for node, (low, high) in zip(places, sections, strict=True)
        ]
    )
    far = np.hypot(*(middles - ego.path.place[0, :2]).T)
    found: list[int] = places[np.argsort(far, kind="stable")][:_OTHER_TRIES].tolist()
    return found


def _car(network: LaneNetwork, programmes: list[Programme], node: int, delay: float = 0.0) -> Car:
    """Return a car that sets out on a node after a delay, s, and goes as far as it should, or can."""
    nodes = _within_reach(network, _way(network, node))
    path = path_along(network, nodes, max(_FIRST, float(network.length[node]) - _LAST))
    lights = lights_on(path, network, programmes)
    return Car(path, plan_motion(path, lights, delay), len(lights))


def _way(network: LaneNetwork, node: int) -> tuple[int, ...]:
    """Return the shortest way from a node to where it is long enough, or as long as can be."""
    far, before = network.ways_from(node)
    reached = np.flatnonzero(np.isfinite(far))
    enough = reached[far[reached] >= _WAY]
    last = int(enough[np.argmin(far[enough])] if len(enough) else reached[np.argmax(far[reached])])
    way = [last]
    while way[-1] != node:
        way.append(int(before[way[-1]]))
    return tuple(reversed(way))


def _within_reach(network: LaneNetwork, way: tuple[int, ...]) -> tuple[int, ...]:
    """Return a way up to where the next road ends too far away for a route: among too many others."""
    for k, node in enumerate(way[1:], 1):
        if network.length[node] > _LAST:
            far, _ = network.ways_from(way[k - 1])
            near = far <= network.length[node]
            if len(sorted_unique(network.road[near])) > _MOST_ROADS:
                return way[: k + 1 - bool(network.in_junction[way[k - 1]])]
    return way


def _worth(car: Car) -> float:
    """Return how much there is to see on a way, m."""
    turns: FloatArray = np.abs(np.diff(np.unwrap(car.path.hdg)))
    return min(car.path.length, _WAY) + _LIGHT_WORTH * min(car.lights, 3) + _TURN_WORTH * min(float(turns.sum()), 6.0)
