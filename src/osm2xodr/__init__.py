"""OpenStreetMap and a GeoTIFF elevation model in, an ASAM OpenDRIVE road network out."""

from importlib.metadata import version

__version__ = version("osm2xodr")
