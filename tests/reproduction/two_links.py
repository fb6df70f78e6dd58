"""A small paper for tests: two links in a vertical plane, with results that follow by hand."""

from collections.abc import Callable
from pathlib import Path


def writer(folder: Path, text: str) -> Callable[..., str]:
    """Writes a paper there, with texts replaced once and others added, and gives its path."""

    def write(*replaced: tuple[str, str], more: str = "") -> str:
        whole = text + more
        for old, new in replaced:
            assert old in whole
            whole = whole.replace(old, new, 1)
        (folder / "two.toml").write_text(whole, encoding="utf-8")
        return str(folder / "two.toml")

    return write


TEXT = """
schema = 1
name = "two_links"
title = "Two links in a vertical plane"
[document]
title = "A paper of two pages"
[joints]
kinds = ["revolute", "revolute"]
[base]
gravity = { values = [0, -9.81, 0], unit = "m/s^2", where = "section 2", kind = "printed" }
[dh]
convention = "standard"
alpha = { values = [0, 0], unit = "deg", where = "Table I", kind = "printed" }
a = { values = [500, 400], unit = "mm", where = "Table I", kind = "printed" }
d = { values = [0, 0], unit = "mm", where = "Table I", kind = "printed" }
[limits]
effort = { values = [40, 10], unit = "N m", where = "Table III", kind = "printed" }
[inertial]
mass = { values = [2.0, 1.5], unit = "kg", where = "Table II", kind = "printed" }
com = { values = [[-250, 0, 0], [-200, 0, 0]], unit = "mm", where = "Table II", kind = "printed" }
[inertial.inertia]
values = [[[0.01, 0, 0], [0, 0.05, 0], [0, 0, 0.05]], [[0.005, 0, 0], [0, 0.02, 0], [0, 0, 0.02]]]
unit = "kg m^2"
about = "com"
axes = "frame"
products = "tensor"
where = "Table II"
kind = "printed"
"""

RESULTS = """
[[result]]
id = "b11"
where = "Table IV, b11"
printed = "0.930"
unit = "kg m^2"
compute = "mass_matrix[1,1]"
q_deg = [0, 0]
[[result]]
id = "holding"
where = "section 3"
printed = ["15.21", "2.94"]
unit = "N m"
compute = "gravity"
q_deg = [0, 0]
[[result]]
id = "share"
where = "conclusion: the first motor"
printed = "38"
unit = "%"
compute = "gravity[1] / limits.effort[1]"
q_deg = [0, 0]
[[result]]
id = "reach"
where = "conclusion: the reach"
printed = "900"
unit = "mm"
compute = "pose[1]"
q_deg = [0, 0]
"""
"""By hand at q = 0: b11 = 2 x 0.25^2 + 0.05 + 1.5 x 0.7^2 + 0.02 = 0.93; g2 = 1.5 x 9.81 x 0.2 = 2.943;
g1 = (2 x 0.25 + 1.5 x 0.5) x 9.81 + 2.943 = 15.2055, which is 38.0 % of 40; 0.5 + 0.4 = 0.9 m."""
