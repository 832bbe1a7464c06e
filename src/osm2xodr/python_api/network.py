"""A road network: what `read` returns, and `convert` with more.

Imports nothing heavy: a conversion needs none of it.
"""

from __future__ import annotations

from functools import cached_property
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, get_args

from osm2xodr.defaults import SAMPLE_STEP, SAMPLE_TOLERANCE
from osm2xodr.diagnostics import counted

if TYPE_CHECKING:
    from osm2xodr.opendrive import OpenDrive
    from osm2xodr.python_api.files import AnyPath
    from osm2xodr.python_api.nouns import Elements, Junction, Road, Signal, View

Layer = Literal["lanes", "roads", "signals"]


def read(file: AnyPath) -> RoadNetwork:
    """Read an OpenDRIVE file, 1.4 to 1.8, of any writer.

    Parameters
    ----------
    file
        The file, plain or packed by gzip; ``-`` is standard input.

    Returns
    -------
    RoadNetwork
        Its roads, junctions and signals; `RoadNetwork.tables` has all of it as arrays.

    Raises
    ------
    InputError
        The file cannot be read, is no XML, or no OpenDRIVE.

    Examples
    --------
    >>> import osm2xodr
    >>> network = osm2xodr.read("area.xodr")  # doctest: +SKIP
    >>> [road.name for road in network.roads if road.length > 100.0]  # doctest: +SKIP
    """
    from osm2xodr.opendrive import read_xodr

    return RoadNetwork(read_xodr(Path(file)))


class RoadNetwork:
    """A road network: its roads, junctions and signals.

    `read` returns one, and `convert` one that knows in addition how it was made. All functions and `Locator` take it
    in place of a file.
    """

    def __init__(self, tables: OpenDrive) -> None:
        self._tables = tables

    @property
    def tables(self) -> OpenDrive:
        """The file as tables, by which all of it is evaluated at once."""
        return self._tables

    @cached_property
    def _view(self) -> View:
        from osm2xodr.python_api.nouns import View

        return View(self.tables)

    @property
    def roads(self) -> Elements[Road]:
        """The roads, by position or id."""
        return self._view.roads

    @property
    def junctions(self) -> Elements[Junction]:
        """The junctions, by position or id."""
        return self._view.junctions

    @property
    def signals(self) -> Elements[Signal]:
        """The signs, lights and lines, by position or id."""
        return self._view.signals

    def to_geodataframe(
        self, layer: Layer = "lanes", *, tolerance: float = SAMPLE_TOLERANCE, step: float = SAMPLE_STEP
    ) -> Any:
        """Return lanes, roads or signals as a `geopandas.GeoDataFrame`, in the projection of the file, m.

        Lanes are polygons, reference lines of roads lines, signals points, with heights. Columns have their unit in
        their name. Without a projection in the file the coordinates are those of the file. ``.to_crs(4326)`` makes
        them longitudes and latitudes.

        Parameters
        ----------
        layer
            ``lanes``, ``roads`` or ``signals``.
        tolerance
            How far straight pieces may lie from curves, m.
        step
            Longest straight piece, m.

        Raises
        ------
        OptionError
            There is no such layer, or a length cannot be.
        Osm2xodrError
            geopandas is not installed.
        """
        from osm2xodr.python_api.exports import needs
        from osm2xodr.python_api.files import check_sampling, choose

        check_sampling(tolerance, step)
        choose("layer", layer, get_args(Layer))
        with needs("geopandas"):
            from osm2xodr.exporting import geodataframe
        return geodataframe(self.tables, layer, tolerance, step)

    def to_geopackage(self, path: AnyPath) -> Path:
        """Write lanes, roads and signals as layers of a GeoPackage, which GIS programs open; return its path.

        Their columns are those of `to_geodataframe`. A file that exists is replaced.

        Raises
        ------
        Osm2xodrError
            geopandas is not installed.
        OutputError
            The file cannot be written.
        """
        from osm2xodr.python_api.exports import export

        return export(self, path, format="geopackage")[0]

    def to_networkx(self) -> Any:
        """Return the graph of the lanes for cars as a `networkx.DiGraph`.

        A node is (id of the road, number of its lane section, id of the lane); one of traffic both ways stands twice,
        with ``"forward"`` or ``"backward"`` as a fourth item. Edges lead from each to those that traffic can go to:
        by `kind` ``successor``, where the lane goes on, or ``change``, where marks let one change lanes. Their
        ``length_m`` and ``time_s`` are what one drives before: those of the lane that is left, or 0 for a change, so
        that ``networkx.shortest_path(graph, a, b, weight="time_s")`` finds the quickest way.

        Raises
        ------
        Osm2xodrError
            networkx is not installed.
        """
        from osm2xodr.python_api.exports import needs

        with needs("networkx"):
            from osm2xodr.exporting import lane_graph
        return lane_graph(self.tables)

    def __repr__(self) -> str:
        return f"<RoadNetwork {self.tables.header.attributes.get('name', '')!r}: {', '.join(self._figures())}>"

    def _repr_html_(self) -> str:
        """Return a table, which notebooks show."""
        rows = "".join(f"<tr><td>{escape(text)}</td></tr>" for text in self._figures())
        return f"<table><caption>{escape(self.tables.header.attributes.get('name', ''))}</caption>{rows}</table>"

    def _figures(self) -> list[str]:
        plain = [road for road in self.roads if road.junction is None]
        length = sum(road.length for road in plain if road.length > 0.0)
        return [
            f"{counted(len(plain), 'road')} of {length / 1000.0:,.1f} km",
            counted(len(self.roads) - len(plain), "connecting road"),
            counted(len(self.junctions), "junction"),
            counted(len(self.signals), "signal"),
        ]
