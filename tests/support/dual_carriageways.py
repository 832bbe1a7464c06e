"""Two carriageways and a street that crosses them, where one may turn back."""

from __future__ import annotations

from street_cases import Case

from osm2xodr.model import RoadMap, Rule


def dual(apart: float, tags: str = "", crossing: float = 0.0) -> Case:
    """Return two carriageways whose lines are so far apart, m, and a street that crosses them at x = `crossing`."""
    half, x = apart / 2, crossing
    return Case(
        {
            "w1": (-80.0, half), "w2": (-80.0, -half), "e1": (80.0, half), "e2": (80.0, -half),
            "o1": (x, half), "o2": (x, -half), "n": (x, 60.0), "s": (x, -60.0),
        },
        {
            1: ("o1 w1", f"oneway=yes {tags}"), 2: ("w2 o2", f"oneway=yes {tags}"),
            3: ("e1 o1", f"oneway=yes {tags}"), 4: ("o2 e2", f"oneway=yes {tags}"),
            5: ("s o2", "highway=residential"), 6: ("o2 o1", "highway=residential"),
            7: ("o1 n", "highway=residential"),
        },
    )  # fmt: skip


def built(case: Case, rule: Rule, u_turns: str = "law", country: str = "") -> RoadMap:
    """Convert a case, or its mirror image where traffic keeps to the left."""
    return (case if rule is Rule.RIGHT_HAND else case.mirrored()).build(rule, u_turns=u_turns, country=country)
