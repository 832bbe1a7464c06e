"""Heights that are coded as colours: Terrain-RGB, in which web maps get elevation models as pictures.

Sources: Mapbox, *Mapbox Terrain-RGB v1*; Mapzen and Tilezen, *Terrain tiles: Terrarium*.
"""

from __future__ import annotations

from typing import Any, Final, NamedTuple

import numpy as np

from osm2xodr.errors import InputError


class Encoding(NamedTuple):
    """Heights are (65536 red + 256 green + blue) * step + lowest, m."""

    step: float
    lowest: float


ENCODINGS: Final = {"terrarium": Encoding(1.0 / 256.0, -32768.0), "mapbox": Encoding(0.1, -10000.0)}
# Edge of the sample of a picture that tells how its colours may code heights, cells.
_SAMPLE: Final = 256
# Heights on Earth, m; hardly any picture of something else has these alone, in either encoding.
_HEIGHTS: Final = (-500.0, 9000.0)


def encoding_of(name: str | None) -> Encoding | None:
    """Return an encoding by its name; `InputError` if it is not known."""
    if name is not None and name not in ENCODINGS:
        raise InputError(f"the encoding of heights '{name}' is not known; choose one of {', '.join(ENCODINGS)}")
    return None if name is None else ENCODINGS[name]


def codes(bands: Any) -> Any:
    """Return the numbers that three bands of bytes (3, rows, cols) code, masked where all of them are."""
    red, green, blue = bands.data.astype(np.uint32)
    masked: Any = np.ma
    return masked.masked_array((red << 16) | (green << 8) | blue, masked.getmaskarray(bands).all(axis=0))


def likely_encoding(dataset: Any) -> str | None:
    """Return the name of the encoding in which all colours of a picture are heights on Earth; None if in neither."""
    shape = tuple(min(size, _SAMPLE) for size in dataset.shape)
    found = codes(dataset.read((1, 2, 3), out_shape=(3, *shape), masked=True)).compressed()
    # Black is what pictures have outside the model.
    found = found[found > 0]
    for name, encoding in ENCODINGS.items():
        z = found * encoding.step + encoding.lowest
        if len(z) and z.min() >= _HEIGHTS[0] and z.max() <= _HEIGHTS[1]:
            return name
    return None
