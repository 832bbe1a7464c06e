"""``python -m osm2xodr``."""

import sys

from osm2xodr.cli import main

if __name__ == "__main__":
    sys.exit(main())
