"""Files of odd names, and numbers with decimal commas, with every command: they change nothing."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree

import pytest
from refusals import SECONDS, refusal, run
from small_area import OSM, write_area, write_dem

from osm2xodr.cli import main

NAMES = [
    "with space",
    "quote'and\"double",
    "two\nlines",
    "tab\there",
    "-dash",
    "--overwrite",
    "日本 ünï",
    "\u202eright to left",
    "%s {0} $HOME `id`",
    "semi;colon|pipe&",
    "x" * 240,
    "back\\slash",
    "http:x",
    "*?[a]",
]


@pytest.mark.parametrize("name", NAMES)
def test_names_of_files(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = tmp_path / name[:100]
    folder.mkdir()
    monkeypatch.chdir(folder)
    write_area(folder, name=f"{name}.osm")
    write_dem(folder, f"{name}.tif")
    words = [
        "--dem",
        f"./{name}.tif",
        "-o",
        f"./{name}.xodr",
        "-q",
        "--report-json",
        f"./{name}.json",
        "--name",
        "map",
    ]
    assert main(["convert", *words, "--", f"{name}.osm"]) == 0
    assert sorted(os.listdir()) == sorted(f"{name}{ending}" for ending in (".osm", ".tif", ".xodr", ".json"))
    plain = tmp_path / "plain.xodr"
    assert main(["convert", f"./{name}.osm", "--dem", f"./{name}.tif", "-o", str(plain), "-q", "--name", "map"]) == 0
    assert plain.read_bytes() == Path(f"{name}.xodr").read_bytes()


# All that is odd in few names: each is tried with every command.
ODD_NAMES = ["a 'b\" \nc\td 日本 ünï", "--overwrite", "%s {0} $HOME `id` ;|&*?[a]\\", "http:x"]
COMMANDS = {
    "check": ["-q"],
    "report": ["--title", "map", "-q"],
    "render": ["--format", "svg", "-q"],
    "export": ["--format", "geojson", "-q"],
    "surface": ["-q"],
    "locate": ["--x", "0", "--y", "0"],
}


@pytest.fixture(scope="module")
def network(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("network")
    path = folder / "map.xodr"
    assert main(["convert", str(write_area(folder)), "-o", str(path), "-q"]) == 0
    return path


def outcome(
    command: str, source: str, out: str, capsys: pytest.CaptureFixture[str]
) -> tuple[int, str, str, bytes | None]:
    """Run a command; return its status, what it prints, and what it writes."""
    target = [] if command == "locate" else ["-o", f"./{out}"]
    status = main([command, *COMMANDS[command], *target, "--", source])
    printed = capsys.readouterr()
    return status, printed.out, printed.err, Path(out).read_bytes() if target else None


@pytest.mark.parametrize("name", ODD_NAMES)
@pytest.mark.parametrize("command", sorted(COMMANDS))
def test_names_of_files_with_every_command(
    command: str,
    name: str,
    network: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    folder = tmp_path / name
    folder.mkdir()
    monkeypatch.chdir(folder)
    ending = "tif" if command == "surface" else "xodr"
    for stem in (name, "plain"):
        if command == "surface":
            write_dem(folder, f"{stem}.tif")
        else:
            Path(f"{stem}.xodr").write_bytes(network.read_bytes())
    given = set(os.listdir())
    status, printed, error, written = outcome(command, f"{name}.{ending}", f"{name}.out", capsys)
    assert (status, error) == (0, "")
    assert set(os.listdir()) - given == (set() if written is None else {f"{name}.out"})
    _, expected, _, plain = outcome(command, f"plain.{ending}", "plain.out", capsys)
    # Pages and lists of findings name their source; all else is the same.
    assert printed == expected
    if command in ("render", "export"):
        assert written == plain
    elif written is not None:
        assert plain is not None
        assert abs(len(written) - len(plain)) < 1000


def test_a_name_that_is_no_text(tmp_path: Path) -> None:
    area = tmp_path / os.fsdecode(b"caf\xe9.osm")
    area.write_text(OSM, encoding="utf-8")
    out = tmp_path / os.fsdecode(b"caf\xe9.xodr")
    status, error, _ = run("convert", area, "-o", out, "--report-json", tmp_path / "report.json")
    assert status == 0, error
    assert out.read_bytes().decode("utf-8").startswith("<?xml")
    (tmp_path / "report.json").read_bytes().decode("utf-8")


def test_names_with_line_breaks_are_told_in_one_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["convert", str(tmp_path / "a\nb.osm"), "-o", str(tmp_path / "x.xodr")]) == 1
    assert refusal(1, capsys.readouterr().err)


@pytest.fixture(scope="module")
def commas(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """Environment in which numbers have decimal commas; the locale is made if the system lacks it."""
    folder = tmp_path_factory.mktemp("locale")
    program = shutil.which("localedef")
    if program is not None:
        made = folder / "de_DE.UTF-8"
        subprocess.run([program, "-i", "de_DE", "-f", "UTF-8", str(made)], capture_output=True, check=False)
    own = {"LOCPATH": str(folder), "LC_ALL": "de_DE.UTF-8", "LANG": "de_DE.UTF-8"}
    systems = [{"LC_ALL": name, "LANG": name} for name in ("de_DE.UTF-8", "fr_FR.UTF-8", "nl_NL.UTF-8")]
    for environment in (own, *systems):
        asked = subprocess.run(
            [sys.executable, "-c", f"{WITH_COMMAS}; print(locale.localeconv()['decimal_point'])"],
            capture_output=True,
            text=True,
            env={**os.environ, **environment},
            check=False,
        )
        if asked.stdout == ",\n":
            return environment
    pytest.skip("no locale with decimal commas, and none can be made: localedef or its sources are missing")


# Python leaves the C library's numbers as they are unless a program asks for this.
WITH_COMMAS = "import locale; locale.setlocale(locale.LC_ALL, '')"


@pytest.mark.parametrize("command", ["convert", *sorted(COMMANDS)])
def test_decimal_commas_change_nothing(
    command: str,
    commas: dict[str, str],
    network: Path,
    tmp_path: Path,
) -> None:
    """Not even where the C library itself writes and reads them, as it does for programs that call this one."""
    area, dem = write_area(tmp_path), write_dem(tmp_path)
    words = {
        "convert": [str(area), "--dem", str(dem), "-q", "--name", "map"],
        "surface": [str(dem), "-q"],
        "locate": [str(network), "--x", "1.5", "--y", "-0.25"],
    }.get(command, [str(network), *COMMANDS.get(command, [])])
    target = [] if command == "locate" else ["-o", str(tmp_path / "out"), "--overwrite"]

    def written() -> bytes:
        # Pages that compare interpolations say how long each took, s, three digits.
        return re.sub(rb"<td>\d+\.\d{3}</td>", b"", (tmp_path / "out").read_bytes()) if target else b""

    def run(before: str, environment: dict[str, str]) -> tuple[bytes, bytes]:
        code = f"{before}; import sys; from osm2xodr.cli import main; sys.exit(main(sys.argv[1:]))"
        # A process for each: how sums round depends on threads of linear algebra, which the test's own process has.
        done = subprocess.run(
            [sys.executable, "-c", code, command, *words, *target],
            capture_output=True,
            timeout=SECONDS,
            env={**os.environ, "PYTHONUTF8": "1", **environment},
            check=False,
        )
        assert (done.returncode, done.stderr) == (0, b"")
        return done.stdout, written()

    assert run(WITH_COMMAS, commas) == run("pass", {})


@pytest.mark.parametrize("raw", [b"n\xff", b"c\x01", b"a\nb"])
def test_names_in_documents(
    raw: bytes, network: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    name = os.fsdecode(raw)
    Path(f"{name}.xodr").write_bytes(network.read_bytes())
    for form, parse in (("json", json.loads), ("sarif", json.loads), ("junit", ElementTree.fromstring)):
        assert main(["check", f"{name}.xodr", "--format", form, "-o", "result", "--overwrite"]) == 0
        parse(Path("result").read_bytes())
    assert main(["export", f"{name}.xodr", "--scene", "scene", "--format", "obj"]) == 0
    json.loads(Path("scene", "scene.json").read_bytes())
    assert main(["crop", f"{name}.xodr", "--roads", "1", "-o", f"{name}.part.xodr"]) == 0
    ElementTree.fromstring(Path(f"{name}.part.xodr").read_bytes())
    capsys.readouterr()
    status = main(["export", f"{name}.xodr", "-o", f"{name}.obj"])
    if raw == b"n\xff":
        assert status == 0
        assert b"\nmtllib n\xff.mtl\n" in Path(f"{name}.obj").read_bytes()
    else:
        assert status == 2
        assert "has a control character, which OBJ cannot name" in capsys.readouterr().err


BIG = "1" + "0" * 399
DEEP = "[" * 100_000


@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        ("m.toml", f'[[area]]\nname = "a"\nosm = "village.osm"\nbbox = [{BIG}, 1, 2, 3]\n', "batch m.toml -o out"),
        ("m.toml", f'[[area]]\nname = "a"\nosm = "{"A" * 3000}"\n', "batch m.toml -o out"),
        (
            "p.json",
            f'{{"type":"Polygon","coordinates":[[[{BIG},1],[1,2],[3,4],[1,1]]]}}',
            "convert village.osm --polygon p.json -o a.xodr",
        ),
        ("p.json", DEEP, "convert village.osm --polygon p.json -o a.xodr"),
        ("r.json", DEEP, "report map.xodr --report-json r.json -o a.html"),
        ("c.toml", f"way.{BIG}.lanes = 2", "convert village.osm --corrections c.toml -o a.xodr"),
        ("c.toml", f"way.10.lanes = {BIG}", "convert village.osm --corrections c.toml -o a.xodr"),
        ("c.json", DEEP, "convert village.osm --corrections c.json -o a.xodr"),
        (
            "f.json",
            f'{{"format":1,"lat_0_deg":1,"lon_0_deg":1,"areas":[{{"name":"village","first_id":{BIG},"rings":[]}}]}}',
            "convert village.osm --frame f.json -o a.xodr",
        ),
        ("f.json", DEEP, "convert village.osm --frame f.json -o a.xodr"),
    ],
)
def test_numbers_and_depths_that_nothing_has(
    name: str,
    text: str,
    words: str,
    network: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    write_area(tmp_path)
    Path("map.xodr").write_bytes(network.read_bytes())
    Path(name).write_text(text, encoding="utf-8")
    assert main(words.split()) in (1, 2)
    error = capsys.readouterr().err
    assert "internal error" not in error
    assert name in error or "A" * 99 in error
