"""The page to explore a road network with."""

from __future__ import annotations

from osm2xodr.viewing.page.html import make_report

__all__ = ["make_report"]
