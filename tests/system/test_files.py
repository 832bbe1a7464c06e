"""Files are there as a whole or not at all."""

from __future__ import annotations

import errno
import os
import stat
import subprocess
import sys
from pathlib import Path

import pytest

from osm2xodr.errors import OutputError
from osm2xodr.system import files
from osm2xodr.system.files import appended, atomic_output, check_target, complete, lock, make_folder, remove_made


def test_a_new_file_appears_at_the_end_only(tmp_path: Path) -> None:
    target = tmp_path / "a.xodr"
    with atomic_output(target) as stream:
        stream.write(b"all of it")
        assert not target.exists()
        assert len(list(tmp_path.iterdir())) == 1
    assert [item.name for item in tmp_path.iterdir()] == ["a.xodr"]
    assert target.read_bytes() == b"all of it"


@pytest.mark.parametrize("failure", [KeyboardInterrupt, MemoryError, ValueError, SystemExit])
def test_a_failure_leaves_the_old_file_and_nothing_else(tmp_path: Path, failure: type[BaseException]) -> None:
    target = tmp_path / "a.xodr"
    target.write_bytes(b"old")

    def fail_half_way() -> None:
        with atomic_output(target) as stream:
            stream.write(b"half of")
            raise failure

    with pytest.raises(failure):
        fail_half_way()
    assert [item.name for item in tmp_path.iterdir()] == ["a.xodr"]
    assert target.read_bytes() == b"old"


@pytest.mark.parametrize(
    ("number", "message"),
    [
        (errno.ENOSPC, "cannot write .*a.xodr: no space left on device; free some space or choose another place"),
        (errno.EIO, "cannot write .*a.xodr: input/output error$"),
        (errno.EROFS, "cannot write .*a.xodr: read-only file system; choose another place"),
    ],
)
def test_system_errors_become_one_sentence(tmp_path: Path, number: int, message: str) -> None:
    target = tmp_path / "a.xodr"
    with pytest.raises(OutputError, match=message), atomic_output(target):
        raise OSError(number, os.strerror(number))
    assert list(tmp_path.iterdir()) == []


def test_a_disk_that_is_full(tmp_path: Path) -> None:
    """The kernel refuses to let the file grow, in a process of its own."""
    target = tmp_path / "a.xodr"
    target.write_bytes(b"old")
    script = (
        "import resource, signal, sys, pathlib\n"
        "from osm2xodr.system.files import atomic_output\n"
        "signal.signal(signal.SIGXFSZ, signal.SIG_IGN)\n"
        "resource.setrlimit(resource.RLIMIT_FSIZE, (4096, 4096))\n"
        "try:\n"
        "    with atomic_output(pathlib.Path(sys.argv[1])) as stream:\n"
        "        for _ in range(100): stream.write(b'x' * 4096)\n"
        "except Exception as error:\n"
        "    print(type(error).__name__, error)\n"
    )
    run = subprocess.run([sys.executable, "-c", script, target], capture_output=True, text=True, check=True)
    assert run.stdout.startswith(f"OutputError cannot write {target}: file too large; ")
    assert [item.name for item in tmp_path.iterdir()] == ["a.xodr"]
    assert target.read_bytes() == b"old"


def test_a_link_is_followed(tmp_path: Path) -> None:
    (tmp_path / "real").mkdir()
    target = tmp_path / "real" / "a.xodr"
    target.write_bytes(b"old")
    link = tmp_path / "link.xodr"
    link.symlink_to(target)
    with atomic_output(link) as stream:
        stream.write(b"new")
    assert link.is_symlink()
    assert target.read_bytes() == b"new"
    assert len(list(tmp_path.iterdir())) == 2


def test_permissions_are_those_of_any_new_file_or_of_the_old_one(tmp_path: Path) -> None:
    before = os.umask(0o027)
    try:
        with atomic_output(tmp_path / "new.xodr"):
            pass
        old = tmp_path / "old.xodr"
        old.touch()
        old.chmod(0o604)
        with atomic_output(old):
            pass
    finally:
        os.umask(before)
    assert stat.S_IMODE((tmp_path / "new.xodr").stat().st_mode) == 0o640
    assert stat.S_IMODE(old.stat().st_mode) == 0o604


def test_the_longest_name_that_a_file_may_have(tmp_path: Path) -> None:
    target = tmp_path / ("x" * 250 + ".xodr")
    with atomic_output(target) as stream:
        stream.write(b"1")
    assert target.read_bytes() == b"1"


def test_devices_are_written_to_and_stay(tmp_path: Path) -> None:
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    reader = subprocess.Popen(["cat", pipe], stdout=subprocess.PIPE)
    check_target(pipe)
    with atomic_output(pipe) as stream:
        stream.write(b"through")
    assert reader.communicate(timeout=20)[0] == b"through"
    assert stat.S_ISFIFO(pipe.stat().st_mode)


def test_check_target(tmp_path: Path) -> None:
    check_target(tmp_path / "new.xodr")
    assert list(tmp_path.iterdir()) == []
    with pytest.raises(OutputError, match=r"is a directory; name a file in it, such as .*/map\.xodr"):
        check_target(tmp_path)
    check_target(tmp_path / "none" / "deeper" / "a.xodr")
    (tmp_path / "file").touch()
    with pytest.raises(OutputError, match=r"/file is a file, where a folder should be; choose another place"):
        check_target(tmp_path / "file" / "a.xodr")


def test_folders_of_outputs_are_made(tmp_path: Path) -> None:
    path = tmp_path / "a" / "b" / "c.txt"
    with atomic_output(path) as stream:
        stream.write(b"c")
    assert path.read_bytes() == b"c"


def test_check_target_without_permission(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # Permissions do not hold for the superuser, as whom tests may run.
    monkeypatch.setattr(os, "access", lambda path, mode: False)
    with pytest.raises(OutputError, match="no permission to make files in"):
        check_target(tmp_path / "a.xodr")


def test_a_file_that_grows(tmp_path: Path) -> None:
    part, path = tmp_path / "a.part", tmp_path / "a"

    def fail() -> None:
        with appended(part) as stream:
            stream.write(b"one")
            raise KeyError

    with pytest.raises(KeyError):
        fail()
    with appended(part) as stream:
        stream.write(b", two")
    assert part.read_bytes() == b"one, two"
    complete(part, path)
    assert [item.name for item in tmp_path.iterdir()] == ["a"]
    assert path.read_bytes() == b"one, two"


def test_a_file_that_cannot_grow(tmp_path: Path) -> None:
    with (
        pytest.raises(OutputError, match=r"cannot write .*a.part: no such file or directory"),
        appended(tmp_path / "none" / "a.part"),
    ):
        pass
    with pytest.raises(OutputError, match=r"cannot write .*a: no such file or directory"):
        complete(tmp_path / "a.part", tmp_path / "a")


def test_folders_are_made(tmp_path: Path) -> None:
    for _ in range(2):
        make_folder(tmp_path / "a" / "b")
    assert (tmp_path / "a" / "b").is_dir()
    (tmp_path / "file").touch()
    with pytest.raises(OutputError, match="file is a file, where a folder should be; choose another place"):
        make_folder(tmp_path / "file")
    with pytest.raises(OutputError, match=r"cannot write .*c: not a directory"):
        make_folder(tmp_path / "file" / "c")


def test_only_files_with_our_head_are_removed(tmp_path: Path) -> None:
    ours, other = tmp_path / "ours", tmp_path / "other"
    ours.write_bytes(b"<head>text")
    other.write_bytes(b"<hea")
    for path in (ours, other, tmp_path, tmp_path / "none"):
        remove_made(path, b"<head>")
    assert [item.name for item in tmp_path.iterdir()] == ["other"]


def test_no_locks_are_told_once(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setitem(sys.modules, "fcntl", None)
    monkeypatch.setitem(sys.modules, "msvcrt", None)
    files._say_unlocked.cache_clear()
    assert lock(0, wait=False)
    assert lock(0, wait=True)
    said = "osm2xodr: this system cannot lock files; let no two runs work on the same folder at once\n"
    assert capsys.readouterr().err == said
