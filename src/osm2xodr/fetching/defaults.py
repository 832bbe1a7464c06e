"""Numbers and addresses of fetching that several modules share, and their sources. SI units."""

from __future__ import annotations

from typing import Final

from osm2xodr import __version__

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
