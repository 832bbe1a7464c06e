"""The page to explore a road network with."""

from __future__ import annotations

from osm2xodr.viewing.page.html import write_report as write_report
