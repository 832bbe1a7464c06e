"""The solve: robust least squares on a beam network with elastic limits, a few sparse factorisations in all."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from osm2xodr.geometry.heights.sparse import System, chosen_rows
from osm2xodr.model import FloatArray, IntArray
from osm2xodr.system import release_memory

# No observation loses more of its weight than this: where all that there is stands out, it still holds the road.
LEAST_FACTOR = 1e-3
# Steps in which the robust weights follow, most steps after these, and the fall of the function that is worth none.
ROBUST_STEPS = 4
STEPS = 30
LEAST_FALL = 0.1
# Unknowns that a step moves by less are at rest, m. In networks of more unknowns than are few, the others are brought
# to rest by themselves if they are no more than this share, together with so many knots around them.
STILL = 1e-4
SMALL = 4000
FEW = 0.2
AROUND = 4
# Steps of each stage on the way through canopy and roofs.
STAGE_STEPS = 4
# A line search always goes on by this share, so that rounding cannot stop it short of the minimum.
LEAST_SHARE = 1e-3
_ALL = slice(None)


@dataclass(frozen=True, slots=True, eq=False)
class Observations:
    """Heights that the unknowns should meet."""

    rows: sp.csr_matrix  # (n, N) Matrix from unknowns to the heights at the samples
    z: FloatArray  # (n,) Observed heights, m
    weight: FloatArray  # (n,) Weight of the squared residual, 1/m²
    sigma: FloatArray  # (n,) Standard error of one observation, m; what the robust weights measure residuals by


@dataclass(frozen=True, slots=True, eq=False)
class Limits:
    """Elastic bounds on linear functions of the unknowns."""

    rows: sp.csr_matrix  # (m, N) The functions
    # (m,) Their bounds; infinite where there is none
    low: FloatArray
    high: FloatArray
    stiffness: FloatArray  # (m,) Force per excess
    cap: FloatArray  # (m,) Largest force: what asks for more gives way. Infinite where the bound must hold.

    def first(self, count: int) -> Limits:
        """Return the first of them, which share their arrays with these."""
        bounds = (column[:count] for column in (self.low, self.high, self.stiffness, self.cap))
        return Limits(first_rows(self.rows, count), *bounds)

    def excess(self, value: FloatArray, index: IntArray | slice = _ALL) -> FloatArray:
        """Return by how much the values of some functions are beyond their bounds, with its sign."""
        out: FloatArray = value - np.clip(value, self.low[index], self.high[index])
        return out

    def force(self, value: FloatArray, index: IntArray | slice = _ALL) -> FloatArray:
        """Return the force with which the values of some functions are pushed back."""
        cap = self.cap[index]
        out: FloatArray = np.clip(self.stiffness[index] * self.excess(value, index), -cap, cap)
        return out


def first_rows(rows: sp.csr_matrix, count: int) -> sp.csr_matrix:
    """Return the first rows of a matrix, which share its arrays."""
    end = rows.indptr[count]
    return sp.csr_matrix((rows.data[:end], rows.indices[:end], rows.indptr[: count + 1]), (count, rows.shape[1]))


def joined_limits(parts: list[Limits], columns: int) -> Limits:
    """Join limits into one; `columns` widens their rows by unknowns that they do not see."""
    return Limits(
        stacked([part.rows for part in parts], columns),
        np.concatenate([part.low for part in parts]),
        np.concatenate([part.high for part in parts]),
        np.concatenate([part.stiffness for part in parts]),
        np.concatenate([part.cap for part in parts]),
    )


def joined_observations(parts: list[Observations], columns: int) -> Observations:
    """Join observations into one; `columns` widens their rows by unknowns that they do not see."""
    return Observations(
        stacked([part.rows for part in parts], columns),
        np.concatenate([part.z for part in parts]),
        np.concatenate([part.weight for part in parts]),
        np.concatenate([part.sigma for part in parts]),
    )


def stacked(parts: list[sp.csr_matrix], columns: int) -> sp.csr_matrix:
    """Put matrices below each other, widened on the right."""
    wide = [sp.csr_matrix((rows.data, rows.indices, rows.indptr), (rows.shape[0], columns)) for rows in parts]
    return sp.csr_matrix(sp.vstack(wide))


@dataclass(frozen=True, slots=True, eq=False)
class Robust:
    """How residuals lose weight: by (1 + (r / (k sigma))²) to the power -1, later -2."""

    # k for observations above and below the road, (n,) or one for all
    above: FloatArray | float
    below: FloatArray | float
    least: FloatArray | float = LEAST_FACTOR  # The factor that they keep at least, (n,) or one for all

    def factors(self, residual: FloatArray, sigma: FloatArray, late: bool) -> FloatArray:
        """Return the factor on each weight; `residual` is observed minus solved, m."""
        k = np.where(residual > 0, self.above, self.below)
        base = 1.0 / (1.0 + (residual / (k * sigma)) ** 2)
        return np.maximum(base * base if late else base, self.least)


@dataclass(frozen=True, slots=True, eq=False)
class Stage:
    """A stiffer network to begin with."""

    stiffness: sp.csr_matrix  # (N, N) Its stiffness
    tolerance: float  # How far the ground may leave what so stiff a road follows, m


def see_through(stages: Sequence[Stage], observations: Observations, robust: Robust) -> FloatArray:
    """Return factors (n,) on the weights of observations, small where they stand on the ground rather than show it.

    A road that bends as roads do follows a wood's canopy up and down, and no residual is left that would tell. One
    that is too stiff for that passes below, as long as ground shows between; what stands out above it loses its
    weight, and a road that is less stiff can then be told from what is left. (Graduated non-convexity: the minimum
    of an easier problem is where the next one starts.)

    Parameters
    ----------
    stages
        From the stiffest on.
    observations
        What is known.
    robust
        How observations lose weight.
    """
    obs = observations
    system = System([stage.stiffness for stage in stages], [obs.rows])
    rows = obs.rows.copy()
    system.put_in_order(rows)
    transposed = rows.T.tocsr()
    factors = np.ones(len(obs.z))
    for stage in stages:
        sigma = np.hypot(obs.sigma, stage.tolerance)
        stiffness = system.placed(stage.stiffness)
        for _ in range(STAGE_STEPS):
            weight = obs.weight * factors
            matrix = stiffness + system.normal(rows, transposed, weight)
            x = system.solve(matrix, transposed @ (weight * obs.z))
            factors = robust.factors(obs.z - rows @ x, sigma, late=False)
    return factors


@dataclass(frozen=True, slots=True, eq=False)
class Solved:
    """What came out."""

    x: FloatArray  # (N,) The unknowns
    z: FloatArray  # (n,) The heights that were observed, as they came out, m
    factors: FloatArray  # (n,) The robust factors that were put on the observations' weights


def solve_network(
    stiffness: sp.csr_matrix,
    observations: Observations,
    limits: Limits,
    inner: int,
    robust: Robust,
    first: FloatArray | None = None,
) -> Solved:
    """Minimise bending, tension and misfit under elastic limits.

    Newton's method on a convex, piecewise quadratic function with an exact line search, so that limits that come
    and go cannot make it circle. What is minimised is half a sum of squares in units of standard errors: a step
    that promises a tenth no longer says anything. The robust weights follow in the first steps, under the inner
    limits only, and then stay: an observation is no outlier because another road bends this one away from it.

    Parameters
    ----------
    stiffness : (N, N)
        The quadratic part that does not change.
    observations
        What is known. Their rows are used up: afterwards the order of their columns is that of the elimination.
    limits
        All limits; likewise.
    inner
        How many of them, the first, a road has by itself.
    robust
        How outliers lose weight.
    first : (n,), optional
        Factors on the weights to begin with.
    """
    obs = observations
    factors = np.ones(len(obs.z)) if first is None else first
    system = System([stiffness], [obs.rows, limits.rows])
    rows = obs.rows
    system.put_in_order(rows)
    system.put_in_order(limits.rows)
    alone = limits.first(inner)
    transposed = rows.T.tocsr()
    plain = system.placed(stiffness)
    release_memory()
    x = np.zeros(0)
    for step in range(ROBUST_STEPS + 1):
        if step:
            factors = robust.factors(obs.z - rows @ x, obs.sigma, late=step > 2)
        weight = obs.weight * factors
        matrix = plain + system.normal(rows, transposed, weight)
        right = transposed @ (weight * obs.z)
        if step:
            x = x + _newton_step(system, matrix, right, alone if step < ROBUST_STEPS else limits, x)[0]
        else:
            x = system.solve(matrix, right)
    x = _settled(system, matrix, right, limits, x, LEAST_FALL)
    return Solved(x[system.place], rows @ x, factors)


def _settled(
    system: System, matrix: FloatArray, right: FloatArray, limits: Limits, x: FloatArray, least_fall: float
) -> FloatArray:
    """Return the minimum under limits, from a place nearby.

    What limits bend is soon at rest but for a few places, far from each other. These are brought to rest by
    themselves, what is around them held, before the next step of all.
    """
    for _ in range(STEPS):
        step, fall = _newton_step(system, matrix, right, limits, x)
        x = x + step
        if fall < least_fall:
            break
        moving = np.abs(step) > STILL
        if len(x) > SMALL and moving.sum() < FEW * len(x):
            some = system.around(moving, AROUND)
            x[some] = _settled_part(system, matrix, right, limits, x, some)
    return x


def _settled_part(
    system: System, matrix: FloatArray, right: FloatArray, limits: Limits, x: FloatArray, some: IntArray
) -> FloatArray:
    """Return some of the unknowns, (n,), at their minimum under limits while the others stay."""
    inside = np.zeros(len(x))
    inside[some] = 1.0
    near = np.flatnonzero(abs(limits.rows) @ inside)
    rows = chosen_rows(limits.rows, near)
    part, own = system.part(matrix, some), sp.csr_matrix(rows[:, some])
    # What the others give is a constant.
    rest = rows @ x - own @ x[some]
    system_part = System([part], [own])
    system_part.put_in_order(own)
    place = system_part.place
    x_part, right_part = np.empty(len(some)), np.empty(len(some))
    x_part[place] = x[some]
    right_part[place] = (right - system.product(matrix, x))[some] + part @ x[some]
    limits_part = Limits(
        own,
        limits.low[near] - rest,
        limits.high[near] - rest,
        limits.stiffness[near],
        limits.cap[near],
    )
    values = system_part.placed(part)
    return _settled(system_part, values, right_part, limits_part, x_part, 0.1 * LEAST_FALL)[place]


def _newton_step(
    system: System, matrix: FloatArray, right: FloatArray, limits: Limits, x: FloatArray
) -> tuple[FloatArray, float]:
    """Return a step toward the minimum under limits, and the fall that a whole one promised."""
    value = limits.rows @ x
    direction = _newton_aim(system, matrix, right, limits, value) - x
    share, fall = _line_search(system.product(matrix, direction), right, limits, x, value, direction)
    return share * direction, fall


def _newton_aim(
    system: System, matrix: FloatArray, right: FloatArray, limits: Limits, value: FloatArray
) -> FloatArray:
    """Return the minimum of the parabola that touches the function, from above where a limit gives way."""
    force = limits.force(value)
    at_work = np.flatnonzero(force)
    if len(at_work):
        rows = chosen_rows(limits.rows, at_work)
        # The secant, which is the stiffness itself until the force reaches its cap. The tangent, 0 beyond that,
        # would overshoot.
        secant = force[at_work] / limits.excess(value[at_work], at_work)
        transposed = rows.T.tocsr()
        matrix = matrix + system.normal(rows, transposed, secant)
        right = right + transposed @ (secant * value[at_work] - force[at_work])
    return system.solve(matrix, right)


def _line_search(
    along: FloatArray, right: FloatArray, limits: Limits, x: FloatArray, value: FloatArray, direction: FloatArray
) -> tuple[float, float]:
    """Return the share of a step, at most 1, after which the function no longer falls, and the fall it promised.

    `along` is the matrix times the direction, `value` what is limited at x.
    """
    start, growth = float(along @ x - right @ direction), float(along @ direction)
    rate = limits.rows @ direction
    # Excess is convex along the line: what keeps its bound at both ends keeps it between them.
    k = np.flatnonzero((limits.excess(value) != 0.0) | (limits.excess(value + rate) != 0.0))
    value, rate = value[k], rate[k]

    def slope(share: float) -> float:
        return start + share * growth + float(limits.force(value + share * rate, k) @ rate)

    low, high = 0.0, 1.0
    if slope(1.0) <= 0.0:
        low = 1.0
    else:
        for _ in range(20):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if slope(middle) <= 0.0 else (low, middle)
        low = max(low, LEAST_SHARE)
    return low, -0.5 * slope(0.0)
