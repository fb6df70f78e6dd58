"""`lwr-dyn origin`."""

import json

import numpy as np

import lwr_dyn
from tests.checks.origin.planted import foreign_arm


def test_a_copy_is_named_and_what_copies_nothing_is_exit_1(lwr_dyn_command, tmp_path):
    copy, own = tmp_path / "copy.urdf", tmp_path / "own.urdf"
    copy.write_text(lwr_dyn.urdf_text(lwr_dyn.load("panda", "fr3")))
    own.write_text(foreign_arm(np.random.default_rng(1)))
    code, out, _ = lwr_dyn_command("origin", str(copy), "--json")
    assert code == 0
    assert json.loads(out)["origin"] == "panda:fr3"
    code, out, _ = lwr_dyn_command("origin", str(own))
    assert code == 1
    assert "no published set" in out
