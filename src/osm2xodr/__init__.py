"""OpenStreetMap and a GeoTIFF elevation model in, an ASAM OpenDRIVE road network out."""

# The only place where it stands: the build reads it here. Asking the installed package's metadata for it would take
# longer than most imports.
__version__ = "0.1.0"
