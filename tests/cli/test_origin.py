"""`lwr-dyn origin`."""

import numpy as np

import lwr_dyn
from tests.checks.origin.planted import foreign_arm


def test_a_copy_is_named_and_what_copies_nothing_is_exit_1(lwr_dyn_command, recorded, folder):
    (folder / "copy.urdf").write_text(lwr_dyn.urdf_text(lwr_dyn.load("panda", "fr3")))
    (folder / "own.urdf").write_text(foreign_arm(np.random.default_rng(1)))
    assert recorded("origin", "copy.urdf")["origin"] == "panda:fr3"
    code, out, _ = lwr_dyn_command("origin", "own.urdf")
    assert (code, "no published set" in out) == (1, True)
