"""The same task under all readings of a robot: every controller simulated on every plant, and what follows; tables."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Annotated, TypedDict

import numpy as np

from lwr_dyn.checks.sensitivity import closed_loops as loops
from lwr_dyn.checks.sensitivity.closed_loops import ClosedLoopResult, Conclusion, Progress, Statics
from lwr_dyn.checks.sensitivity.study_tasks import SimulatedTask, simulated_task
from lwr_dyn.foundation.arrays import Array, read_only
from lwr_dyn.foundation.document import Document, Fact, Note, Section
from lwr_dyn.foundation.errors import OptionError, ShapeError
from lwr_dyn.foundation.tables import Heading, Table
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.run import repr_html
from lwr_dyn.simulation.metrics import RIGID, MetricsRecord
from lwr_dyn.trajectory.motion_profile import positive_number

POSES = 500
OMEGA_N, XI = 50.0, 1.0
"""[rad/s], 1: of the gains that are compared."""
MOST_POSES = 1_000_000
MOST_ARMS = 8
"""Arms at once: the number of runs grows with the square."""


@dataclass(frozen=True, slots=True, eq=False)
class Sensitivity:
    """What depends on the reading, and what does not."""

    names: tuple[str, ...]
    joints: tuple[str, ...]
    study: SimulatedTask
    rate: float
    poses: int
    statics: Mapping[str, Statics]
    runs: tuple[ClosedLoopResult, ...]
    conclusions: tuple[Conclusion, ...]

    _repr_html_ = repr_html

    @property
    def document(self) -> Document:
        """The result for people and programs."""
        return _document(self)

    def tip_rms_mm(self, controller: str) -> Array:
        """RMS errors of the tip [mm], a row per model, a column per plant; NaN where a simulation failed."""
        return self._matrix(controller, lambda run: run.tip_rms_mm)

    def worst_mrad(self, controller: str) -> Array:
        """Largest joint errors [mrad], a row per model, a column per plant."""
        return self._matrix(controller, lambda run: run.worst_mrad)

    def _matrix(self, controller: str, figure: Callable[[ClosedLoopResult], float]) -> Array:
        values = {(r.model, r.plant): figure(r) for r in self.runs if r.controller == controller}
        return read_only(np.array([[values[model, plant] for plant in self.names] for model in self.names]))


def sensitivity(
    arms: Mapping[str, Arm],
    task: str | None = None,
    *,
    poses: int = POSES,
    seed: int = 0,
    rate: float = 1000.0,
    progress: Progress | None = None,
) -> Sensitivity:
    """The same task under several readings (or files) of a robot, for every controller and plant.

    Parameters
    ----------
    arms : mapping
        Name -> arm, two to eight; the first sets the reference and is what others are compared with.
    task : str, optional
        A task of `lwr_dyn.checks.sensitivity.study_tasks`, or "joint-move"; that of the first arm's paper if not given.
    poses, seed : int
        How many joint positions the gravity torques are compared at.
    rate : float
        Samples a second of the simulations [Hz].
    progress : callable, optional
        Called with the share of the runs that are done.

    Raises
    ------
    OptionError, ShapeError, UnknownNameError
        Another number of arms, no poses, no rate; different numbers of joints; no such task, or one that the first arm
        cannot do.
    MissingDataError, PathLimitError
        An arm without inertias, a task beyond the limits of the first arm.
    """
    if not 2 <= len(arms) <= MOST_ARMS:
        raise OptionError("arms", f"{len(arms)}", f"2 to {MOST_ARMS} readings or files")
    if not 1 <= poses <= MOST_POSES:
        raise OptionError("poses", poses, f"from 1 to {MOST_POSES}")
    positive_number("rate", rate)
    first, *others = arms.items()
    for name, arm in others:
        if arm.n != first[1].n:
            raise ShapeError(name, f"{arm.n} joints", f"{first[1].n}, as {first[0]} has")
    for arm in arms.values():
        arm.require_dynamics()
    study = simulated_task(first[1], task)
    statics = loops.statics_of(arms, poses, seed, OMEGA_N, XI)
    runs = tuple(loops.closed_loops(arms, study, statics, rate, progress))
    return Sensitivity(
        names=tuple(arms), joints=first[1].joint_names, study=study, rate=rate, poses=poses, statics=statics,
        runs=runs, conclusions=loops.conclusions(study, runs, statics),
    )  # fmt: skip


FASTER, STOPPED = "*", "!"
"""Marks of an error: of a loop that is sampled faster, and of a run in which a joint met its stop."""
TINY = 1e-12
"""Below this a torque or inertia is rounding."""


class StaticsRecord(TypedDict):
    """`Statics` in a record, one number a joint."""

    gravity_largest: Annotated[list[float], "Largest |g_i| over the poses, N m (N)."]
    b: Annotated[list[float], "max B_ii over the joint box, kg m^2 (kg)."]
    Kp: Annotated[list[float], "N m/rad (N/m)."]
    Kd: Annotated[list[float], "N m s/rad (N s/m)."]
    gravity_difference: Annotated[list[float], "Largest difference to g of the first reading, N m (N)."]


class CaseRecord(TypedDict):
    """Whether a conclusion holds in one case."""

    case: Annotated[list[str], "Model and plant, or the one reading."]
    holds: Annotated[bool | None, "Null where a simulation failed."]


RUN = (
    Heading(key="controller"), Heading(key="model", says="The controller's reading."),
    Heading(key="plant", says="The simulated reading."),
    Heading(key="rate", says="Samples a second that the loop needs: more than wanted where it would chatter."),
    Heading(key="fault", says="Why there is none; empty where there is one."),
    Heading(key="metrics", says="Errors and uses of limits; null without a run.", kind=MetricsRecord | None),
)  # fmt: skip
CONCLUSION = (
    Heading(key="text"), Heading(key="survives", says="Whether it holds in every case."),
    Heading(key="share", says="Of the cases in which it holds."), Heading(key="verdict", says="The same in words."),
    Heading(key="holds", says="Case by case.", kind=list[CaseRecord]),
)  # fmt: skip


def _document(result: Sensitivity) -> Document:
    """Gravity torques, inertias and gains, errors of every pair, conclusions."""
    first, *_ = result.statics.values()
    task = result.study.task
    statics = {
        name: {"gravity_largest": np.abs(s.gravity).max(axis=0), "b": s.b, "Kp": s.gains.Kp, "Kd": s.gains.Kd,
               "gravity_difference": s.gravity_off(first)}
        for name, s in result.statics.items()
    }  # fmt: skip
    runs = [
        (r.controller, r.model, r.plant, r.rate, r.fault, None if r.metrics is None else r.metrics.to_json())
        for r in result.runs
    ]
    cases = [
        (c.text, c.survives, c.share, c.verdict(), [{"case": [*k], "holds": held} for k, held in c.holds.items()])
        for c in result.conclusions
    ]
    facts = [
        Fact("readings", [*result.names], "Names of the readings, or files."), Fact("joints", [*result.joints]),
        Fact("task", task.name), Fact("about", task.about, "The task in words."),
        Fact("rate", result.rate, "Samples a second that are wanted."),
        Fact("poses", result.poses, "Where gravity torques are compared."),
        Fact("statics", statics, "By reading.", kind=dict[str, StaticsRecord]),
    ]  # fmt: skip
    errors = [error_table(result, name) for name in result.study.labels.values()]
    sections = [
        Section("", [gravity_table(result)]), Section("", [gains_table(result)]),
        Section("", [Note(errors_text(result)), *errors, Note(notes(result)),
                     Table("", RUN, runs, key="runs", says="Each controller on each plant.")]),
        Section("", [survival(result), Table("", CONCLUSION, cases, key="conclusions",
                                             says="What a paper concludes, and whether it survives.")]),
    ]  # fmt: skip
    title = f"{', '.join(result.names)}: {task.about}"
    return Document(title, "", sections, "lwr-dyn sensitivity", "sensitivity", facts)


def gravity_table(result: Sensitivity) -> Table:
    """Largest |g_i| over the poses, and the largest difference to the first reading [N m (N)]."""
    first, *_ = result.statics.values()
    rows = []
    for name, s in result.statics.items():
        rows.append((name, "largest |g|", *np.abs(s.gravity).max(axis=0)))
        if s is not first:
            rows.append((name, f"largest difference to {result.names[0]}", *s.gravity_off(first)))
    return Table(f"gravity torques at {result.poses} poses [N m (N)]", _headings(result), rows)


def gains_table(result: Sensitivity) -> Table:
    """max B_ii of every joint, and the gains drawn from it."""
    first, *_ = result.statics.values()
    rows: list[tuple[object, ...]] = []
    for name, s in result.statics.items():
        rows += [(name, figure, *x) for figure, x in (("b", s.b), ("Kp", s.gains.Kp), ("Kd", s.gains.Kd))]
        if s is not first:
            rows.append((name, f"off {result.names[0]}", *(f"{x:+.2%}" for x in (s.b / first.b - 1.0).round(4) + 0.0)))
    gains = f"gains {OMEGA_N**2:g} b, {2 * XI * OMEGA_N:g} b"
    title = f"largest inertia b = max B_ii over the joint box [kg m^2 (kg)], and {gains}"
    return Table(title, _headings(result), rows)


def error_table(result: Sensitivity, controller: str) -> Table:
    """Errors under one controller: a row per model, a column per plant, with the marks that `notes` explains."""
    tips, worst = result.tip_rms_mm(controller), result.worst_mrad(controller)
    runs = {(r.model, r.plant): r for r in result.runs if r.controller == controller}
    least, largest = float(np.nanmin(tips)), float(np.nanmax(tips)) or 1.0

    def shade(cell: tuple[float, float, str]) -> float:
        return float(np.nan_to_num((cell[0] - least) / largest))

    rows = []
    for i, model in enumerate(result.names):
        row = [runs[model, plant] for plant in result.names]
        marks = [FASTER * (r.rate > result.rate) + STOPPED * bool(r.metrics and r.metrics.stops.met) for r in row]
        rows.append((model, *zip(tips[i], worst[i], marks, strict=True)))
    plants = (Heading(f"on {name}", format=_errors, shade=shade) for name in result.names)
    return Table("", (controller, *plants), rows)


def errors_text(result: Sensitivity) -> str:
    """What the tables of errors hold, in one sentence."""
    runs, duration = len(result.runs), result.study.reference.duration
    return (
        f"{runs} runs of {duration:g} s at {result.rate:g} samples a second or more: RMS error of the tip ({RIGID})"
        " [mm] (largest error of a joint [mrad (mm)]); rows: the controller's model, columns: the plant"
    )


def _errors(cell: tuple[float, float, str]) -> str:
    tip, worst, mark = cell
    return "no run" if math.isnan(tip) else f"{tip:.3g} ({worst:.3g}){mark}"


def survival(result: Sensitivity) -> Table:
    """Which conclusions hold under which readings."""
    return Table("what survives", ("conclusion", "verdict"), [(c.text, c.verdict()) for c in result.conclusions])


def _headings(result: Sensitivity) -> tuple[Heading | str, ...]:
    return ("reading", "figure", *(Heading(joint, format=_number) for joint in result.joints))


def _number(value: float | str) -> str:
    if isinstance(value, str):
        return value
    return f"{value:.4g}" if abs(value) > TINY else "0"


def notes(result: Sensitivity) -> list[str]:
    """What stands below the tables of errors: loops sampled faster, joints on their stops, simulations that failed."""
    raised = sorted({r.rate for r in result.runs if r.rate > result.rate})
    lines = []
    if raised:
        rates = " to ".join(f"{r:g}" for r in dict.fromkeys((raised[0], raised[-1])))
        lines.append(
            f"{FASTER} at {result.rate:g} samples a second this loop chatters: the damping is too strong for the"
            f" lighter plant, and needs {rates}; simulated with the controller at every moment, or where joints stick"
            " or meet a stop at that rate"
        )
    met = [(r, r.metrics.stops.sentence()) for r in result.runs if r.metrics and r.metrics.stops.met]
    lines += [f"{STOPPED} {r.controller}, {r.model} on {r.plant}: {stops}" for r, stops in met]
    faults: dict[tuple[str, str], list[str]] = {}
    for r in result.runs:
        if r.fault:
            faults.setdefault((r.plant, r.fault), []).append(f"{r.controller}, {r.model}")
    for (plant, fault), of in faults.items():
        alone = len(of) > 1 and len(of) == sum(r.plant == plant for r in result.runs)
        which = "any law and model" if alone else "; ".join(of)
        lines.append(f"no run of {which} on {plant}: {fault}")
    return lines
