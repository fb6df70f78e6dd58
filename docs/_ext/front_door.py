"""The names of `import lwr_dyn`, each with its documentation and where it is used."""

import inspect
from pathlib import Path
from typing import Any

from sphinx.application import Sphinx
from used_in import used_in

import lwr_dyn

PAGE = "docs/reference/python.md"
SUBJECTS = {
    "Robots": ("robots", "readings", "load", "urdf_text"),
    "Dynamics": ("engines", "dynamics_of", "batch_dynamics"),
    "Kinematics": ("forward_kinematics", "inverse_kinematics", "ik_solver"),
    "Motion": ("controller", "reference", "simulate", "rollouts", "Run"),
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


def head_examples(app: Sphinx, what: str, name: str, value: Any, options: Any, lines: list[str]) -> None:
    """Give the examples of a docstring a heading, without which they would belong to the section before them."""
    first = next((i for i, line in enumerate(lines) if line.startswith(">>>")), None)
    if first is not None and "Examples" not in lines:
        lines[first:first] = ["Examples", "--------"]


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the step; it comes before numpydoc reads the docstring."""
    app.connect("autodoc-process-docstring", head_examples, priority=100)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
