"""What a release is made of: source archive, wheel, a clean installation, workflows, recipe, citation."""

from __future__ import annotations

import email
import re
import shlex
import subprocess
import sys
import tarfile
import venv
import zipfile
from pathlib import Path
from typing import Any

import hatch_build
import pytest
import release
from scene_files import scene_named

import osm2xodr

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

# The oldest libraries are tried without what makes documents and archives.
jinja2, yaml = pytest.importorskip("jinja2"), pytest.importorskip("yaml")

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
HOOK = PROJECT["tool"]["hatch"]["metadata"]["hooks"]["custom"]
WORKFLOWS = sorted((ROOT / ".github" / "workflows").glob("*.yml"))


@pytest.fixture(scope="module")
def dist(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """Source archive, and the wheel that is built of it; by the libraries of the gate."""
    folder = tmp_path_factory.mktemp("dist")
    command = [sys.executable, "-m", "build", "--no-isolation", "--outdir", str(folder), str(ROOT)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    (source,), (wheel,) = folder.glob("*.tar.gz"), folder.glob("*.whl")
    return source, wheel


def metadata_of(wheel: Path) -> Any:
    with zipfile.ZipFile(wheel) as archive:
        (name,) = (name for name in archive.namelist() if name.endswith(".dist-info/METADATA"))
        return email.message_from_bytes(archive.read(name))


def test_the_source_archive_is_whole_and_nothing_else(dist: tuple[Path, Path]) -> None:
    with tarfile.open(dist[0]) as archive:
        names = {name.partition("/")[2] for name in archive.getnames()}
    assert {"pyproject.toml", "hatch_build.py", "README.md", "LICENSE", "Makefile", "docs/osm2xodr.1"} <= names
    assert {str(path.relative_to(ROOT)) for path in (ROOT / "src").rglob("*.pxd")} <= names
    assert [name for name in names if name.endswith((".so", ".pyc")) or name.startswith((".venv", "build/"))] == []


def test_the_wheel_has_compiled_loops_documents_and_the_manual_page(dist: tuple[Path, Path]) -> None:
    with zipfile.ZipFile(dist[1]) as archive:
        names = set(archive.namelist())
    data = f"osm2xodr-{osm2xodr.__version__}.data/data/share"
    assert {f"{data}/man/man1/osm2xodr.1", f"{data}/doc/osm2xodr/how_it_works.md"} <= names
    assert {"osm2xodr/__init__.py", "osm2xodr/py.typed", "osm2xodr/fetching/elevation_models.ini"} <= names
    forms = {str(hatch_build.compiled(path).relative_to(hatch_build.SOURCE)) for path in hatch_build.modules()}
    assert (forms <= names) is hatch_build.has_compiler()
    assert any(hatch_build.SHARED in name for name in names) is hatch_build.has_compiler()
    assert ("-none-any" in dist[1].name) is not hatch_build.has_compiler()


def test_links_and_pictures_of_the_description_are_addresses(dist: tuple[Path, Path]) -> None:
    metadata = metadata_of(dist[1])
    assert metadata["Description-Content-Type"] == "text/markdown"
    text = metadata.get_payload()
    targets = re.findall(r"\]\(([^)]+)\)", text)
    assert len(targets) > 15
    assert [target for target in targets if not target.startswith("https://")] == []
    base, version = HOOK["repository"], osm2xodr.__version__
    assert f"]({base}/raw/v{version}/docs/images/scene.png)" in text
    assert f"]({HOOK['documentation']}/how_it_works.html)" in text
    assert f"]({base}/blob/v{version}/LICENSE)" in hatch_build.with_addresses("[x](LICENSE)", base, "", f"v{version}")


def test_the_address_of_the_project_stands_in_one_place(dist: tuple[Path, Path]) -> None:
    urls = dict(item.split(", ") for item in metadata_of(dist[1]).get_all("Project-URL"))
    assert urls.keys() == {"Repository", "Documentation", "Changelog", "Issues"}
    assert all(url.startswith((HOOK["repository"], HOOK["documentation"])) for url in urls.values())
    listed = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, text=True, check=True).stdout
    texts = {name: (ROOT / name).read_bytes() for name in listed.split("\0") if name and (ROOT / name).is_file()}
    for url in HOOK.values():
        assert [name for name, text in texts.items() if url.encode() in text] == ["pyproject.toml"]


def test_a_clean_installation_converts(dist: tuple[Path, Path], tmp_path: Path) -> None:
    """In an environment that has nothing else, with the newest libraries that the wheel asks for."""
    venv.create(tmp_path / "clean", with_pip=True)
    bin_ = tmp_path / "clean" / ("Scripts" if sys.platform == "win32" else "bin")
    quiet = ["--quiet", "--disable-pip-version-check", "--no-compile", "--only-binary", ":all:"]
    subprocess.run([bin_ / "python", "-m", "pip", "install", *quiet, str(dist[1])], check=True, cwd=tmp_path)
    said = subprocess.check_output([bin_ / "osm2xodr", "--version"], text=True, cwd=tmp_path)
    assert osm2xodr.__version__ in said
    scene = scene_named("montlake_roundabout")
    command = [str(bin_ / "osm2xodr"), "convert", str(scene.osm), "--dem", str(scene.dem), "-o", "area.xodr", "-q"]
    subprocess.run(command, check=True, cwd=tmp_path)
    code = (
        "import osm2xodr\n"
        "from osm2xodr.curves import records\n"
        "print(osm2xodr.check('area.xodr').headline(), records.__file__, sep='\\n')"
    )
    headline, file = subprocess.check_output([bin_ / "python", "-c", code], text=True, cwd=tmp_path).splitlines()
    assert headline.startswith("area.xodr: 0 errors, ")
    assert Path(file).is_relative_to(tmp_path)
    assert file.endswith(".py") is not hatch_build.has_compiler()
    assert (tmp_path / "clean" / "share" / "man" / "man1" / "osm2xodr.1").is_file()


# ---------------------------------------------------------------- workflows and templates


def read(path: Path) -> Any:
    # YAML 1.1 takes the word "on" for a truth value.
    return {"on" if key is True else key: value for key, value in yaml.safe_load(path.read_text("utf-8")).items()}


def steps_of(workflow: Any) -> list[Any]:
    return [step for job in workflow["jobs"].values() for step in job.get("steps", [])]


@pytest.mark.parametrize("path", WORKFLOWS, ids=lambda path: path.stem)
def test_a_workflow_is_sound(path: Path) -> None:
    workflow = read(path)
    # Nobody's token may do more than it has to.
    assert workflow["permissions"] == {"contents": "read"}
    for job in workflow["jobs"].values():
        needs = job.get("needs", [])
        assert set([needs] if isinstance(needs, str) else needs) <= workflow["jobs"].keys()
        assert "uses" not in job or (ROOT / job["uses"]).is_file()
    for step in steps_of(workflow):
        if "uses" in step:
            assert re.fullmatch(r"[\w.-]+/[\w.-]+@(v\d+(\.\d+\.\d+)?|release/v\d+)", step["uses"])


def test_what_workflows_run_is_there() -> None:
    targets = set(re.findall(r"^([a-z-]+|\$\(VENV\)/\.\w+):", (ROOT / "Makefile").read_text("utf-8"), re.MULTILINE))
    commands = [step["run"] for path in WORKFLOWS for step in steps_of(read(path)) if "run" in step]
    assert len(commands) > 8
    for command in commands:
        program, *words = shlex.split(command)
        if program == "make":
            assert set(words) <= {target.replace("$(VENV)", ".venv") for target in targets}
        elif program == ".ci/run":
            assert (ROOT / program).is_file()
        else:
            assert program in ("python", ".venv/bin/python", "osm2xodr")
        files = [word for word in words if re.match(r"(tools|tests|data)/", word)]
        assert [word for word in files if not (ROOT / word).exists()] == []
        if "-m" in words:
            assert words[words.index("-m") + 1] in ("pip", "pytest", "build", "twine")


def test_every_system_and_python_is_tried() -> None:
    jobs = read(ROOT / ".github" / "workflows" / "ci.yml")["jobs"]
    assert {job["runs-on"].partition("-")[0] for job in jobs.values()} == {"ubuntu", "macos", "windows"}
    named = re.findall(r"Python :: (3\.\d+)", " ".join(PROJECT["project"]["classifiers"]))
    assert jobs["linux"]["strategy"]["matrix"]["python"] == named
    built = PROJECT["tool"]["cibuildwheel"]["build"].split()
    assert built == [f"cp{version.replace('.', '')}-*" for version in named]


@pytest.mark.parametrize(
    ("schema", "pattern"),
    [
        ("github-workflows", ".github/workflows/*.yml"),
        ("github-issue-forms", ".github/ISSUE_TEMPLATE/[!c]*.yml"),
        ("github-issue-config", ".github/ISSUE_TEMPLATE/config.yml"),
        ("citation-file-format", "CITATION.cff"),
    ],
)
def test_files_for_others_are_valid(schema: str, pattern: str) -> None:
    files = sorted(str(path.relative_to(ROOT)) for path in ROOT.glob(pattern))
    assert files != []
    command = [sys.executable, "-m", "check_jsonschema", "--builtin-schema", f"vendor.{schema}", *files]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr


def test_hooks_before_a_commit_are_those_of_the_gate() -> None:
    (repo,) = yaml.safe_load((ROOT / ".pre-commit-config.yaml").read_text("utf-8"))["repos"]
    for hook in repo["hooks"]:
        program, command, *_ = shlex.split(hook["entry"])
        subprocess.run([Path(sys.executable).with_name(Path(program).name), command, "--help"], check=True, stdout=-3)


def test_the_recipe_for_conda_has_the_same_requirements() -> None:
    def load_file_data(name: str, from_recipe_dir: bool) -> Any:
        assert from_recipe_dir
        return tomllib.loads((ROOT / "conda" / name).read_text("utf-8"))

    def load_file_regex(name: str, pattern: str, from_recipe_dir: bool) -> Any:
        assert from_recipe_dir
        return re.search(pattern, (ROOT / "conda" / name).read_text("utf-8"))

    words = {"load_file_data": load_file_data, "load_file_regex": load_file_regex, "PYTHON": "python"}
    text = jinja2.Template((ROOT / "conda" / "meta.yaml").read_text("utf-8")).render(
        words, compiler=lambda name: name
    )
    recipe = yaml.safe_load(text)
    assert recipe["package"] == {"name": "osm2xodr", "version": osm2xodr.__version__}
    wanted = {item.partition(";")[0] for item in PROJECT["project"]["dependencies"]}
    assert {item.replace(" ", "").replace("pyosmium", "osmium") for item in recipe["requirements"]["run"]} == {
        *wanted,
        f"python{PROJECT['project']['requires-python']}",
    }
    host = {item.replace(" ", "") for item in recipe["requirements"]["host"]}
    assert set(PROJECT["build-system"]["requires"]) <= host
    assert recipe["about"]["home"] == HOOK["repository"]


def test_the_citation_is_that_of_this_version() -> None:
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text("utf-8"))
    assert citation["license"] == PROJECT["project"]["license"]
    assert [item["name"] for item in citation["authors"]] == [item["name"] for item in PROJECT["project"]["authors"]]


def test_a_release_that_is_not_ready_says_why(tmp_path: Path) -> None:
    version = osm2xodr.__version__
    known = [f"pyproject.toml has no {name} of the project yet" for name, url in HOOK.items() if "example" in url]
    assert release.faults(f"v{version}") == known
    for name in ("CHANGELOG.md", "CITATION.cff", "pyproject.toml", "src/osm2xodr/__init__.py"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        text = (ROOT / name).read_text("utf-8").replace("/example", "/us").replace("//example", "//us")
        (tmp_path / name).write_text(text, encoding="utf-8")
    assert release.faults(f"v{version}", tmp_path) == []
    assert release.faults("v9.9.9", tmp_path) == [
        f"the tag is v9.9.9, but src/osm2xodr/__init__.py has the version {version}"
    ]
    citation = tmp_path / "CITATION.cff"
    citation.write_text(
        citation.read_text("utf-8").replace(f"version: {version}", "version: 0.0.9"), encoding="utf-8"
    )
    assert "CITATION.cff does not have the version" in release.faults(f"v{version}", tmp_path)[0]
