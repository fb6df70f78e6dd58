"""The override given from outside outlives BAS(#INITMOV, 0) and is listed; speeds that are no array are refused."""

import pytest

from tests.krl.short_programs import HOME


def test_the_override_outlives_the_initialisation(recorded, folder):
    lines = ["DEF a( )", "BAS(#INITMOV, 0)", "BAS(#VEL_PTP, 100)", HOME, "PTP_REL {A1 70}", "END", ""]
    (folder / "a.src").write_text("\n".join(lines))
    whole, half = (recorded("krl", "run", "a.src", "--set", f"$OV_PRO={x}") for x in (100, 50))
    assert whole["cycle_time"] == pytest.approx(70 / 140 + 0.4)
    assert half["cycle_time"] == pytest.approx(70 / 70 + 0.2)
    assert [a["value"] for a in half["assumptions"] if a["name"] == "$OV_PRO"] == ["50"]


@pytest.mark.parametrize("line", ["$VEL_AXIS = 50", "$ACC_AXIS = {A1 5}"])
def test_speeds_of_axes_that_are_set_whole_are_refused(line, refused, folder):
    """Found by fuzzing."""
    (folder / "a.src").write_text("\n".join(["DEF a( )", "BAS(#INITMOV, 0)", line, HOME, "PTP_REL {A1 70}", "END", ""]))
    assert f"a.src:5:1: {line.split()[0]}[1] has no value; more than 0" in refused("krl", "run", "a.src")
