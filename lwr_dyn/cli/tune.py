"""`lwr-dyn tune`: gains for a stated aim over the runs of a study, judged on runs that the search has not seen."""

import sys
from collections.abc import Mapping
from dataclasses import fields, replace

import click

from lwr_dyn.cli.options import NO_CODE, check_code, option, show
from lwr_dyn.cli.vocabulary import shared
from lwr_dyn.control.controllers import CONTROLLERS, ControllerSpec
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import OptionError, UnknownNameError
from lwr_dyn.foundation.progress import progress
from lwr_dyn.foundation.registry import options_of
from lwr_dyn.studies.sweep.gain_search import SearchedGain, gain_aim, searched_gain
from lwr_dyn.studies.sweep.read_study import read_study
from lwr_dyn.studies.sweep.rollout_arguments import plant_parameters
from lwr_dyn.studies.sweep.running.workshop import SweepWorkshop
from lwr_dyn.studies.sweep.sampling import Values
from lwr_dyn.studies.sweep.sweep_study import SweepStudy, arm_of_study, is_task, spec_of_study, study_caveats
from lwr_dyn.studies.sweep.tune import USE, Evaluate, SearchSize, tune
from lwr_dyn.studies.sweep.vocabulary import parameter_path

USUAL = {"omega_n": (0.2, 5.0), "xi": (0.4, 2.0)}
"""Options that are searched where none is named, and the bounds as factors of what is given."""
OF_LIMITS = ("limits.torque", "reading")
"""Paths that give a run torque limits of its own."""
GAIN_HELP = (
    "What is searched, repeatable: an option of the controller, as omega-n=5:200, or a path of studies. "
    "omega-n and xi around what is given, if none is named."
)
SIZES = {
    "runs": "Runs of each controller that is tried, the same of each.",
    "population": "Candidates of a generation.",
    "generations": "Generations after the first.",
    "check": "Runs, not seen in the search, that judge what is found.",
    "front": "Further searches under tighter bounds, for the Pareto front.",
    "seed": "Seed of the search and of the runs that are drawn.",
}
NAMES = {"check": "--check-runs check"}
"""Options that are not named as their field."""
AIM_HELP = "The metric, and its quantile over the runs, that is to be small."
BOUND_HELP = "Share of the torque limits that the same quantile of the largest command may have; inf for none."
OPTIONS = [
    shared("--law law", ", one of the study's; its first if not given", form="NAME:OPTION=VALUE"),
    option("--gain gains", GAIN_HELP, str, metavar="NAME=LOW:HIGH", multiple=True),
    option("--aim", AIM_HELP, str, "tip_max:0.99", metavar="METRIC:SHARE"),
    option("--torque-share", BOUND_HELP, float, 1.0),
    *(option(NAMES.get(one.name, f"--{one.name}"), SIZES[one.name], int, one.default) for one in fields(SearchSize)),
    shared("--jobs", default=1),
    NO_CODE,
    shared("--json as_json"),
]


@click.command("tune", params=[click.Argument(["study"], metavar="STUDY.toml"), *OPTIONS])
def command(
    study: str,
    law: str | None,
    gains: tuple[str, ...],
    aim: str,
    torque_share: float,
    jobs: int,
    no_code: bool,
    as_json: bool,
    **sizes: int,
) -> None:
    """Find gains of a controller of STUDY.toml with which a quantile of an error over its runs is least.

    Every candidate meets the same runs; what is found is judged beside the gains as given on runs that the search has
    not seen. Exit 1 where no candidate keeps the bound.
    """
    read, size = read_study(study, lambda path: check_code([path], no_code, typed=False)), SearchSize(**sizes)
    text = read.controllers[0] if law is None else law
    if text not in read.controllers:
        raise UnknownNameError(f"controller of {read.name}", text, read.controllers)
    spec = spec_of_study(read, text)
    given = _given(read, spec)
    usual = [(f"controller.{name}", ends) for name, ends in USUAL.items()]
    chosen = tuple(map(searched_gain, gains)) or tuple(
        SearchedGain(path, low * given[path], high * given[path]) for path, (low, high) in usual if path in given
    )
    if not chosen:
        raise OptionError("gain", f"none, and {spec.name} has neither omega-n nor xi", "--gain NAME=LOW:HIGH")
    _check_gains(read, spec, chosen)
    with progress("searching gains") as report:
        found = tune(
            read, text, chosen, evaluator(read, text, jobs), given,
            aim=gain_aim(aim, read.quantiles), bound=torque_share, size=size, report=report,
        )  # fmt: skip
    show(replace(found.document, caveats=study_caveats(read)), as_json)
    sys.exit(0 if found.keeps_bound else 1)


def evaluator(study: SweepStudy, controller: str, threads: int = 1) -> Evaluate:
    """Runs of one controller of a study: values by path -> metrics, with the torque use."""
    workshop, effort = SweepWorkshop(study, threads), arm_of_study(study).effort

    def evaluate(values: Mapping[str, Values]) -> Mapping[str, Array]:
        metrics = workshop.evaluate(controller, values)
        of_limits = {path: x for path, x in values.items() if path.startswith(OF_LIMITS)}
        limits = plant_parameters(study, of_limits).get("effort", effort)
        return {**metrics, USE: (metrics["peak_command"] / limits).max(axis=1)}

    return evaluate


def _given(study: SweepStudy, spec: ControllerSpec) -> dict[str, float]:
    """Path -> number with which the study has it: of the controller's options, and of parameters that are fixed."""
    own = {} if spec.is_file else {key: one.default for key, one in options_of(CONTROLLERS.load(spec.base)).items()}
    options = {f"controller.{key}": x for key, x in {**own, **spec.options}.items()}
    fixed = {one.path: one.values[0] for one in study.parameters if not one.is_varied}
    return {
        path: float(x)
        for path, x in {**options, **fixed}.items()
        if isinstance(x, int | float) and not isinstance(x, bool)
    }


def _check_gains(study: SweepStudy, spec: ControllerSpec, gains: tuple[SearchedGain, ...]) -> None:
    """Raise for an option that the controller does not have, or a path that has no single number in these bounds."""
    options = {} if spec.is_file else options_of(CONTROLLERS.load(spec.base))
    known = sorted(key for key, one in options.items() if one.kind in (int, float))
    n = arm_of_study(study).n
    for gain in gains:
        if gain.path.startswith("controller."):
            if not spec.is_file and gain.name not in known:
                raise UnknownNameError(f"gain of {spec.base}", gain.name, known)
            continue
        path = parameter_path(gain.path, n)
        if path.row.text or is_task(gain.path) or len(path.columns(n)) > 1:
            raise OptionError("gain", gain.path, "a path of one number, as payload.known or arm.mass.all")
        for end in (gain.low, gain.high):
            if not path.row.allows(end):
                raise OptionError(f"bounds of {gain.path}", f"{end:g}", path.row.allowed)
