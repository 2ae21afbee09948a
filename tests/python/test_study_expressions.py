"""Studies: expressions and templates of scenes."""

import math
import random
import re

import numpy as np
import pytest

from cloudcontact import study
from cloudcontact.study import expressions


def test_expressions_are_pythons():
    source = random.Random(1)
    names = {"a": 1.25, "b": -3.0, "c": 2}

    def make(depth):
        if depth == 0:
            return source.choice(["a", "b", "c", "0.5", "3"])
        kind = source.choice(["binary", "minus", "call", "compare", "chain", "and"])
        one, two, three = make(depth - 1), make(depth - 1), make(depth - 1)
        return {
            "binary": f"({one} {source.choice('+-*')} {two})",
            "minus": f"(-{one})",
            "call": f"{source.choice(['abs', 'cos'])}({one})",
            "compare": f"({one} {source.choice(['<', '<=', '>', '==', '!='])} {two})",
            "chain": f"({one} < {two} <= {three})",
            "and": f"({one} {source.choice(['and', 'or'])} not {two})",
        }[kind]

    for _ in range(300):
        text = make(4)
        expected = eval(text, {"abs": abs, "cos": math.cos}, names)
        assert repr(expressions.Expression(text, "x")(names)) == repr(expected), text


@pytest.mark.parametrize(
    "text",
    [
        "__import__('os')",
        "a.b",
        "1 +",
        "a[0]",
        "lambda: 1",
        "abs(x=2)",
        "(1, 2)",
        "exec('1')",
        "b'x'",
        "a if a else a",
        "a is a",
    ],
)
def test_expressions_are_nothing_else_of_python(text):
    with pytest.raises(study.StudyError, match="success: "):
        expressions.Expression(text, "success")


def test_a_template_keeps_all_digits():
    text = expressions.Template("<p>${a} ${a / 3} ${name}</p>", "x.sdf").filled({"a": 0.1 + 0.2, "name": "n"}, 0)
    first, second = map(float, re.findall(r"[\d.e-]{5,}", text))
    assert first == 0.1 + 0.2 and second == (0.1 + 0.2) / 3 and "n</p>" in text


def test_a_template_draws_from_the_seed():
    template = expressions.Template("${uniform(2, 3)} ${normal(0, 1)}", "x.sdf")
    assert template.filled({}, 5) == template.filled({}, 5) != template.filled({}, 6)
    drawn = np.array([list(map(float, template.filled({}, s).split())) for s in range(400)])
    assert drawn[:, 0].min() >= 2 and drawn[:, 0].max() <= 3
    assert abs(drawn[:, 1].mean()) < 0.2 and abs(drawn[:, 1].std() - 1) < 0.15
