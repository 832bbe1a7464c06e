"""Parts of road networks: cut out of files of any writer, and joined again.

Documents are edited as trees, so that what OpenDRIVE does not know stays where it is.
"""

from __future__ import annotations

from osm2xodr.crop_and_merge.cropping import (
    Choice as Choice,
    Stretch as Stretch,
    choose_inside as choose_inside,
    choose_roads as choose_roads,
    crop_network as crop_network,
)
from osm2xodr.crop_and_merge.document import write_tree as write_tree
from osm2xodr.crop_and_merge.merging import merge_networks as merge_networks
