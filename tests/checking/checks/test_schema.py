"""Files held against schemas."""

from __future__ import annotations

from pathlib import Path

import pytest
from real_readers import SCHEMA, need
from t_junction import sound_map

from osm2xodr.checking import CheckOptions, check_file
from osm2xodr.checking.checks import schema
from osm2xodr.cli import main
from osm2xodr.errors import InputError

ONLY = ("schema",)


@pytest.fixture
def path(tmp_path: Path) -> Path:
    path = tmp_path / "map.xodr"
    path.write_text(sound_map(), encoding="utf-8")
    return path


def with_version(path: Path, minor: int) -> Path:
    path.write_text(sound_map().replace('revMinor="6"', f'revMinor="{minor}"'), encoding="utf-8")
    return path


def test_the_schema_of_the_version_is_taken(path: Path) -> None:
    found = check_file(with_version(path, 4), CheckOptions(only=ONLY))
    # The rule of the road came with 1.6.
    rules = [item for item in found.findings if "'rule' is not allowed" in item.text]
    assert len(rules) == 10
    assert {item.line for item in rules} == {
        k for k, line in enumerate(path.read_text().splitlines(), 1) if line.startswith("<road ")
    }
    for minor in (6, 7):
        assert check_file(with_version(path, minor), CheckOptions(only=ONLY)).counts == ()


def test_a_schema_of_xsd_1_1_is_understood(path: Path) -> None:
    result = check_file(with_version(path, 8), CheckOptions(only=ONLY))
    assert (result.counts, result.notes) == ((), ())
    path.write_text(path.read_text().replace('junction="-1"', 'crossing="-1"', 1))
    result = check_file(path, CheckOptions(only=ONLY))
    assert result.by_rule()["schema"] >= 1
    assert any("crossing" in item.text for item in result.findings)
    assert all(item.line > 0 for item in result.findings)


def test_large_files_of_1_8_are_not_held_against_it(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(schema, "_MOST_BYTES", 1000)
    result = check_file(with_version(path, 8), CheckOptions(only=ONLY))
    assert [note for note in result.notes if "takes long" in note] == list(result.notes) != []


def test_a_version_without_a_schema_is_reported(path: Path) -> None:
    result = check_file(with_version(path, 9), CheckOptions(only=ONLY))
    assert result.notes == ("the schema was not checked: there is none for version 1.9; give one with --schema",)
    assert result.counts == ()


def test_a_missing_checker_is_reported(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(schema, "_PACKAGE", "no_such_package")
    result = check_file(path, CheckOptions(only=ONLY))
    assert result.notes == ("the schema was not checked: give one with --schema, or pip install asam-qc-opendrive",)


def test_a_missing_library_is_reported(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(schema, "_module", lambda name: None)
    result = check_file(with_version(path, 8), CheckOptions(only=ONLY))
    assert [note for note in result.notes if "install xmlschema" in note] == list(result.notes) != []


# What a small schema of one's own may ask for: that the root has an attribute.
OWN = """<xs:schema xmlns:xs="http://www.w3.org/2001/XMLSchema"><xs:element name="OpenDRIVE"><xs:complexType>
<xs:sequence><xs:any maxOccurs="unbounded" processContents="skip"/></xs:sequence>
<xs:attribute name="audited" use="{use}"/></xs:complexType></xs:element></xs:schema>"""


@pytest.mark.parametrize(("use", "status"), [("required", 1), ("optional", 0)])
def test_a_schema_of_ones_own_needs_no_extra(
    use: str,
    status: int,
    path: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.setattr(schema, "_PACKAGE", "no_such_package")
    monkeypatch.setattr(schema, "_module", lambda name: None)
    own = tmp_path / "own.xsd"
    own.write_text(OWN.format(use=use))
    assert main(["check", str(path), "--schema", str(own), "--only", "schema"]) == status
    said = capsys.readouterr().out
    assert ("The attribute 'audited' is required but missing" in said) is bool(status)
    assert "not checked" not in said


def test_a_missing_schema_does_not_change_the_exit_status(
    path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(schema, "_PACKAGE", "no_such_package")
    for least in ("error", "warning", "info"):
        assert main(["check", str(path), "--only", "schema", "--fail-on", least]) == 0
        assert "note: the schema was not checked: give one with --schema" in capsys.readouterr().out


def test_a_schema_can_be_given(path: Path) -> None:
    need("qc_opendrive", "the ASAM checker (asam-qc-opendrive)")
    import qc_opendrive

    given = Path(str(qc_opendrive.__file__)).parent / "schema" / SCHEMA["1.4"]
    result = check_file(path, CheckOptions(only=ONLY, schema=given))
    assert result.by_rule()["schema"] >= 10


def test_an_unusable_schema_is_refused(path: Path, tmp_path: Path) -> None:
    for name, text in (("absent.xsd", None), ("bad.xsd", "<no/>"), ("worse.xsd", "no XML")):
        given = tmp_path / name
        if text is not None:
            given.write_text(text)
        with pytest.raises(InputError, match=name):
            check_file(path, CheckOptions(only=ONLY, schema=given))


def test_large_files_that_violate_it_are_not_read_as_a_tree(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path.write_text(path.read_text().replace('junction="-1"', 'crossing="-1"', 1))
    small = check_file(path, CheckOptions(only=ONLY))
    monkeypatch.setattr(schema, "_LARGEST_TREE", 1000)
    large = check_file(path, CheckOptions(only=ONLY))
    assert large.counts == small.counts
    assert [item.text for item in large.findings] == [item.text for item in small.findings]
    assert {item.line for item in large.findings} == {0}
    assert any("have no line" in note for note in large.notes)


def test_a_file_that_follows_it_is_never_read_as_a_tree(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delattr(schema, "_tree")
    assert check_file(path, CheckOptions(only=ONLY)).counts == ()
