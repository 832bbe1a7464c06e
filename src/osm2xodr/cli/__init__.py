"""The command line: the only package that reads options and prints messages."""

from __future__ import annotations

from osm2xodr.cli.program import main

__all__ = ["main"]
