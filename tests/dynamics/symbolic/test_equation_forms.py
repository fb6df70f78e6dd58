"""One entry of B, C or g in letters, against the engine."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.dynamics.symbolic.equation_forms import entry_text, named_entries, symbolic_entries
from lwr_dyn.foundation.errors import MissingDataError, OptionError
from tests.dynamics.symbolic.evaluated import evaluated, state_letters
from tests.random_arms import random_arm

AGREES = 1e-11


@pytest.mark.slow
def test_every_entry_is_the_engines():
    arm = random_arm(2, "PR")
    entries, dynamics = symbolic_entries(arm.chain), lwr_dyn.dynamics_of(arm)
    q, dq = np.random.default_rng(5).uniform(-1, 1, (2, arm.n))
    known = {"B": dynamics.mass_matrix(q), "C": dynamics.coriolis_matrix(q, dq), "g": dynamics.gravity_vector(q)}
    letters = entries.values | state_letters(q, dq)
    for name, (letter, i, j) in named_entries(arm.n).items():
        expected = known[letter][i] if letter == "g" else known[letter][i, j]
        assert abs(evaluated(entries.text(letter, i, j), letters) - expected) < AGREES, name


@pytest.mark.slow
def test_a_paper_names_its_lengths():
    assert entry_text("lwr4plus", "B_66").endswith("m7*(c7z + d7)^2")


def test_an_entry_that_does_not_exist_and_an_arm_without_masses():
    for entry in ("B_88", "tau_1", "B66", ""):
        with pytest.raises(OptionError, match="B_23"):
            entry_text("lwr4plus", entry)
    with pytest.raises(MissingDataError):
        entry_text("lwr4", "B_11")


def test_names_beyond_nine_joints_stay_apart():
    assert len(named_entries(11)) == 2 * 121 + 11
    assert named_entries(11)["B_1,11"] == ("B", 0, 10)
