"""Fetching the data of an area: a map from the Overpass API or an extract, and elevation models, all with sources.

`area` has the steps in order. `place` finds places by their names, too, `overpass` asks for maps; `models` and
``elevation_models.ini`` say where elevation models are, `elevation` and `rasters` read windows of them. `connection`
and `downloads` are what touches the network, apart from GDAL.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from osm2xodr.system import lazy_exports

if TYPE_CHECKING:
    from osm2xodr.fetching.area import FetchedArea as FetchedArea, fetch_area as fetch_area
    from osm2xodr.fetching.models import ElevationModel as ElevationModel, read_models as read_models
    from osm2xodr.fetching.options import (
        CACHE_AGE as CACHE_AGE,
        DOWNLOAD_MAX as DOWNLOAD_MAX,
        ELEVATION_MODEL as ELEVATION_MODEL,
        GEOCODER as GEOCODER,
        OVERPASS_SERVERS as OVERPASS_SERVERS,
        PATIENCE as PATIENCE,
        RETRIES as RETRIES,
        FetchOptions as FetchOptions,
        Network as Network,
        ServerError as ServerError,
        Shows as Shows,
    )
    from osm2xodr.fetching.place import Place as Place, place_of_box as place_of_box, place_of_file as place_of_file

__getattr__ = lazy_exports(
    __name__,
    {
        "area": ("FetchedArea", "fetch_area"),
        "options": (
            "CACHE_AGE",
            "DOWNLOAD_MAX",
            "ELEVATION_MODEL",
            "GEOCODER",
            "OVERPASS_SERVERS",
            "PATIENCE",
            "RETRIES",
            "FetchOptions",
            "Network",
            "ServerError",
            "Shows",
        ),
        "models": ("ElevationModel", "read_models"),
        "place": ("Place", "place_of_box", "place_of_file"),
    },
)
