"""Reference lines against closed forms and an independent integration.

Heights and cross slopes, and the surface that they make.

Borders of lanes, and sections and lanes at places.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.special import fresnel
from xodr_text import cubics, document, geometry, lane, read_text, road, section

from osm2xodr.model import FloatArray
from osm2xodr.opendrive.space.finder import places_on
from osm2xodr.opendrive.space.positions import (
    curvature,
    elevation,
    grade,
    lane_borders,
    pose,
    record_lengths,
    section_at,
    surface_points,
)
from osm2xodr.opendrive.tables import ABSENT, OpenDrive

FIRST = np.zeros(1, np.int64)

LANES = (
    cubics("laneOffset", (0, 1.0), (50, 2.0))
    + section(0.0, lane(2, (0, 2.0)) + lane(1, (0, 3.0, 0.1)), lane(-1, (0, 4.0), (10, 5.0)))
    + section(50.0, lane(1, (0, 6.0), border=True), lane(-1, (0, -1.0), border=True) + lane(-2, (0, 2.0)))
)


def at(file: OpenDrive, s: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    return pose(file, np.zeros(len(s), np.int64), s)


def test_lines_and_arcs(tmp_path: Path) -> None:
    plan = geometry("<line/>", 10.0, x=1.0, y=2.0, hdg=math.pi / 2)
    plan += geometry('<arc curvature="0.1"/>', 5 * math.pi, 10.0, 1.0, 12.0, math.pi / 2)
    file = read_text(tmp_path, document(road(plan=plan, length=10 + 5 * math.pi)))
    x, y, hdg = at(file, np.array([0.0, 10.0, 10 + 2.5 * math.pi, 10 + 5 * math.pi]))
    half = 10 * math.sqrt(0.5)
    np.testing.assert_allclose(x, [1, 1, -9 + half, -9], atol=1e-9)
    np.testing.assert_allclose(y, [2, 12, 12 + half, 22], atol=1e-9)
    np.testing.assert_allclose(hdg, [math.pi / 2, math.pi / 2, 0.75 * math.pi, math.pi])
    assert curvature(file, FIRST, np.array([10.0])).tolist() == [0.1]
    assert curvature(file, FIRST, np.array([10.0]), before=True).tolist() == [0.0]


@pytest.mark.parametrize("end", [0.02, -0.05, 0.5, -2.0])
def test_spirals_against_fresnel_integrals(tmp_path: Path, end: float) -> None:
    length = 100.0
    file = read_text(
        tmp_path, document(road(plan=geometry(f'<spiral curvStart="0" curvEnd="{end}"/>', length), length=length))
    )
    s = np.linspace(0, length, 41)
    # x + iy is the integral of exp(i a s² / 2) with a = end / length.
    scale = math.sqrt(math.pi * length / abs(end))
    sine, cosine = fresnel(s / scale)
    x, y, hdg = at(file, s)
    np.testing.assert_allclose(x, scale * cosine, atol=1e-6)
    np.testing.assert_allclose(y, math.copysign(1, end) * scale * sine, atol=1e-6)
    np.testing.assert_allclose(hdg, end / length * s * s / 2)
    np.testing.assert_allclose(curvature(file, np.zeros(41, np.int64), s), end * s / length)


def test_spirals_between_curvatures_against_integration(tmp_path: Path) -> None:
    first, last, length = 0.05, -0.1, 60.0
    shape = f'<spiral curvStart="{first}" curvEnd="{last}"/>'
    file = read_text(tmp_path, document(road(plan=geometry(shape, length), length=length)))

    def step(s: float, state: FloatArray, /) -> FloatArray:
        turn = first * s + 0.5 * (last - first) / length * s * s
        return np.array([math.cos(turn), math.sin(turn)])

    s = np.linspace(0, length, 13)
    goal = solve_ivp(step, (0, length), [0.0, 0.0], t_eval=s, rtol=1e-11, atol=1e-11).y
    x, y, _ = at(file, s)
    np.testing.assert_allclose([x, y], goal, atol=1e-7)


@pytest.mark.parametrize("normalized", [True, False])
def test_polynomials_follow_their_arc_length(tmp_path: Path, normalized: bool) -> None:
    """A curve whose parameter is far from its arc length: u = 20 p, v = 30 p³ over p from 0 to 1."""
    fine = np.linspace(0, 1, 200_001)
    speed = np.hypot(20.0, 90 * fine**2)
    arc = np.concatenate([[0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(fine))])
    length = float(arc[-1])
    top = 1.0 if normalized else length
    shape = (
        f'<paramPoly3 aU="0" bU="{20 / top!r}" cU="0" dU="0" aV="0" bV="0" cV="0" dV="{30 / top**3!r}"'
        f' pRange="{"normalized" if normalized else "arcLength"}"/>'
    )
    file = read_text(tmp_path, document(road(plan=geometry(shape, length), length=length)))
    s = np.linspace(0, length, 23)
    p = np.interp(s, arc, fine)
    x, y, hdg = at(file, s)
    np.testing.assert_allclose(x, 20 * p, atol=1e-6)
    np.testing.assert_allclose(y, 30 * p**3, atol=1e-6)
    np.testing.assert_allclose(hdg, np.arctan2(90 * p**2, 20), atol=1e-6)
    bend = 20 * 180 * p / np.hypot(20, 90 * p**2) ** 3
    np.testing.assert_allclose(curvature(file, np.zeros(23, np.int64), s), bend, atol=1e-6)
    np.testing.assert_allclose(record_lengths(file), [length], rtol=1e-6)


def test_a_wrong_length_of_a_polynomial_is_found_and_its_end_stays(tmp_path: Path) -> None:
    shape = '<paramPoly3 aU="0" bU="20" cU="0" dU="0" aV="0" bV="0" cV="0" dV="0" pRange="normalized"/>'
    file = read_text(tmp_path, document(road(plan=geometry(shape, 20.5), length=20.5)))
    assert record_lengths(file)[0] == pytest.approx(20.0)
    assert at(file, np.array([20.5]))[0][0] == pytest.approx(20.0)


def test_a_quarter_circle_as_polynomial(tmp_path: Path) -> None:
    """The usual cubic of a quarter circle of 10 m is off by 2.8e-4 of the radius at most."""
    k = 0.5522847498
    # Bézier points (0, 0), (k, 0), (1, 1 - k), (1, 1) of a circle about (0, 1) as powers of p, times 10.
    u = 10 * np.array([0, 3 * k, 3 - 6 * k, 3 * k - 2])
    v = 10 * np.array([0, 0, 3 - 3 * k, 3 * k - 2])
    names = [f'{name}="{value!r}"' for name, value in zip(("aU", "bU", "cU", "dU"), u.tolist(), strict=True)]
    names += [f'{name}="{value!r}"' for name, value in zip(("aV", "bV", "cV", "dV"), v.tolist(), strict=True)]
    shape = f'<paramPoly3 {" ".join(names)} pRange="normalized"/>'
    length = 5 * math.pi
    file = read_text(tmp_path, document(road(plan=geometry(shape, length), length=length)))
    s = np.linspace(0, length, 31)
    x, y, hdg = at(file, s)
    np.testing.assert_allclose(np.hypot(x, y - 10), 10, atol=3e-3)
    np.testing.assert_allclose(hdg, s / 10, atol=4e-3)


def test_cubics_over_u(tmp_path: Path) -> None:
    file = read_text(
        tmp_path, document(road(plan=geometry('<poly3 a="0" b="0" c="0.05" d="0"/>', 20.0), length=20.0))
    )
    s = np.linspace(0, 20, 9)
    x, y, _ = at(file, s)
    np.testing.assert_allclose(y, 0.05 * x**2, atol=1e-9)
    # Arc length of a parabola.
    r = 0.1 * x
    np.testing.assert_allclose((r * np.sqrt(1 + r**2) + np.arcsinh(r)) / 0.2, s, atol=1e-6)


def test_elevation_and_its_slope(tmp_path: Path) -> None:
    file = read_text(tmp_path, document(road(elevation=cubics("elevation", (0, 1.0, 0.1), (50, 7.0, 0.0, 0.01)))))
    roads, s = np.zeros(3, np.int64), np.array([20.0, 50.0, 60.0])
    np.testing.assert_allclose(elevation(file, roads, s), [3, 7, 8])
    np.testing.assert_allclose(elevation(file, roads, s, before=True), [3, 6, 8])
    np.testing.assert_allclose(grade(file, roads, s), [0.1, 0.0, 0.2])


def test_superelevation_makes_a_plane(tmp_path: Path) -> None:
    roll = 0.1
    file = read_text(
        tmp_path,
        document(road(elevation=cubics("elevation", (0, 5.0)), lateral=cubics("superelevation", (0, roll)))),
    )
    t = np.array([-10.0, 0.0, 10.0])
    x, y, z = surface_points(file, np.zeros(3, np.int64), np.full(3, 30.0), t, 1.0)
    np.testing.assert_allclose(x, 30)
    np.testing.assert_allclose(y, t * math.cos(roll) - math.sin(roll))
    np.testing.assert_allclose(z, 5 + t * math.sin(roll) + math.cos(roll))


def test_borders_add_up_from_the_lane_offset(tmp_path: Path) -> None:
    file = read_text(tmp_path, document(road(lanes=LANES)))
    assert file.lanes.id.tolist() == [2, 1, 0, -1, 1, 0, -1, -2]
    inner, outer = lane_borders(file, np.arange(4), np.full(4, 20.0))
    np.testing.assert_allclose(inner, [6, 1, 1, 1])
    np.testing.assert_allclose(outer, [8, 6, 1, -4])
    inner, outer = lane_borders(file, np.arange(4, 8), np.full(4, 60.0))
    np.testing.assert_allclose(inner, [2, 2, 2, 1])
    np.testing.assert_allclose(outer, [8, 2, 1, -1])


def test_the_end_of_a_section_is_its_own(tmp_path: Path) -> None:
    file = read_text(tmp_path, document(road(lanes=LANES)))
    inner, outer = lane_borders(file, np.array([1]), np.array([50.0]), before=True)
    np.testing.assert_allclose([inner[0], outer[0]], [1, 9])
    inner, outer = lane_borders(file, np.array([3]), np.array([10.0]), before=True)
    np.testing.assert_allclose(outer, [-3])


def test_lanes_at_places(tmp_path: Path) -> None:
    file = read_text(tmp_path, document(road(lanes=LANES), road("2", lanes="")))
    s = np.array([20.0, 20.0, 20.0, 60.0, 20.0])
    t = np.array([7.0, -3.9, -4.1, 0.0, 0.0])
    roads = np.array([0, 0, 0, 0, 1])
    places = places_on(file, roads, s, t)
    assert places.lane.tolist() == [0, 3, 3, 7, ABSENT]
    assert places.inside.tolist() == [True, True, False, True, False]
    np.testing.assert_allclose(places.distance, [0.0, 0.0, 0.1, 0.0, 0.0])
    assert section_at(file, roads, np.full(5, 50.0)).tolist() == [1, 1, 1, 1, ABSENT]
    assert section_at(file, roads[:1], np.array([50.0]), before=True).tolist() == [0]
