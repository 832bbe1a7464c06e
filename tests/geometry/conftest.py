"""Fixtures of the tests of this folder."""

from even_lanes import even_lanes as even_lanes
