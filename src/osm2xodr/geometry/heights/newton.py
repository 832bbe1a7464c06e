"""The solve: robust least squares under elastic limits, by Newton's method with a few sparse factorisations.

The objective and why it is minimised this way: docs/method/heights.md.
"""

from __future__ import annotations

from typing import Final

import numpy as np
import scipy.sparse as sp

from osm2xodr.curves import dot
from osm2xodr.geometry.heights.limits import Limits
from osm2xodr.geometry.heights.observations import Observations
from osm2xodr.geometry.heights.sparse import System, chosen_rows
from osm2xodr.model import BoolArray, FloatArray, IntArray
from osm2xodr.system import record, release_memory

# Rounds in which the robust weights are set anew, and those of them that use Cauchy's loss before Geman-McClure's.
_ROBUST_ROUNDS: Final = 4
_CAUCHY_ROUNDS: Final = 2
# Most Newton steps after these, and the promised fall of the objective at which they stop (its unit is a squared
# standard error, halved). A part that is solved by itself must promise this share of it.
_NEWTON_STEPS: Final = 30
_SMALLEST_FALL: Final = 0.1
_FALL_SHARE_OF_PART: Final = 0.1
# Unknowns that a step moves by less are at rest, m. In networks of more unknowns than this, the moving ones are
# solved by themselves if they are less than this share, together with those this many steps away in the pattern.
_AT_REST: Final = 1e-4
_PARTS_FROM: Final = 4000
_MOVING_SHARE: Final = 0.2
_NEIGHBOUR_STEPS: Final = 4
# The line search halves its interval this many times, and always goes on by this share of a step, so that rounding
# cannot stop it short of the minimum.
_BISECTIONS: Final = 20
_SHORTEST_STEP: Final = 1e-3


@record(eq=False)
class Solved:
    """The minimum."""

    x: FloatArray  # (N,) The unknowns
    value: FloatArray  # (n,) The observed functions there
    factors: FloatArray  # (n,) Robust factors on the observations' weights


@record(eq=False)
class _Objective:
    """x·matrix·x / 2 - right·x plus the energy of the limits, in the order of the system."""

    system: System
    matrix: FloatArray  # The system's values
    right: FloatArray  # (N,)
    limits: Limits


def solve_network(stiffness: sp.csr_matrix, obs: Observations, limits: Limits, factors: FloatArray) -> Solved:
    """Minimise bending, tension and misfit under elastic limits.

    The robust weights are set in the first rounds, under the roads' own limits only, and then stay: an observation is
    no outlier because another road bends this one away from it.

    The quadratic part that does not change is the stiffness, (N, N); factors, (n,), are on the observations' weights
    to begin with. The rows of observations and limits are used up: afterwards the order of their columns is that of
    the elimination.
    """
    rows = obs.rows
    system = System([stiffness], [rows, limits.rows])
    system.put_in_order(rows)
    system.put_in_order(limits.rows)
    own = limits.own_only()
    transposed = rows.T.tocsr()
    plain = system.placed(stiffness)
    release_memory()
    x = np.zeros(0)
    for step in range(_ROBUST_ROUNDS + 1):
        if step:
            residual = obs.value - rows @ x
            factors = obs.robust_factors(residual, obs.sigma, geman_mcclure=step > _CAUCHY_ROUNDS)
        weight = obs.weight * factors
        matrix = plain + system.normal(rows, transposed, weight)
        right = transposed @ (weight * obs.value)
        objective = _Objective(system, matrix, right, own if step < _ROBUST_ROUNDS else limits)
        x = x + _newton_step(objective, x)[0] if step else system.solve(matrix, right)
    x = _settle(objective, x, _SMALLEST_FALL)
    return Solved(x[system.place], rows @ x, factors)


def _settle(objective: _Objective, x: FloatArray, smallest_fall: float) -> FloatArray:
    """Return the minimum, from a place nearby.

    Most of the network is soon at rest; a few places, far from each other, still move. They are solved by themselves,
    with their surroundings held, before the next step of all.
    """
    for _ in range(_NEWTON_STEPS):
        step, fall = _newton_step(objective, x)
        x = x + step
        if fall < smallest_fall:
            break
        moving: BoolArray = np.abs(step) > _AT_REST
        if len(x) > _PARTS_FROM and moving.sum() < _MOVING_SHARE * len(x):
            some = objective.system.around(moving, _NEIGHBOUR_STEPS)
            x[some] = _settle_part(objective, x, some)
    return x


def _settle_part(objective: _Objective, x: FloatArray, some: IntArray) -> FloatArray:
    """Return some of the unknowns, (n,), at their minimum while the others stay."""
    system, matrix, limits = objective.system, objective.matrix, objective.limits
    inside = np.zeros(len(x))
    inside[some] = 1.0
    near = np.flatnonzero(abs(limits.rows) @ inside)
    rows = chosen_rows(limits.rows, near)
    part, rows_part = system.part(matrix, some), sp.csr_matrix(rows[:, some])
    # What the others give is a constant.
    rest = rows @ x - rows_part @ x[some]
    system_part = System([part], [rows_part])
    system_part.put_in_order(rows_part)
    place = system_part.place
    x_part, right = np.empty(len(some)), np.empty(len(some))
    x_part[place] = x[some]
    right[place] = (objective.right - system.product(matrix, x))[some] + part @ x[some]
    low, high = limits.low[near] - rest, limits.high[near] - rest
    limits_part = Limits(rows_part, low, high, limits.stiffness[near], limits.cap[near], limits.own[near])
    objective_part = _Objective(system_part, system_part.placed(part), right, limits_part)
    return _settle(objective_part, x_part, _FALL_SHARE_OF_PART * _SMALLEST_FALL)[place]


def _newton_step(objective: _Objective, x: FloatArray) -> tuple[FloatArray, float]:
    """Return a step toward the minimum, and the fall that a whole one promised."""
    value = objective.limits.rows @ x
    direction = _newton_aim(objective, value) - x
    share, fall = _line_search(objective, x, value, direction)
    return share * direction, fall


def _newton_aim(objective: _Objective, value: FloatArray) -> FloatArray:
    """Return the minimum of the parabola that touches the objective, from above where a limit is at its cap.

    A limit's curvature is taken as the secant from its bound, force / excess: the stiffness itself until the force
    reaches its cap. The tangent, 0 beyond that, would overshoot.
    """
    system, limits = objective.system, objective.limits
    matrix, right = objective.matrix, objective.right
    force = limits.force(value)
    at_work = np.flatnonzero(force)
    if len(at_work):
        rows = chosen_rows(limits.rows, at_work)
        secant = force[at_work] / limits.excess(value[at_work], at_work)
        transposed = rows.T.tocsr()
        matrix = matrix + system.normal(rows, transposed, secant)
        right = right + transposed @ (secant * value[at_work] - force[at_work])
    return system.solve(matrix, right)


def _line_search(
    objective: _Objective, x: FloatArray, value: FloatArray, direction: FloatArray
) -> tuple[float, float]:
    """Return the share of a step, at most 1, after which the objective no longer falls, and the fall it promised.

    `value` is that of the limited functions at x.
    """
    limits = objective.limits
    along = objective.system.product(objective.matrix, direction)
    start, growth = dot(along, x) - dot(objective.right, direction), dot(along, direction)
    rate = limits.rows @ direction
    # Excess is convex along the line: what keeps its bound at both ends keeps it between them.
    k = np.flatnonzero((limits.excess(value) != 0.0) | (limits.excess(value + rate) != 0.0))
    value, rate = value[k], rate[k]

    def slope(share: float) -> float:
        return start + share * growth + dot(limits.force(value + share * rate, k), rate)

    fall = -0.5 * slope(0.0)
    if slope(1.0) <= 0.0:
        return 1.0, fall
    low, high = 0.0, 1.0
    for _ in range(_BISECTIONS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if slope(middle) <= 0.0 else (low, middle)
    return max(low, _SHORTEST_STEP), fall
