"""The names of `import lwr_dyn`, each with its documentation and where it is used."""

import inspect
from pathlib import Path

from used_in import used_in

import lwr_dyn

PAGE = "docs/reference/python.md"
SUBJECTS = {
    "Robots": ("robots", "readings", "load", "urdf_text"),
    "Dynamics": ("engines", "dynamics_of", "batch_dynamics"),
    "Kinematics": ("forward_kinematics", "inverse_kinematics", "ik_solver"),
    "Motion": ("controller", "reference", "simulate", "Run"),
}
"""Headings and their names; a name that stands under none comes under "Pictures and results"."""


def front_door_text(root: Path) -> str:
    """A section for each name."""
    listed = {name for names in SUBJECTS.values() for name in names}
    subjects = SUBJECTS | {"Pictures and results": tuple(n for n in sorted(lwr_dyn.__all__) if n not in listed)}
    lines = []
    for subject, names in subjects.items():
        lines += [f"## {subject}", ""]
        for name in names:
            lines += [f"### {name}", "", entry(name), "", used_in(rf"lwr_dyn\.{name}\b", root, PAGE), ""]
    return "\n".join(lines)


def entry(name: str) -> str:
    """The directive that documents a name."""
    value = getattr(lwr_dyn, name)
    kind = "autoclass" if inspect.isclass(value) else "autofunction"
    members = "\n   :members:\n   :undoc-members:" if kind == "autoclass" else ""
    return f"```{{eval-rst}}\n.. {kind}:: lwr_dyn.{name}{members}\n```"
