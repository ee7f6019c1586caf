"""The documents cannot go stale: their commands and Python run, their outputs match, their links exist."""

from __future__ import annotations

import re
import runpy
import shlex
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from urllib.parse import unquote

import pytest
import typer
import yaml

from command_line import evening, fidmap
from fidmap.arena import read_arena
from fidmap.cli import app
from fidmap.detect import spread
from fidmap.profiles import read_profile

ROOT = Path(__file__).parents[1]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
BLOCK = re.compile(r"^```(\w*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
RUN_WORDS = {"demo", "test", "lint", "bench", "fuzz"}  # of ./run itself: known to its usage, not run here


def blocks(*languages: str) -> list[tuple[Path, str]]:
    """Fenced blocks of all pages in these languages."""
    found = [(page, block) for page in PAGES for block in BLOCK.findall(page.read_text(encoding="utf-8"))]
    return [(page, text) for page, (language, text) in found if language in languages]


def commands() -> list[tuple[Path, str, str | None]]:
    """Page, command and the output shown with it (None where none is shown)."""
    found: list[tuple[Path, str, str | None]] = []
    for page, text in blocks("console"):
        for shown in re.split(r"^\$ ", text, flags=re.MULTILINE)[1:]:
            command, _, output = shown.partition("\n")
            found.append((page, command, output))
    for page, text in blocks("sh"):
        found += [(page, line, None) for line in text.splitlines() if line and not line.startswith("#")]
    return found


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with everything that the documents talk about."""
    evening(tmp_path, monkeypatch)
    data = {path.name: path for path in tmp_path.iterdir()}
    (tmp_path / "fidmap-demo").mkdir()
    folders = {"teamA": "good", "teamB": "noisy", "teamC": "broken"}
    for folder in (tmp_path / "fidmap-demo/maps", *(tmp_path / "handed-in" / team for team in folders)):
        folder.mkdir(parents=True)
        for path in data.values():
            shutil.copyfile(path, folder / path.name)
    for team, name in folders.items():
        (tmp_path / "handed-in" / team / f"{name}.yaml").rename(tmp_path / "handed-in" / team / "map.yaml")
    shutil.copyfile("noisy.pgm", "today.pgm")
    Path("today.yaml").write_text(Path("noisy.yaml").read_text().replace("noisy.pgm", "today.pgm"))
    Path("judge.csv").write_text("map,coverage,overall\nteamA_map,1,1\nteamB_map,3,2\nteamC_map,2,3\n")
    return tmp_path


def run(command: str) -> str:
    """What a user sees of `fidmap ...`, run in this process, with wildcards and `> FILE`."""
    words = shlex.split(command, comments=True)
    target = words[words.index(">") + 1] if ">" in words else None
    words = words[: words.index(">")] if target else words
    assert words[0] == "fidmap", command
    expanded = [name for word in words[1:] for name in (map(str, sorted(Path().glob(word))) if "*" in word else [word])]
    result = fidmap(*expanded)
    assert result.exit_code in {0, 3}, result.output
    if target:
        Path(target).write_text(result.stdout)
    return result.stderr if target else result.output


def plain(output: str) -> list[str]:
    """Output without what may change: digits, padding and rules."""
    lines = (re.sub(r"\d+", "0", re.sub(r"[\s─]+", " ", line)).strip() for line in output.splitlines())
    return [line for line in lines if line]


@pytest.mark.parametrize("page", [ROOT / "README.md", ROOT / "docs/usage.md"], ids=lambda page: page.name)
@pytest.mark.usefixtures("here")
def test_the_commands_of_a_page_run_in_its_order_and_show_what_it_shows(page: Path) -> None:
    usage = subprocess.run([sys.executable, ROOT / "run"], capture_output=True, text=True, check=False).stderr
    known = {line.split()[0] for line in usage.splitlines()[1:]}
    for where, command, output in commands():
        if where != page:
            continue
        words = shlex.split(command, comments=True)
        if words[0] == "./run" and words[1] != "fidmap":
            assert words[1] in known & RUN_WORDS, command
            continue
        seen = run(command.removeprefix("./run "))
        if output is not None:
            assert plain(seen) == plain(output), f"{command} prints\n{seen}"


def test_no_page_but_these_has_commands() -> None:
    """A page with commands belongs into the test above; those of synth.md run in test_synth_command."""
    assert {page.name for page, _, _ in commands()} <= {"README.md", "usage.md", "synth.md"}


@pytest.mark.parametrize(("page", "code"), blocks("python"), ids=lambda value: getattr(value, "name", ""))
@pytest.mark.usefixtures("here")
def test_python_runs(
    page: Path, code: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("PATH", str(Path(sys.executable).parent), prepend=":")
    script = Path(f"{page.stem}.py")
    script.write_text(code)
    runpy.run_path(str(script))
    assert re.search(r"\d", capsys.readouterr().out)


@pytest.mark.parametrize(("page", "text"), blocks("yaml"), ids=lambda value: getattr(value, "name", ""))
def test_yaml_is_what_it_says(tmp_path: Path, page: Path, text: str) -> None:
    """Arena and profile files in the documents are read without a fault."""
    file = tmp_path / "file.yaml"
    file.write_text(text)
    if "fidmap_arena" in text:
        assert read_arena(file).parts
    elif "fidmap_profile" in text:
        assert read_profile(file).weights
    else:
        assert yaml.safe_load(text), page


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_relative_links_exist(page: Path) -> None:
    text = BLOCK.sub("", page.read_text(encoding="utf-8"))
    for target in re.findall(r"\]\(([^)\s]+)\)", text):
        if not re.match(r"[a-z]+:|#", target):
            assert (page.parent / unquote(target.partition("#")[0])).exists(), f"{page}: {target}"


def every_command() -> Iterator[tuple[str, list[str]]]:
    """Each command and its options, from the program itself."""

    def walk(command: object, words: str) -> Iterator[tuple[str, list[str]]]:
        yield words, [word for p in command.params for word in p.opts if word.startswith("--")]  # type: ignore[attr-defined]
        for name, below in getattr(command, "commands", {}).items():
            yield from walk(below, f"{words} {name}")

    yield from walk(typer.main.get_command(app), "fidmap")


def test_every_command_and_option_is_in_the_usage() -> None:
    text = (ROOT / "docs/usage.md").read_text(encoding="utf-8")
    found = dict(every_command())
    assert {"fidmap score", "fidmap profile show"} <= set(found)
    for command, options in found.items():
        assert command in text
        section = text.partition(f"### `{command} ")[2].partition("\n### ")[0] if " " in command else text
        for option in options:
            assert option == "--help" or option in (section or text), f"{command} {option}"


@pytest.mark.parametrize("command", [command for command, _ in every_command()])
def test_help_works(command: str) -> None:
    result = fidmap(*command.split()[1:], "--help")
    assert result.exit_code == 0
    assert result.stdout.startswith("Usage: ")


def test_the_formula_of_resolution_quality_has_the_program_s_numbers() -> None:
    """They are tuned anew now and then."""
    text = " ".join((ROOT / "docs" / "metric.md").read_text(encoding="utf-8").split())
    assert f"m = {spread.TO_DEVIATION:g} (1 + {spread.COARSE:g} / R^2) times" in text
    assert f"within {spread.BAND:g} R of the ring" in text
    assert f"m^2 - ({spread.RASTER_SPREAD:g} cells)^2" in text


def test_the_version_is_the_same_everywhere() -> None:
    from fidmap import __version__

    assert yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))["version"] == __version__
    assert f"## [{__version__}]" in (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
