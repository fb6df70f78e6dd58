"""The smoke test of an installed wheel sees a command that fails, and accepts one that names its extra."""

import pytest

from lwr_dyn.cli.main import help_texts
from scripts.wheel_smoke import LEFT_OUT, examples, faults, is_missing

MISSING = "lwr-dyn: lark is not installed; install it with: pip install 'lwr_dyn[krl]'\n"
FACTS = {"commands": ["fk", "krl"], "texts": {"fk": {"examples": [{"run": "lwr-dyn fk x", "exit": 1}]}}}


def runner(of_fk=(0, "Usage: lwr-dyn fk", ""), of_krl=(2, "", MISSING), of_example=(1, "", "")):
    answers = {"lwr-dyn fk --help": of_fk, "lwr-dyn krl --help": of_krl, "lwr-dyn fk x": of_example}
    return lambda _, words: answers[" ".join(words)]


def test_what_works_and_what_names_its_extra_holds():
    assert faults(FACTS, runner()) == []
    assert faults(FACTS, runner(of_example=(2, "", MISSING))) == []


@pytest.mark.parametrize(
    ("answers", "fault"),
    [
        ({"of_fk": (1, "", "Traceback")}, "help of fk"),
        ({"of_krl": (2, "", "lwr-dyn: bad input\n")}, "help of krl"),
        ({"of_krl": (2, "", f"Traceback\n{MISSING}")}, "help of krl"),
        ({"of_example": (0, "", "")}, "lwr-dyn fk x: exit code 0, not 1: "),
    ],
)
def test_what_fails_is_named(answers, fault):
    assert faults(FACTS, runner(**answers)) == [fault]


def test_the_examples_of_most_commands_are_run():
    tried = {line.split()[1] for path, text in help_texts().items() for line, _ in examples(path, text)}
    assert {"check", "simulate", "replay", "show", "urdf", "ik", "fk", "lint"} <= tried
    assert not tried & set(LEFT_OUT)
    assert not is_missing(1, MISSING)
