"""Say which share of mutmut's changes the tests noticed, by package, and fail below nine in ten.

    python tools/mutation_score.py [FOLDER]

Reads what ``mutmut run`` left in ``mutants/``. A change counts as noticed if a test failed or took far too long.
"""

from __future__ import annotations

import json
import sys
from collections import Counter
from pathlib import Path

NOTICED = 0.9
# Exit codes of mutmut: the tests passed, there are none, none runs the line.
SURVIVED = {0, 5, 33}


def main(folder: Path) -> int:
    """Print a line per package; 1 where too little is noticed."""
    tried, noticed = Counter[str](), Counter[str]()
    for path in sorted(folder.rglob("*.meta")):
        for name, status in json.loads(path.read_text(encoding="utf-8"))["exit_code_by_key"].items():
            if status not in (None, 2, 34):  # not tried, interrupted, skipped
                package = ".".join(name.split(".")[:3])
                tried[package] += 1
                noticed[package] += status not in SURVIVED
    for package, count in tried.items():
        sys.stdout.write(f"{package}: {noticed[package] / count:.1%} of {count} changes are noticed\n")
    return int(not tried or any(noticed[package] < NOTICED * count for package, count in tried.items()))


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1] if len(sys.argv) > 1 else "mutants")))
