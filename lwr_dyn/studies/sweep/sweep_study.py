"""A study: which loops, what is varied, how many runs; and its arm, references and controllers, built when needed."""

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from hashlib import sha256
from inspect import signature
from itertools import product
from math import prod
from pathlib import Path
from typing import Any

import numpy as np

from lwr_dyn.arms.loading import load_with_paper
from lwr_dyn.control.controllers import CONTROLLERS, ControllerSpec, controller_spec
from lwr_dyn.control.laws.friction_compensation import arm_with_friction
from lwr_dyn.control.protocol import Controller
from lwr_dyn.dynamics.engines import dynamics_of
from lwr_dyn.foundation.errors import FileAccessError, OptionError
from lwr_dyn.foundation.files import read_bytes
from lwr_dyn.model.arm import Arm, caveats_of
from lwr_dyn.model.caveats import ABSENT_ROTORS, DYNAMICS, ROTOR_FILE
from lwr_dyn.model.run import Reference
from lwr_dyn.studies.sweep.sampling import HYPERCUBE, METHODS, Values, VariedParameter, points, saltelli_rows
from lwr_dyn.trajectory.references.references import REFERENCES

MOST_RUNS = 10_000_000
"""Of one controller."""
MOST_KEPT = 1000
MOST_AT_ONCE = 50_000_000
"""Numbers of a Latin hypercube, which is drawn whole, up to a power of 2 of runs: 400 MB."""


@dataclass(frozen=True, slots=True, eq=False)
class SweepStudy:
    """Closed loops of one task: every controller on the same `runs` plants, numbered from 0.

    Parameters
    ----------
    robot, reading : str
        As `lwr_dyn.load` takes them, a file in its full path; "" for the paper's default reading.
    tip : str or None
        Last link of the chain of a `.urdf`.
    controllers : tuple of str
        As `lwr-dyn compare` takes them: "adaptive:omega_n=30", "mine.py" beside the study's file.
    task_options : mapping
        By keyword of the task's factory, in rad and m.
    loop : mapping
        Keywords of `lwr_dyn.rollouts` that are the same in all runs: rate [Hz], substeps, duration [s], friction,
        friction_width [rad/s], saturate, position_limits.
    cutoff_hz : float
        Of the encoders' velocity filter, where a path of `sensor` is varied.
    assumed_friction : float or None
        Coulomb friction as a share of the torque limits that arm and controllers are modelled with; None for the arm's.
    method, runs, seed, chunk : str, int, int, int
        How the runs are drawn, how many for each controller, how many in a file of results.
    keep : int
        Worst runs of each controller that are replayed.
    limits : mapping
        Metric -> bound, in SI units; they judge runs and change none.
    tolerance : float or None
        [m] Error of the tip whose first violation is a metric.
    quantiles : tuple of float
        Over time, of the error of the tip.
    file, text : str
        Path and content of the file.
    sources : mapping
        SHA-256 of every file that the study names: of controllers by the path that it gives, of others by name.
    places : mapping
        The same by full path, for a look at the files again when runs are made; not in the digest.

    Raises
    ------
    OptionError
        A method, or counts of runs, chunks or kept runs that are not possible.
    """

    name: str
    robot: str
    reading: str
    controllers: tuple[str, ...]
    task: str
    task_options: Mapping[str, Any] = field(default_factory=dict)
    loop: Mapping[str, Any] = field(default_factory=dict)
    cutoff_hz: float = 100.0
    assumed_friction: float | None = None
    method: str = "sobol"
    runs: int = 256
    seed: int = 0
    chunk: int = 500
    keep: int = 3
    parameters: tuple[VariedParameter, ...] = ()
    limits: Mapping[str, float] = field(default_factory=dict)
    tolerance: float | None = None
    quantiles: tuple[float, ...] = ()
    file: str = ""
    text: str = ""
    sources: Mapping[str, str] = field(default_factory=dict)
    places: Mapping[str, str] = field(default_factory=dict)
    tip: str | None = None

    def __post_init__(self) -> None:
        if self.method not in METHODS:
            raise OptionError("method", repr(self.method), ", ".join(METHODS))
        for name, least, most in (("runs", 1, MOST_RUNS), ("chunk", 1, MOST_RUNS), ("keep", 0, MOST_KEPT)):
            value = getattr(self, name)
            if not (isinstance(value, int) and least <= value <= most):
                raise OptionError(name, value, f"a whole number from {least} to {most}")
        if not (isinstance(self.seed, int) and 0 <= self.seed < 2**63):
            raise OptionError("seed", self.seed, "a whole number from 0 on")
        self._check_runs()

    def _check_runs(self) -> None:
        """Raise `OptionError` for a number of runs that the method cannot have."""
        if self.method == "grid" and self.runs != prod(self.levels):
            raise OptionError("runs", f"{self.runs} of a grid", f"{prod(self.levels)}, the product of its levels")
        most = 2 ** ((MOST_AT_ONCE // max(len(self.levels), 1)).bit_length() - 1)
        if self.method == HYPERCUBE and self.runs > most:
            found = f"{self.runs} by latin-hypercube, {len(self.levels)} numbers each"
            raise OptionError("runs", found, f"at most {most}, or random, or sobol")
        if self.method == "saltelli":
            rows = saltelli_rows(len(self.varied))
            base = self.runs // rows
            if self.runs % rows or base & (base - 1):
                near = [2 ** max(int(np.floor(np.log2(max(self.runs / rows, 1)))) + k, 0) * rows for k in (0, 1)]
                words = f"{rows} times a power of 2 (two more than the parameters that vary), as {near[0]} or {near[1]}"
                raise OptionError("runs", f"{self.runs} by saltelli", words)

    @property
    def varied(self) -> tuple[VariedParameter, ...]:
        """The parameters in which runs differ."""
        return tuple(one for one in self.parameters if one.is_varied)

    @property
    def levels(self) -> tuple[int, ...]:
        """Levels of each number of a grid; 0 for one that is not on levels."""
        return tuple(len(one.values) for one in self.varied for _ in one.columns)

    @property
    def count(self) -> int:
        """Runs of each controller."""
        return self.runs

    @property
    def chunks(self) -> int:
        """Chunks of each controller; the last may be shorter."""
        return -(-self.runs // self.chunk)

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of the numbers of a run, in the order of the parameters."""
        return tuple(name for one in self.parameters for name in one.columns)

    def values(self, first: int, stop: int) -> dict[str, Values]:
        """Values of the runs first ... stop - 1 by path, the same whatever the chunking.

        Returns
        -------
        dict
            Path -> (stop - first,), or (stop - first, k) for a path of k numbers, see `VariedParameter.columns`; texts
            where the path is a choice of names.

        Raises
        ------
        OptionError
            Runs outside 0 ... `runs`.
        """
        if not 0 <= first < stop <= self.runs:
            raise OptionError("runs", f"{first} to {stop}", f"first < stop inside 0 to {self.runs}")
        sizes = [len(one.columns) for one in self.varied]
        cube = points(self.method, sizes, self.levels, self.seed, first, stop)
        shares = iter(np.split(cube, np.cumsum(sizes)[:-1], axis=1))
        out: dict[str, Values] = {}
        for one in self.parameters:
            k = len(one.columns)
            drawn = one.values_of(next(shares) if one.is_varied else np.zeros((stop - first, k)))
            out[one.path] = drawn[:, 0] if k == 1 else drawn
        return out

    @property
    def digest(self) -> str:
        """SHA-256 of all that changes a run; not of comments, names, limits, the kept runs or where files are.

        The number of runs is none of it: a sweep can be extended.
        """
        drawn = [[one.path, one.distribution, one.columns, one.values, one.low, one.high, one.mean, one.deviation]
                 for one in self.parameters]  # fmt: skip
        record = [
            sorted(self.sources.items()), Path(self.robot).name, self.reading, self.controllers, self.task,
            _plain(self.task_options), _plain(self.loop), self.cutoff_hz, self.assumed_friction, self.method,
            None, self.seed,  # None: once the number of runs; without it the digests of stored sweeps would change
            self.chunk, drawn, self.tolerance,
            self.quantiles, *([] if self.tip is None else [self.tip]),
        ]  # fmt: skip
        return sha256(json.dumps(record).encode()).hexdigest()


def _plain(options: Mapping[str, Any]) -> list[tuple[str, Any]]:
    """Options in the order of their names; arrays as lists, a file by its name (its content is in `sources`)."""
    plain = {key: x.tolist() if isinstance(x, np.ndarray) else x for key, x in options.items()}
    return sorted((key, Path(x).name if isinstance(x, str) else x) for key, x in plain.items())


class ChangedFileError(FileAccessError):
    """A file that a study names is not the one that was there when the study was read."""

    def __init__(self, path: str) -> None:
        super().__init__(path, "changed since the study was read", "the file as it was, or the study read again")


def digest_of(path: str) -> str:
    """SHA-256 of a file; raises `FileAccessError`."""
    return sha256(read_bytes(path, "a file that the study names")).hexdigest()


def refuse_changed(study: SweepStudy) -> None:
    """Raise `ChangedFileError` for a file of the study with another content, `FileAccessError` for one that is gone."""
    for path, digest in study.places.items():
        if digest_of(path) != digest:
            raise ChangedFileError(path)


MOST_REFERENCES = 64
"""Of one study: values of the options of its task, in every combination."""


def arm_of_study(study: SweepStudy, reading: str | None = None) -> Arm:
    """The arm as the controllers know it, or as another reading has it; raises as `lwr_dyn.load`."""
    content = study.sources.get(Path(study.robot).name, "")
    return _arm(study.robot, study.reading if reading is None else reading, study.assumed_friction, content, study.tip)


def study_caveats(study: SweepStudy) -> tuple[str, ...]:
    """What must be known before numbers of a study's arm."""
    return caveats_of([arm_of_study(study)], (*DYNAMICS, ABSENT_ROTORS), ROTOR_FILE)


@lru_cache(maxsize=8)
def _arm(robot: str, reading: str, share: float | None, content: str, tip: str | None) -> Arm:
    """`content` makes a file that has changed another arm."""
    arm, _ = load_with_paper(robot, reading or None, tip=tip)
    return arm if share is None else arm_with_friction(arm, share)


def references_of_study(study: SweepStudy) -> tuple[Reference, ...]:
    """The task's reference; several where options of the task vary, in the order of `task_choices`.

    Raises as the task's factory.
    """
    arm = arm_of_study(study)
    return tuple(REFERENCES.make(study.task, arm, **{**study.task_options, **each}) for each in task_choices(study))


def task_choices(study: SweepStudy) -> list[dict[str, Any]]:
    """Values of the options of the task that the study gives, in every combination, the last fastest."""
    given = {option_name(one.path): one.values for one in study.parameters if is_task(one.path)}
    return [dict(zip(given, values, strict=True)) for values in product(*given.values())]


def is_task(path: str) -> bool:
    """Whether a path is an option of the task."""
    return path.startswith("task.")


def option_name(path: str) -> str:
    """The keyword of an option of the task or of the controllers.

    >>> option_name("controller.omega-n")
    'omega_n'
    """
    return path.partition(".")[2].replace("-", "_")


def spec_of_study(study: SweepStudy, text: str) -> ControllerSpec:
    """The controller of a text; a Python file is looked for beside the study's file. Raises as `controller_spec`."""
    spec = controller_spec(text)
    if not spec.is_file:
        return spec
    place = str((Path(study.file).parent / spec.base).resolve()) if study.file else spec.base
    return ControllerSpec(text, place, spec.options, spec.wrappers)


def try_controller(study: SweepStudy, text: str, options: Mapping[str, Any]) -> None:
    """Make a controller to see that it can be made; without the search for its gains. Raises as `make_controller`."""
    arm, spec = arm_of_study(study), spec_of_study(study, text)
    unit = {"inertia": [1.0] * arm.n} if takes_inertia(spec) else {}
    spec.make(arm, dynamics_of(arm), {**unit, **options})


def takes_inertia(spec: ControllerSpec) -> bool:
    """Whether a controller's gains are made from the largest inertia of each joint."""
    return not spec.is_file and "inertia" in signature(CONTROLLERS.load(spec.base)).parameters


def controller_of_study(study: SweepStudy, text: str, options: Mapping[str, Any] | None = None) -> Controller:
    """A new controller of the study; `options` are added to those of its text. Raises as `make_controller`."""
    arm = arm_of_study(study)
    return spec_of_study(study, text).make(arm, dynamics_of(arm), options)
