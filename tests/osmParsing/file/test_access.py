"""Files that cannot be written to their end."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

SAMPLE = Path(__file__).parents[3] / "data" / "samples" / "andorra_ordino" / "area.osm"
SCRIPT = """
import gc, resource, sys
import osmium
from osm2xodr.osmParsing import close_writer

limit = int(sys.argv[3])
resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))
writer = osmium.SimpleWriter(sys.argv[2], bufsz=int(sys.argv[4]))
try:
    for item in osmium.FileProcessor(sys.argv[1]):
        writer.add(item)
except RuntimeError:
    pass
try:
    close_writer(writer)
except RuntimeError as error:
    print(error)
del writer
gc.collect()
print("goes on")
"""


@pytest.mark.parametrize("buffer", [1 << 16, 1 << 24])
@pytest.mark.parametrize("room", [100, 5000, 20_000])
def test_a_full_disk_does_not_end_the_process(tmp_path: Path, room: int, buffer: int) -> None:
    arguments = [str(SAMPLE), str(tmp_path / "a.osm.pbf"), str(room), str(buffer)]
    run = subprocess.run([sys.executable, "-c", SCRIPT, *arguments], capture_output=True, text=True, check=False)
    assert (run.returncode, run.stderr) == (0, "")
    why, goes_on = run.stdout.splitlines()
    assert "File too large" in why or "in status 'closed' or 'error'" in why
    assert goes_on == "goes on"
