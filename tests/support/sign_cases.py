"""Signs of small networks built by hand."""

from __future__ import annotations

from dataclasses import dataclass, replace

from light_cases import point
from street_cases import Case

from osm2xodr.conventions.targets import TARGETS
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.furniture.objects.crossings import find_crossings
from osm2xodr.furniture.options import FurnitureOptions
from osm2xodr.furniture.signs import PlacedSigns, place_signs
from osm2xodr.furniture.world.approaches import find_approaches, find_rail_stops
from osm2xodr.furniture.world.lane_table import LaneTable
from osm2xodr.furniture.world.world import World
from osm2xodr.model import Rule, Signal

# The main road from west to east (ways 1 and 2), a side street from the south (way 3).
T = Case(
    {
        "w": (-150.0, 0.0),
        "o": (0.0, 0.0),
        "e": (150.0, 0.0),
        "s": (0.0, -150.0),
        "sm": (0.0, -80.0),
        "si": (0.0, -12.0),
    },
    {1: ("w o", "highway=secondary"), 2: ("o e", "highway=secondary"), 3: ("s sm si o", "highway=residential")},
)
STREET = Case(
    {"w": (-150.0, 0.0), "m": (0.0, 0.0), "n": (60.0, 0.0), "e": (150.0, 0.0)},
    {1: ("w m", "highway=tertiary maxspeed=50"), 2: ("m n e", "highway=tertiary maxspeed=30")},
)


@dataclass(frozen=True)
class Signed:
    """A network with its signs, and what was said about them."""

    world: World
    signs: PlacedSigns
    rule: Rule
    origin: complex

    @property
    def left_out(self) -> dict[str, str]:
        """The nodes that give no sign, and why."""
        return {item.osm_id: item.message for item in self.world.diagnostics if item.code == "sign-left-out"}

    def at(self, signal: Signal) -> complex:
        """Return where a sign stands as the case is drawn, x + iy, m: left-hand traffic is mirrored back."""
        place = point(self.world.road_map, signal.road, signal.s, signal.t) - self.origin
        return place if self.rule is Rule.RIGHT_HAND else place.conjugate()

    def way(self, signal: Signal) -> int:
        """Return the OSM way that a sign stands at, from whose traffic it is seen."""
        road = next(road for road in self.world.road_map.roads if road.id == signal.road)
        return road.osm_way_ids[-1 if signal.orientation == "+" else 0]

    def named(self, name: str) -> list[Signal]:
        """Return all signs of a meaning."""
        return [item for item in self.signs.signals if item.name == name]

    def summary(self) -> list[tuple[str, float | None, str, str]]:
        """Return meaning, value, orientation and id of all signs, sorted."""
        return sorted((item.name, item.value, item.orientation, item.osm_id) for item in self.signs.signals)


def signed(
    case: Case,
    rule: Rule = Rule.RIGHT_HAND,
    *,
    target: str = "generic",
    signalled: frozenset[int] = frozenset(),
    with_crossings: bool = False,
) -> Signed:
    """Place the signs of a case, drawn for right-hand traffic and mirrored for left-hand traffic.

    Parameters
    ----------
    case, rule
        The network.
    target
        The reader to write for.
    signalled
        Ways at whose approaches there are lights.
    with_crossings
        Whether crossings are looked for.
    """
    drawn = case if rule is Rule.RIGHT_HAND else case.mirrored()
    road_map = drawn.build(rule)
    assert road_map.places is not None
    options = FurnitureOptions(target=TARGETS[target])
    network = drawn.stages(rule).network
    world = World(network, road_map, road_map.places, LaneTable(road_map), options, Diagnostics())
    approaches = find_approaches(world, ())
    lit = frozenset(
        (item.road, item.at_end)
        for item in approaches
        if network.streets[item.street_end // 2].pieces[-1 if item.street_end % 2 else 0][1].osm_way_id in signalled
    )
    # The frame's origin is in the middle of the area. Nodes are numbered from 1001 on.
    drawn_at = complex(*next(iter(drawn.nodes.values())))
    (found_at,) = {
        complex(*street.points[street.node_ids == 1001][0]) for street in network.streets if 1001 in street.node_ids
    }
    crossings = find_crossings(world) if with_crossings else ()
    placed = place_signs(world, approaches, lit, crossings, find_rail_stops(world))
    return Signed(world, placed, rule, found_at - drawn_at)


def ways(case: Case, **tags: str) -> Case:
    """Return a case with other tags of its ways, by ``w`` and their number."""
    return replace(
        case, ways={number: (nodes, tags.get(f"w{number}", old)) for number, (nodes, old) in case.ways.items()}
    )


def the(found: Signed, name: str) -> complex:
    """Return where the only sign of a meaning stands."""
    (sign,) = found.named(name)
    return found.at(sign)
