"""Whether what a study varies exists: in its arm, in its controllers, in its task."""

from collections.abc import Callable
from dataclasses import dataclass
from math import prod

import numpy as np

from lwr_dyn.arms.papers.catalog import readings
from lwr_dyn.control.controller_specs import ControllerSpec
from lwr_dyn.control.controllers import CONTROLLERS
from lwr_dyn.foundation.errors import PaperError, did_you_mean
from lwr_dyn.foundation.files import ends_in
from lwr_dyn.foundation.registry import Option, options_of
from lwr_dyn.model.arm import Arm
from lwr_dyn.studies.sweep.study.distributions import VariedParameter
from lwr_dyn.studies.sweep.study.study_file import SweepStudy
from lwr_dyn.studies.sweep.study.study_setup import (
    MOST_REFERENCES,
    arm_of_study,
    field_of,
    is_task,
    option_name,
    spec_of_study,
    try_controller,
)
from lwr_dyn.trajectory.references.tasks import REFERENCES

SEPARATE = "each in one place"


@dataclass(frozen=True, slots=True)
class ParameterCheck:
    """One parameter of a study, and where it stands in the file."""

    study: SweepStudy
    arm: Arm
    one: VariedParameter
    file: str
    field: str

    def refuse(self, found: str, allowed: str, key: str = "path") -> PaperError:
        """The error, to be raised."""
        return PaperError(self.file, f"{self.field}.{key}", found, allowed)

    def reading(self) -> None:
        """Readings that the robot has."""
        study = self.study
        if ends_in(study.robot, ".urdf", ".xacro"):
            raise self.refuse("reading of a URDF", "a robot of a data file, which has readings")
        known = readings(study.robot)
        for name in self.one.values:
            if name not in known:
                raise self.refuse(
                    f"no reading named {name!r}{did_you_mean(str(name), known)}", ", ".join(known), "values"
                )

        for name in map(str, self.one.values):
            with field_of(self.file, f"{self.field}.values"):
                other = arm_of_study(self.study, name)
            if not same_frames(self.arm, other):
                found = f"{name}, with other frames of the links than {self.arm.reading}"
                raise self.refuse(found, "readings that differ in masses, rotors or limits alone", "values")

    def armature(self) -> None:
        """Rotors that the arm gives."""
        if not self.arm.armature.any():
            raise self.refuse(f"{self.one.path}, and {self.arm.name} gives no rotors", "an arm with rotors")

    def share_of_torque(self) -> None:
        """Torque limits of the joints that are varied."""
        limited = np.isfinite(self.arm.effort)
        for part in (column.split(".")[2] for column in self.one.columns):
            joints = range(self.arm.n) if part == "all" else [int(part) - 1]
            for joint in (joint for joint in joints if not limited[joint]):
                name = self.arm.joint_names[joint]
                raise self.refuse(
                    f"{self.one.path}, and {name} of {self.arm.name} has no torque limit", "joints with one"
                )

    def friction(self) -> None:
        """Friction that the loop has."""
        if self.study.loop["friction"] == "none":
            raise self.refuse(f"{self.one.path} beside loop.friction = 'none'", "loop.friction = 'smooth', or left out")
        if self.one.path.startswith("friction.coulomb"):
            self.share_of_torque()

    def payload(self) -> None:
        """A payload, where its place or who knows it is varied."""
        if not any(other.path == "payload.mass" for other in self.study.parameters):
            raise self.refuse(f"{self.one.path} without a payload", "payload.mass beside it, perhaps with one value")

    def of_task(self) -> None:
        """An option of the task that is a number, of a few values."""
        task, keyword = self.study.task, option_name(self.one.path)
        known = {key: x for key, x in options_of(REFERENCES.load(task)).items() if x.kind in (int, float)}
        self._number(keyword, known, f"task {task}", keyword in self.study.task_options, "[task]")
        if not self.one.values:
            found = f"{self.one.distribution}, and each value is a reference of its own"
            raise self.refuse(found, f"values (a choice), or levels; at most {MOST_REFERENCES}", "distribution")

    def of_controller(self) -> None:
        """An option of every controller that is a number."""
        for text in self.study.controllers:
            spec = spec_of_study(self.study, text)
            if not spec.is_file:
                known = {key: x for key, x in _options(spec).items() if x.kind in (int, float)}
                keyword = option_name(self.one.path)
                self._number(keyword, known, f"controller {text}", keyword in spec.options, f"controller {text!r}")
            for end in (self.one.lowest, self.one.highest):
                with field_of(self.file, self.field):
                    try_controller(self.study, text, {option_name(self.one.path): end})

    def _number(self, keyword: str, known: dict[str, Option], owner: str, given: bool, place: str) -> None:
        if keyword not in known:
            near = did_you_mean(keyword, known)
            raise self.refuse(
                f"{owner} has no number {keyword!r}{near}", ", ".join(known) or "no number of its options"
            )
        if given:
            raise self.refuse(f"{self.one.path}, and {keyword} in {place}", SEPARATE)
        if known[keyword].kind is int and any(float(value) % 1.0 for value in self.one.values or (0.5,)):
            raise self.refuse(
                f"{self.one.distribution_words}, and {keyword} is a whole number", "values that are whole"
            )


CHECKS: dict[str, Callable[[ParameterCheck], None]] = {
    "reading": ParameterCheck.reading,
    "arm.armature": ParameterCheck.armature,
    "limits.torque": ParameterCheck.share_of_torque,
    "friction": ParameterCheck.friction,
    "payload.com": ParameterCheck.payload,
    "payload.known": ParameterCheck.payload,
    "task": ParameterCheck.of_task,
    "controller": ParameterCheck.of_controller,
}
"""Start of a path -> its check."""


def same_frames(one: Arm, other: Arm) -> bool:
    """Whether two arms have the same joints at the same places, to rounding, and the same gravity."""
    if [link.kind for link in one.chain.links] != [link.kind for link in other.chain.links]:
        return False
    poses = [[p.matrix() for link in a.chain.links for p in (link.before, link.after)] for a in (one, other)]
    ends = [[a.chain.flange.matrix()] for a in (one, other)]
    same = np.allclose(poses[0] + ends[0], poses[1] + ends[1], rtol=0.0, atol=1e-12)
    return bool(same and np.array_equal(one.chain.gravity, other.chain.gravity))


def check_parameters(study: SweepStudy, arm: Arm, file: str) -> None:
    """Raise `PaperError` for the first parameter that the study cannot have."""
    if not study.varied:
        raise PaperError(file, "parameter", "nothing that varies", "one [[parameter]] or more with a range or values")
    for i, one in enumerate(study.parameters):
        for start, check in CHECKS.items():
            if f"{one.path}.".startswith(f"{start}."):
                check(ParameterCheck(study, arm, one, file, f"parameter[{i}]"))
    tasks = prod(len(one.values) for one in study.parameters if is_task(one.path))
    if tasks > MOST_REFERENCES:
        raise PaperError(
            file, "parameter", f"{tasks} tasks", f"at most {MOST_REFERENCES}: each is a reference of its own"
        )


def _options(spec: ControllerSpec) -> dict[str, Option]:
    return options_of(CONTROLLERS.load(spec.base))
