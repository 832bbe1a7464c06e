"""Which nodes become one junction, and how far it reaches along its arms."""

from __future__ import annotations

import math

import numpy as np
import pytest
from street_cases import Case, Stages

from osm2xodr.geometry.junctions.clusters import _share_streets


def two_ts(apart: float, tags: str = "", between: str = "") -> Case:
    """Make two Ts at both ends of way 5, with arms to the south and to the north."""
    nodes = {"w": (-90.0, 0.0), "a": (0.0, 0.0), "b": (apart, 0.0), "e": (apart + 90.0, 0.0)}
    nodes |= {"s": (0.0, -90.0), "n": (apart, 90.0)}
    ways = {1: ("w a", tags), 2: ("b e", tags), 3: ("s a", tags), 4: ("b n", tags), 5: ("a b", between or tags)}
    return Case(nodes, ways)


def trims(stages: Stages) -> dict[tuple[int, int], float]:
    """Return what each street gives at its start (0) and at its end (1), by way."""
    trim = stages.layout.trim.tolist()
    return {(stages.way(end), end % 2): trim[end] for end in range(len(trim))}


def test_a_node_of_two_streets_is_no_junction() -> None:
    case = Case({"a": (0.0, 0.0), "b": (50.0, 0.0), "c": (90.0, 10.0)}, {1: ("a b", ""), 2: ("b c", "oneway=yes")})
    stages = case.stages()
    assert stages.layout.arms == ()
    assert not stages.layout.trim.any()


def test_a_crossing_gives_every_arm_half_the_other_street_and_a_kerb() -> None:
    nodes = {"w": (-80.0, 0.0), "o": (0.0, 0.0), "e": (80.0, 0.0), "s": (0.0, -80.0), "n": (0.0, 80.0)}
    ways = {1: ("w o", "width=7"), 2: ("o e", "width=7"), 3: ("s o", "width=5"), 4: ("o n", "width=5")}
    stages = Case(nodes, ways).stages()
    found = trims(stages)
    clear = 0.3 + 0.5 + 6.0
    assert (found[(1, 1)], found[(2, 0)]) == pytest.approx((2.5 + clear, 2.5 + clear), abs=0.05)
    assert (found[(3, 1)], found[(4, 0)]) == pytest.approx((3.5 + clear, 3.5 + clear), abs=0.05)
    assert (found[(1, 0)], found[(2, 1)], found[(3, 0)], found[(4, 1)]) == (0.0, 0.0, 0.0, 0.0)
    assert stages.layout.nodes == ((int(stages.ends.node[stages.end(1, 1)]),),)


# A street of 6 m takes 3.8 m of a street that crosses it (3 m, 0.3 m gap, 0.5 m clearance); 6 m must be left.
@pytest.mark.parametrize(("apart", "junctions"), [(4.0, 1), (10.8, 1), (13.5, 1), (13.7, 2), (30.0, 2)])
def test_nodes_join_where_the_street_between_them_has_no_room(apart: float, junctions: int) -> None:
    layout = two_ts(apart).stages().layout
    assert len(layout.arms) == junctions
    assert int(layout.inner.sum()) == (1 if junctions == 1 else 0)
    assert sum(len(nodes) for nodes in layout.nodes) == 2
    assert sorted(len(arms) for arms in layout.arms) == ([4] if junctions == 1 else [3, 3])


def test_wide_streets_join_farther_apart() -> None:
    assert len(two_ts(17.0, "lanes=4").stages().layout.arms) == 2
    assert len(two_ts(15.0, "lanes=4").stages().layout.arms) == 1


def test_a_bridge_between_two_junctions_stays_a_road() -> None:
    layout = two_ts(8.1, "", "bridge=yes layer=1").stages().layout
    assert len(layout.arms) == 2
    assert not layout.inner.any()


@pytest.mark.parametrize(
    ("around", "between", "junctions"),
    [
        ("bridge=yes layer=1", "bridge=yes layer=1", 1),
        ("tunnel=yes layer=-1", "tunnel=yes layer=-1", 1),
        ("layer=-1", "tunnel=yes layer=-1", 2),
    ],
)
def test_nodes_join_within_one_bridge_or_tunnel(around: str, between: str, junctions: int) -> None:
    layout = two_ts(10.0, around, between).stages().layout
    assert len(layout.arms) == junctions
    assert int(layout.inner.sum()) == 2 - junctions


def dual_carriageway(apart: float, name: str = "Main") -> Case:
    """Make a street, ways 5 to 7, across two carriageways; the northern one has a name of its own."""
    nodes = {"w": (-90.0, 0.0), "a": (0.0, 0.0), "e": (90.0, 0.0), "s": (0.0, -90.0)}
    nodes |= {"w2": (-90.0, apart), "b": (0.0, apart), "e2": (90.0, apart), "n": (0.0, apart + 90.0)}
    tags = "oneway=yes lanes=2 name="
    rows = {1: "w a", 2: "a e", 3: "e2 b", 4: "b w2"}
    names = {1: "Main", 2: "Main", 3: name, 4: name}
    ways = {way: (row, tags + names[way]) for way, row in rows.items()}
    return Case(nodes, ways | {5: ("s a", ""), 6: ("a b", ""), 7: ("b n", "")})


# Each carriageway of 6 m takes 3.8 m of the street across, and its corners 6 m; 3 m would have to be left.
@pytest.mark.parametrize(("apart", "junctions"), [(10.0, 1), (16.0, 1), (22.0, 1), (23.0, 2), (30.0, 2)])
def test_both_carriageways_make_one_junction_where_corners_fill_the_median(apart: float, junctions: int) -> None:
    layout = dual_carriageway(apart).stages().layout
    assert len(layout.arms) == junctions
    assert sorted(len(arms) for arms in layout.arms) == ([6] if junctions == 1 else [4, 4])


def test_two_one_way_streets_of_other_names_are_no_dual_carriageway() -> None:
    layout = dual_carriageway(16.0, "Other").stages().layout
    assert sorted(len(arms) for arms in layout.arms) == [4, 4]


# A node of the street where people cross, 3.8 m or more from either end of it.
@pytest.mark.parametrize(("apart", "junctions"), [(11.0, 1), (12.0, 2)])
def test_a_street_with_room_for_its_crossing_stays(apart: float, junctions: int) -> None:
    case = two_ts(apart)
    ways = {**case.ways, 5: ("a x b", "")}
    crossed = Case({**case.nodes, "x": (apart / 2, 0.0)}, ways, node_tags={"x": "highway=crossing"})
    assert len(Case(crossed.nodes, ways).stages().layout.arms) == 1
    for found in (crossed, crossed.mirrored()):
        assert len(found.stages().layout.arms) == junctions


def test_a_street_beside_another_between_the_same_junctions_stays() -> None:
    """A loop begins and ends on one street, at nodes 12 m apart."""
    case = two_ts(12.0)
    nodes = {**case.nodes, "c": (-40.0, -50.0), "d": (52.0, -50.0)}
    ways = {1: case.ways[1], 2: case.ways[2], 3: ("a c d b", ""), 5: ("a b", "")}
    assert len(Case(nodes, ways).stages().layout.arms) == 2


@pytest.mark.parametrize(("degrees", "junctions"), [(90.0, 1), (25.0, 2)])
def test_a_street_stays_where_ways_over_it_would_cut_a_corner(degrees: float, junctions: int) -> None:
    """Two arms beyond b lie on each other for 14 m if they part at 25 degrees: a turn onto them would begin at a."""
    case = two_ts(12.0)
    x, y = 90.0 * math.sin(math.radians(degrees)), 90.0 * math.cos(math.radians(degrees))
    nodes = {**case.nodes, "x": (12.0 + x, y), "e": (12.0, -90.0)}
    ways = {**case.ways, 6: ("b x", "")}
    assert len(Case(nodes, ways).stages().layout.arms) == junctions


def test_a_ring_stays_apart_from_the_junction_beside_it() -> None:
    """A T 18 m from the middle of a roundabout: 4.7 m are left, and corners give way."""
    ring = {f"r{k}": (10 * math.cos(math.tau * k / 24), 10 * math.sin(math.tau * k / 24)) for k in range(24)}
    nodes = {**ring, "t": (21.5, 0.0), "e": (100.0, 0.0), "n": (21.5, 90.0), "w": (-90.0, 0.0)}
    ways = {1: (f"{' '.join(ring)} r0", "junction=roundabout width=6"), 2: ("r0 t", ""), 3: ("t e", "")}
    stages = Case(nodes, {**ways, 4: ("t n", ""), 5: ("r12 w", "")}).stages()
    assert sorted(len(found) for found in stages.layout.arms) == [3, 3, 3]
    street = stages.end(2, 0) // 2
    left = float(stages.ends.length[2 * street]) - float(stages.layout.trim[2 * street :][:2].sum())
    assert 3.0 <= left < 6.0
    assert stages.layout.squeezed[street]


def test_what_both_ends_of_a_street_may_give_leaves_room_for_a_car() -> None:
    stages = two_ts(60.0).stages()
    layout, end = stages.layout, stages.end(5, 1)
    assert float(layout.most[end] + layout.most[end ^ 1]) == pytest.approx(60.0 - 6.02, abs=0.01)
    assert layout.most[end] == pytest.approx(layout.most[end ^ 1], abs=0.05)
    alone = stages.end(1, 1)
    assert float(layout.most[alone]) == pytest.approx(90.0 - 1.02, abs=0.01)
    assert layout.least[[end // 2, alone // 2]].tolist() == [3.0, 1.0]


@pytest.mark.parametrize(("tags", "least"), [("", 1.0), ("highway=crossing", 3.0), ("highway=stop", 3.0)])
def test_dead_ends_with_furniture_keep_more(tags: str, least: float) -> None:
    nodes = {"w": (-80.0, 0.0), "o": (0.0, 0.0), "e": (80.0, 0.0), "c": (0.0, -10.0), "s": (0.0, -20.0)}
    stages = Case(nodes, {1: ("w o", ""), 2: ("o e", ""), 3: ("o c s", "")}, node_tags={"c": tags}).stages()
    assert stages.layout.least[stages.end(3, 1) // 2] == least


@pytest.mark.parametrize(
    ("ramp", "trim", "most"),
    # 9.8 m with the kerb; setbacks leave 4 m before the bridge.
    [(30.0, 9.8, 26.0), (16.0, 9.8, 12.0), (12.0, 9.8, 9.8)],
)
def test_setbacks_leave_a_ramp_before_a_bridge(ramp: float, trim: float, most: float) -> None:
    nodes = {
        "w": (-90.0, 0.0),
        "o": (0.0, 0.0),
        "e": (90.0, 0.0),
        "n": (0.0, 90.0),
        "p": (0.0, -ramp),
        "s": (0.0, -90.0),
    }
    ways = {1: ("w o", ""), 2: ("o e", ""), 3: ("o n", ""), 4: ("o p", ""), 5: ("p s", "bridge=yes layer=1")}
    stages = Case(nodes, ways).stages()
    (south,) = (end for end in stages.layout.arms[0] if abs(math.sin(stages.ends.hdg[end]) + 1.0) < 1e-6)
    assert float(stages.layout.trim[south]) == pytest.approx(trim, abs=0.05)
    assert float(stages.layout.most[south]) == pytest.approx(most, abs=0.05)


def test_bridges_shorter_than_a_road_can_be_lie_within_the_junction() -> None:
    layout = two_ts(7.9, "", "bridge=yes layer=1").stages().layout
    assert sorted(len(arms) for arms in layout.arms) == [4]


def test_what_is_left_between_two_junctions_is_shared() -> None:
    """Bare needs come first: kerbs give way until a road of 6 m is left."""
    stages = two_ts(15.0).stages()
    found = trims(stages)
    assert found[(5, 0)] + found[(5, 1)] == pytest.approx(15.0 - 6.02, abs=0.01)
    assert min(found[(5, 0)], found[(5, 1)]) >= 3.7
    assert not stages.layout.squeezed.any()
    far = trims(two_ts(60.0).stages())
    assert far[(5, 0)] == pytest.approx(far[(5, 1)], abs=0.02)
    assert far[(5, 0)] == pytest.approx(9.8, abs=0.05)


def test_no_junction_grows_without_end() -> None:
    """A row of Ts 8 m apart would be one junction of 150 m if there were no limit."""
    count = 20
    nodes = {"w": (-90.0, 0.0), "e": (8.0 * count + 90.0, 0.0)}
    ways = {1: ("w p0", "")}
    for k in range(count):
        nodes |= {f"p{k}": (8.0 * k, 0.0), f"s{k}": (8.0 * k, -60.0)}
        ways[10 + k] = (f"p{k} s{k}", "")
        ways[50 + k] = (f"p{k} p{k + 1}" if k + 1 < count else f"p{k} e", "")
    stages = Case(nodes, ways).stages()
    for members in stages.layout.nodes:
        x = [stages.network.intersections[node].x for node in members]
        assert max(x) - min(x) <= 60.0
    assert len(stages.layout.nodes) >= 3
    length = stages.ends.length[0::2]
    left = length - stages.layout.trim[0::2] - stages.layout.trim[1::2]
    assert (left[~stages.layout.inner] > 0).all()


def test_every_end_belongs_to_the_junction_that_lists_it() -> None:
    layout = two_ts(30.0).stages().layout
    for number, arms in enumerate(layout.arms):
        assert list(arms) == sorted(arms)
        assert {int(layout.junction[end]) for end in arms} == {number}
    listed = {end for arms in layout.arms for end in arms}
    assert all(int(layout.junction[end]) == -1 for end in range(len(layout.junction)) if end not in listed)


def test_the_order_of_ways_does_not_matter() -> None:
    case = two_ts(8.0)
    other = Case(case.nodes, dict(reversed(list(case.ways.items()))))
    assert trims(case.stages()) == trims(other.stages())


def test_the_order_of_nodes_does_not_matter() -> None:
    for case, arms in ((two_ts(8.0), 4), (dual_carriageway(16.0), 6)):
        names = list(case.nodes)
        for k in range(len(names)):
            nodes = {name: case.nodes[name] for name in names[k:] + names[:k]}
            # The ways at its first node come first, too.
            ways = dict(sorted(case.ways.items(), key=lambda item: names[k] not in item[1][0].split()))
            layout = Case(nodes, {n: row for n, (_, row) in enumerate(ways.items(), start=1)}).stages().layout
            assert [len(found) for found in layout.arms] == [arms]


@pytest.mark.parametrize(("length", "kept"), [(1.5, False), (9.0, False), (9.9, True)])
def test_a_dead_end_of_which_too_little_is_left_is_no_road(length: float, kept: bool) -> None:
    """A street of 12 m width takes more than 6 m of the one beside it; of the last 3 m corners take 2."""
    nodes = {"w": (-80.0, 0.0), "o": (0.0, 0.0), "e": (80.0, 0.0), "s": (0.0, -length)}
    wide = "lanes=2 width:lanes:forward=6 width:lanes:backward=6"
    stages = Case(nodes, {1: ("w o", wide), 2: ("o e", wide), 3: ("o s", "")}).stages()
    end = stages.end(3, 1)
    assert stages.layout.inner[end // 2] != kept
    if kept:
        assert 1.0 <= float(stages.ends.length[end]) - trims(stages)[(3, end % 2)] < 1.1


def test_branches_of_a_fork_at_the_edge_of_a_file_are_streets() -> None:
    """They lie on each other for all of their 50 m: 6 m apart at their ends."""
    nodes = {"w": (-80.0, 0.0), "o": (0.0, 0.0), "n": (50.0, 3.0), "s": (50.0, -3.0)}
    motorway = "highway=motorway oneway=yes lanes=2"
    stages = Case(nodes, {1: ("w o", motorway), 2: ("o n", motorway), 3: ("o s", motorway)}).stages()
    assert not stages.layout.inner.any()
    assert [len(arms) for arms in stages.layout.arms] == [3]


@pytest.mark.parametrize(("count", "junctions"), [(8, 1), (9, 2)])
def test_a_row_of_ts_is_one_junction_up_to_60_m(count: int, junctions: int) -> None:
    """The Ts are 8 m apart: eight measure 56 m, nine 64 m."""
    nodes = {"w": (-90.0, 0.0), "e": (8.0 * count + 90.0, 0.0)}
    ways = {1: ("w p0", "")}
    for k in range(count):
        nodes |= {f"p{k}": (8.0 * k, 0.0), f"s{k}": (8.0 * k, -60.0)}
        ways[10 + k] = (f"p{k} s{k}", "")
        ways[50 + k] = (f"p{k} p{k + 1}" if k + 1 < count else f"p{k} e", "")
    assert len(Case(nodes, ways).stages().layout.arms) == junctions


@pytest.mark.parametrize(("apart", "junctions"), [(38.0, 1), (42.0, 2)])
def test_a_median_is_crossed_by_streets_of_up_to_40_m(apart: float, junctions: int) -> None:
    """Carriageways of 30 m take 15.8 m of the street across, and their corners 5 m: more than there is."""
    case = dual_carriageway(apart)
    wide = {way: (row, tags.replace("lanes=2", "lanes=10")) for way, (row, tags) in case.ways.items()}
    assert len(Case(case.nodes, wide).stages().layout.arms) == junctions


@pytest.mark.parametrize(("turned", "junctions"), [(33.0, 1), (41.0, 2)])
def test_carriageways_lie_square_to_the_street_across_them(turned: float, junctions: int) -> None:
    """Within 37 degrees they are crossed, beyond they are only met."""
    case = dual_carriageway(16.0)
    aside = 16.0 * math.tan(math.radians(turned))
    nodes = {name: (x + aside if y > 10.0 else x, y) for name, (x, y) in case.nodes.items()}
    assert len(Case(nodes, case.ways).stages().layout.arms) == junctions


@pytest.mark.parametrize(("apart", "junctions"), [(28.0, 1), (32.0, 2)])
def test_a_restriction_over_a_street_of_up_to_30_m_takes_it_into_the_junction(apart: float, junctions: int) -> None:
    case = two_ts(apart)
    restricted = Case(case.nodes, case.ways, (("no_left_turn", 3, "5", 4),))
    assert len(case.stages().layout.arms) == 2
    assert len(restricted.stages().layout.arms) == junctions


@pytest.mark.parametrize(("around", "kept"), [(17.0, False), (19.0, True)])
def test_a_ring_is_no_shorter_than_a_circle_that_a_car_drives(around: float, kept: bool) -> None:
    """Circumference of a circle of 3 m radius: 18.8 m."""
    radius, angles = around / math.tau, [math.tau * k / 24 for k in range(24)]
    nodes = {f"r{k}": (radius * math.cos(a), radius * math.sin(a)) for k, a in enumerate(angles)}
    ring = f"{' '.join(nodes)} r0"
    layout = Case({**nodes, "w": (-90.0, 40.0), "e": (90.0, 40.0)}, {1: (ring, ""), 2: ("w e", "")}).stages().layout
    assert bool(layout.inner.any()) == (not kept)


def test_where_a_street_turns_on_the_spot_its_arms_keep_their_length() -> None:
    """At 10 degrees they lie on each other for 35 m; slow ones end 12 m out, fast ones where they part."""
    x, y = 90.0 * math.cos(math.radians(10.0)), 90.0 * math.sin(math.radians(10.0))
    nodes = {"o": (0.0, 0.0), "e": (90.0, 0.0), "n": (x, y)}
    slow = Case(nodes, {1: ("e o", "width=6"), 2: ("o n", "width=6 oneway=yes")}).stages()
    assert trims(slow)[(1, 1)] == pytest.approx(12.5, abs=1e-6)
    fast = Case(nodes, {1: ("e o", "highway=trunk width=6"), 2: ("o n", "highway=trunk_link width=6 oneway=yes")})
    assert trims(fast.stages())[(1, 1)] > 30.0


@pytest.mark.parametrize(
    ("highway", "kerb"),
    [("secondary", 6.0), ("residential", 5.0), ("living_street", 4.0), ("service", 4.0)],
)
def test_kerbs_have_the_radius_of_the_lesser_street(highway: str, kerb: float) -> None:
    nodes = {"w": (-80.0, 0.0), "o": (0.0, 0.0), "e": (80.0, 0.0), "s": (0.0, -80.0)}
    ways = {1: ("w o", "width=6"), 2: ("o e", "width=6"), 3: ("s o", f"highway={highway} width=6")}
    assert trims(Case(nodes, ways).stages())[(3, 1)] == pytest.approx(3.0 + 0.3 + 0.5 + kerb, abs=0.05)


@pytest.mark.parametrize(("highway", "reach"), [("tertiary", 40.0), ("motorway_link", 100.0)])
def test_a_junction_reaches_only_so_far_along_arms_that_lie_on_each_other(highway: str, reach: float) -> None:
    """At 2 degrees the edges of both part some 180 m from the node."""
    x, y = 300.0 * math.cos(math.radians(2.0)), 300.0 * math.sin(math.radians(2.0))
    nodes = {"w": (-300.0, 0.0), "o": (0.0, 0.0), "e": (300.0, 0.0), "n": (x, y)}
    tags = f"highway={highway} oneway=yes width=6"
    found = trims(Case(nodes, {1: ("w o", tags), 2: ("o e", tags), 3: ("o n", tags)}).stages())
    assert (found[(2, 0)], found[(3, 0)]) == pytest.approx((reach + 0.5, reach + 0.5), abs=1e-6)


@pytest.mark.parametrize(
    ("tags", "joined"),
    [
        ({}, True),
        # Where the name is missing the number is that of the road; where both are, its class.
        ({1: "ref=B7", 2: "ref=B7", 3: "ref=B7", 4: "ref=B7"}, True),
        ({1: "ref=B7", 2: "ref=B7", 3: "ref=B8", 4: "ref=B8"}, False),
        ({1: "name=A ref=B7", 2: "name=A ref=B7", 3: "name=B ref=B7", 4: "name=B ref=B7"}, False),
        ({3: "highway=secondary", 4: "highway=secondary"}, False),
    ],
)
def test_carriageways_of_one_road_have_one_name_number_or_class(tags: dict[int, str], joined: bool) -> None:
    case = dual_carriageway(16.0)
    ways = {way: (row, f"oneway=yes lanes=2 {tags.get(way, '')}") for way, (row, _) in case.ways.items() if way < 5}
    layout = Case(case.nodes, {**case.ways, **ways}).stages().layout
    assert sorted(len(arms) for arms in layout.arms) == ([6] if joined else [4, 4])


@pytest.mark.parametrize("reversed_ways", [(), (1, 2, 3, 4), (6,), (1, 6), (2, 4)])
def test_it_does_not_matter_which_way_carriageways_are_drawn(reversed_ways: tuple[int, ...]) -> None:
    case = dual_carriageway(16.0)
    ways = dict(case.ways)
    for way in reversed_ways:
        row, tags = ways[way]
        ways[way] = (" ".join(reversed(row.split())), tags.replace("oneway=yes", "oneway=-1"))
    assert sorted(len(arms) for arms in Case(case.nodes, ways).stages().layout.arms) == [6]


@pytest.mark.parametrize(
    "tags",
    [
        # Both run the same way; two-way streets.
        {1: ("w a", "oneway=yes"), 2: ("a e", "oneway=yes"), 3: ("w2 b", "oneway=yes"), 4: ("b e2", "oneway=yes")},
        {1: ("w a", ""), 2: ("a e", ""), 3: ("e2 b", ""), 4: ("b w2", "")},
        {1: ("w a", ""), 2: ("a e", ""), 3: ("e2 b", "oneway=yes"), 4: ("b w2", "oneway=yes")},
        {1: ("w a", "oneway=yes"), 2: ("a e", "oneway=yes"), 3: ("e2 b", ""), 4: ("b w2", "")},
    ],
)
def test_streets_that_do_not_run_opposite_ways_are_no_carriageways(tags: dict[int, tuple[str, str]]) -> None:
    case = dual_carriageway(16.0)
    ways = {way: (row, f"{text} lanes=2 name=Main") for way, (row, text) in tags.items()}
    layout = Case(case.nodes, {**case.ways, **ways}).stages().layout
    assert sorted(len(arms) for arms in layout.arms) == [4, 4]


@pytest.mark.parametrize("turned", range(0, 360, 45))
def test_it_does_not_matter_where_the_network_turns_to(turned: int) -> None:
    case = dual_carriageway(16.0)
    c, s = math.cos(math.radians(turned)), math.sin(math.radians(turned))
    nodes = {name: (c * x - s * y, s * x + c * y) for name, (x, y) in case.nodes.items()}
    assert sorted(len(arms) for arms in Case(nodes, case.ways).stages().layout.arms) == [6]


@pytest.mark.parametrize(("turned", "joined"), [(34.0, True), (40.0, False)])
def test_carriageways_run_opposite_ways_within_37_degrees(turned: float, joined: bool) -> None:
    """Either is turned by half of the angle, so that the street across stays square to both."""
    half = math.radians(turned / 2)
    c, s = 90.0 * math.cos(half), 90.0 * math.sin(half)
    case = dual_carriageway(16.0)
    nodes = {**case.nodes, "w": (-c, s), "e": (c, -s), "w2": (-c, 16.0 - s), "e2": (c, 16.0 + s)}
    found = [len(arms) for arms in Case(nodes, case.ways).stages().layout.arms]
    assert sorted(found) == ([6] if joined else [4, 4])


@pytest.mark.parametrize(("degrees", "nodes"), [(25.0, [3]), (90.0, [1, 2])])
def test_a_junction_that_has_grown_may_have_no_room_beside_the_next_one(degrees: float, nodes: list[int]) -> None:
    """Ts at a, b and c: a and b are one junction, whose arm at 25 degrees lies on the street to c for 14 m."""
    places = {"w": (-90.0, 0.0), "a": (0.0, 0.0), "b": (8.0, 0.0), "c": (22.0, 0.0), "e": (110.0, 0.0)}
    places |= {"s": (8.0, -90.0), "t": (22.0, -90.0)}
    places["n"] = (90.0 * math.cos(math.radians(degrees)), 90.0 * math.sin(math.radians(degrees)))
    ways = {1: ("w a", ""), 2: ("a n", ""), 3: ("a b", ""), 4: ("b s", ""), 5: ("b c", ""), 6: ("c t", "")}
    layout = Case(places, {**ways, 7: ("c e", "")}).stages().layout
    assert sorted(len(found) for found in layout.nodes) == nodes


@pytest.mark.parametrize("rows", [("o e", "o n"), ("e o", "n o")])
@pytest.mark.parametrize("first", ["o", "e"])
def test_where_nobody_can_turn_arms_end_apart(rows: tuple[str, str], first: str) -> None:
    """One-way streets that part or merge at 10 degrees lie on each other for 35 m."""
    x, y = 90.0 * math.cos(math.radians(10.0)), 90.0 * math.sin(math.radians(10.0))
    places = {"o": (0.0, 0.0), "e": (90.0, 0.0), "n": (x, y)}
    ways = {k: (row, "oneway=yes lanes=2 width=6") for k, row in enumerate(rows, start=1)}
    stages = Case({first: places[first], **places}, ways).stages()
    end = int(rows[0] == "e o")
    apart = (3.0 * (1 + math.cos(math.radians(10.0))) + 0.3) / math.sin(math.radians(10.0)) + 0.5
    assert [trims(stages)[(way, end)] for way in (1, 2)] == pytest.approx([apart, apart], abs=0.1)


def test_between_the_arms_of_a_small_roundabout_three_metres_of_road_are_enough() -> None:
    """Quarters of 10.2 m, of which crossing arms take 7.6 m at least, and 8 m more for their corners."""
    ring = {f"r{k}": (6.5 * math.cos(math.tau * k / 24), 6.5 * math.sin(math.tau * k / 24)) for k in range(24)}
    arms = {f"a{k}": (80.0 * math.cos(math.tau * k / 4), 80.0 * math.sin(math.tau * k / 4)) for k in range(4)}
    ways = {1: (f"{' '.join(ring)} r0", "junction=roundabout width=6")}
    ways |= {2 + k: (f"r{6 * k} a{k}", "width=6") for k in range(4)}
    stages = Case({**ring, **arms}, ways).stages()
    assert sorted(len(found) for found in stages.layout.arms) == [3] * 4
    length, trim = stages.ends.length[0::2], stages.layout.trim
    left = (length - trim[0::2] - trim[1::2])[stages.ends.roundabout[0::2]]
    assert left == pytest.approx(np.full(4, 3.02), abs=1e-6)
    assert stages.layout.squeezed[stages.ends.roundabout[0::2]].all()


@pytest.mark.parametrize(
    ("length", "bare", "wished", "given", "squeezed"),
    [
        # Corners have room; some of it, in equal shares; none.
        (16.0, (3.0, 4.0), (5.0, 7.0), (5.0, 7.0), False),
        (13.0, (3.0, 4.0), (5.0, 7.0), (3.8, 5.2), False),
        (11.0, (3.0, 4.0), (5.0, 7.0), (3.0, 4.0), False),
        (10.1, (3.0, 4.0), (5.0, 7.0), (3.0, 4.0), False),
        # Less than is needed: a road of 3.02 m is left, half of the street where that is less than 6.04 m.
        (8.02, (3.0, 4.5), (5.0, 7.0), (2.0, 3.0), True),
        (1.5, (3.0, 4.5), (5.0, 7.0), (0.3, 0.45), True),
        # A dead end that needs little.
        (1.2, (0.5, 0.0), (0.5, 0.0), (0.5, 0.0), False),
        (1.2, (0.0, 0.0), (0.0, 0.0), (0.0, 0.0), False),
        (20.0, (0.0, 4.0), (0.0, 4.0), (0.0, 4.0), False),
    ],
)
def test_streets_are_shared_by_need_first(
    length: float,
    bare: tuple[float, float],
    wished: tuple[float, float],
    given: tuple[float, float],
    squeezed: bool,
) -> None:
    least = np.array([4.0])
    trim, tight = _share_streets(np.array([length]), np.array([bare]), np.array([wished]), least)
    assert trim.tolist() == [pytest.approx(given)]
    assert tight.tolist() == [squeezed]
