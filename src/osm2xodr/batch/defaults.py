"""Default numbers of batches: meaning, unit, source. SI units unless the name says otherwise."""

from __future__ import annotations

from typing import Final

# Road and junction ids that each area of a shared frame may use; a choice.
BATCH_IDS_PER_AREA: Final = 100_000
