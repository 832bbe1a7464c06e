"""A road network as a picture."""

from __future__ import annotations

from osm2xodr.viewing.picture.contents import box_of_degrees, make_picture
from osm2xodr.viewing.picture.png import draw_png
from osm2xodr.viewing.picture.svg import draw_svg

__all__ = ["box_of_degrees", "draw_png", "draw_svg", "make_picture"]
