"""The command line: the only package that reads options and prints messages."""

from __future__ import annotations

from typing import TYPE_CHECKING

from osm2xodr.cli.program import main as main
from osm2xodr.system import lazy_exports

if TYPE_CHECKING:
    from osm2xodr.cli.areas import batch as batch

__getattr__ = lazy_exports(__name__, {"areas": ("batch",)})
