"""Types of the options of conversions, so that type checkers find misspelt ones.

Made by tools/option_types.py of the declarations on the dataclasses of the stages; a test holds them equal.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from typing import Literal, TypedDict


class AreaKeywords(TypedDict, total=False):
    """Options that areas of a batch may have."""

    right_hand: bool | None
    xodr_version: Literal["1.4", "1.6", "1.7", "1.8"]
    date: str
    ways: str | Iterable[str]
    include_private: bool
    left_hand: bool | None
    default_lane_width: float | None
    no_default_speeds: bool
    no_guessed_parking: bool
    no_guessed_sidewalks: bool
    no_guessed_shoulders: bool
    surface: Literal["nearest", "bilinear", "bicubic", "polynomial"]
    polynomial_order: int
    dem_type: Literal["auto", "dtm", "dsm"]
    dem_sigma: float | None
    vertical_datum: str | None
    dem_vertical_datum: str | None
    dem_crs: str | None
    dem_unit: str | None
    dem_encoding: Literal["terrarium", "mapbox"] | None
    allow_partial: bool
    fail_below_coverage: float | None
    smoothing: float
    max_grade: str | Mapping[str, float] | None
    no_structures: bool
    superelevation: Literal["auto", "model", "none"]
    turnarounds: bool
    u_turns: Literal["law", "all", "mapped", "none"]
    plan: Literal["spirals", "arcs"]
    target: Literal["generic", "carla", "esmini", "sumo", "roadrunner"]
    objects: str | Iterable[str] | None
    no_furniture: bool


class ConvertKeywords(AreaKeywords, total=False):
    """Options of a conversion; `ConvertOptions` says more."""

    bbox: str | Iterable[float] | None
    polygon: str | os.PathLike[str] | None
    clip: bool
    corrections: str | os.PathLike[str] | None
    name: str | None
    jobs: int | None
    corrections_shared: bool
    frame: str | os.PathLike[str] | None
    tile: str | None
