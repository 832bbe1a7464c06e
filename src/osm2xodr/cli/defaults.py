"""Default numbers of the command line: meaning, unit, source. SI units unless the name says otherwise."""

from __future__ import annotations

from typing import Final

# More processes than these gain little: what cannot be shared out takes about a third of the time on one core, so
# eight are at most twice as fast as two (Amdahl's law).
MOST_JOBS: Final = 8
