"""The smoke test of an installed wheel sees a command that fails, and accepts one that names its extra."""

import pytest

from lwr_dyn.cli.help_text import help_texts
from scripts.wheel_smoke import LEFT_OUT, examples, faults, is_missing

MISSING = "lwr-dyn: lark is not installed; install it with: pip install 'lwr_dyn[krl]'\n"
FACTS = {
    "commands": {"fk": "", "krl": "krl", "lint": ""},
    "texts": {"fk": {"examples": [{"run": "lwr-dyn fk x", "exit": 1}, {"run": "lwr-dyn fk --plot"}]}},
}
PLOTS = MISSING.replace("krl", "plots")


def runner(of_lint=(0, "Usage: lwr-dyn lint", ""), of_krl=(2, "", MISSING), of_fk=(1, "", ""), of_plot=(0, "", "")):
    answers = {"lint --help": of_lint, "krl --help": of_krl, "fk x": of_fk, "fk --plot": of_plot}
    return lambda _, words: answers[" ".join(words[1:])]


@pytest.mark.parametrize(
    ("answers", "fault"),
    [
        ({}, None),
        ({"of_plot": (2, "", PLOTS)}, None),
        ({"of_lint": (1, "", "Traceback")}, "help of lint"),
        ({"of_lint": (2, "", MISSING)}, "help of lint"),
        ({"of_krl": (2, "", "lwr-dyn: bad input\n")}, "help of krl"),
        ({"of_krl": (2, "", f"Traceback\n{MISSING}")}, "help of krl"),
        ({"of_krl": (2, "", PLOTS)}, "help of krl"),
        ({"of_fk": (0, "", "")}, "lwr-dyn fk x: exit code 0, not 1: "),
        ({"of_fk": (2, "", MISSING)}, f"lwr-dyn fk x: exit code 2, not 1: {MISSING}"),
        ({"of_plot": (2, "", MISSING)}, f"lwr-dyn fk --plot: exit code 2, not 0: {MISSING}"),
    ],
)
def test_what_fails_is_named_and_what_works_or_names_its_extra_is_not(answers, fault):
    assert faults(FACTS, runner(**answers)) == ([] if fault is None else [fault])


def test_the_examples_of_most_commands_are_run():
    tried = {line.split()[1] for path, text in help_texts().items() for line, _ in examples(path, text)}
    assert {"check", "simulate", "replay", "show", "urdf", "ik", "fk", "lint"} <= tried
    assert not tried & set(LEFT_OUT)
    assert not is_missing(1, MISSING, "krl")
