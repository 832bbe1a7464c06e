"""Bounds on memory and time."""

from __future__ import annotations

import os
import resource
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from small_area import street_grid

from osm2xodr.system import limits
from osm2xodr.system.limits import LimitError, available_memory, limited, parse_duration, parse_memory


@pytest.mark.parametrize(
    ("text", "size"),
    [
        ("2G", 2 * 10**9),
        ("2GB", 2 * 10**9),
        ("1.5GiB", 3 * 2**29),
        ("1500m", 1500 * 10**6),
        (" 300 MB ", 300 * 10**6),
        ("400000000", 4 * 10**8),
        ("400000kb", 4 * 10**8),
    ],
)
def test_memory_is_read(text: str, size: int) -> None:
    assert parse_memory(text) == size


@pytest.mark.parametrize("text", ["", "much", "-2G", "2T", "nan", "1e9", "10M", "0"])
def test_what_is_no_memory_is_refused(text: str) -> None:
    with pytest.raises(ValueError, match=r"give one such as 2G|less than the 200M"):
        parse_memory(text)


@pytest.mark.parametrize(("text", "seconds"), [("90", 90.0), ("0.5s", 0.5), ("10min", 600.0), ("2 h", 7200.0)])
def test_durations_are_read(text: str, seconds: float) -> None:
    assert parse_duration(text) == seconds


@pytest.mark.parametrize("text", ["", "0", "-3", "soon", "3d", "inf"])
def test_what_is_no_duration_is_refused(text: str) -> None:
    with pytest.raises(ValueError, match="give one such as 90s"):
        parse_duration(text)


def test_time_is_bounded_and_given_back() -> None:
    before = signal.getsignal(signal.SIGALRM)
    began = time.monotonic()
    with pytest.raises(LimitError, match=r"longer than --timeout 0\.2 s"), limited(None, 0.2):
        time.sleep(30)
    assert time.monotonic() - began < 5
    assert signal.getsignal(signal.SIGALRM) is before
    assert signal.getitimer(signal.ITIMER_REAL) == (0.0, 0.0)


def test_time_is_bounded_where_exceptions_are_dropped(capsys: pytest.CaptureFixture[str]) -> None:
    """What a finalizer raises is dropped by Python; the time is up all the same."""

    class Slow:
        def __del__(self) -> None:
            time.sleep(0.5)

    def linger() -> None:
        Slow()
        time.sleep(30)

    hook = sys.unraisablehook
    began = time.monotonic()
    with pytest.raises(LimitError, match=r"longer than --timeout 0\.2 s"), limited(None, 0.2):
        linger()
    assert time.monotonic() - began < 5
    assert sys.unraisablehook is hook
    assert capsys.readouterr().err == ""


def test_time_is_bounded_where_nobody_listens(tmp_path: Path) -> None:
    """What runs in C alone hears no signal; the process is ended from outside."""
    busy = "collections.deque(itertools.repeat(None, 10**12), maxlen=0)"
    code = (
        f"import collections, itertools; from osm2xodr.system.limits import limited\nwith limited(None, 0.5): {busy}"
    )
    began = time.monotonic()
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, check=False, text=True, timeout=60, cwd=tmp_path
    )
    assert 3.0 < time.monotonic() - began < 20.0
    assert done.returncode == 1
    assert done.stderr.startswith("osm2xodr: error: it takes longer than --timeout 0.5 s;")
    assert done.stderr.count("\n") == 1


def test_time_is_up_whatever_libraries_make_of_it(capsys: pytest.CaptureFixture[str]) -> None:
    """Cython prints what is raised in a callback before it drops it, and codecs wrap it in errors of their own."""

    def decode() -> None:
        try:
            time.sleep(30)
        except LimitError as error:
            sys.excepthook(type(error), error, error.__traceback__)
            raise ValueError("decoding failed") from None

    hook = sys.excepthook
    with pytest.raises(LimitError, match=r"^it takes longer than --timeout 0\.2 s"), limited(None, 0.2):
        decode()
    assert sys.excepthook is hook
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize(("option", "size"), [("-v", 150_000), ("-v", 300_000), ("-d", 60_000), ("-d", 150_000)])
def test_too_little_memory_to_start(option: str, size: int, tmp_path: Path) -> None:
    """Where it has no room for its buffers, OpenBLAS tries for ever."""
    area = tmp_path / "area.osm"
    area.write_text(street_grid(2), encoding="utf-8")
    command = f"ulimit {option} {size}; exec {sys.executable} -m osm2xodr convert {area} -o {tmp_path / 'out.xodr'}"
    done = subprocess.run(["bash", "-c", command], capture_output=True, check=False, text=True, timeout=30)
    assert done.returncode == 1
    assert f"(ulimit {option}), less than the" in done.stderr
    assert done.stderr.count("\n") == 1


def test_memory_is_bounded_and_given_back() -> None:
    before = resource.getrlimit(resource.RLIMIT_DATA)
    with (
        pytest.raises(LimitError, match="more memory is needed than --max-memory 3,000 MB"),
        limited(3 * 10**9, None),
    ):
        np.ones(10**9)
    assert resource.getrlimit(resource.RLIMIT_DATA) == before


def test_without_bounds_memory_errors_stay_what_they_are() -> None:
    with pytest.raises(MemoryError), limited(None, None):
        raise MemoryError


@pytest.mark.parametrize(
    ("bound", "words"),
    [(("--timeout", "3"), "longer than --timeout 3 s"), (("--max-memory", "200M"), "--max-memory 200 MB")],
)
def test_a_bounded_run_says_why_it_stops_and_leaves_nothing(
    tmp_path: Path, bound: tuple[str, str], words: str
) -> None:
    area = tmp_path / "large.osm"
    area.write_text(street_grid(60), encoding="utf-8")
    out = tmp_path / "out.xodr"
    done = subprocess.run(
        [sys.executable, "-m", "osm2xodr", "convert", str(area), "-o", str(out), "-q", *bound],
        capture_output=True,
        check=False,
        text=True,
        env={**os.environ, "PYTHONWARNINGS": "error"},
        timeout=60,
    )
    assert done.returncode == 1
    assert words in done.stderr
    assert done.stderr.count("\n") == 1
    assert sorted(item.name for item in tmp_path.iterdir()) == ["large.osm"]


def test_containers_bound_what_is_available(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(limits, "_CONTROL_GROUPS", tmp_path)
    (tmp_path / "memory.max").write_text("max\n")
    free = available_memory()
    assert free is not None
    assert 10**8 < free <= os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    (tmp_path / "memory.max").write_text("123456789\n")
    assert available_memory() == 123456789
