"""The program override: given from outside it outlives BAS(#INITMOV, 0), and is listed."""

import pytest

from tests.krl.short_programs import HOME


def test_the_override_outlives_the_initialisation(recorded, folder):
    lines = ["DEF a( )", "BAS(#INITMOV, 0)", "BAS(#VEL_PTP, 100)", HOME, "PTP_REL {A1 70}", "END", ""]
    (folder / "a.src").write_text("\n".join(lines))
    whole, half = (recorded("krl", "run", "a.src", "--set", f"$OV_PRO={x}") for x in (100, 50))
    assert whole["cycle_time"] == pytest.approx(70 / 140 + 0.4)
    assert half["cycle_time"] == pytest.approx(70 / 70 + 0.2)
    assert [a["value"] for a in half["assumptions"] if a["name"] == "$OV_PRO"] == ["50"]
