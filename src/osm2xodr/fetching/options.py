"""What can be asked for, how servers are treated, and the sources of these numbers and addresses. SI units."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import field
from pathlib import Path
from typing import Final, Protocol

from osm2xodr import __version__
from osm2xodr.errors import OptionError, Osm2xodrError
from osm2xodr.system import record

# Servers of the Overpass API that anybody may use, asked in this order (OSM wiki, Overpass API, public instances).
OVERPASS_SERVERS: Final = (
    "https://overpass-api.de/api/interpreter",
    "https://overpass.private.coffee/api/interpreter",
)
# Geocoder that anybody may use for single names (OSM wiki, Nominatim).
GEOCODER: Final = "https://nominatim.openstreetmap.org/search"
# Elevation model that is taken unless the user names one: the finest that covers nearly all of the world.
ELEVATION_MODEL: Final = "copernicus-glo30"
# What servers get to know about who asks; the Overpass API turns away requests without a name.
USER_AGENT: Final = f"osm2xodr/{__version__} (road networks for driving simulators)"
# How long a server may be silent, or send less than `LEAST_RATE`, s; a choice, twice what busy servers take.
PATIENCE: Final = 60.0
# Slower than this a download counts as stuck, bytes/s; a choice, below any line that is of use.
LEAST_RATE: Final = 1000.0
# How often a server is asked again after it was busy or the connection was cut; and the first pause, s, which doubles
# each time where the server names none. Choices: 5 to 80 s, about as long as a slot of the Overpass API is taken.
RETRIES: Final = 5
PAUSE: Final = 5.0
# Largest file that is downloaded as a whole, bytes; a choice, above the extract of any country (5 GB).
DOWNLOAD_MAX: Final = 6_000_000_000
# What was fetched is taken from the cache for so long, s: a day, as often as public extracts are renewed.
CACHE_AGE: Final = 86_400.0


class ServerError(Osm2xodrError):
    """A server cannot be reached, or does not give what it was asked for.

    Parameters
    ----------
    message
        One sentence that names the address and the remedy.
    status
        Status of its answer (RFC 9110); 0 without one.
    unreached
        Why there is no connection to it, in a few words; empty if there was one.
    """

    def __init__(self, message: str, status: int = 0, unreached: str = "") -> None:
        super().__init__(message)
        self.status = status
        self.unreached = unreached


def _nothing(text: str) -> None:
    """Say nothing."""


class Shows(Protocol):
    """Is told what is done at the moment."""

    def __call__(self, task: str, state: str = "", share: float | None = None) -> None:
        """Take the name of what is done, what of it is there, in words, and what share that is, if known."""


def _show_nothing(task: str, state: str = "", share: float | None = None) -> None:
    """Show nothing."""


@record
class Network:
    """How servers are treated. Requests are made one at a time."""

    patience: float = PATIENCE  # How long a server may be silent or hardly send anything, s
    retries: int = RETRIES  # How often it is asked again when it is busy or the connection is cut
    pause: float = PAUSE  # The first pause before it is asked again, s; it doubles each time
    download_max: int = DOWNLOAD_MAX  # Largest file to download as a whole, bytes
    note: Callable[[str], None] = _nothing  # Told, in one sentence, why there is a wait
    progress: Shows = _show_nothing  # Told what is done at the moment
    sleep: Callable[[float], None] = time.sleep


@record
class FetchOptions:
    """What is fetched, and from where; OptionError if there is nothing to fetch."""

    out_dir: Path  # Folder for the files; it is made where it is missing
    cache_dir: Path  # Folder for what was fetched before, and for downloads that are not complete
    # A map to cut the area out of, file or address; None asks the Overpass API
    extract: str | None = None
    overpass: tuple[str, ...] = OVERPASS_SERVERS  # Addresses of servers of the Overpass API, in order
    geocoder: str = GEOCODER  # Address of what finds places by their names, with the API of Nominatim
    models: tuple[str, ...] = (ELEVATION_MODEL,)  # Names of elevation models, the preferred one first
    model_files: tuple[Path, ...] = ()  # Further tables of elevation models
    model_url: str | None = None  # Where the only elevation model is instead of where its table says
    osm: bool = True  # Whether a map is fetched
    dem: bool = True  # Whether elevation models are
    surroundings: bool = True  # Whether the map has the buildings and the water of scenes
    pbf: bool = False  # Whether the map is written as ``area.osm.pbf`` rather than ``area.osm``
    allow_partial: bool = False  # Whether the extract may be one of which its server says that it is not whole
    age: float = CACHE_AGE  # How old a map in the cache may be, s; 0 fetches everything anew
    overwrite: bool = False  # Whether files that exist are replaced
    network: Network = field(default_factory=Network)

    def __post_init__(self) -> None:
        if not (self.osm or self.dem):
            raise OptionError("no_osm and no_dem leave nothing to fetch; give one of them", "no_osm", "no_dem")
        if self.extract is not None and not self.osm:
            raise OptionError("no_osm and extract exclude each other; give one of them", "no_osm", "extract")
        if self.model_url is not None and len(self.models) != 1:
            raise OptionError("dem_url is for one elevation model; give one dem_model", "dem_url", "dem_model")
