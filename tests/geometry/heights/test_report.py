"""What is told about heights that could not be as wanted."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from elevation_helpers import make_problem, straight

from osm2xodr.diagnostics import Diagnostics
from osm2xodr.geometry.heights.readings import Reading
from osm2xodr.geometry.heights.report import Outcome, _report_crossings
from osm2xodr.geometry.heights.structures import Crossings


def test_a_clearance_of_nothing_has_no_sign() -> None:
    problem = make_problem(
        [straight((-50.0, 0.0), (50.0, 0.0), spans=[(0.0, 1, 1)]), straight((0.0, -50.0), (0.0, 50.0))]
    )
    road, none = np.array([0], np.int64), np.zeros(0)
    crossings = Crossings(road, np.array([50.0]), road + 1, np.array([50.0]), np.array([5.2]))
    no_road = np.zeros(0, np.int64)
    reading = Reading(none, none, none, none, none, none > 0, none > 0)
    outcome = Outcome(none, reading, none > 0, none, none, crossings, np.array([-0.04]), no_road, none)
    for height, word in ((-0.04, "0.0"), (-0.3, "-0.3"), (1.26, "1.3")):
        diagnostics = Diagnostics()
        _report_crossings(problem, replace(outcome, clearance=np.array([height])), diagnostics)
        (told,) = diagnostics
        assert told.osm_id == "way/100"
        assert told.message.startswith(f"it passes {word} m above way/101 instead of 5.2 m")
