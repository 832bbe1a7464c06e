"""Dead ends on or behind the carriageway of a street that they do not meet.

Loops at turning circles and at dead ends: where there are any, how large, and drivable.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from road_measures import RoadMeasures, assert_smooth, assert_sound, records, smallest_radius_of
from street_cases import Case, Stages, built_links

from osm2xodr.curves import lengths, pose
from osm2xodr.defaults import CONNECTING_RADIUS
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.geometry import RoadOptions
from osm2xodr.geometry.defaults import SHORTEST_ROAD
from osm2xodr.geometry.junctions import JunctionLayout, cut_back_ends_on_streets, ends_on_streets
from osm2xodr.geometry.junctions.dead_ends import add_turnarounds, draw_loops
from osm2xodr.geometry.junctions.movements import Loop
from osm2xodr.geometry.junctions.road_parts import without_idle_junctions
from osm2xodr.geometry.plan_view.streets import fit_streets
from osm2xodr.model import LaneType, PlanView, Road, RoadMap, Rule

STREET = "highway=secondary width=8"

EITHER = pytest.mark.parametrize("rule", list(Rule), ids=lambda rule: rule.value)
_LINE = {"w": (-80.0, 0.0), "o": (0.0, 0.0)}


def laid_out(stages: Stages, diagnostics: Diagnostics) -> JunctionLayout:
    """Return the junctions with dead ends on streets cut back."""
    found = ends_on_streets(fit_streets(stages.network, Diagnostics()), stages.ends)
    return cut_back_ends_on_streets(stages.network, stages.ends, stages.layout, found, diagnostics)


def cut_back(end: tuple[float, float], *, tags: str = "highway=service width=4", way: str = "c d") -> float:
    """Return by how much a street that ends there is cut back, beside one along x that is 8 m wide, m."""
    nodes = {"a": (-100.0, 0.0), "b": (100.0, 0.0), "c": (0.0, 60.0), "d": end}
    stages = Case(nodes, {1: ("a b", STREET), 2: (way, tags)}).stages()
    diagnostics = Diagnostics()
    after = laid_out(stages, diagnostics)
    gone = after.trim - stages.layout.trim
    assert [(item.code, item.osm_id) for item in diagnostics] == [("lies-on-another", "way/2")] * int(gone.any())
    return float(gone.sum())


@pytest.mark.parametrize("way", ["c d", "d c"])
@pytest.mark.parametrize(
    ("y", "gone"), [(5.0, 0.0), (3.0, 1.3), (0.0, 4.3), (-3.5, 7.8), (-10.0, 14.3), (-12.0, 0.0)]
)
def test_an_end_on_a_street_or_behind_it_is_cut_back_to_its_edge(y: float, gone: float, way: str) -> None:
    assert cut_back((0.0, y), way=way) == pytest.approx(gone, abs=0.5)


def test_at_a_slant_the_farther_edge_counts() -> None:
    # It comes at 45 degrees, 2 m wide on either side.
    apart = (4.0 + 0.3 + 2.0 * math.cos(math.pi / 4)) / math.sin(math.pi / 4)
    assert cut_back((60.0, 0.0)) == pytest.approx(apart, abs=0.6)


@pytest.mark.parametrize(
    ("y", "gone"), [(4.5, (4.0 + 0.3 + 2.0 * math.sqrt(0.5) - 4.5) * math.sqrt(2.0)), (5.6, 0.0)]
)
def test_an_end_with_a_corner_on_a_street_is_cut_back(y: float, gone: float) -> None:
    # At 45 degrees its nearer corner lies 1.4 m closer to the street, whose edge is at y = 4, than its middle.
    assert cut_back((60.0 - y, y)) == pytest.approx(gone, abs=0.5)


def test_what_passes_the_street_or_runs_along_it_keeps_its_length() -> None:
    assert cut_back((0.0, -20.0)) == 0.0
    nodes = {"a": (-100.0, 0.0), "b": (100.0, 0.0), "c": (-60.0, 1.0), "d": (60.0, 1.0)}
    stages = Case(nodes, {1: ("a b", STREET), 2: ("c d", "highway=service")}).stages()
    after = laid_out(stages, Diagnostics())
    assert after.trim.tolist() == stages.layout.trim.tolist()


@pytest.mark.parametrize("tags", ["bridge=yes layer=1", "tunnel=yes layer=-1", "layer=-2", "bridge=yes layer=0"])
def test_ends_above_and_below_a_street_keep_their_length(tags: str) -> None:
    assert cut_back((0.0, 0.0), tags=f"highway=service width=4 {tags}") == 0.0


def test_stubs_of_the_street_itself_are_arms() -> None:
    nodes = {"a": (-100.0, 0.0), "b": (100.0, 0.0), "c": (0.0, 0.0), "d": (2.0, 3.0)}
    stages = Case(nodes, {1: ("a c b", STREET), 2: ("c d", "highway=service width=4")}).stages()
    after = laid_out(stages, Diagnostics())
    assert after.trim.tolist() == stages.layout.trim.tolist()


@pytest.mark.parametrize(("y", "cut"), [(26.0, True), (16.0, False)])
def test_what_the_junction_at_its_other_end_takes_is_left_to_it(y: float, cut: bool) -> None:
    nodes = {"a": (-100.0, 0.0), "b": (100.0, 0.0), "e": (-100.0, y), "c": (0.0, y), "f": (100.0, y), "d": (0.0, 1.0)}
    ways = {
        1: ("a b", STREET),
        2: ("c d", "highway=service width=4"),
        3: ("e c f", "highway=primary lanes=2 width:lanes:forward=8 width:lanes:backward=8"),
    }
    stages = Case(nodes, ways).stages()
    before = stages.layout
    after = laid_out(stages, Diagnostics())
    (street,) = [k for k, item in enumerate(stages.network.streets) if item.pieces[0][1].osm_way_id == 2]
    ends = slice(2 * street, 2 * street + 2)
    gone = after.trim[ends] - before.trim[ends]
    assert gone.tolist() == [0.0, pytest.approx(3.5 if cut else 0.0, abs=0.5)]
    # What is left is a street, however far the arm at the junction is set back.
    assert after.trim[2 * street + 1] + after.most[2 * street] <= y - 1.0 - SHORTEST_ROAD + 1e-9


def _built(case: Case, rule: Rule, *, turnarounds: bool = False) -> RoadMap:
    return (case if rule is Rule.RIGHT_HAND else case.mirrored()).build(rule, turnarounds=turnarounds)


def _loops(roads: RoadMap) -> list[tuple[int, Road]]:
    return [(k, road) for k, road in enumerate(roads.roads) if road.junction is not None]


def _codes(case: Case, options: RoadOptions | None = None) -> list[tuple[str, str]]:
    """Return what is reported when turnarounds are added to a case."""
    stages, diagnostics = case.stages(), Diagnostics()
    fitted = fit_streets(stages.network, Diagnostics())
    layout = without_idle_junctions(stages.ends, stages.layout, stages.movements)
    add_turnarounds(stages.network, fitted, stages.ends, layout, options or RoadOptions(), diagnostics)
    return [(item.code, item.osm_id) for item in diagnostics]


@EITHER
@pytest.mark.parametrize(
    ("tags", "radius"),
    [
        # Not along the edge of a circle whose size is not known
        ("highway=turning_circle", 6.0),
        ("highway=turning_circle diameter=20", 10.0 - 1.5),
        ("highway=turning_loop diameter=80'", 40 * 0.3048 - 1.5),
        ("highway=mini_roundabout diameter=wide", 6.0),
        ("highway=turning_circle diameter=70", 20.0 - 1.5),
    ],
)
def test_a_turning_circle_is_driven_round_its_node(tags: str, radius: float, rule: Rule) -> None:
    roads = _built(Case(_LINE, {1: ("w o", "width=6 lanes=2")}, node_tags={"o": tags}), rule)
    assert_sound(roads)
    ((k, loop),) = _loops(roads)
    assert_smooth(roads.plan_view, k, 1e-6, 1e-6)
    out, round_, back = records(roads.plan_view, k)
    assert 1 / abs(out[3]) == pytest.approx(4.0)
    assert 1 / abs(round_[3]) == pytest.approx(radius, abs=1e-6)
    # Right-hand traffic goes round counter-clockwise.
    assert (round_[3] > 0) == (rule is Rule.RIGHT_HAND)
    assert out[3] * round_[3] < 0
    assert back[3] == pytest.approx(out[3])
    measures = RoadMeasures(roads)
    middle = round_[0] + round_[2] / 2
    (street,) = (road for road in roads.roads if road.junction is None)
    start = measures.pose(street, 0.0)
    assert measures.pose(loop, middle).gap(start) == pytest.approx(80.0 + radius, abs=0.05)
    assert measures.pose(loop, middle).turn(start) == pytest.approx(math.pi / 2, abs=1e-3)


@pytest.mark.parametrize(
    ("kind", "middle"),
    [
        ("turning_circle", LaneType.SHOULDER),
        ("mini_roundabout", LaneType.SHOULDER),
        ("turning_loop", LaneType.BORDER),
    ],
)
def test_a_turning_circle_is_paved_but_a_loop_goes_round_something(kind: str, middle: LaneType) -> None:
    case = Case(_LINE, {1: ("w o", "width=6 lanes=2")}, node_tags={"o": f"highway={kind}"})
    ((_, loop),) = _loops(_built(case, Rule.RIGHT_HAND))
    (inner,) = (lane for lane in loop.lane_sections[0].lanes if lane.id > 0)
    assert inner.type is middle
    assert max(width.a for width in inner.widths) == pytest.approx(6.0 - 1.5 - 0.05, abs=0.02)


@EITHER
def test_lanes_go_round_one_middle_side_by_side(rule: Rule) -> None:
    case = Case(_LINE, {1: ("w o", "lanes=4 width=12")}, node_tags={"o": "highway=turning_loop diameter=30"})
    roads = _built(case, rule)
    assert_sound(roads)
    radii = sorted(1 / abs(records(roads.plan_view, k)[1][3]) for k, _ in _loops(roads))
    assert radii == pytest.approx([15.0 - 1.5 - 3.0, 15.0 - 1.5], abs=1e-6)
    assert min(smallest_radius_of(roads.plan_view, k) for k, _ in _loops(roads)) >= CONNECTING_RADIUS


@EITHER
def test_dead_ends_stay_unless_asked_for(rule: Rule) -> None:
    case = Case(
        {**_LINE, "n": (0.0, 90.0), "e": (90.0, 0.0)}, {1: ("w o", ""), 2: ("o n", ""), 3: ("o e", "oneway=yes")}
    )
    plain = _built(case, rule)
    assert len(plain.junctions) == 1
    closed = _built(case, rule, turnarounds=True)
    assert_sound(closed)
    assert len(closed.junctions) == 3
    side = -1 if rule is Rule.RIGHT_HAND else 1
    back = [link for link in built_links(closed) if link[0] == link[2]]
    assert back == [(1, -side, 1, side), (2, side, 2, -side)]
    for k, road in _loops(closed):
        if road.predecessor == road.successor:
            radius = 1 / abs(records(closed.plan_view, k)[1][3])
            assert CONNECTING_RADIUS <= radius <= 6.0


def test_a_loop_is_smaller_where_a_street_is_near() -> None:
    def radius(aside: float) -> float:
        nodes = {**_LINE, "a": (-60.0, aside), "b": (60.0, aside)}
        tags = {"o": "highway=turning_circle diameter=20"}
        roads = Case(nodes, {1: ("w o", ""), 2: ("a b", "")}, node_tags=tags).build()
        ((k, _),) = _loops(roads)
        return 1 / abs(records(roads.plan_view, k)[1][3])

    assert radius(60.0) == pytest.approx(8.5, abs=0.1)
    assert 3.0 <= radius(11.0) < 8.0


def test_where_there_is_no_room_the_dead_end_stays_and_that_is_reported() -> None:
    nodes = {**_LINE, "a": (-60.0, 6.5), "b": (60.0, 6.5)}
    near = Case(nodes, {1: ("w o", ""), 2: ("a b", "")}, node_tags={"o": "highway=turning_circle"})
    assert near.build().junctions == ()
    assert _codes(near) == [("no-room-to-turn", "node/1002")]
    short = Case({"w": (-4.0, 0.0), "o": (0.0, 0.0)}, {1: ("w o", "")}, node_tags={"o": "highway=turning_circle"})
    assert short.build().junctions == ()
    assert _codes(short) == [("no-room-to-turn", "node/1002")]
    above = Case(nodes, {1: ("w o", ""), 2: ("a b", "bridge=yes layer=1")}, node_tags={"o": "highway=turning_circle"})
    assert len(above.build().junctions) == 1


def test_two_loops_do_not_share_their_ground() -> None:
    nodes = {**_LINE, "e": (80.0, 0.0), "p": (10.0, 0.0)}
    tags = {"o": "highway=turning_circle", "p": "highway=turning_circle"}
    case = Case(nodes, {1: ("w o", ""), 2: ("p e", "")}, node_tags=tags)
    roads = case.build()
    places = [pose for k, _ in _loops(roads) for _, pose, _, _ in records(roads.plan_view, k)[1:2]]
    assert len(places) + len(_codes(case)) == 2


def test_no_u_turn_forbids_a_loop() -> None:
    rules = (("no_u_turn", 1, "o", 1),)
    case = Case(_LINE, {1: ("w o", "")}, rules, {"o": "highway=turning_circle"})
    assert case.build().junctions == ()


def test_a_loop_is_no_longer_than_its_circle_and_the_way_there() -> None:
    roads = Case(_LINE, {1: ("w o", "")}, node_tags={"o": "highway=turning_circle"}).build()
    ((_, loop),) = _loops(roads)
    assert RoadMeasures(roads).length(loop) < 2 * math.pi * 8.0


@pytest.mark.parametrize(("length", "loops"), [(14.0, 1), (60.0, 2)])
def test_a_short_street_has_no_room_for_loops_at_both_ends(length: float, loops: int) -> None:
    case = Case({"a": (0.0, 0.0), "b": (length, 0.0)}, {1: ("a b", "highway=living_street")})
    roads = case.build(turnarounds=True)
    assert len(roads.junctions) == loops
    assert all(road.lane_sections for road in roads.roads)
    assert all(records(roads.plan_view, k) for k in range(len(roads.roads)))


def _radius(roads: RoadMap) -> float:
    ((k, _),) = _loops(roads)
    return 1 / abs(records(roads.plan_view, k)[1][3])


def test_loops_at_other_dead_ends_have_the_circle_of_a_car() -> None:
    """A diameter of 12 m, less half of a lane of 2.5 m; however small a tagged one is, cars drive 3 m radius."""
    roads = Case(_LINE, {1: ("o w", "width=5 lanes=2")}, node_tags={"w": "highway=turning_circle diameter=2"}).build()
    assert _radius(roads) == pytest.approx(3.0, abs=1e-6)
    asked = Case(_LINE, {1: ("w o", "width=5 lanes=2")}).build(turnarounds=True)
    assert [1 / abs(records(asked.plan_view, k)[1][3]) for k, _ in _loops(asked)] == pytest.approx([4.75] * 2)


@pytest.mark.parametrize(("gap", "free"), [(0.6, True), (0.4, False)])
def test_half_a_metre_stays_free_beside_a_loop(gap: float, free: bool) -> None:
    """A circle of 15 m and a street of 6 m across the end of its own."""
    aside = 7.5 + gap + 3.0
    nodes = {**_LINE, "a": (aside, -60.0), "b": (aside, 60.0)}
    tags = {"o": "highway=turning_circle"}
    roads = Case(nodes, {1: ("w o", "width=6 lanes=2"), 2: ("a b", "width=6")}, node_tags=tags).build()
    assert (_radius(roads) == pytest.approx(6.0)) == free


@pytest.mark.parametrize("line", ["a b", "b a"])
def test_a_street_that_points_at_a_loop_is_as_far_away_as_its_end(line: str) -> None:
    """It is 6 m wide and ends 12 m from the middle: 9 m are free, and 8 m needed."""
    tags = {"o": "highway=turning_circle"}
    nodes = {**_LINE, "a": (3.0, 60.0), "b": (3.0, 12.0)}
    case = Case(nodes, {1: ("w o", "width=6 lanes=2"), 2: (line, "width=6")}, node_tags=tags)
    assert _radius(case.build()) == pytest.approx(6.0, abs=1e-6)


@pytest.mark.parametrize(("line", "drawn"), [("o p q r", 1), ("r q p o", -1)])
@pytest.mark.parametrize(("back", "near"), [(80.0, True), (50.0, False)])
def test_a_street_is_in_the_way_of_its_own_loop_where_it_comes_back(
    back: float, near: bool, line: str, drawn: int
) -> None:
    """Beside the circle, 9 m off, it is 169 m along itself away, or 109 m: it counts from 120 m on."""
    nodes = {"o": (0.0, 0.0), "p": (-back, 0.0), "q": (-back, 9.0), "r": (40.0, 9.0)}
    nodes |= {"x": (0.0, 300.0), "y": (400.0, 300.0)}
    ways = {1: ("x y", ""), 2: (line, "width=6 lanes=2")}
    roads = Case(nodes, ways, node_tags={"o": "highway=turning_circle"}).build()
    ((k, loop),) = _loops(roads)
    assert (_radius(roads) == pytest.approx(6.0, abs=1e-6)) != near
    assert 1 / abs(records(roads.plan_view, k)[1][3]) <= 6.0 + 1e-6
    assert loop.predecessor is not None
    assert loop.predecessor.at_start == (drawn > 0)


@pytest.mark.parametrize(("length", "loops"), [(15.9, 1), (16.2, 2)])
def test_two_loops_of_a_street_leave_a_road_of_two_metres(length: float, loops: int) -> None:
    """Circles of 12 m: their middles lie 7 m beyond the ends of the road."""
    beyond = math.sqrt((1.25 + 3.5 + 4.0) ** 2 - (1.25 + 4.0) ** 2)
    assert (length - 2 * beyond >= 2.0) == (loops == 2)
    case = Case({"a": (0.0, 0.0), "b": (length, 0.0)}, {1: ("a b", "width=5 lanes=2")})
    roads = case.build(turnarounds=True)
    assert len(roads.junctions) == loops
    (street,) = (road for road in roads.roads if road.junction is None)
    assert RoadMeasures(roads).length(street) == pytest.approx(length - loops * beyond, abs=0.01)
    reported = _codes(case, RoadOptions(turnarounds=True))
    assert reported == [("no-room-to-turn", "node/1002")] * (2 - loops)


def test_every_loop_has_the_lanes_of_its_own_street_at_its_end() -> None:
    """A street of two lanes that ends with four goes round in two lanes there, and in one at its other end."""
    nodes = {"a": (0.0, 0.0), "b": (100.0, 0.0), "c": (200.0, 0.0), "x": (0.0, 300.0), "y": (100.0, 300.0)}
    ways = {1: ("x y", "width=12 lanes=4"), 2: ("a b", "width=6 lanes=2"), 3: ("b c", "width=12 lanes=4")}
    circle = "highway=turning_circle diameter=30"
    roads = Case(nodes, ways, node_tags={"a": circle, "c": circle}).build()
    found = sorted(
        (records(roads.plan_view, k)[1][1].x, 1 / records(roads.plan_view, k)[1][3]) for k, _ in _loops(roads)
    )
    assert [radius for _, radius in found] == pytest.approx([13.5, 13.5, 10.5], abs=1e-6)


@pytest.mark.parametrize(
    ("aside", "radius"),
    [
        # A circle of 20 m is wished for: 8.5 m to the middle of the lane. The curb is 1.5 m beyond, 0.5 m are free.
        (13.6, 8.5),
        (13.4, 5.75),
        (10.8, 5.75),
        # Half of the way to the least circle, of 3 m; then that one.
        (10.7, 3.0),
        (8.1, 3.0),
    ],
)
def test_loops_shrink_in_two_steps(aside: float, radius: float) -> None:
    nodes = {**_LINE, "a": (-60.0, aside), "b": (60.0, aside)}
    tags = {"o": "highway=turning_circle diameter=20"}
    roads = Case(nodes, {1: ("w o", "width=6 lanes=2"), 2: ("a b", "width=6 lanes=2")}, node_tags=tags).build()
    assert _radius(roads) == pytest.approx(radius, abs=1e-6)


@pytest.mark.parametrize(("diameter", "radius"), [(2.0, 3.25), (7.0, 3.25), (9.0, 3.75)])
def test_a_circle_has_eight_metres_at_least(diameter: float, radius: float) -> None:
    """Lanes of 1.5 m: their middle is three quarters of a metre from the kerb."""
    narrow = "lanes=2 width:lanes:forward=1.5 width:lanes:backward=1.5"
    tags = {"o": f"highway=turning_circle diameter={diameter}"}
    assert _radius(Case(_LINE, {1: ("w o", narrow)}, node_tags=tags).build()) == pytest.approx(radius)


def test_lanes_that_are_wide_need_little_more_than_half_a_circle() -> None:
    """Lanes of 5 m whose middles are 5 m apart, and the least circle, of 3 m radius."""
    tags = {"o": "highway=turning_circle diameter=8"}
    assert _radius(Case(_LINE, {1: ("w o", "width=10 lanes=2")}, node_tags=tags).build()) == pytest.approx(3.0)


@pytest.mark.parametrize("along", [0.0, 20.0, 40.0])
def test_a_long_street_is_seen_where_it_is_nearest(along: float) -> None:
    """A circle of 40 m and a street of 6 m whose middle line is 22 m away: 19 m are free."""
    nodes = {**_LINE, "a": (22.0, -80.0 - along), "b": (22.0, 80.0 - along)}
    tags = {"o": "highway=turning_circle diameter=40"}
    roads = Case(nodes, {1: ("w o", "width=6 lanes=2"), 2: ("a b", "width=6")}, node_tags=tags).build()
    # Half of the way to the least circle.
    assert _radius(roads) == pytest.approx((18.5 + 3.0) / 2)


def test_loops_are_movements_of_junctions_of_their_own() -> None:
    nodes = {**_LINE, "e": (80.0, 0.0), "n": (0.0, 80.0)}
    case = Case(nodes, {1: ("w o", ""), 2: ("o e", ""), 3: ("n o", "")}, node_tags={"e": "highway=turning_circle"})
    stages = case.stages()
    fitted = fit_streets(stages.network, Diagnostics())
    found = [
        add_turnarounds(
            stages.network, fitted, stages.ends, stages.layout, RoadOptions(turnarounds=asked), Diagnostics()
        )
        for asked in (False, True)
    ]
    (layout, (only,)), (_, every) = found
    end = stages.end(2, 2)
    assert (only.junction, only.entry, only.exit, only.inner, only.stated) == (1, end, end, (), None)
    assert (layout.arms[1], layout.nodes[1]) == ((end,), (int(stages.ends.node[end]),))
    assert layout.junction[end] == 1
    assert [item.junction for item in every] == [1, 2, 3]
    assert {item.entry for item in every} == {stages.end(1, 0), end, stages.end(3, 3)}
    # The junction that was there, and what it takes of its arms, have stayed.
    assert layout.arms[0] == stages.layout.arms[0]
    rest = np.arange(6) != end
    assert layout.trim[rest].tolist() == stages.layout.trim[rest].tolist()
    assert layout.trim[end] > 0.0


# ---------------------------------------------------------------- loops as curves


def _paths(*places: tuple[float, float, float]) -> PlanView:
    """Return straight paths of 1 m from places (x, y, heading)."""
    x, y, hdg = (np.array(column) for column in zip(*places, strict=True))
    n = len(places)
    return PlanView(np.arange(n + 1), np.zeros(n), x, y, hdg, np.ones(n), np.zeros(n))


@pytest.mark.parametrize("left", [False, True])
def test_loops_of_lanes_side_by_side_go_round_one_middle(left: bool) -> None:
    """Two lanes there and two back, 3 m wide, the inner lane listed first; another loop has one lane."""
    side = 1.0 if left else -1.0
    plan = _paths((0.0, side * 1.5, 0.0), (7.0, 7.0, 1.0), (0.0, side * 4.5, 0.0), (100.0, side * 2.0, 0.0))
    loop = [Loop(3.0, 5.0), Loop(3.0, 5.0), Loop(1.0, 4.0)]
    half = np.array([1.5, 4.5, 2.0])
    found = draw_loops(plan, np.array([0, 2, 3]), np.array([8, 8, 3]), loop, half, left)
    # Circles that touch from outside: their middles are as far apart as both radii together.
    beyond = [math.sqrt((4.5 + 3.0 + 5.0) ** 2 - (4.5 + 5.0) ** 2), math.sqrt(7.0**2 - 6.0**2)]
    length = lengths(found)
    for k, t, away, radius in ((0, 1.5, beyond[0], 4.5), (2, 4.5, beyond[0], 7.5), (3, 2.0, beyond[1], 3.0)):
        x0 = 100.0 if k == 3 else 0.0
        x, y, hdg = (float(v[0]) for v in pose(found, np.array([k]), length[[k]]))
        # It comes back beside where it began, on the other side of the road.
        assert (x, y) == pytest.approx((x0, -side * t), abs=1e-9)
        assert math.cos(hdg) == pytest.approx(-1.0)
        out, round_, back = records(found, k)
        assert 1 / abs(round_[3]) == pytest.approx(radius)
        assert np.sign([out[3], round_[3], back[3]]).tolist() == [side, -side, side]
        x, y, _ = (float(v[0]) for v in pose(found, np.array([k]), length[[k]] / 2))
        assert (x, y) == pytest.approx((x0 + away + radius, 0.0), abs=1e-9)
    # What is no loop stays.
    assert records(found, 1) == records(plan, 1)


@pytest.mark.parametrize(("aside", "whole"), [(0.0, False), (0.04, False), (0.06, True)])
def test_lanes_far_apart_turn_in_half_a_circle(aside: float, whole: bool) -> None:
    """Two lanes 16 m apart; less than 5 cm more of radius are not worth curves before and after it."""
    found = draw_loops(
        _paths((0.0, -8.0, 0.0)), np.array([0]), np.array([0]), [Loop(aside, 3.0)], np.array([8.0]), False
    )
    length = lengths(found)
    assert (length[0] == pytest.approx(8.0 * math.pi)) != whole
    x, y, hdg = (float(v[0]) for v in pose(found, np.array([0]), length))
    assert (x, y, math.cos(hdg)) == pytest.approx((0.0, 8.0, -1.0), abs=1e-9)


def test_without_loops_curves_stay() -> None:
    plan = _paths((0.0, 0.0, 0.0))
    none = np.zeros(0, np.int64)
    assert draw_loops(plan, none, none, [], np.zeros(0), False) is plan
