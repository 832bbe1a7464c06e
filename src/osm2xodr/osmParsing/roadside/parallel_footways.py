"""Footways and cycleways that are mapped apart but run along a street become margins of it.

1. Points along footways are matched with the nearest edge of a carriageway that runs the same way at the same level.
2. Of each stretch of street (part of a way), side and use: how much of it is covered, and how far off, as a median.
3. Short gaps are closed, and distances that hardly differ along a street are made one.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from osm2xodr.diagnostics import Diagnostics
from osm2xodr.model import Direction, Footway, IntArray, LaneSpec, LaneType, MarginSpec, Street, StreetAttributes
from osm2xodr.osmParsing.defaults import (
    CYCLE_TRACK_WIDTH,
    CYCLE_TRACK_WIDTH_BOTH,
    FOOTWAY_BESIDE,
    FOOTWAY_BESIDE_SERVICE,
    FOOTWAY_BESIDE_UNTAGGED,
    FOOTWAY_STRIP_MIN,
    SIDEWALK_WIDTH,
)
from osm2xodr.osmParsing.roadside.footway_cuts import cut_where_footways_end, join_like_pieces
from osm2xodr.osmParsing.roadside.footway_matches import LEFT, RIGHT, FootwayMatches, covered, match_footways
from osm2xodr.osmParsing.roadside.reach import StreetSamples
from osm2xodr.osmParsing.tags import LEFT_RIGHT, NO, kerb_height, parse_length, sides_of

# A stretch of street has it as its sidewalk if it runs along so much of it; gaps between two such stretches that are
# shorter than this are closed, m. Where OSM says that there is no sidewalk, it is believed from this distance on, m.
_FOOTWAY_COVER: Final = 0.6
_FOOTWAY_GAP_CLOSED: Final = 20.0
_FOOTWAY_AGAINST_TAGS: Final = 3.0
# Distances of a footway that differ by less along a street are one, m; strips of verge narrower than the second are
# none. Choices.
_FOOTWAY_STEADY: Final = 0.5
_FOOTWAY_VERGE_MIN: Final = 0.3
# Widths of footways and cycleways that are believed, m.
_FOOTWAY_WIDTH_MIN: Final = 0.8
_FOOTWAY_WIDTH_MAX: Final = 6.0

_NO_SIDEWALKS: Final = frozenset({"motorway", "motorway_link", "track", "raceway"})
# What a footway is for: the index of its use among these.
_USES: Final = (LaneType.SIDEWALK, LaneType.BIKING)


@dataclass(frozen=True, slots=True)
class _Strip:
    """A footway along a stretch of street: distance of its middle from the edge and its width, m."""

    distance: float
    width: float
    direction: Direction


def attach_footways(
    streets: tuple[Street, ...],
    samples: StreetSamples,
    footways: Sequence[Footway],
    way_tags: Mapping[int, Mapping[str, str]],
    diagnostics: Diagnostics,
) -> tuple[Street, ...]:
    """Give streets the footways that run along them as margins.

    Parameters
    ----------
    streets, samples
        The streets, and points along them.
    footways
        What lies within reach of them.
    way_tags
        Of the ways, by OSM id.
    diagnostics
        Gets what was done, in one sentence.
    """
    candidates = [footway for footway in footways if not footway.crossing]
    if not candidates:
        return streets
    matches = match_footways(streets, samples, candidates)
    use = np.array([_USES.index(_use(footway.tags)) for footway in candidates], np.int64)[matches.footway]
    streets, samples = cut_where_footways_end(streets, samples, matches, use)
    found = _stretches(streets, samples, candidates, matches, use, way_tags)
    _close_gaps(streets, samples, found, way_tags)
    _drop_short(samples, found)
    _steady(samples, found)
    out = [join_like_pieces(street) for street in streets]
    by_street: dict[int, list[int]] = defaultdict(list)
    for piece in sorted({piece for piece, _, _ in found}):
        by_street[int(samples.street[piece])].append(piece)
    for number, pieces in by_street.items():
        new = list(streets[number].pieces)
        for piece in pieces:
            at, attributes = new[int(samples.index[piece])]
            new[int(samples.index[piece])] = at, _with_margins(attributes, piece, found, way_tags)
        out[number] = join_like_pieces(replace(streets[number], pieces=tuple(new)))
    _report(samples, matches, use, found, diagnostics)
    return tuple(out)


# ---------------------------------------------------------------- stretches of streets


_Key = tuple[int, int, int]
_Found = dict[_Key, _Strip]


def _stretches(
    streets: Sequence[Street],
    samples: StreetSamples,
    footways: Sequence[Footway],
    matches: FootwayMatches,
    use: IntArray,
    way_tags: Mapping[int, Mapping[str, str]],
) -> _Found:
    """Find the strips along stretches: by number of the piece, side and use."""
    widths = [_width(footway.tags) for footway in footways]
    runs = [_runs(footway.tags) for footway in footways]
    out: _Found = {}
    lengths = np.bincount(samples.piece, samples.lines.length, len(samples.street))
    for kind in range(len(_USES)):
        for side in (LEFT, RIGHT):
            chosen = np.flatnonzero((use == kind) & (matches.side == side))
            # Of several footways at one place the nearest.
            chosen = chosen[np.lexsort((matches.footway[chosen], matches.distance[chosen], matches.sample[chosen]))]
            sample, first = np.unique(matches.sample[chosen], return_index=True)
            chosen = chosen[first]
            share = np.bincount(samples.piece, samples.lines.length * covered(samples, sample), len(lengths))
            piece = samples.piece[sample]
            order = np.lexsort((matches.distance[chosen], piece))
            chosen, piece = chosen[order], piece[order]
            every, begin, count = np.unique(piece, return_index=True, return_counts=True)
            for number, start, size in zip(every.tolist(), begin.tolist(), count.tolist(), strict=True):
                if share[number] < _FOOTWAY_COVER * lengths[number]:
                    continue
                # The median: the one in the middle, or between the two in the middle.
                low, high = chosen[start + (size - 1) // 2], chosen[start + size // 2]
                distance = 0.5 * float(matches.distance[low] + matches.distance[high])
                attributes = streets[samples.street[number]].pieces[samples.index[number]][1]
                footway = int(matches.footway[low])
                limit = _farthest(attributes.highway, footways[footway].tags)
                if distance <= limit and _wanted(attributes, side, kind, distance, way_tags):
                    runs_along = runs[footway] * (1 if matches.along[low] else -1)
                    out[number, side, kind] = _Strip(distance, widths[footway], Direction(runs_along))
    return out


def _use(tags: Mapping[str, str]) -> LaneType:
    """Return what a footway is: one for bicycles only if people may not walk on it."""
    on_foot = tags.get("foot") in ("designated", "yes", "permissive") or "segregated" in tags
    return LaneType.BIKING if tags.get("highway") == "cycleway" and not on_foot else LaneType.SIDEWALK


def _width(tags: Mapping[str, str]) -> float:
    for key in ("width", "est_width"):
        width = parse_length(tags.get(key, ""))
        if width is not None and _FOOTWAY_WIDTH_MIN <= width <= _FOOTWAY_WIDTH_MAX:
            return width
    if _use(tags) is LaneType.SIDEWALK:
        return SIDEWALK_WIDTH
    return CYCLE_TRACK_WIDTH if _runs(tags) else CYCLE_TRACK_WIDTH_BOTH


def _runs(tags: Mapping[str, str]) -> int:
    """Return 1 or -1 if a cycleway is one-way along or against its nodes, else 0."""
    if _use(tags) is LaneType.SIDEWALK:
        return 0
    return {"yes": 1, "true": 1, "1": 1, "-1": -1, "reverse": -1}.get(
        tags.get("oneway:bicycle", tags.get("oneway", "")), 0
    )


def _farthest(highway: str, tags: Mapping[str, str]) -> float:
    """Return how far from the edge of a road a footway may lie to be a sidewalk, m."""
    if "sidewalk" in (tags.get("footway"), tags.get("path"), tags.get("cycleway")):
        return FOOTWAY_BESIDE
    return FOOTWAY_BESIDE_SERVICE if highway == "service" else FOOTWAY_BESIDE_UNTAGGED


def _wanted(
    attributes: StreetAttributes,
    side: int,
    kind: int,
    distance: float,
    way_tags: Mapping[int, Mapping[str, str]],
) -> bool:
    """Say whether a stretch may get a strip: its tags have none there yet, and do not speak against it."""
    if attributes.highway in _NO_SIDEWALKS:
        return False
    margin = attributes.margin_left if side == LEFT else attributes.margin_right
    if any(strip.type is _USES[kind] for strip in margin):
        return False
    if _USES[kind] is LaneType.BIKING:
        return not any(lane.type is LaneType.BIKING for lane in _outer_lanes(attributes, side))
    said = sides_of(way_tags[attributes.osm_way_id], "sidewalk", "sidewalk", [])
    return said.get(_way_side(attributes, side)) != NO or distance <= _FOOTWAY_AGAINST_TAGS


def _way_side(attributes: StreetAttributes, side: int) -> str:
    """Return the word for a side of a street as tags of its way use it."""
    return LEFT_RIGHT[side] if not attributes.reversed else LEFT_RIGHT[1 - side]


def _outer_lanes(attributes: StreetAttributes, side: int) -> tuple[LaneSpec, ...]:
    lanes = attributes.lanes_ltr
    return lanes[:1] if side == LEFT else lanes[-1:]


# ---------------------------------------------------------------- along streets


def _close_gaps(
    streets: Sequence[Street],
    samples: StreetSamples,
    found: _Found,
    way_tags: Mapping[int, Mapping[str, str]],
) -> None:
    """Give short stretches between two that have a strip the same one."""
    lengths = np.bincount(samples.piece, samples.lines.length, len(samples.street))
    for piece, side, kind in sorted(found):
        length, last = 0.0, piece + 1
        while (
            last < len(lengths) and samples.street[last] == samples.street[piece] and (last, side, kind) not in found
        ):
            length += lengths[last]
            last += 1
        if last == piece + 1 or last == len(lengths) or samples.street[last] != samples.street[piece]:
            continue
        pieces = streets[samples.street[piece]].pieces
        a, b = found[piece, side, kind], found[last, side, kind]
        strip = replace(a, distance=0.5 * (a.distance + b.distance), width=min(a.width, b.width))
        between = [pieces[samples.index[number]][1] for number in range(piece + 1, last)]
        if length <= _FOOTWAY_GAP_CLOSED and all(
            _wanted(attributes, side, kind, strip.distance, way_tags) for attributes in between
        ):
            found.update({(number, side, kind): strip for number in range(piece + 1, last)})


def _continuous(
    samples: StreetSamples, found: _Found, alike: Callable[[_Key, Sequence[_Key]], bool] = lambda key, before: True
) -> list[list[_Key]]:
    """Return strips that follow each other along a street, as long as each is like those before it."""
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
    """Leave out strips that go on for less than `FOOTWAY_STRIP_MIN` along their street."""
    lengths = np.bincount(samples.piece, samples.lines.length, len(samples.street))
    for run in _continuous(samples, found):
        if math.fsum(float(lengths[item[0]]) for item in run) < FOOTWAY_STRIP_MIN:
            for item in run:
                del found[item]


def _steady(samples: StreetSamples, found: _Found) -> None:
    """Let strips that follow each other along a street at nearly one distance lie at one, and be of one width."""
    lengths = np.bincount(samples.piece, samples.lines.length, len(samples.street))

    def alike(key: _Key, before: Sequence[_Key]) -> bool:
        return all(
            abs(found[item].distance - found[key].distance) <= _FOOTWAY_STEADY
            and abs(found[item].width - found[key].width) <= _FOOTWAY_STEADY
            for item in before
        )

    for run in _continuous(samples, found, alike):
        weights = [float(lengths[item[0]]) for item in run]
        distance = math.fsum(w * found[item].distance for w, item in zip(weights, run, strict=True)) / math.fsum(
            weights
        )
        width = math.fsum(w * found[item].width for w, item in zip(weights, run, strict=True)) / math.fsum(weights)
        for item in run:
            found[item] = replace(found[item], distance=distance, width=round(width, 2))


def _with_margins(
    attributes: StreetAttributes, piece: int, found: _Found, way_tags: Mapping[int, Mapping[str, str]]
) -> StreetAttributes:
    tags = way_tags[attributes.osm_way_id]
    left, right = (kerb_height(tags, _way_side(attributes, side), []) for side in (LEFT, RIGHT))
    return replace(
        attributes,
        margin_left=_margin(attributes.margin_left, piece, LEFT, found, left),
        margin_right=_margin(attributes.margin_right, piece, RIGHT, found, right),
    )


def _margin(
    margin: tuple[MarginSpec, ...], piece: int, side: int, found: _Found, kerb: float
) -> tuple[MarginSpec, ...]:
    """Put the strips of a side after what is there, in the order of their distance, with verges between them."""
    strips = [(found[piece, side, kind], _USES[kind]) for kind in range(len(_USES)) if (piece, side, kind) in found]
    out, edge = list(margin), 0.0
    for strip, use in sorted(strips, key=lambda item: item[0].distance):
        # Added first, so that what is rounded does not depend on the last bits of the distance.
        verge = round(strip.distance - edge - 0.5 * strip.width + 1e-9, 1)
        if verge > _FOOTWAY_VERGE_MIN:
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
