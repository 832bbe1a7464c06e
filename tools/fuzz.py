"""Throws hostile input at the readers and at the whole conversion, and prints what breaks them.

python tools/fuzz.py --minutes 60
python tools/fuzz.py --fuzzer map --seed 4711     one case, with its traceback
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "support"))

from fuzzing import FUZZERS, run_case, run_for


def main() -> int:
    """Run what the command line asks for; 1 if anything was found."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--minutes", type=float, default=1.0, help="for all fuzzers together")
    parser.add_argument("--fuzzer", choices=sorted(FUZZERS), action="append", help="only this one; may be repeated")
    parser.add_argument("--most", type=int, help="seeds of each fuzzer, at most")
    parser.add_argument("--first", type=int, default=0, help="seed to begin with")
    parser.add_argument("--seed", type=int, help="run this seed alone")
    given = parser.parse_args()
    chosen = given.fuzzer or sorted(FUZZERS)
    if given.seed is not None:
        found = [what for name in chosen if (what := run_case(name, given.seed))]
        print("\n".join(found) or "nothing found")
        return int(bool(found))
    failed = False
    for name in chosen:
        cases, findings = run_for(name, given.first, 60.0 * given.minutes / len(chosen), given.most)
        print(f"{name}: {cases:,} cases, {len(findings)} findings", flush=True)
        for item in findings:
            print(f"  --fuzzer {item.fuzzer} --seed {item.seed}\n{item.what}", flush=True)
        failed |= bool(findings)
    return int(failed)


if __name__ == "__main__":
    sys.exit(main())
