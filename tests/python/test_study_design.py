"""Studies: grids, Latin hypercubes, lists, seeds."""

from typing import Any

import numpy as np
import pytest

from cloudcontact import study
from cloudcontact.study import design


def points(parameters, kind="grid", trials=None, repeats=1, seed=0):
    return design.plan(parameters, kind, trials, repeats, seed)


def test_a_grid_has_all_combinations_once():
    plan = points({"a": study.Range(0, 1, 3), "b": ["x", "y"], "c": 7})
    rows = [(p.parameters["a"], p.parameters["b"], p.parameters["c"]) for p in plan]
    assert rows == [(0, "x", 7), (0, "y", 7), (0.5, "x", 7), (0.5, "y", 7), (1, "x", 7), (1, "y", 7)]
    assert [p.number for p in plan] == list(range(6))


def test_ranges_meet_their_ends_and_keep_their_ratios():
    values = study.Range(1e-5, 1e-2, 4, log=True).values("x")
    assert values[0] == 1e-5 and values[-1] == 1e-2
    np.testing.assert_allclose(np.diff(np.log10(values)), 1, rtol=1e-12)
    assert study.Range(3, 9, 1).values("x") == [3]


@pytest.mark.parametrize("trials", [1, 7, 64])
def test_a_latin_hypercube_meets_each_part_once(trials):
    plan = points(
        {"a": study.Range(-1, 3), "b": study.Range(1e-3, 10, log=True), "c": ["x", "y", "z"]}, "latin", trials
    )
    a = np.array([p.parameters["a"] for p in plan])
    b = np.array([p.parameters["b"] for p in plan])
    assert sorted(np.floor((a + 1) / 4 * trials)) == list(range(trials))
    assert sorted(np.floor(np.log(b / 1e-3) / np.log(1e4) * trials)) == list(range(trials))
    counts = [sum(p.parameters["c"] == v for p in plan) for v in "xyz"]
    assert max(counts) - min(counts) <= 1 and sum(counts) == trials


def test_a_latin_hypercube_follows_its_seed():
    ranges = {"a": study.Range(0, 1), "b": study.Range(0, 1)}
    first, again, other = (points(ranges, "latin", 20, seed=s) for s in (3, 3, 4))
    assert first == again and first != other
    # Columns do not go along with each other: 20 ranks in common order have correlation 1.
    a, b = np.array([list(p.parameters.values()) for p in points(ranges, "latin", 400)]).T
    assert abs(np.corrcoef(a, b)[0, 1]) < 0.2


def test_lists_and_repeats():
    plan = points({"k": 5}, "list", [{"a": 1, "b": 2}, {"b": 3, "a": 4}], repeats=2)
    assert [p.parameters for p in plan] == 2 * [{"k": 5, "a": 1, "b": 2}] + 2 * [{"k": 5, "b": 3, "a": 4}]
    assert [p.repeat for p in plan] == [0, 1, 0, 1]


def test_seeds_depend_on_study_and_number_alone():
    seeds = {design.seed_of(s, n) for s in range(20) for n in range(200)}
    assert len(seeds) == 4000 and all(0 <= s < 2**63 for s in seeds)
    assert [p.seed for p in points({"a": [1, 2, 3]})] == [p.seed for p in points({"b": list("xyz")})]
    # Those of other versions of numpy are these, too.
    assert [design.seed_of(0, 0), design.seed_of(7, 1000)] == [8069282889424829228, design.seed_of(7, 1000)]


def test_numpys_numbers_are_numbers():
    """They give what Python's own give, to the bit."""

    def study_of(kind: Any, real: Any) -> study.Study:
        ranges = {"a": study.Range(real(0.1), real(0.7), kind(3)), "b": study.Range(kind(1), kind(4), kind(2))}
        more: dict[str, Any] = {"n": [kind(1), kind(2)], "r": np.array(real(0.3)), "flag": np.bool_(True)}
        words: dict[str, Any] = {"repeats": kind(2), "seed": kind(5), "timeout": real(2.5)}
        return study.Study(trial=takes, parameters={**ranges, **more}, **words)

    plain = study_of(int, float)
    for integer, real in ((np.int64, np.float64), (np.uint8, np.longdouble)):
        same = study_of(integer, lambda x, real=real: real(float(x)))
        assert same.points == plain.points and same.statement == plain.statement and same.timeout == plain.timeout
    small = study_of(int, lambda x: float(np.float32(x)))
    assert study_of(np.int32, np.float32).points == small.points
    kinds = {type(v) for p in study_of(np.int32, np.float32).points for v in [p.seed, *p.parameters.values()]}
    assert kinds == {int, float, bool}
    assert len(points({"a": study.Range(0, 1)}, "latin", np.int16(4))) == 4


def takes(a, b, n, r, flag):
    return {}


@pytest.mark.parametrize(
    "words, message",
    [
        ({"repeats": True}, "repeats: must be a whole number"),
        ({"repeats": np.bool_(True)}, "repeats: must be a whole number"),
        ({"repeats": np.float64(2)}, "repeats: must be a whole number"),
        ({"seed": np.int64(-1)}, "seed: must be a whole number of 0 or more"),
        ({"timeout": True}, "timeout: must be a number of seconds"),
        ({"timeout": float("inf")}, "timeout: must be a number of seconds"),
        ({"timeout": "9"}, "timeout: must be a number of seconds"),
        ({"parameters": {"n": study.Range(0, 10**400, 2)}}, "parameters.n: from and to must be finite"),
        ({"parameters": {"n": study.Range(True, 2, 2)}}, "parameters.n: from and to must be finite"),
        ({"parameters": {"n": study.Range(0, 2, True)}}, "parameters.n: count must be a whole number"),
        ({"parameters": {"n": 2**64}}, "parameters.n: 18446744073709551616 has more than 63 bits"),
        ({"parameters": {"n": np.float32("nan")}}, "parameters.n: nan is not finite"),
        ({"parameters": {1: 2}}, "parameters.1: is no name"),
        ({"parameters": ["n"]}, "parameters: must be a dict"),
    ],
)
def test_what_is_no_number_is_named(words, message):
    stated: dict[str, Any] = {"trial": takes, "parameters": {"n": 1}, **words}
    with pytest.raises(study.StudyError, match=message):
        study.Study(**stated)
