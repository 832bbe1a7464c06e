"""Folders that simulators run: a road network with traffic, a scenario or a script, and the command that starts it.

Made of the conversion and the exports of `osm2xodr.python_api`; a module for each simulator adds what that needs.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from osm2xodr.starting.request import NOT_CHOSEN as NOT_CHOSEN, SIMULATORS as SIMULATORS
from osm2xodr.system import lazy_exports

if TYPE_CHECKING:
    from osm2xodr.starting.folder import Started as Started, start as start

__getattr__ = lazy_exports(__name__, {"folder": ("Started", "start")})
