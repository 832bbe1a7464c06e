"""The options of a conversion: those that its stages declare, and those of the conversion itself.

Imports nothing heavy: the command line reads it before it knows what to do.
"""

from __future__ import annotations

import contextlib
import dataclasses
import os
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final, cast

from osm2xodr import __version__
from osm2xodr.conventions import TARGETS, Declaration, Group, Reported, declarations
from osm2xodr.errors import InputError, OptionError
from osm2xodr.furniture import FurnitureOptions
from osm2xodr.geometry import ElevationOptions, RoadOptions
from osm2xodr.osmParsing import ParseOptions
from osm2xodr.surface import SurfaceOptions
from osm2xodr.system import STANDARD_OUTPUT
from osm2xodr.xodrWriter import WriteOptions

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from osm2xodr.python_api.keywords import ConvertKeywords

# More processes than these gain little: what cannot be shared out takes about a third of the time on one core, so
# eight are at most twice as fast as two (Amdahl's law).
MOST_JOBS: Final = 8
# With fewer streets copies of the process cost more than they save: six scenes with 35 to 259 streets take 10 to 18 %
# more time on all cores together with two processes than with one, and none is done sooner; one with 563 gains.
COPIES_FROM: Final = 300


def _of_area(name: str, group: Group, help: str, reported: Reported = Reported.GIVEN, **more: Any) -> Declaration:
    """Declare an option of a conversion as a whole, which areas of a batch do not choose."""
    return Declaration(name, group, help, reported=reported, per_area=False, **more)


# Those that no stage has.
_BEFORE: Final = (
    _of_area(
        "bbox",
        Group.WHAT,
        "Convert only this part of AREA, with roads that reach beyond it up to their next junction: degrees, WGS 84."
        "  [default: everything]",
        metavar="W,S,E,N",
    ),
    _of_area("polygon", Group.WHAT, "Likewise: the polygons of a GeoJSON file.", kind=Path, metavar="FILE"),
    _of_area(
        "clip",
        Group.WHAT,
        "Cut roads off at --bbox or --polygon, as the command crop does.",
        kind=bool,
        default=False,
    ),
    _of_area(
        "corrections",
        Group.WHAT,
        "What you know better than OpenStreetMap, by its ids, in TOML or GeoJSON; docs/corrections.md describes it.",
        kind=Path,
        metavar="FILE",
    ),
    _of_area(
        "name",
        Group.OUTPUT,
        "Name of the road network.  [default: that of AREA]",
        Reported.NEVER,
        metavar="TEXT",
    ),
    # The opposite of `left_hand`.
    Declaration(
        "right_hand",
        Group.LANES,
        "Traffic drives on the right.  [default: as in the country]",
        bool,
        reported=Reported.NEVER,
    ),
)
_AFTER: Final = (
    _of_area(
        "jobs",
        Group.MACHINE,
        "Processes that work at once; the result is the same for any number.  [default: one per core, up to"
        f" {MOST_JOBS}; one for areas with fewer than {COPIES_FROM} streets]",
        Reported.NEVER,
        kind=int,
        metavar="N",
        least=1,
    ),
    _of_area(
        "corrections_shared",
        Group.MORE,
        "The corrections are for more areas than this one: those that match nothing here are not reported.",
        kind=bool,
        default=False,
    ),
    _of_area(
        "frame",
        Group.MORE,
        "Areas side by side, as batch --shared-frame writes them: cut roads at the border of the one that AREA is"
        " named after.",
        kind=Path,
        metavar="FILE",
    ),
    _of_area(
        "tile",
        Group.MORE,
        "With --frame, where AREA is the map of a block of areas: lay out the roads of the block, and write those of"
        " this area.",
        metavar="NAME",
    ),
)
_STAGES: Final = (WriteOptions, ParseOptions, SurfaceOptions, ElevationOptions, RoadOptions, FurnitureOptions)
DECLARATIONS: Final[Mapping[str, Declaration]] = MappingProxyType(
    {item.name: item for item in (*_BEFORE, *declarations(*_STAGES).values(), *_AFTER)}
)

# A field for each of them.
_Fields: Any = dataclasses.make_dataclass(
    "_Fields",
    [(item.name, Any, dataclasses.field(default=item.default)) for item in DECLARATIONS.values()],
    frozen=True,
    kw_only=True,
)


@dataclass(frozen=True, kw_only=True)
class ConvertOptions(_Fields):  # type: ignore[misc,unused-ignore] # noqa: D101 (its text is made below)
    __doc__ = f"""How an area is converted: the options of ``osm2xodr convert``, by the same names.

    Lists may be given as text with commas or as iterables of text, tables as text or as mappings; they are kept as
    text. `left_hand` and `right_hand` say the same: True, False, or None for what is usual in the country.

    Parameters
    ----------
    {chr(10).join(f"    {item.name}{chr(10)}        {item.help}" for item in DECLARATIONS.values()).strip()}

    Raises
    ------
    OptionError
        A value cannot be, or two contradict each other.
    """

    if TYPE_CHECKING:

        def __init__(self, **options: Unpack[ConvertKeywords]) -> None: ...

    def __post_init__(self) -> None:
        for name, declaration in DECLARATIONS.items():
            value = _checked(name, getattr(self, name), declaration)
            object.__setattr__(self, name, value)
            if value is not None:
                with refused(name):
                    declaration.for_stage(value)
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
        if self.clip and TARGETS[self.target].programmes_option:
            why = f"clip cannot cut the programmes of traffic lights that {self.target} has beside the file"
            raise OptionError(f"{why}; choose another target, or leave it out", "clip", "target")
        if self.tile is not None and self.frame is None:
            raise OptionError("tile is about areas side by side; give their frame, or leave it out", "tile", "frame")

    def inputs(self, area: Path, dems: Iterable[Path]) -> dict[str, Any]:
        """Return what was asked for, as reports say it."""
        out: dict[str, Any] = {
            "osm2xodr": __version__,
            "area": str(area),
            "dem": [str(path) for path in dems],
            "name": self.name_for(area),
        }
        given: dict[str, Any] = {}
        for name, declaration in DECLARATIONS.items():
            value = getattr(self, name)
            if declaration.reported is Reported.ALWAYS:
                out[declaration.negates or name] = not value if declaration.negates else value
            elif declaration.reported is Reported.GIVEN and value not in (None, False):
                given[name] = value
        return out | given

    def name_for(self, area: Path) -> str:
        """Return the name of the road network."""
        return area_name(area) if self.name is None else str(self.name)

    def for_stage(self, field: dataclasses.Field[Any]) -> dict[str, Any]:
        """Return the value of a stage's field by its name; nothing where no option says it, or none is given."""
        name: str = field.metadata.get("option", "")
        value = getattr(self, name) if name else None
        return {} if value is None else {field.name: DECLARATIONS[name].for_stage(value)}

    def changed(self, **changes: Unpack[ConvertKeywords]) -> ConvertOptions:
        """Return options with other values of some."""
        out: ConvertOptions = dataclasses.replace(cast(Any, self), **changes)
        return out


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
