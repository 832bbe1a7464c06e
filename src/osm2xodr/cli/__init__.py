"""The command line: the only place that reads options and talks to people."""

from __future__ import annotations

from osm2xodr.cli.program import main

__all__ = ["main"]
