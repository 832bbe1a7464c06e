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
        U_TURNS as U_TURNS,
        Country as Country,
        MarkStyle as MarkStyle,
        find_country as find_country,
    )
    from osm2xodr.conventions.options import (
        Declaration as Declaration,
        Group as Group,
        Reported as Reported,
        declarations as declarations,
        flag as flag,
        option as option,
        same_option as same_option,
    )
    from osm2xodr.conventions.signs import (
        NO_SUBTYPE as NO_SUBTYPE,
        SignCode as SignCode,
        Signs as Signs,
        is_supplementary as is_supplementary,
        meant_ends as meant_ends,
        places_on_streets as places_on_streets,
        priority_rank as priority_rank,
        ranks_at_junction as ranks_at_junction,
        read_signs as read_signs,
        sign_code as sign_code,
        sign_meaning as sign_meaning,
        sign_meanings as sign_meanings,
    )
    from osm2xodr.conventions.targets import (
        DEFAULT_TARGET as DEFAULT_TARGET,
        MEASURED as MEASURED,
        NO_SUPERELEVATION as NO_SUPERELEVATION,
        PLANS as PLANS,
        PROGRAMMES_HEAD as PROGRAMMES_HEAD,
        SPIRALS as SPIRALS,
        SUPERELEVATION as SUPERELEVATION,
        TARGETS as TARGETS,
        Crosswalks as Crosswalks,
        Target as Target,
        programmes_file as programmes_file,
    )

__getattr__ = lazy_exports(
    __name__,
    {
        "countries": ("GENERIC", "KMH", "MPH", "SPEED_UNITS", "U_TURNS", "Country", "MarkStyle", "find_country"),
        "options": ("Declaration", "Group", "Reported", "declarations", "flag", "option", "same_option"),
        "signs": (
            "NO_SUBTYPE",
            "SignCode",
            "Signs",
            "is_supplementary",
            "meant_ends",
            "places_on_streets",
            "priority_rank",
            "ranks_at_junction",
            "read_signs",
            "sign_code",
            "sign_meaning",
            "sign_meanings",
        ),
        "targets": (
            "DEFAULT_TARGET",
            "MEASURED",
            "NO_SUPERELEVATION",
            "PLANS",
            "PROGRAMMES_HEAD",
            "SPIRALS",
            "SUPERELEVATION",
            "TARGETS",
            "Crosswalks",
            "Target",
            "programmes_file",
        ),
    },
)
