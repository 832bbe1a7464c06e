"""Hard shoulders of motorways whose tags say nothing of any."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Final

from osm2xodr.curves import running_lengths
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.model import Direction, LaneSpec, LaneType, MarginSpec, Rule, Street, StreetAttributes, Structure
from osm2xodr.osmParsing.defaults import SHOULDER_WIDTH
from osm2xodr.osmParsing.roadside.footway_cuts import join_like_pieces
from osm2xodr.osmParsing.tags import near_side, tells_of_shoulders

# Values of OSM's ``highway`` of carriageways with hard shoulders. Ramps have narrow ones or none.
_CLASSES: Final = frozenset({"motorway"})
# The turns of lanes that go through. Exit and entry lanes take the place of the shoulder.
_THROUGH: Final = frozenset({"through", "none"})
# An exit lane without turns before the piece that tells them began at an entry, if at all, at most this far back, m.
# A choice: weaving lanes are shorter.
_LONGEST_WEAVING: Final = 1000.0


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
    if piece.highway not in _CLASSES or piece.structure is Structure.TUNNEL or len(piece.car_directions()) != 1:
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
