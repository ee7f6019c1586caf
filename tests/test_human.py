"""Human rankings: percents or ranks per column, and every fault with its line."""

from __future__ import annotations

from pathlib import Path

import pytest

from fidmap.human import HumanRanking, read_human
from fidmap.model import HumanFileError
from fidmap.ranking import Rank


def read(folder: Path, text: str) -> HumanRanking:
    path = folder / "h.csv"
    path.write_text(text, encoding="utf-8")
    return read_human(path)


def column(folder: Path, *cells: str) -> tuple[str, list[str | None]]:
    """Kind and ranks of one column of as many maps."""
    rows = "".join(f"m{i};{cell}\n" for i, cell in enumerate(cells))
    found = read(folder, f"map;overall\n{rows}").columns["overall"]
    return found.kind, [str(rank) if rank else None for rank in found.ranks()]


def fault(folder: Path, text: str) -> str:
    with pytest.raises(HumanFileError) as told:
        read(folder, text)
    assert "\n" not in str(told.value)
    return str(told.value).removeprefix(f"{folder / 'h.csv'}: ")


def test_a_ranking_is_read(tmp_path: Path) -> None:
    """Percents in one column, ranks in another, blanks for what nobody judged."""
    found = read(tmp_path, "map,coverage,overall\nteamA_map,80,1\nteamB,,2-3\nteamC,55.5%,2-3\n")
    assert found.maps == ("teamA_map", "teamB", "teamC")
    assert found.columns["coverage"].kind == "percents"
    assert found.columns["coverage"].percents == (80.0, None, 55.5)
    assert found.columns["coverage"].ranks() == (Rank(1, 1), None, Rank(2, 2))
    assert found.columns["overall"].shared == (Rank(1, 1), Rank(2, 3), Rank(2, 3))


@pytest.mark.parametrize(
    ("cells", "kind", "expected"),
    [
        (["80", "50", "80"], "percents", ["1-2", "3", "1-2"]),
        (["3", "1", "2"], "ranks", ["3", "1", "2"]),
        (["1", "2", "2", "4"], "ranks", ["1", "2-3", "2-3", "4"]),
        (["1", "2-3", "2–3", "4"], "ranks", ["1", "2-3", "2-3", "4"]),
        (["", "1", "", "2"], "ranks", [None, "1", None, "2"]),
        (["1%", "2%", "3%"], "percents", ["3", "2", "1"]),
        (["1", "2", "3.5"], "percents", ["3", "2", "1"]),
        (["0", "1", "2"], "percents", ["3", "2", "1"]),
        (["2", "3", "3"], "percents", ["3", "1-2", "1-2"]),
        (["66,9", "66,4", "10"], "percents", ["1-2", "1-2", "3"]),
        (["", "", ""], "percents", [None, None, None]),
    ],
)
def test_percents_and_ranks_are_told_apart(
    tmp_path: Path, cells: list[str], kind: str, expected: list[str | None]
) -> None:
    """The rules of `read_human`, one case each."""
    assert column(tmp_path, *cells) == (kind, expected)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("", "is empty, expected a human ranking with a first line map"),
        ("map\na\n", "line 1: no column is judged, expected any of coverage, relative_accuracy, consistency, "
         "global_accuracy, resolution_quality, overall"),
        ("map,average\n", "unknown column 'average', known are map, coverage, relative_accuracy, "
         "consistency, global_accuracy, resolution_quality, overall"),
        ("map,overall\n,50\na,60\na,x\n", "line 2: map is missing; line 4: map 'a' stands already on line 3; "
         "line 4: overall must be a percent or a rank like 4 or 4-5, not 'x'"),
        ("map,overall\na,101\n", "line 2: overall must be from 0 to 100 percent, not '101'"),
        ("map,overall\na,2-3\nb,1\n",
         "line 2: overall must rise from 1 to at most 2, the number of maps, not '2-3'"),
        ("map,overall\na,1-2\nb,50%\n", "column overall: mixes percents with ranks"),
        ("map,overall\na,1-2\nb,50\n", "column overall: '50' is no rank from 1 to 2"),
        ("map,overall\na,1\nb,2\nc,2\nd,3\n", "column overall: is no ranking, write tied maps as 2-3"),
        ("map,overall\na,0.8\nb,1\n", "column overall: holds fractions, write percents from 0 to 100"),
    ],
)  # fmt: skip
def test_a_fault_is_told_with_its_line(tmp_path: Path, text: str, told: str) -> None:
    """All faults at once; what cannot be decided is told, not guessed."""
    assert fault(tmp_path, text) == told
