"""Footways and cycleways that are mapped apart but run along a street become its sidewalks and bicycle tracks.

OpenDRIVE has sidewalks as lanes of the road, but tags do not say which street a footway belongs to: geometry decides.
A piece of street gets a strip where matches (`footway_matches`) cover most of it, at their median distance from the
edge; then short gaps are closed, short strips dropped, and distances that hardly differ made equal.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from osm2xodr.curves import unique_all, unique_first
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.model import Direction, Footway, IntArray, LaneType, MarginSpec, Street, StreetAttributes
from osm2xodr.osmParsing.defaults import CYCLE_TRACK_WIDTH, CYCLE_TRACK_WIDTH_BOTH, FOOTWAY_BESIDE, SIDEWALK_WIDTH
from osm2xodr.osmParsing.roadside.footway_matches import (
    LEFT,
    RIGHT,
    FootwayMatches,
    covered,
    cut_where_footways_end,
    join_like_pieces,
    match_footways,
)
from osm2xodr.osmParsing.roadside.reach import StreetSamples
from osm2xodr.osmParsing.tags import LEFT_RIGHT, NO, kerb_height, parse_length, sides_of
from osm2xodr.system import record

# Footways that no tag calls a sidewalk must be nearer to the edge than `FOOTWAY_BESIDE`, nearer still beside drives
# and alleys, m. Choices.
_BESIDE_UNTAGGED: Final = 6.0
_BESIDE_SERVICE: Final = 4.0
# Share of a piece's length that matches must cover for a strip; length of gaps that are closed, and least length of
# strips, m. Choices.
_COVER_MIN: Final = 0.6
_GAP_CLOSED: Final = 20.0
_STRIP_LENGTH_MIN: Final = 10.0
# A street tagged as having no sidewalk gets none from footways farther away than this, m.
_FARTHEST_AGAINST_TAGS: Final = 3.0
# Distances and widths of a strip along a street that differ by no more than this are averaged, m; verges narrower
# than the second are left out. Choices.
_SAME_STRIP: Final = 0.5
_VERGE_WIDTH_MIN: Final = 0.3
# Widths of footways and cycleways that are believed, m.
_WIDTH_MIN: Final = 0.8
_WIDTH_MAX: Final = 6.0

_NO_SIDEWALKS: Final = frozenset({"motorway", "motorway_link", "track", "raceway"})
# Uses of footways; elsewhere they are numbered by their index here.
_USES: Final = (LaneType.SIDEWALK, LaneType.BIKING)


@record
class _Strip:
    """A footway along a piece of street."""

    distance: float  # From the edge of the carriageway to its middle, m
    width: float  # m
    direction: Direction


def attach_footways(
    streets: tuple[Street, ...],
    samples: StreetSamples,
    footways: Sequence[Footway],
    way_tags: Mapping[int, Mapping[str, str]],
    diagnostics: Diagnostics,
) -> tuple[Street, ...]:
    """Give streets the footways within reach that run along them as margins; one sentence to the diagnostics.

    `samples` are points along the streets, `way_tags` the tags of their ways by OSM id.
    """
    candidates = [footway for footway in footways if not footway.crossing]
    if not candidates:
        return streets
    matches = match_footways(streets, samples, candidates)
    use = np.array([_USES.index(_use(footway.tags)) for footway in candidates], np.int64)[matches.footway]
    streets, samples = cut_where_footways_end(streets, samples, matches, use)
    found = _find_strips(streets, samples, candidates, matches, use, way_tags)
    _close_gaps(streets, samples, found, way_tags)
    _drop_short(samples, found)
    _even_out(samples, found)
    out = [join_like_pieces(street) for street in streets]
    new: dict[int, list[tuple[int, StreetAttributes]]] = {}
    for piece in sorted({piece for piece, _, _ in found}):
        street, index = int(samples.street[piece]), int(samples.index[piece])
        pieces = new.setdefault(street, list(streets[street].pieces))
        pieces[index] = pieces[index][0], _with_margins(pieces[index][1], piece, found, way_tags)
    for street, pieces in new.items():
        out[street] = join_like_pieces(replace(streets[street], pieces=tuple(pieces)))
    _report(samples, matches, use, found, diagnostics)
    return tuple(out)


# Number of the piece, side, number of the use.
_Key = tuple[int, int, int]
_Found = dict[_Key, _Strip]


def _find_strips(
    streets: Sequence[Street],
    samples: StreetSamples,
    footways: Sequence[Footway],
    matches: FootwayMatches,
    use: IntArray,
    way_tags: Mapping[int, Mapping[str, str]],
) -> _Found:
    """Find the strips along pieces of streets."""
    widths = [_width(footway.tags) for footway in footways]
    runs = [_runs(footway.tags) for footway in footways]
    out: _Found = {}
    lengths = samples.piece_lengths()
    for kind in range(len(_USES)):
        for side in (LEFT, RIGHT):
            chosen = np.flatnonzero((use == kind) & (matches.side == side))
            # Of several footways at one point the nearest.
            chosen = chosen[np.lexsort((matches.footway[chosen], matches.distance[chosen], matches.sample[chosen]))]
            sample, first = unique_first(matches.sample[chosen])
            chosen = chosen[first]
            cover = np.bincount(samples.piece, samples.lines.length * covered(samples, sample), len(lengths))
            piece = samples.piece[sample]
            order = np.lexsort((matches.distance[chosen], piece))
            chosen, piece = chosen[order], piece[order]
            every, begin, _, count = unique_all(piece)
            for number, start, size in np.column_stack([every, begin, count]).tolist():
                if cover[number] < _COVER_MIN * lengths[number]:
                    continue
                # The median distance.
                low, high = chosen[start + (size - 1) // 2], chosen[start + size // 2]
                distance = 0.5 * float(matches.distance[low] + matches.distance[high])
                attributes = streets[samples.street[number]].pieces[samples.index[number]][1]
                footway = int(matches.footway[low])
                limit = _distance_max(attributes.highway, footways[footway].tags)
                if distance <= limit and _may_have(attributes, side, kind, distance, way_tags):
                    runs_along = runs[footway] * (1 if matches.along[low] else -1)
                    out[number, side, kind] = _Strip(distance, widths[footway], Direction(runs_along))
    return out


def _use(tags: Mapping[str, str]) -> LaneType:
    """Return the use of a footway: bicycles if people may not walk on it, else pedestrians."""
    on_foot = tags.get("foot") in ("designated", "yes", "permissive") or "segregated" in tags
    return LaneType.BIKING if tags.get("highway") == "cycleway" and not on_foot else LaneType.SIDEWALK


def _width(tags: Mapping[str, str]) -> float:
    for width in (parse_length(tags.get(key, "")) for key in ("width", "est_width")):
        if width is not None and _WIDTH_MIN <= width <= _WIDTH_MAX:
            return width
    if _use(tags) is LaneType.SIDEWALK:
        return SIDEWALK_WIDTH
    return CYCLE_TRACK_WIDTH if _runs(tags) else CYCLE_TRACK_WIDTH_BOTH


def _runs(tags: Mapping[str, str]) -> int:
    """Return 1 or -1 if a cycleway is one-way along or against its nodes, else 0."""
    if _use(tags) is LaneType.SIDEWALK:
        return 0
    value = tags.get("oneway:bicycle", tags.get("oneway", ""))
    return {"yes": 1, "true": 1, "1": 1, "-1": -1, "reverse": -1}.get(value, 0)


def _distance_max(highway: str, tags: Mapping[str, str]) -> float:
    """Return the largest distance from the edge of a road at which a footway is its sidewalk, m."""
    if "sidewalk" in (tags.get("footway"), tags.get("path"), tags.get("cycleway")):
        return FOOTWAY_BESIDE
    return _BESIDE_SERVICE if highway == "service" else _BESIDE_UNTAGGED


def _may_have(
    attributes: StreetAttributes, side: int, kind: int, distance: float, way_tags: Mapping[int, Mapping[str, str]]
) -> bool:
    """Whether a piece may get a strip: its tags neither give one there already nor rule it out."""
    if attributes.highway in _NO_SIDEWALKS:
        return False
    margin = attributes.margin_left if side == LEFT else attributes.margin_right
    if any(strip.type is _USES[kind] for strip in margin):
        return False
    if _USES[kind] is LaneType.BIKING:
        lanes = attributes.lanes_ltr
        return not any(lane.type is LaneType.BIKING for lane in (lanes[:1] if side == LEFT else lanes[-1:]))
    stated = sides_of(way_tags[attributes.osm_way_id], "sidewalk", "sidewalk", [])
    return stated.get(_way_side(attributes, side)) != NO or distance <= _FARTHEST_AGAINST_TAGS


def _way_side(attributes: StreetAttributes, side: int) -> str:
    """Return the side of a street as the tags of its way name it."""
    return LEFT_RIGHT[side] if not attributes.reversed else LEFT_RIGHT[1 - side]


def _close_gaps(
    streets: Sequence[Street], samples: StreetSamples, found: _Found, way_tags: Mapping[int, Mapping[str, str]]
) -> None:
    """Give short pieces between two that have a strip the same one."""
    lengths = samples.piece_lengths()
    for piece, side, kind in sorted(found):
        length, last = 0.0, piece + 1
        end = int(np.searchsorted(samples.street, samples.street[piece], side="right"))
        while last < end and (last, side, kind) not in found:
            length += lengths[last]
            last += 1
        if last in (piece + 1, end):
            continue
        pieces = streets[samples.street[piece]].pieces
        a, b = found[piece, side, kind], found[last, side, kind]
        strip = replace(a, distance=0.5 * (a.distance + b.distance), width=min(a.width, b.width))
        between = [pieces[samples.index[number]][1] for number in range(piece + 1, last)]
        if length <= _GAP_CLOSED and all(_may_have(item, side, kind, strip.distance, way_tags) for item in between):
            found.update({(number, side, kind): strip for number in range(piece + 1, last)})


def _continuous_runs(
    samples: StreetSamples, found: _Found, alike: Callable[[_Key, Sequence[_Key]], bool] = lambda key, before: True
) -> list[list[_Key]]:
    """Return runs of strips along a street, each run as long as strips are `alike` those before them."""
    runs: list[list[_Key]] = []
    for side, kind, piece in sorted((side, kind, piece) for piece, side, kind in found):
        key = piece, side, kind
        before = runs[-1] if runs else []
        follows = bool(before) and before[-1] == (piece - 1, side, kind)
        if follows and samples.street[piece] == samples.street[piece - 1] and alike(key, before):
            before.append(key)
        else:
            runs.append([key])
    return runs


def _drop_short(samples: StreetSamples, found: _Found) -> None:
    """Drop runs of strips shorter than `_STRIP_LENGTH_MIN`."""
    lengths = samples.piece_lengths()
    for run in _continuous_runs(samples, found):
        if math.fsum(float(lengths[item[0]]) for item in run) < _STRIP_LENGTH_MIN:
            for item in run:
                del found[item]


def _even_out(samples: StreetSamples, found: _Found) -> None:
    """Give runs of similar strips one distance and one width: the means weighted by length."""
    lengths = samples.piece_lengths()

    def alike(key: _Key, before: Sequence[_Key]) -> bool:
        own = found[key]
        others = [found[item] for item in before]
        return all(max(abs(it.distance - own.distance), abs(it.width - own.width)) <= _SAME_STRIP for it in others)

    for run in _continuous_runs(samples, found, alike):
        weights = [float(lengths[item[0]]) for item in run]
        total = math.fsum(weights)
        distance = math.fsum(w * found[item].distance for w, item in zip(weights, run, strict=True)) / total
        width = math.fsum(w * found[item].width for w, item in zip(weights, run, strict=True)) / total
        for item in run:
            found[item] = replace(found[item], distance=distance, width=round(width, 2))


def _with_margins(
    attributes: StreetAttributes, piece: int, found: _Found, way_tags: Mapping[int, Mapping[str, str]]
) -> StreetAttributes:
    tags = way_tags[attributes.osm_way_id]
    margins = [
        _margin(margin, piece, side, found, kerb_height(tags, _way_side(attributes, side), []))
        for side, margin in ((LEFT, attributes.margin_left), (RIGHT, attributes.margin_right))
    ]
    return replace(attributes, margin_left=margins[LEFT], margin_right=margins[RIGHT])


def _margin(
    margin: tuple[MarginSpec, ...], piece: int, side: int, found: _Found, kerb: float
) -> tuple[MarginSpec, ...]:
    """Append the strips of a side to its margin, in the order of their distance, with verges between them."""
    strips = [(found[piece, side, kind], _USES[kind]) for kind in range(len(_USES)) if (piece, side, kind) in found]
    out, edge = list(margin), 0.0
    # Of two at one distance the sidewalk comes first, whatever the last bits of the distances.
    for strip, use in sorted(strips, key=lambda item: round(item[0].distance, 3)):
        # 1e-9: the rounding must not depend on the last bits of the distance.
        verge = round(strip.distance - edge - 0.5 * strip.width + 1e-9, 1)
        if verge > _VERGE_WIDTH_MIN:
            out.append(MarginSpec(LaneType.BORDER, verge, Direction.BOTH, kerb))
            edge += verge
        out.append(MarginSpec(use, strip.width, strip.direction, kerb))
        edge += strip.width
    return tuple(out)


def _report(
    samples: StreetSamples, matches: FootwayMatches, use: IntArray, found: _Found, diagnostics: Diagnostics
) -> None:
    if not found:
        return
    keys = zip(samples.piece[matches.sample].tolist(), matches.side.tolist(), use.tolist(), strict=True)
    attached = math.fsum(length for key, length in zip(keys, matches.length.tolist(), strict=True) if key in found)
    streets = len({int(samples.street[number]) for number, _, _ in found})
    words = (
        f"{attached / 1e3:.1f} of {matches.total / 1e3:.1f} km of footways and cycleways mapped beside streets "
        f"run along them and become sidewalks and bicycle tracks there (of {streets} street{'s' * (streets != 1)})"
    )
    diagnostics.note("separate-sidewalk", "", words)
