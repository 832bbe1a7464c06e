"""Junctions whose lights are one installation: no queue fits on the short roads with lights between them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import numpy as np
import scipy.sparse
from scipy.sparse.csgraph import connected_components

from osm2xodr.furniture.defaults import ONE_INSTALLATION
from osm2xodr.furniture.world import Approach, World


def installations(
    world: World, approaches: Sequence[Approach], lit: Iterable[int], phases: Mapping[int, int]
) -> list[list[int]]:
    """Return groups of junctions with lights, by ascending ids.

    Junctions share a group if an approach to one of them, of those with lights (indices `lit`), is a road of up to
    `ONE_INSTALLATION` that comes from the other. `phases` says how many each junction takes alone: where one is
    enough, nobody waits for anybody, and other junctions need not be waited for.
    """
    ids = sorted(phases)
    place = {junction: k for k, junction in enumerate(ids) if phases[junction] > 1}
    pairs = np.array(
        [
            (place[approaches[k].junction], place[behind])
            for k in lit
            if approaches[k].junction in place
            and (behind := _junction_behind(world, approaches[k])) in place
            and world.lanes.length(approaches[k].road) <= ONE_INSTALLATION
        ],
        np.int64,
    ).reshape(-1, 2)
    links = scipy.sparse.coo_matrix((np.ones(len(pairs)), pairs.T), shape=(len(ids), len(ids)))
    groups: dict[int, list[int]] = {}
    for junction, group in zip(ids, connected_components(links, directed=False)[1].tolist(), strict=True):
        groups.setdefault(group, []).append(junction)
    return list(groups.values())


def _junction_behind(world: World, approach: Approach) -> int | None:
    """Return the id of the junction from which an approach comes; None where it comes from none."""
    road = world.lanes.road(approach.road)
    link = road.predecessor if approach.at_end else road.successor
    return link.id if link is not None and link.to_junction else None
