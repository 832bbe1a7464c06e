"""Down-weighting of canopy and roofs, which surface models show, by graduated non-convexity (Blake and Zisserman).

A road that bends as roads do follows a wood's canopy up and down, and no residual is left that would give it away.
One that is too stiff for that passes below, as long as ground shows between; what stands out above it loses its
weight, and a road that is less stiff is then found from the rest. Each stage starts from the weights of the last.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import Final

import numpy as np
import scipy.sparse as sp

from osm2xodr.curves import hypot
from osm2xodr.geometry.heights import defaults
from osm2xodr.geometry.heights.observations import FLOOR, Kind, Observations
from osm2xodr.geometry.heights.sparse import System
from osm2xodr.geometry.heights.stiffness import Beams
from osm2xodr.model import BoolArray, FloatArray, IntArray
from osm2xodr.system import record

# Solves of each stage, and the weights between them.
_STAGE_ROUNDS: Final = 4
# Shortest distance between two heights that a slope is computed over, m.
_SHORTEST: Final = 1e-6


@record(eq=False)
class Stage:
    """A stiffer network to begin with."""

    stiffness: sp.csr_matrix  # (N, N)
    tolerance: float  # How far the ground may leave what so stiff a road follows, m


def canopy_stages(beams: Beams, stiffness: Callable[[FloatArray], sp.csr_matrix]) -> Iterator[Stage]:
    """Yield the networks to begin with, stiffest first; `stiffness` makes (N, N) from the flexibility (E,), 1/m.

    A beam on an elastic foundation gives way over the length (1 / (w q))^(1/4).
    """
    for length, tolerance in defaults.CANOPY_STAGES:
        flexibility = np.minimum(beams.flexibility, 1.0 / (beams.density * (length * length * length * length)))
        yield Stage(stiffness(flexibility), tolerance)


def downweight_canopy(stages: Sequence[Stage], observations: Observations) -> FloatArray:
    """Return factors (n,) on the weights: small where heights stand on the ground rather than show it."""
    obs = observations
    system = System([stage.stiffness for stage in stages], [obs.rows])
    rows = obs.rows.copy()
    system.put_in_order(rows)
    transposed = rows.T.tocsr()
    factors = np.ones(len(obs.value))
    for stage in stages:
        sigma = hypot(obs.sigma, stage.tolerance)
        stiffness = system.placed(stage.stiffness)
        for _ in range(_STAGE_ROUNDS):
            weight = obs.weight * factors
            matrix = stiffness + system.normal(rows, transposed, weight)
            x = system.solve(matrix, transposed @ (weight * obs.value))
            factors = obs.robust_factors(obs.value - rows @ x, sigma, geman_mcclure=False)
    return np.where(obs.canopy, factors, 1.0)


def restore_ground(
    observations: Observations, factors: FloatArray, road: IntArray, s: FloatArray, z: FloatArray
) -> tuple[Observations, FloatArray]:
    """Return observations in which ground keeps a share of its weight, and factors that give hills all of theirs.

    Without that floor the few heights of a short road that lie lowest could win over all others: nothing that is
    higher counts for much. The factors, (n,), are those of `downweight_canopy`; road, s and z, (samples,), are road,
    place along it and height of the ground, m, of the observed road heights.
    """
    along = np.flatnonzero(observations.kind == Kind.ROAD_HEIGHT)
    out = observations.canopy[along] & (factors[along] < defaults.CANOPY_OUTLIER)
    factors = factors.copy()
    factors[along[bare_runs(road, s, z, out)]] = 1.0
    ground = observations.canopy & (factors >= defaults.CANOPY_OUTLIER)
    return replace(observations, floor=np.where(ground, defaults.CANOPY_GROUND_FLOOR, FLOOR)), factors


def bare_runs(road: IntArray, s: FloatArray, z: FloatArray, out: BoolArray) -> BoolArray:
    """Return which heights that stand out are those of the ground, (n,).

    What stands on the ground has walls: heights change abruptly at its edge, where it begins and ends along the road.
    A stretch of road that stands out as a whole without a wall is a hill that the stiff road did not follow: the
    model shows the ground there. Road, place along it, s, and height, z, m, are in the order of roads and along them.
    """
    if not len(road):
        return np.zeros(0, bool)
    same = road[1:] == road[:-1]
    rise, steep = np.abs(np.diff(z)), defaults.WALL_SLOPE * np.maximum(np.diff(s), _SHORTEST)
    k = np.flatnonzero(same & (rise > defaults.WALL_HEIGHT) & (rise > steep))
    begins = out & np.r_[True, ~(same & out[:-1])]
    run = np.cumsum(begins) - 1
    walled = np.zeros(max(int(begins.sum()), 1), bool)
    # A wall between two heights is one of the run on either side of it.
    walled[run[k[out[k]]]] = True
    walled[run[k[out[k + 1]] + 1]] = True
    bare: BoolArray = out & ~walled[run]
    return bare
