"""The folder that a batch writes to: names of its files, and a lock for one batch at a time."""

from __future__ import annotations

import contextlib
import json
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from osm2xodr.errors import OutputError
from osm2xodr.system import lock, record, stream_to


@record
class OutDir:
    """The folder of a batch."""

    path: Path

    def outputs(self, name: str) -> tuple[Path, Path]:
        """Return the files of an area: road network and report."""
        return self.path / f"{name}.xodr", self.path / f"{name}.json"

    def state(self, name: str) -> Path:
        """Return the file that records what an area was made of."""
        return self.path / ".state" / f"{name}.json"

    def thumbnail(self, name: str) -> Path:
        """Return the file with a small picture of an area."""
        return self.path / ".state" / f"{name}.png"

    def cut(self, name: str) -> Path:
        """Return the file with what is cut out for an area."""
        return self.cuts / f"{name}.osm.pbf"

    @property
    def cuts(self) -> Path:
        """The folder with what is cut out of maps."""
        return self.path / ".cuts"

    @property
    def frame(self) -> Path:
        """The file with the frame and the outlines that all areas share."""
        return self.path / "frame.json"

    def known(self) -> list[str]:
        """Return the names of all areas that were made."""
        return sorted(path.name.removesuffix(".json") for path in (self.path / ".state").glob("*.json"))


@contextlib.contextmanager
def open_out_dir(path: Path) -> Iterator[OutDir]:
    """Make the folder if need be, and lock it for one batch.

    `OutputError` says that it cannot be made or written, or that another batch works in it.
    """
    folders = path, path / ".state", path / ".cuts"
    try:
        for item in folders:
            item.mkdir(parents=True, exist_ok=True)
        held = os.open(path / ".state" / "lock", os.O_RDWR | os.O_CREAT, 0o666)
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise OutputError(f"the folder {path} cannot be made or written: {reason}; choose another -o") from error
    try:
        if not lock(held, wait=False):
            raise OutputError(f"another batch works in {path}; wait for its end, or choose another -o")
        # Killed processes may have left these half-written.
        for part in (
            *(part for item in folders for part in item.glob(".osm2xodr-*.part")),
            *folders[2].glob("*.part"),
        ):
            part.unlink(missing_ok=True)
        yield OutDir(path)
    finally:
        # The file of the lock stays: removing it could remove that of the next batch.
        with contextlib.suppress(OSError):  # It is not empty
            (path / ".cuts").rmdir()
        os.close(held)


def write_if_changed(path: Path, document: dict[str, Any]) -> None:
    """Write JSON, unless the file has the same contents already."""
    text = json.dumps(document, indent=1, ensure_ascii=False, allow_nan=False).encode("utf-8", "replace") + b"\n"
    with contextlib.suppress(OSError):
        if path.read_bytes() == text:
            return
    with stream_to(path) as stream:
        stream.write(text)
