"""Sidewalks of streets in towns, and hard shoulders of motorways, whose tags say nothing of any.

Nearly all streets in towns have sidewalks, few are tagged. A side gets one unless something shows that there is none:
the way's tags, a footway mapped apart, or another street that runs beside it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence, Set
from dataclasses import replace
from functools import lru_cache
from typing import Final

import numpy as np

from osm2xodr.curves import PointTree, cosine, hypot, running_lengths
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.model import (
    BoolArray,
    Direction,
    FloatArray,
    Footway,
    IntArray,
    LaneSpec,
    LaneType,
    MarginSpec,
    Rule,
    Street,
    StreetAttributes,
    Structure,
)
from osm2xodr.osmParsing.defaults import (
    BESIDE_SPACING,
    ROADSIDE_REACH,
    SHOULDER_WIDTH,
    SIDEWALK_CLASSES,
    SIDEWALK_WIDTH,
)
from osm2xodr.osmParsing.roadside.footway_matches import LEFT, RIGHT, join_like_pieces
from osm2xodr.osmParsing.roadside.reach import LineSamples, StreetSamples, sample_lines, with_pieces
from osm2xodr.osmParsing.tags import (
    LEFT_RIGHT,
    is_town_street,
    kerb_height,
    near_side,
    tells_of_shoulders,
    tells_of_sidewalks,
)
from osm2xodr.system import record

# Lines whose headings differ by at most this run beside each other, degrees; a choice.
_BESIDE_DEG: Final = 30.0
# Share of a piece's length that must be free of what rules a sidewalk out; a choice.
_FREE_MIN: Final = 0.7
# Between the carriageways of one street farther apart than this, m, people may walk; a choice.
_MEDIAN_MAX: Final = 25.0
# Number of points beside a place that are looked at.
_NEIGHBOURS: Final = 8

# Values of OSM's ``highway`` of carriageways with hard shoulders. Ramps have narrow ones or none.
_SHOULDER_CLASSES: Final = frozenset({"motorway"})
# The turns of lanes that go through. Exit and entry lanes take the place of the shoulder.
_THROUGH: Final = frozenset({"through", "none"})
# An exit lane without turns before the piece that tells them began at an entry, if at all, at most this far back, m.
# A choice: weaving lanes are shorter.
_LONGEST_WEAVING: Final = 1000.0


@record
class _Lines:
    """Points along whatever may rule a sidewalk out: streets and footways."""

    points: FloatArray  # (n, 2) m
    along: FloatArray  # (n, 2) Unit vectors
    street: IntArray  # (n,) Number of the street; -1 for footways
    left: FloatArray  # (n,) t of the left edge, m
    right: FloatArray  # (n,)
    name: IntArray  # (n,) Number of the name of a one-way street; -1 for others


def with_guessed_sidewalks(
    streets: tuple[Street, ...],
    points: LineSamples,
    footways: Sequence[Footway],
    tags: Mapping[int, Mapping[str, str]],
    dense: Set[int],
    diagnostics: Diagnostics,
) -> tuple[Street, ...]:
    """Give streets in towns the sidewalks that their tags do not mention.

    `points` lie along the streets, whatever their pieces; `tags` are those of ways by id; `dense` are the ids of the
    ways among residential streets. The diagnostics get each way that is given one.
    """
    pieces = [piece for street in streets for _, piece in street.pieces]
    chosen = {way for way, item in tags.items() if _may_have_untagged(item, way in dense)}
    # Whoever mapped footways along a part of a way would have mapped the others.
    chosen -= {piece.osm_way_id for piece in pieces if _has_sidewalk(piece)}
    open_sides = np.array([_open_sides(piece, piece.osm_way_id in chosen) for piece in pieces], np.bool_)
    if not open_sides.any():
        return streets
    samples = with_pieces(points, streets)
    lengths = samples.piece_lengths()
    lines = _lines(streets, samples, [footway for footway in footways if not footway.crossing])
    tree = PointTree(lines.points)
    free = np.zeros((len(pieces), 2), np.bool_)
    for side in (LEFT, RIGHT):
        rows = np.flatnonzero(open_sides[samples.piece, side])
        ruled_out = _ruled_out(samples, rows, side, lines, tree, ROADSIDE_REACH)
        of_two = np.flatnonzero(~ruled_out & (lines.name[rows] >= 0))
        ruled_out[of_two] = _ruled_out(samples, rows[of_two], side, lines, tree, _MEDIAN_MAX)
        share = np.bincount(samples.piece[rows], samples.lines.length[rows] * ~ruled_out, len(pieces))
        free[:, side] = open_sides[:, side] & (share >= _FREE_MIN * lengths)
    return _with_sidewalks(streets, free, tags, diagnostics)


def _may_have_untagged(tags: Mapping[str, str], dense: bool) -> bool:
    """Whether a way lies in a town, is of a class with sidewalks there, and says nothing of people on foot."""
    if tags["highway"] not in SIDEWALK_CLASSES or tells_of_sidewalks(tags):
        return False
    return is_town_street(tags, dense)


def _open_sides(piece: StreetAttributes, may_have: bool) -> tuple[bool, bool]:
    """Return for the left and right side whether a piece may get a sidewalk there."""
    if not may_have or piece.roundabout or piece.structure is Structure.TUNNEL:
        return False, False
    left, right = (
        all(strip.type is not LaneType.SHOULDER for strip in margin)
        for margin in (piece.margin_left, piece.margin_right)
    )
    return left, right


def _has_sidewalk(piece: StreetAttributes) -> bool:
    return any(strip.type is LaneType.SIDEWALK for strip in (*piece.margin_left, *piece.margin_right))


def _lines(streets: Sequence[Street], samples: StreetSamples, footways: Sequence[Footway]) -> _Lines:
    names: dict[str, int] = {}
    numbers = np.array(
        [
            names.setdefault(piece.name or piece.ref, len(names))
            if (piece.name or piece.ref) and len(piece.car_directions()) == 1
            else -1
            for street in streets
            for _, piece in street.pieces
        ],
        np.int64,
    )
    piece = samples.piece
    if footways:
        counts = np.array([len(footway.points) for footway in footways], np.int64)
        paths = sample_lines(np.concatenate([footway.points for footway in footways]), counts, BESIDE_SPACING)
    else:
        paths = sample_lines(np.zeros((1, 2)), np.ones(1, np.int64), BESIDE_SPACING)
    none, zeros = np.full(len(paths.points), -1, np.int64), np.zeros(len(paths.points))
    return _Lines(
        np.concatenate([samples.lines.points, paths.points]),
        np.concatenate([samples.lines.along, paths.along]),
        np.concatenate([samples.street[piece], none]),
        np.concatenate([samples.left[piece], zeros]),
        np.concatenate([samples.right[piece], zeros]),
        np.concatenate([numbers[piece], none]),
    )


def _ruled_out(
    samples: StreetSamples, rows: IntArray, side: int, lines: _Lines, tree: PointTree, reach: float
) -> BoolArray:
    """Return at which points of streets (rows of `samples`) a line within reach, m, rules a sidewalk out, (n,)."""
    sign = 1.0 if side == LEFT else -1.0
    (x, y), (ahead_x, ahead_y) = samples.lines.points[rows].T, samples.lines.along[rows].T
    out_x, out_y = -sign * ahead_y, sign * ahead_x
    edge = sign * (samples.left if side == LEFT else samples.right)[samples.piece[rows]]
    middle = edge + 0.5 * reach
    bound = float(hypot(0.5 * reach, BESIDE_SPACING))
    query = np.column_stack([x + middle * out_x, y + middle * out_y])
    _, near = tree.neighbours(query, _NEIGHBOURS, bound)
    # One row for each point of a street and each point of a line near it.
    at, _ = np.nonzero(near >= 0)
    found = near[near >= 0]
    away_x, away_y = lines.points[found, 0] - x[at], lines.points[found, 1] - y[at]
    # From this carriageway's edge to the other line.
    gap = away_x * out_x[at] + away_y * out_y[at] - edge[at]
    same_way = lines.along[found, 0] * ahead_x[at] + lines.along[found, 1] * ahead_y[at]
    beside = np.abs(away_x * ahead_x[at] + away_y * ahead_y[at]) <= BESIDE_SPACING
    beside &= np.abs(same_way) >= cosine(np.radians(_BESIDE_DEG))
    beside &= lines.street[found] != samples.street[samples.piece[rows]][at]
    # The other street's edge that faces this one.
    faces = np.where((same_way > 0.0) == (sign > 0.0), -lines.right[found], lines.left[found])
    street, own_name = lines.street[found] >= 0, lines.name[rows][at]
    one_street = street & (own_name >= 0) & (lines.name[found] == own_name)
    room = np.where(one_street, _MEDIAN_MAX, SIDEWALK_WIDTH)
    by_street = street & (gap > 0.0) & (gap - faces < room)
    by_footway = ~street & (gap > -SIDEWALK_WIDTH) & (gap < ROADSIDE_REACH)
    out = np.zeros(len(rows), np.bool_)
    out[at[beside & (by_street | by_footway)]] = True
    return out


def _with_sidewalks(
    streets: tuple[Street, ...], free: BoolArray, tags: Mapping[int, Mapping[str, str]], diagnostics: Diagnostics
) -> tuple[Street, ...]:
    """Append sidewalks to the margins of pieces, counted over all streets, where `free` (m, 2) says so."""
    # By identity and sides: the pieces of a way share their attributes.
    made: dict[tuple[int, bool, bool], StreetAttributes] = {}
    out: list[Street] = []
    every, number = free.tolist(), 0
    for street in streets:
        rows = every[number : number + len(street.pieces)]
        number += len(street.pieces)
        if any(left or right for left, right in rows):
            pieces = []
            for (first, piece), (left, right) in zip(street.pieces, rows, strict=True):
                key = id(piece), left, right
                if key not in made:
                    made[key] = _with_sidewalk_on(piece, left, right, tags[piece.osm_way_id])
                pieces.append((first, made[key]))
            street = join_like_pieces(replace(street, pieces=tuple(pieces)))
        out.append(street)
    words = f"no sidewalk tagged, one of {SIDEWALK_WIDTH:g} m assumed as streets in towns have them"
    for way in sorted({made[key].osm_way_id for key in made if any(key[1:])}):
        diagnostics.guessed("sidewalk", f"way/{way}", words)
    return tuple(out)


def _with_sidewalk_on(piece: StreetAttributes, left: bool, right: bool, tags: Mapping[str, str]) -> StreetAttributes:
    """Append sidewalks to the margins of a piece where it gets some; `tags` are those of its way."""
    margins = [piece.margin_left, piece.margin_right]
    for side, has_one in ((LEFT, left), (RIGHT, right)):
        if has_one:
            name = LEFT_RIGHT[side if not piece.reversed else 1 - side]
            margins[side] = _and_sidewalk(margins[side], kerb_height(tags, name, []))
    return replace(piece, margin_left=margins[LEFT], margin_right=margins[RIGHT]) if left or right else piece


@lru_cache(maxsize=4096)
def _and_sidewalk(margin: tuple[MarginSpec, ...], kerb: float) -> tuple[MarginSpec, ...]:
    """Return a margin with a sidewalk at its outer edge, one tuple for all equal ones; `kerb` is its height, m."""
    return (*margin, MarginSpec(LaneType.SIDEWALK, SIDEWALK_WIDTH, height=kerb))


def with_guessed_shoulders(
    streets: tuple[Street, ...], tags: Mapping[int, Mapping[str, str]], rule: Rule, diagnostics: Diagnostics
) -> tuple[Street, ...]:
    """Give carriageways of motorways the hard shoulders that their tags do not mention.

    They lie on the near side, beside a lane that goes through. `tags` are those of ways by id. The diagnostics get
    each way that is given one.
    """
    shoulder = (MarginSpec(LaneType.SHOULDER, SHOULDER_WIDTH["motorway"]),)
    reported: set[int] = set()
    out = []
    for street in streets:
        open_pieces = [
            _may_have_one(piece, rule) and not tells_of_shoulders(tags[piece.osm_way_id])
            for _, piece in street.pieces
        ]
        if any(open_pieces):
            auxiliary = _beside_auxiliary_lanes(street, rule)
            pieces = list(street.pieces)
            for k, (first, piece) in enumerate(pieces):
                if open_pieces[k] and not auxiliary[k]:
                    on_right = _on_right(piece, rule)
                    margins = (piece.margin_left, shoulder) if on_right else (shoulder, piece.margin_right)
                    pieces[k] = first, replace(piece, margin_left=margins[0], margin_right=margins[1])
                    reported.add(piece.osm_way_id)
            street = join_like_pieces(replace(street, pieces=tuple(pieces)))
        out.append(street)
    words = f"no shoulder tagged, one of {shoulder[0].width:g} m assumed as motorways have them"
    for way in sorted(reported):
        diagnostics.guessed("shoulder", f"way/{way}", words)
    return tuple(out)


def _on_right(piece: StreetAttributes, rule: Rule) -> bool:
    """Whether the near side of a one-way piece is its right one, seen along the street."""
    runs = Direction.FORWARD if Direction.FORWARD in piece.car_directions() else Direction.BACKWARD
    return near_side(runs, rule) == "right"


def _near_lane(piece: StreetAttributes, rule: Rule) -> LaneSpec:
    return piece.lanes_ltr[-1 if _on_right(piece, rule) else 0]


def _may_have_one(piece: StreetAttributes, rule: Rule) -> bool:
    """Whether a piece is a motorway's carriageway, not in a tunnel, without other strips at its near side."""
    if (
        piece.highway not in _SHOULDER_CLASSES
        or piece.structure is Structure.TUNNEL
        or len(piece.car_directions()) != 1
    ):
        return False
    margin = piece.margin_right if _on_right(piece, rule) else piece.margin_left
    return not margin and _near_lane(piece, rule).type is LaneType.DRIVING


def _beside_auxiliary_lanes(street: Street, rule: Rule) -> list[bool]:
    """Say of which pieces the near lane leads off or ends, as its turns or those of a piece behind tell."""
    pieces = [piece for _, piece in street.pieces]
    reach = running_lengths(street.points)
    begin = [float(reach[first]) for first, _ in street.pieces]
    out = [not _near_lane(piece, rule).turns <= _THROUGH for piece in pieces]
    along = Direction.FORWARD in pieces[0].car_directions()
    # From each piece whose turns tell it, against traffic.
    order = range(len(pieces) - 1, 0, -1) if along else range(len(pieces) - 1)
    for k in order:
        before = k - 1 if along else k + 1
        like = (
            len(pieces[before].lanes_ltr) == len(pieces[k].lanes_ltr) and not _near_lane(pieces[before], rule).turns
        )
        if out[k] and like and abs(begin[before] - begin[k]) <= _LONGEST_WEAVING:
            out[before] = True
    return out
