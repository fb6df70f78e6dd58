"""A small study for tests of its execution, and its results as bytes."""

from pathlib import Path

from lwr_dyn.studies.sweep.read_study import read_study

TEXT = """
robot = "lwr4plus"
reading = "physical"
controllers = [CONTROLLERS]
[task]
name = "point-to-point"
from-deg = [0, 30, 0, -60, 0, 30, 0]
to-deg = [3, 33, 0, -63, 0, 33, 0]
duration = 0.03
[sampling]
method = "random"
seed = 5
runs = 24
chunk = 2
[metrics]
quantiles = [0.95]
[[parameter]]
path = "payload.mass"
low = 0.0
high = 3.0
[[parameter]]
path = "payload.known"
values = [0, 1]
[[parameter]]
path = "arm.com.7"
low = -0.01
high = 0.01
[[parameter]]
path = "sensor.noise"
low = 0.0
high = 1e-5
"""
LAW = """
def make(arm, dynamics):
    B = dynamics
    def controller(t, q, dq, q_ref, dq_ref, ddq_ref):
        return B.inverse_dynamics(q, dq, ddq_ref + 400.0 * (q_ref - q) + 40.0 * (dq_ref - dq))
    return controller
"""
"""Inverse dynamics as the package's own with omega_n = 20 rad/s, in a file."""
OWN = "inverse-dynamics:omega-n=20"


def small_study(folder: Path, *controllers: str, **files: str):
    """The study of these controllers; `files` are written beside it, by name without .py."""
    for name, text in files.items():
        (folder / f"{name}.py").write_text(text, encoding="utf-8")
    listed = ", ".join(f'"{text}"' for text in controllers or (OWN,))
    path = folder / "small.toml"
    path.write_text(TEXT.replace("CONTROLLERS", listed), encoding="utf-8")
    return read_study(path)


def contents(folder: Path) -> dict[str, bytes]:
    """Path -> bytes of every file of a sweep, hidden ones too."""
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in folder.rglob("*") if path.is_file()}
