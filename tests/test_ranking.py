"""Ranks with ties and rank correlations: hand-computed cases, a peer, and properties."""

from __future__ import annotations

import math
from random import Random

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import kendalltau, rankdata, spearmanr

from fidmap.model import Value
from fidmap.ranking import Agreement, Rank, agreement, average_ranks, ranks


def texts(values: list[float | None], tie_within: float = 0.5) -> list[str | None]:
    return [str(rank) if rank else None for rank in ranks(values, tie_within)]


def plain(values: list[float]) -> tuple[Rank | None, ...]:
    return ranks(values, 0)


def test_higher_is_better() -> None:
    """The best map is first, whatever the order of the input."""
    assert texts([50.0, 90.0, 70.0]) == ["3", "1", "2"]


def test_ties_share_their_places() -> None:
    """Written as in the paper's Table III."""
    assert texts([80.0, 80.0, 90.0, 10.0]) == ["2-3", "2-3", "1", "4"]


def test_neighbours_within_half_a_point_tie_in_chains() -> None:
    """60 and 60.8 are 0.8 apart and still one tie, since 60.4 lies between; 0.5 itself ties."""
    assert texts([60.0, 60.4, 60.8, 62.0]) == ["2-4", "2-4", "2-4", "1"]
    assert texts([66.9, 66.4, 65.89]) == ["1-2", "1-2", "3"]


def test_a_map_that_is_not_computable_has_no_rank() -> None:
    """It is neither last nor zero."""
    assert texts([None, 50.0, None, 60.0]) == [None, "2", None, "1"]
    assert ranks([]) == ()


def test_values_that_are_no_numbers_are_our_bug() -> None:
    """NaN would sort anywhere in silence."""
    with pytest.raises(ValueError, match="finite"):
        ranks([1.0, math.nan])


def test_perfect_agreement_and_its_opposite() -> None:
    """Four maps have 24 orders; one agrees fully, one fully not: p = 2/24."""
    same = agreement(plain([4.0, 3, 2, 1]), plain([40.0, 30, 20, 10]))
    assert (same.n, same.spearman.value.value, same.kendall.value.value) == (4, 1.0, 1.0)
    assert same.spearman.p_value.value == same.kendall.p_value.value == pytest.approx(2 / 24)
    turned = agreement(plain([4.0, 3, 2, 1]), plain([1.0, 2, 3, 4]))
    assert (turned.spearman.value.value, turned.kendall.value.value) == (-1.0, -1.0)


def test_a_case_by_hand() -> None:
    """Ranks 1 2 3 against 1 3 2: rho = 1 - 6 * 2 / 24 = 0.5, tau = (2 - 1) / 3; p from 6 orders."""
    found = agreement(plain([3.0, 2, 1]), plain([3.0, 1, 2]))
    assert found.spearman.value.value == pytest.approx(0.5)
    assert found.kendall.value.value == pytest.approx(1 / 3)
    assert found.spearman.p_value.value == pytest.approx(1.0)


def test_only_maps_ranked_by_both_count() -> None:
    """A map that was not judged says nothing about the judge."""
    ours, theirs = plain([4.0, 3, 2, 1]), (*plain([3.0, 2, 1]), None)
    assert agreement(ours, theirs).n == 3
    assert agreement(ours, theirs).spearman.value.value == pytest.approx(1)


@pytest.mark.parametrize(
    ("ours", "theirs", "reason"),
    [
        ([1.0], [1.0], "1 map ranked by both, three are needed"),
        ([2.0, 1.0], [2.0, 1.0], "2 maps ranked by both, three are needed"),
        ([5.0, 5.0, 5.0], [1.0, 2.0, 3.0], "all maps share one rank"),
    ],
)
def test_what_cannot_be_compared_has_a_reason(ours: list[float], theirs: list[float], reason: str) -> None:
    """Never 0 and never NaN."""
    found = agreement(plain(ours), plain(theirs))
    assert found.spearman.value == found.kendall.p_value == Value(None, reason)


@settings(derandomize=True, deadline=None, max_examples=60)
@given(st.lists(st.tuples(st.integers(0, 5), st.integers(0, 5)), min_size=3, max_size=8))
def test_scipy_agrees(pairs: list[tuple[int, int]]) -> None:
    """Rho and tau-b with ties as scipy computes them."""
    x, y = (np.array(side, float) for side in zip(*pairs, strict=True))
    found = agreement(plain(list(x)), plain(list(y)))
    if found.spearman.value.value is None:
        assert len(set(x)) == 1 or len(set(y)) == 1
    else:
        assert found.spearman.value.value == pytest.approx(spearmanr(x, y).statistic)
        assert found.kendall.value.value == pytest.approx(kendalltau(x, y).statistic)


@settings(derandomize=True, max_examples=60)
@given(st.lists(st.integers(-9, 9), min_size=1))
def test_average_ranks_as_scipy(values: list[int]) -> None:
    """Ties share the mean of their places."""
    assert average_ranks(np.array(values, float)).tolist() == rankdata(values).tolist()


@settings(derandomize=True, max_examples=100)
@given(st.lists(st.none() | st.floats(0, 100)), st.floats(0, 5), st.randoms(use_true_random=False))
def test_order_of_input_does_not_matter(values: list[float | None], tie: float, random: Random) -> None:
    """A map keeps its rank wherever it stands, and every place is given once."""
    order = list(range(len(values)))
    random.shuffle(order)
    found = ranks(values, tie)
    assert ranks([values[i] for i in order], tie) == tuple(found[i] for i in order)
    given_ranks = [rank for rank in found if rank]
    assert sum(rank.middle for rank in given_ranks) == len(given_ranks) * (len(given_ranks) + 1) / 2


def many(n: int, seed: int = 0) -> Agreement:
    generator = np.random.default_rng(5)
    x = generator.normal(size=n)
    y = x + generator.normal(size=n)
    return agreement(plain(list(x)), plain(list(y)), seed)


def test_draws_are_seeded_and_near_the_exact_share() -> None:
    """Nine maps and more are drawn 10,000 times: the same twice, and near scipy's exact p-value."""
    assert many(9) == many(9)
    x, y = np.arange(9.0), np.array([1.0, 0, 3, 2, 5, 4, 8, 6, 7])
    found = agreement(plain(list(x)), plain(list(y))).kendall
    exact = kendalltau(x, y, method="exact").pvalue
    assert found.p_value.value == pytest.approx(exact, abs=0.001)


def test_many_maps_are_approximated() -> None:
    """Over 200 maps the approximations take over, in well under a second."""
    found = many(300)
    assert found.n == 300
    assert 0.5 < (found.spearman.value.value or 0) < 0.9
    assert (found.kendall.p_value.value or 0) < 1e-6
