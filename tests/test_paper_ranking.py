"""The paper's rank comparison, from the figures that it prints (SSRR 2011, Tables I, II and III)."""

from __future__ import annotations

import json

import pytest

from fidmap.ranking import Rank, agreement, ranks
from real_data import real_data

# Table I: coverage, relative accuracy, short-range, long-range, average; one row per map
TABLE_1 = (
    (56, 75, 100, 0, 60), (100, 97, 100, 100, 99), (44, 94, 100, 0, 63), (67, 100, 100, 100, 89),
    (33, 100, 0, 100, 61), (67, 71, 38, 25, 57), (56, 95, 100, 0, 67), (33, 67, 75, 0, 46),
    (44, 81, 100, 50, 67), (44, 100, 100, 0, 65),
)  # fmt: skip
# Table II: coverage, relative accuracy, consistency, average
TABLE_2 = (
    (80, 50, 70, 67), (100, 90, 90, 93), (50, 50, 70, 57), (60, 90, 90, 80), (40, 50, 90, 60),
    (50, 40, 50, 47), (50, 90, 90, 77), (30, 60, 80, 57), (60, 70, 80, 70), (40, 90, 90, 73),
)  # fmt: skip
# Table III: metric / human per attribute
TABLE_3 = (
    "4-5/2 8/7-9 4-6/8-9 8/6", "1/1 4/1-4 1-2/1-5 1/1", "6-8/5-7 6/7-9 4-6/8-9 6/8-9",
    "2-3/3-4 1-3/1-4 1-2/1-5 2/2",
    "9-10/8-9 1-3/7-9 4-6/1-5 7/7", "2-3/5-7 9/10 9/10 9/10", "4-5/5-6 5/1-4 7-8/1-5 3-4/3",
    "9-10/10 10/6 10/6-7 10/8-9", "6-8/3-4 7/5 3/6-7 3-4/5", "6-8/8-9 1-3/1-4 7-8/1-5 5/4",
)  # fmt: skip

ATTRIBUTES = ("coverage", "relative_accuracy", "consistency", "overall")

Ranking = tuple[Rank | None, ...]


def metric() -> dict[str, Ranking]:
    """Ranks of the metric from the printed percentages; consistency is the mean of short and long (IV)."""
    rows = [(row[0], row[1], (row[2] + row[3]) / 2, row[4]) for row in TABLE_1]
    return {name: ranks(column) for name, column in zip(ATTRIBUTES, zip(*rows, strict=True), strict=True)}


def human() -> dict[str, Ranking]:
    """Ranks of the judge from the printed percentages."""
    return {name: ranks(column) for name, column in zip(ATTRIBUTES, zip(*TABLE_2, strict=True), strict=True)}


def test_ranks_agree_with_table_3_but_in_eight_cells() -> None:
    """The paper's Table III contradicts its Tables I and II in these cells; the rule is not bent to them."""
    disagreeing = []
    for index, row in enumerate(TABLE_3):
        for name, cell in zip(ATTRIBUTES, row.split(), strict=True):
            for who, found, printed in zip(("metric", "human"), (metric(), human()), cell.split("/"), strict=True):
                if str(found[name][index]) != printed:
                    disagreeing.append((index + 1, name, who, printed, str(found[name][index])))
    assert disagreeing == [
        (1, "consistency", "metric", "4-6", "4-8"),
        (3, "consistency", "metric", "4-6", "4-8"),
        (5, "consistency", "metric", "4-6", "4-8"),
        (6, "consistency", "metric", "9", "10"),
        (7, "coverage", "human", "5-6", "5-7"),
        (7, "consistency", "metric", "7-8", "4-8"),
        (8, "consistency", "metric", "10", "9"),
        (10, "consistency", "metric", "7-8", "4-8"),
    ]


@pytest.mark.parametrize(
    ("name", "spearman", "kendall"),
    [
        ("coverage", 0.757, 0.658),
        ("relative_accuracy", 0.552, 0.463),
        ("consistency", 0.564, 0.508),
        ("overall", 0.896, 0.750),
    ],
)
def test_correlation_of_metric_and_judge(name: str, spearman: float, kendall: float) -> None:
    """Rank correlations of the ten maps of part A; with n = 10 only coverage and average are clear at 5 %."""
    found = agreement(metric()[name], human()[name])
    assert found.n == 10
    assert found.spearman.value.value == pytest.approx(spearman, abs=0.0005)
    assert found.kendall.value.value == pytest.approx(kendall, abs=0.0005)
    p_value = found.spearman.p_value.value
    assert p_value is not None
    assert (p_value < 0.05) == (name in {"coverage", "overall"})


def test_exact_values_do_not_tie_maps_7_and_9() -> None:
    """Their averages are 66.85 and 66.90 before rounding: a tie only within half a point, as printed."""
    exact = (60.185, 99.074, 62.731, 88.889, 61.111, 56.25, 66.852, 45.833, 66.898, 64.815)
    assert [str(rank) for rank in ranks(exact, 0)][6:9:2] == ["4", "3"]
    assert [str(rank) for rank in ranks(exact)][6:9:2] == ["3-4", "3-4"]


def test_the_tables_are_those_of_the_checked_file() -> None:
    """The averages typed here are those of the independent check of the tables."""
    rows = json.loads(real_data("paper", "tables.json").read_text(encoding="utf-8"))["table1"]
    assert [rows[str(i + 1)]["avg_printed"] for i in range(10)] == [row[-1] for row in TABLE_1]
