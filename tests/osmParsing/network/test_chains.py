import itertools

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from osm2xodr.model import FloatArray
from osm2xodr.osmParsing.network.streets import make_chains


def nowhere(pieces: int) -> tuple[FloatArray, FloatArray]:
    """All nodes, and the nodes next to the ends of pieces, at one place: nothing turns on the spot."""
    return np.zeros((128, 2)), np.zeros((2 * pieces, 2))


def chains(text: str) -> list[str]:
    """Make chains of pieces such as ``ab a>b``: from node to node, one-way along (>), against (<) or not.

    Chains are written as the nodes that they run through, rings with a star.
    """
    pieces = [(item[0], item[-1], {2: 0}.get(len(item), 1 if ">" in item else -1)) for item in text.split()]
    start, end, flow = (np.array([values[k] for values in pieces]) for k in range(3))
    letters = np.array([ord(letter) for letter in start]), np.array([ord(letter) for letter in end])
    out = []
    for chain in make_chains(*letters, flow, *nowhere(len(flow))):
        ends = [(start[piece], end[piece]) if along else (end[piece], start[piece]) for piece, along in chain.links]
        assert all(one[1] == next_one[0] for one, next_one in itertools.pairwise(ends))
        out.append("".join(one for one, _ in ends) + ends[-1][1] + "*" * chain.ring)
    return out


@pytest.mark.parametrize(
    ("pieces", "expected"),
    [
        ("ab", ["ab"]),
        ("ab bc", ["abc"]),
        # What is two-way between one-ways head on goes with the lower of them, from wherever the walk comes.
        ("a>b bc c<d", ["abc", "dc"]),
        ("c<d bc a>b", ["dcb", "ab"]),
        ("cb a>b c<d", ["abc", "dc"]),
        ("cb d>c a>b", ["dcb", "ab"]),
        # The lowest piece gives a two-way chain its direction, wherever in the chain it stands.
        ("cb ba", ["cba"]),
        ("cb ab", ["cba"]),
        ("bc cd ab", ["abcd"]),
        ("cb cd ab", ["dcba"]),
        # Where three meet, chains end.
        ("ab bc bd", ["ab", "bc", "bd"]),
        ("ab cb db", ["ab", "cb", "db"]),
        # Chains run along their one-way pieces.
        ("a>b b>c", ["abc"]),
        ("a<b b<c", ["cba"]),
        ("ab b<c", ["cba"]),
        ("ab c>b", ["cba"]),
        ("ab bc c<d de", ["edcba"]),
        # Head on, nothing runs through.
        ("a>b c>b", ["ab", "cb"]),
        ("a<b b>c", ["ba", "bc"]),
        # Against each other with two-way pieces between: broken where the second one begins.
        ("a>b bc d>c", ["abc", "dc"]),
        ("a>b bc cd e>d", ["abcd", "ed"]),
        ("a<b bc c>d", ["cba", "cd"]),
        ("a>b bc c<d de e>f", ["abc", "edc", "ef"]),
        # Rings.
        ("ab bc ca", ["abca*"]),
        ("aa", ["aa*"]),
        ("a>a", ["aa*"]),
        ("a<a", ["aa*"]),
        ("a<b b<c c<a", ["acba*"]),
        ("ab b>c ca", ["abca*"]),
        ("ab b<c ca", ["acba*"]),
        ("a>b b>c a>c", ["abc", "ac"]),
        ("a>b bc c<d da", ["abc", "adc"]),
        # A ring on a stalk, and two rings that touch.
        ("ab bc cd db", ["ab", "bcdb"]),
        ("ab ba ac ca", ["aba", "aca"]),
        ("ab bb", ["ab", "bb"]),
    ],
)
def test_chains(pieces: str, expected: list[str]) -> None:
    assert chains(pieces) == expected


@given(
    st.lists(st.tuples(st.integers(0, 9), st.integers(0, 9), st.sampled_from([-1, 0, 0, 1])), min_size=1, max_size=25)
)
@settings(deadline=None)
def test_every_piece_is_in_one_chain_and_traffic_runs_along(pieces: list[tuple[int, int, int]]) -> None:
    start, end, flow = (np.array(column) for column in zip(*pieces, strict=True))
    made = make_chains(start, end, flow, *nowhere(len(flow)))
    assert sorted(piece for chain in made for piece, _ in chain.links) == list(range(len(pieces)))
    lowest = [min(chain.links)[0] for chain in made]
    assert lowest == sorted(lowest)
    degree = np.bincount(np.concatenate([start, end]), minlength=10)
    for chain in made:
        ends = [(start[piece], end[piece]) if along else (end[piece], start[piece]) for piece, along in chain.links]
        for (_, joint), (other, _) in itertools.pairwise(ends):
            assert joint == other
            assert degree[joint] == 2
        runs = {int(flow[piece]) if along else -int(flow[piece]) for piece, along in chain.links}
        assert -1 not in runs
        if runs == {0}:
            assert min(chain.links)[1]
        if chain.ring:
            assert ends[0][0] == ends[-1][1]
            assert degree[ends[0][0]] == 2


@pytest.mark.parametrize(
    ("forbidden", "flow", "made"),
    [
        ((), (0, 0), 1),
        # From the end of piece 0 to the start of piece 1, and back.
        (((1, 2),), (0, 0), 2),
        (((2, 1),), (0, 0), 2),
        (((2, 1),), (1, 1), 1),  # nobody drives back anyway
        (((1, 2),), (1, 1), 2),
        (((1, 2),), (-1, 0), 1),
    ],
)
def test_a_chain_ends_where_restrictions_forbid_to_go_on(
    forbidden: tuple[tuple[int, int], ...], flow: tuple[int, int], made: int
) -> None:
    start, end = np.array([0, 1]), np.array([1, 2])
    assert len(make_chains(start, end, np.array(flow), *nowhere(2), frozenset(forbidden))) == made


def test_a_chain_ends_where_it_would_turn_on_the_spot() -> None:
    start, end, flow = np.array([0, 1]), np.array([1, 2]), np.zeros(2, np.int64)
    points = np.array([[0.0, 0.0], [30.0, 0.0], [0.0, 1.0]])
    neighbour = points[[1, 0, 2, 1]]
    assert len(make_chains(start, end, flow, points, neighbour)) == 2
    points[2] = [60.0, 1.0]
    assert len(make_chains(start, end, flow, points, points[[1, 0, 2, 1]])) == 1
