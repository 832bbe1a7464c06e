"""OpenStreetMap and a GeoTIFF elevation model in, an ASAM OpenDRIVE road network out.

>>> import osm2xodr
>>> network = osm2xodr.convert("area.osm", dem="dem.tif")  # doctest: +SKIP
>>> network.write("area.xodr")  # doctest: +SKIP

`fetch` gets the map and elevation models of a place, `convert` makes a road network of them, `batch` makes many, and
`start` a folder that a simulator runs. `read`, `check`, `report`, `render`, `locate`, `export`, `export_scene`,
`crop` and `merge` work with OpenDRIVE files of any writer.

A road network, `RoadNetwork`, has `roads`, `junctions` and `signals`, and `to_geodataframe`, `to_geopackage` and
`to_networkx` for Python's tools. All functions and `Locator` take it in place of a file.

>>> road = network.roads["12"]  # doctest: +SKIP
>>> road.name, road.osm_ways, road.height(20.0), road.lanes(20.0)  # doctest: +SKIP

Options of the command line are keywords. All that can go wrong is an `Osm2xodrError`. Everything is loaded when first
used.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from osm2xodr.system import lazy_exports

if TYPE_CHECKING:
    from osm2xodr.cli import batch as batch
    from osm2xodr.diagnostics import Diagnostic as Diagnostic, Diagnostics as Diagnostics, Kind as Kind
    from osm2xodr.errors import (
        CoverageError as CoverageError,
        EmptyAreaError as EmptyAreaError,
        InputError as InputError,
        OptionError as OptionError,
        Osm2xodrError as Osm2xodrError,
        OutputError as OutputError,
    )
    from osm2xodr.opendrive import Locator as Locator
    from osm2xodr.python_api import (
        AreaKeywords as AreaKeywords,
        Conversion as Conversion,
        ConvertKeywords as ConvertKeywords,
        ConvertOptions as ConvertOptions,
        Elements as Elements,
        Junction as Junction,
        Lane as Lane,
        Road as Road,
        RoadNetwork as RoadNetwork,
        Signal as Signal,
        check as check,
        convert as convert,
        crop as crop,
        export as export,
        export_scene as export_scene,
        fetch as fetch,
        locate as locate,
        merge as merge,
        read as read,
        render as render,
        report as report,
    )
    from osm2xodr.reporting import Written as Written
    from osm2xodr.starting import Started as Started, start as start
    from osm2xodr.xodrWriter import WriteOptions as WriteOptions

# The only place where it stands: the build reads it here. Asking the installed package's metadata for it would take
# longer than most imports.
__version__ = "0.1.0"

_EXPORTS = {
    "cli": ("batch",),
    "diagnostics": ("Diagnostic", "Diagnostics", "Kind"),
    "errors": ("CoverageError", "EmptyAreaError", "InputError", "OptionError", "Osm2xodrError", "OutputError"),
    "python_api": (
        "AreaKeywords",
        "ConvertKeywords",
        "Conversion",
        "ConvertOptions",
        "check",
        "convert",
        "Elements",
        "Junction",
        "Lane",
        "Road",
        "RoadNetwork",
        "Signal",
        "crop",
        "export",
        "export_scene",
        "fetch",
        "locate",
        "merge",
        "read",
        "render",
        "report",
    ),
    "opendrive": ("Locator",),
    "reporting": ("Written",),
    "starting": ("Started", "start"),
    "xodrWriter": ("WriteOptions",),
}

if not TYPE_CHECKING:
    # Type checkers know all names, and would take any other for one that this finds.
    __all__ = ["__version__", *sorted(name for names in _EXPORTS.values() for name in names)]  # noqa: PLE0604 (all are)
    __getattr__ = lazy_exports(__name__, _EXPORTS)


def __dir__() -> list[str]:
    """Return the names that the library offers, loaded or not."""
    return list(globals()["__all__"])
