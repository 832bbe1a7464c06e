"""Prints the oldest versions of the libraries that osm2xodr says it works with, for ``pip install --requirement``.

What only checks the code or reads its output is left out, as are libraries for which no oldest version is named.
"""

from __future__ import annotations

import importlib.metadata
import re

# Linters, types, real readers of OpenDRIVE, and what documents are made with.
NOT_NEEDED = frozenset(
    {
        "lxml-stubs",
        "mypy",
        "ruff",
        "scipy-stubs",
        "eclipse-sumo",
        "asam-qc-opendrive",
        "asam-qc-openscenarioxml",
        "carla",
        "lanelet2",
        "cython",
        "build",
        "check-jsonschema",
        "furo",
        "pyyaml",
        "latex2mathml",
        "matplotlib",
        "myst-parser",
        "sphinx",
    }
)
EXTRA = "test"


def oldest(requirements: list[str]) -> list[str]:
    """Return the lower bound of each requirement that is needed, as ``name==version``."""
    found = []
    for requirement in requirements:
        match = re.match(r"([A-Za-z0-9._-]+)\s*(?:<[^,;]*,)?>=([0-9.]+)", requirement)
        extra = re.search(r"extra == ['\"](\w+)['\"]", requirement)
        if match and match[1] not in NOT_NEEDED and (extra is None or extra[1] == EXTRA):
            found.append(f"{match[1]}=={match[2]}")
    return found


if __name__ == "__main__":
    print("\n".join(oldest(importlib.metadata.requires("osm2xodr") or [])))
