"""The options of a conversion, each declared once.

The command line, the keyword arguments of `osm2xodr.convert`, the manifests of batches and what reports say about the
input are made of these declarations. Imports nothing heavy: the command line reads it before it knows what to do.
"""

from __future__ import annotations

import contextlib
import dataclasses
import math
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final

from osm2xodr import __version__
from osm2xodr.conventions import DEFAULT_TARGET, PLANS, SUPERELEVATION, TARGETS, U_TURNS
from osm2xodr.defaults import POLYNOMIAL_ORDER, SURFACE_METHOD
from osm2xodr.errors import InputError, OptionError
from osm2xodr.furniture import EXTRA_OBJECTS
from osm2xodr.system import STANDARD_OUTPUT
from osm2xodr.xodrWriter import VERSIONS, WriteOptions, check_date

# `METHODS`, `DEM_TYPES` and `DEM_ENCODINGS` of `osm2xodr.surface`, which is too slow to load for --help; a test holds
# them equal.
SURFACE_METHODS: Final = ("nearest", "bilinear", "bicubic", "polynomial")
DEM_TYPES: Final = ("auto", "dtm", "dsm")
DEM_ENCODINGS: Final = ("terrarium", "mapbox")
# More processes than these gain little: what cannot be shared out takes about a third of the time on one core, so
# eight are at most twice as fast as two (Amdahl's law).
MOST_JOBS: Final = 8
# With fewer streets copies of the process cost more than they save: six scenes with 35 to 259 streets take 10 to 18 %
# more time on all cores together with two processes than with one, and none is done sooner; one with 563 gains.
COPIES_FROM: Final = 300
# Options that reports say only where they are given.
_RARE: Final = ("frame", "tile", "bbox", "polygon", "clip", "corrections", "corrections_shared")
# Beyond this factor nothing is left of the terrain: a choice.
_SMOOTHING_MOST: Final = 100.0


@dataclass(frozen=True, slots=True)
class Declaration:
    """What there is to say about an option beside its name."""

    help: str  # One sentence for --help
    kind: type  # Of a value: str, float, int, bool or Path
    default: Any
    metavar: str | None  # Stands for the value in --help
    choices: tuple[str, ...] = ()  # All values that it can have; none where any will do
    least: int | None = None  # The smallest and the largest number
    most: int | None = None
    in_report: bool = True  # Whether reports say it
    negates: str = ""  # What the flag turns off, for the report
    per_area: bool = True  # Whether the areas of a batch can have it


def _option(help: str, kind: type = str, default: Any = None, metavar: str | None = None, **more: Any) -> Any:
    """Declare an option of `ConvertOptions`."""
    told = Declaration(help, kind, default, metavar, **more)
    return dataclasses.field(default=default, metadata={"declaration": told})


def _flag(help: str, **more: Any) -> Any:
    return _option(help, bool, False, **more)


@dataclass(frozen=True, kw_only=True)
class ConvertOptions:
    """How an area is converted: the options of ``osm2xodr convert``, by the same names.

    Lists may be given as text with commas or as iterables of text, tables as text or as mappings; they are kept as
    text. `left_hand` and `right_hand` say the same: True, False, or None for what is usual in the country.

    Raises
    ------
    OptionError
        A value cannot be, or two contradict each other.
    """

    name: str | None = _option(
        "Name of the road network.  [default: that of AREA]", metavar="TEXT", in_report=False, per_area=False
    )
    date: str = _option("Date for the header, such as 2024-05-01.  [default: none]", default="", metavar="TEXT")
    bbox: str | Sequence[float] | None = _option(
        "Convert only this part of AREA, with roads that reach beyond it up to their next junction: degrees, WGS 84."
        "  [default: everything]",
        metavar="W,S,E,N",
        in_report=False,
        per_area=False,
    )
    polygon: str | None = _option(
        "Likewise: the polygons of a GeoJSON file.", Path, metavar="FILE", in_report=False, per_area=False
    )
    clip: bool = _flag(
        "Cut roads off at --bbox or --polygon, as the command crop does.", in_report=False, per_area=False
    )
    ways: str | Iterable[str] = _option(
        "Which ways: major, drivable, all, or values of OSM's highway, separated by commas.",
        default="drivable",
        metavar="LIST",
    )
    include_private: bool = _flag("Keep ways that are closed to the public.")
    corrections: str | None = _option(
        "What you know better than OpenStreetMap, by its ids, in TOML or GeoJSON; docs/corrections.md describes it.",
        Path,
        metavar="FILE",
        in_report=False,
        per_area=False,
    )
    corrections_shared: bool = _flag(
        "The corrections are for more areas than this one: those that match nothing here are not reported.",
        in_report=False,
        per_area=False,
    )
    xodr_version: str = _option(
        "Version of OpenDRIVE.", default=WriteOptions().version, choices=VERSIONS, in_report=False
    )
    left_hand: bool | None = _option("Traffic drives on the left.  [default: as in the country]", bool)
    right_hand: bool | None = _option(
        "Traffic drives on the right.  [default: as in the country]", bool, in_report=False
    )
    default_lane_width: float | None = _option(
        "Width of lanes where OSM gives none.  [default: by class of road]", float, metavar="METRES"
    )
    no_default_speeds: bool = _flag(
        "Write only the speed limits that OSM gives, none that is usual in the country.", negates="default_speeds"
    )
    no_guessed_sidewalks: bool = _flag(
        "Write only the sidewalks that OSM gives, none that streets in towns usually have.",
        negates="guessed_sidewalks",
    )
    no_guessed_shoulders: bool = _flag(
        "Write only the shoulders that OSM gives, none that motorways usually have.",
        negates="guessed_shoulders",
    )
    surface: str = _option(
        "How heights between the cells of the elevation model are found.",
        default=SURFACE_METHOD,
        choices=SURFACE_METHODS,
    )
    polynomial_order: int = _option(
        "Degree of the trend that fills gaps of the elevation model.",
        int,
        POLYNOMIAL_ORDER,
        metavar="2-5",
        least=2,
        most=5,
    )
    dem_type: str = _option(
        "Whether elevation models show the ground (dtm), or canopy and roofs (dsm), which roads then see through.",
        default="auto",
        choices=DEM_TYPES,
    )
    dem_sigma: float | None = _option(
        "Standard error of the elevation models' heights.  [default: estimated]", float, metavar="METRES"
    )
    vertical_datum: str | None = _option(
        "Turn heights into this datum: ellipsoid, or a code such as EPSG:3855 (EGM2008).  [default: as they are]",
        metavar="DATUM",
    )
    dem_vertical_datum: str | None = _option(
        "Datum of the elevation models' heights, likewise.  [default: as the files say]", metavar="DATUM"
    )
    dem_crs: str | None = _option(
        "CRS of elevation models that do not say theirs, such as EPSG:25832.  [default: they are refused]",
        metavar="CRS",
    )
    dem_unit: str | None = _option(
        "Unit of heights of elevation models that do not say theirs, such as ft or us-ft.  [default: m]",
        metavar="UNIT",
    )
    dem_encoding: str | None = _option(
        "How elevation models that are pictures (Terrain-RGB) code heights as colours.  [default: they are refused]",
        choices=DEM_ENCODINGS,
    )
    allow_partial: bool = _flag(
        "Accept elevation models that cover less than half of the roads, and maps that their server did not send in"
        " full."
    )
    fail_below_coverage: float | None = _option(
        "Fail if elevation models cover less than this share of the roads, 0 to 1.  [default: half of them]",
        float,
        metavar="SHARE",
        least=0,
        most=1,
    )
    smoothing: float = _option(
        "Factor on the length over which heights are smoothed.", float, default=1.0, metavar="FACTOR"
    )
    max_grade: str | Mapping[str, float] | None = _option(
        "Largest grades by class, such as motorway=0.05,residential=12%.  [default: see docs/elevation.md]",
        metavar="TABLE",
    )
    no_structures: bool = _flag("Lay bridges and tunnels on the ground.", negates="structures")
    superelevation: str = _option(
        "Cross slope of motorways and trunk roads: as a fine elevation model shows it (cells up to 2 m), elsewhere as"
        " roads are designed (auto); as such a model shows it alone; or none.",
        default=SUPERELEVATION[0],
        choices=SUPERELEVATION,
    )
    turnarounds: bool = _flag("End every dead end of a two-way street in a loop.")
    u_turns: str = _option(
        "U-turns between carriageways that are kept: as the country's law says at signals, all that OSM allows, those"
        " that it maps, or none.",
        default=U_TURNS[0],
        choices=U_TURNS,
    )
    plan: str = _option(
        "Reference lines with spirals, of continuous curvature on plain roads, or of lines and arcs alone.",
        default=PLANS[0],
        choices=PLANS,
    )
    target: str = _option(
        "Reader to write for where readers contradict each other; generic suits CARLA, esmini and SUMO.",
        default=DEFAULT_TARGET,
        choices=tuple(TARGETS),
    )
    objects: str | Iterable[str] | None = _option(
        f"Further objects: {', '.join(EXTRA_OBJECTS)}, or all.  [default: none]", metavar="LIST"
    )
    no_furniture: bool = _flag(
        "Write the carriageway alone: no signals, objects and lanes beside it.", negates="furniture"
    )
    frame: str | None = _option(
        "Areas side by side, as batch --shared-frame writes them: cut roads at the border of the one that AREA is"
        " named after.",
        Path,
        metavar="FILE",
        in_report=False,
        per_area=False,
    )
    tile: str | None = _option(
        "With --frame, where AREA is the map of a block of areas: lay out the roads of the block, and write those of"
        " this area.",
        metavar="NAME",
        in_report=False,
        per_area=False,
    )
    jobs: int | None = _option(
        "Processes that work at once; the result is the same for any number.  [default: one per core, up to"
        f" {MOST_JOBS}; one for areas with fewer than {COPIES_FROM} streets]",
        int,
        metavar="N",
        least=1,
        in_report=False,
        per_area=False,
    )

    def __post_init__(self) -> None:
        for name, declaration in DECLARATIONS.items():
            object.__setattr__(self, name, _checked(name, getattr(self, name), declaration))
        if self.left_hand is not None and self.left_hand == self.right_hand:
            raise OptionError(
                "left_hand and right_hand exclude each other; give one of them", "left_hand", "right_hand"
            )
        if self.right_hand is not None:
            object.__setattr__(self, "left_hand", not self.right_hand)
        if self.allow_partial and self.fail_below_coverage is not None:
            names = "allow_partial", "fail_below_coverage"
            raise OptionError("allow_partial and fail_below_coverage exclude each other; give one of them", *names)
        if self.corrections_shared and self.corrections is None:
            names = "corrections", "corrections_shared"
            raise OptionError("corrections_shared is about corrections; give them, or leave it out", *names)
        if self.clip and self.bbox is None and self.polygon is None:
            why = "clip is about a part of the map; give bbox or polygon, or leave it out"
            raise OptionError(why, "clip", "bbox", "polygon")
        if self.clip and TARGETS[self.target].programmes:
            why = f"clip cannot cut the programmes of traffic lights that {self.target} has beside the file"
            raise OptionError(f"{why}; choose another target, or leave it out", "clip", "target")
        if self.tile is not None and self.frame is None:
            raise OptionError("tile is about areas side by side; give their frame, or leave it out", "tile", "frame")
        if not 0.0 < self.smoothing < math.inf:
            raise OptionError(
                f"smoothing: {self.smoothing:g} is not above 0; 1 is the usual, 2 is smoother", "smoothing"
            )
        if self.smoothing > _SMOOTHING_MOST:
            many = f"smoothing: {self.smoothing:g} is above {_SMOOTHING_MOST:g}, which levels mountains"
            raise OptionError(f"{many}; 1 is the usual, 2 is smoother", "smoothing")
        with refused("date"):
            check_date(self.date)

    def inputs(self, area: Path, dems: Iterable[Path]) -> dict[str, Any]:
        """Return what was asked for, as reports say it."""
        out: dict[str, Any] = {
            "osm2xodr": __version__,
            "area": str(area),
            "dem": [str(path) for path in dems],
            "name": self.name_for(area),
        }
        for name, declaration in DECLARATIONS.items():
            if declaration.in_report:
                value = getattr(self, name)
                out[declaration.negates or name] = not value if declaration.negates else value
        rare = {name: getattr(self, name) for name in _RARE}
        return out | {name: value for name, value in rare.items() if value not in (None, False)}

    def name_for(self, area: Path) -> str:
        """Return the name of the road network."""
        return area_name(area) if self.name is None else self.name


DECLARATIONS: Final[Mapping[str, Declaration]] = MappingProxyType(
    {item.name: item.metadata["declaration"] for item in dataclasses.fields(ConvertOptions)}
)


# For help(): the declarations as parameters.
ConvertOptions.__doc__ = (ConvertOptions.__doc__ or "").replace(
    "    Raises\n",
    "    Parameters\n    ----------\n"
    + "".join(f"    {name}\n        {declared.help}\n" for name, declared in DECLARATIONS.items())
    + "\n    Raises\n",
)


def paths(given: str | os.PathLike[str] | Iterable[str | os.PathLike[str]]) -> tuple[Path, ...]:
    """Return the paths of one file or of several."""
    return (Path(given),) if isinstance(given, (str, os.PathLike)) else tuple(Path(item) for item in given)


@contextlib.contextmanager
def refused(option: str) -> Iterator[None]:
    """Name the option whose value is refused inside."""
    try:
        yield
    except (ValueError, InputError) as error:
        raise OptionError(f"{option}: {error}", option) from error


def area_name(area: Path) -> str:
    """Return the name of a file without the endings of OSM files."""
    name = "standard_input" if area == STANDARD_OUTPUT else area.name
    for ending in (".gz", ".bz2", ".xz", ".zip", ".zst", ".osm", ".pbf", ".xml", ".osm"):
        name = name.removesuffix(ending)
    return name


def _checked(name: str, value: Any, declaration: Declaration) -> Any:
    """Return the value of an option, lists and tables as text; refuse what it cannot be."""
    kind = declaration.kind
    if value is None and declaration.default is None:
        return None
    if kind is bool:
        if not isinstance(value, bool):
            raise OptionError(f"{name}: {value!r} is neither True nor False", name)
    elif kind is Path:
        if not isinstance(value, (str, os.PathLike)):
            raise OptionError(f"{name}: {value!r} is not a path", name)
        value = str(Path(value))
    elif kind is str:
        value = _text(name, value)
        if declaration.choices and value not in declaration.choices:
            raise OptionError(f"{name}: {value!r} is unknown; choose from {', '.join(declaration.choices)}", name)
    elif isinstance(value, bool) or not isinstance(value, (int, float) if kind is float else int):
        raise OptionError(f"{name}: {value!r} is not a {'whole number' if kind is int else 'number'}", name)
    else:
        value = kind(value)
        least, most = declaration.least, declaration.most
        # Written so that NaN fails.
        if not ((least is None or value >= least) and (most is None or value <= most)):
            bounds = f"{least} or more" if most is None else f"{least} to {most}"
            raise OptionError(f"{name}: {value} cannot be; give {bounds}", name)
    return value


def _text(name: str, value: Any) -> str:
    """Write a list or table as on the command line."""
    if isinstance(value, str):
        return value
    lists = DECLARATIONS[name].metavar
    if lists == "TABLE" and isinstance(value, Mapping):
        return ",".join(f"{key}={item}" for key, item in value.items())
    if lists in ("LIST", "W,S,E,N") and isinstance(value, Iterable):
        return ",".join(str(item) for item in (sorted(value) if isinstance(value, (set, frozenset)) else value))
    raise OptionError(f"{name}: {value!r} is not text", name)
