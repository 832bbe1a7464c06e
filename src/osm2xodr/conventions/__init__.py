"""Conventions that several stages share: laws and designs by country, readers of OpenDRIVE, OSM's signs on nodes."""

from __future__ import annotations

from typing import TYPE_CHECKING

from osm2xodr.system import lazy_exports

if TYPE_CHECKING:
    from osm2xodr.conventions.countries import (
        GENERIC as GENERIC,
        KMH as KMH,
        MPH as MPH,
        SPEED_UNITS as SPEED_UNITS,
        Country as Country,
        MarkStyle as MarkStyle,
        find_country as find_country,
    )
    from osm2xodr.conventions.street_signs import (
        Light as Light,
        Sign as Sign,
        Signs as Signs,
        light_of as light_of,
        priority_rank as priority_rank,
        read_signs as read_signs,
        signed_direction as signed_direction,
        signed_ends as signed_ends,
        stops_all as stops_all,
    )
    from osm2xodr.conventions.targets import (
        DEFAULT_TARGET as DEFAULT_TARGET,
        TARGETS as TARGETS,
        Crosswalks as Crosswalks,
        Target as Target,
    )

__getattr__ = lazy_exports(
    __name__,
    {
        "countries": ("Country", "GENERIC", "KMH", "MPH", "MarkStyle", "SPEED_UNITS", "find_country"),
        "street_signs": (
            "Light",
            "Sign",
            "Signs",
            "light_of",
            "signed_direction",
            "signed_ends",
            "priority_rank",
            "read_signs",
            "stops_all",
        ),
        "targets": ("Crosswalks", "DEFAULT_TARGET", "TARGETS", "Target"),
    },
)
