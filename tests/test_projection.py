"""What depends on PROJ's settings does not depend on those of the program around it."""

from __future__ import annotations

from typing import Any

from pyproj import network

from osm2xodr.projection import offline


def test_proj_stays_off_the_network_and_gets_its_setting_back() -> None:
    # Not all versions of pyproj have types for these two.
    switch: Any = network
    for before in (True, False):
        switch.set_network_enabled(before)
        with offline():
            assert not switch.is_network_enabled()
        assert switch.is_network_enabled() is before
