"""The solve: robust least squares on a beam network with elastic limits, a few sparse factorisations in all."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import splu

from osm2xodr.model import FloatArray, IntArray

# Added to the diagonal, so that what nothing determines stays at the mean height instead of failing the solve.
TINY = 1e-9
# No observation loses more of its weight than this: where all that there is stands out, it still holds the road.
LEAST_FACTOR = 1e-3
# Most steps of the solve, those in which the robust weights follow, and the fall of the function that is worth none.
STEPS = 30
ROBUST_STEPS = 4
LEAST_FALL = 0.1
# Steps of each stage on the way through canopy and roofs.
STAGE_STEPS = 4
# A line search always goes on by this share, so that rounding cannot stop it short of the minimum.
LEAST_SHARE = 1e-3
_ALL = slice(None)


@dataclass(frozen=True, slots=True, eq=False)
class Observations:
    """Heights that the unknowns should meet.

    Parameters
    ----------
    rows : (n, N)
        Matrix from unknowns to the heights at the samples.
    z : (n,)
        Observed heights, m.
    weight : (n,)
        Weight of the squared residual, 1/m².
    sigma : (n,)
        Standard error of one observation, m; what the robust weights measure residuals by.
    """

    rows: sp.csr_matrix
    z: FloatArray
    weight: FloatArray
    sigma: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Limits:
    """Elastic bounds on linear functions of the unknowns.

    Parameters
    ----------
    rows : (m, N)
        The functions.
    low, high : (m,)
        Their bounds; infinite where there is none.
    stiffness : (m,)
        Force per excess.
    cap : (m,)
        Largest force: what asks for more gives way. Infinite where the bound must hold.
    """

    rows: sp.csr_matrix
    low: FloatArray
    high: FloatArray
    stiffness: FloatArray
    cap: FloatArray

    def excess(self, value: FloatArray, index: IntArray | slice = _ALL) -> FloatArray:
        """Return by how much the values of some functions are beyond their bounds, with its sign."""
        out: FloatArray = value - np.clip(value, self.low[index], self.high[index])
        return out

    def force(self, value: FloatArray, index: IntArray | slice = _ALL) -> FloatArray:
        """Return the force with which the values of some functions are pushed back."""
        cap = self.cap[index]
        out: FloatArray = np.clip(self.stiffness[index] * self.excess(value, index), -cap, cap)
        return out


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
    """How residuals lose weight: by (1 + (r / (k sigma))²) to the power -1, later -2.

    Parameters
    ----------
    above, below
        k for observations above and below the road, (n,) or one for all.
    least
        The factor that they keep at least, (n,) or one for all.
    """

    above: FloatArray | float
    below: FloatArray | float
    least: FloatArray | float = LEAST_FACTOR

    def factors(self, residual: FloatArray, sigma: FloatArray, late: bool) -> FloatArray:
        """Return the factor on each weight; `residual` is observed minus solved, m."""
        k = np.where(residual > 0, self.above, self.below)
        base = 1.0 / (1.0 + (residual / (k * sigma)) ** 2)
        return np.maximum(base * base if late else base, self.least)


@dataclass(frozen=True, slots=True, eq=False)
class Stage:
    """A stiffer network to begin with.

    Parameters
    ----------
    stiffness : (N, N)
        Its stiffness.
    tolerance
        How far the ground may leave what so stiff a road follows, m.
    """

    stiffness: sp.csr_matrix
    tolerance: float


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
    transposed = obs.rows.T.tocsr()
    factors = np.ones(len(obs.z))
    for stage in stages:
        sigma = np.hypot(obs.sigma, stage.tolerance)
        for _ in range(STAGE_STEPS):
            weight = obs.weight * factors
            matrix = stage.stiffness + transposed @ sp.diags(weight) @ obs.rows
            x = solve_symmetric(matrix, transposed @ (weight * obs.z))
            factors = robust.factors(obs.z - obs.rows @ x, sigma, late=False)
    return factors


def solve_symmetric(matrix: sp.csr_matrix, rhs: FloatArray) -> FloatArray:
    """Solve a sparse symmetric positive definite system. Chains eliminate without fill: linear in road length."""
    system = sp.csc_matrix(matrix + sp.diags(np.full(matrix.shape[0], TINY)))
    # Rows have a handful of entries: panels of columns, made for denser systems, would only cost time.
    factor = splu(
        system,
        permc_spec="MMD_AT_PLUS_A",
        diag_pivot_thresh=0.0,
        relax=4,
        panel_size=1,
        options={"SymmetricMode": True},
    )
    x: FloatArray = factor.solve(rhs)
    return x


def solve_network(
    stiffness: sp.csr_matrix,
    observations: Observations,
    inner: Limits,
    limits: Limits,
    robust: Robust,
    first: FloatArray | None = None,
) -> tuple[FloatArray, FloatArray]:
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
        What is known.
    inner
        Limits that a road has by itself.
    limits
        All limits.
    robust
        How outliers lose weight.
    first : (n,), optional
        Factors on the weights to begin with.

    Returns
    -------
    x : (N,)
        The unknowns.
    factors : (n,)
        The robust factors that were put on the observations' weights.
    """
    obs = observations
    factors = np.ones(len(obs.z)) if first is None else first
    transposed = obs.rows.T.tocsr()
    x = np.zeros(0)
    for step in range(STEPS):
        if step <= ROBUST_STEPS:
            if step:
                factors = robust.factors(obs.z - obs.rows @ x, obs.sigma, late=step > 2)
            weight = obs.weight * factors
            matrix = stiffness + transposed @ sp.diags(weight) @ obs.rows
            right = transposed @ (weight * obs.z)
        if not step:
            x = solve_symmetric(matrix, right)
            continue
        bounds = inner if step < ROBUST_STEPS else limits
        direction = _newton_aim(matrix, right, bounds, x) - x
        share, fall = _line_search(matrix, right, bounds, x, direction)
        x = x + share * direction
        if step > ROBUST_STEPS and fall < LEAST_FALL:
            break
    return x, factors


def _newton_aim(matrix: sp.csr_matrix, right: FloatArray, limits: Limits, x: FloatArray) -> FloatArray:
    """Return the minimum of the parabola that touches the function at x, from above where a limit gives way."""
    value = limits.rows @ x
    force = limits.force(value)
    at_work = np.flatnonzero(force)
    if len(at_work):
        rows = limits.rows[at_work.tolist()]
        # The secant, which is the stiffness itself until the force reaches its cap. The tangent, 0 beyond that,
        # would overshoot.
        secant = force[at_work] / limits.excess(value)[at_work]
        matrix = matrix + rows.T @ sp.diags(secant) @ rows
        right = right + rows.T @ (secant * value[at_work] - force[at_work])
    return solve_symmetric(matrix, right)


def _line_search(
    matrix: sp.csr_matrix, right: FloatArray, limits: Limits, x: FloatArray, direction: FloatArray
) -> tuple[float, float]:
    """Return the share of a step, at most 1, after which the function no longer falls, and the fall it promised."""
    along = matrix @ direction
    start, growth = float(along @ x - right @ direction), float(along @ direction)
    value, rate = limits.rows @ x, limits.rows @ direction
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
