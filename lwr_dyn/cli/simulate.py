"""`lwr-dyn simulate`: a robot, a task and a controller become a run file with its metrics and audit.

The run as a document: errors joint by joint, limits, audit, friction.
"""

from collections.abc import Mapping
from dataclasses import asdict, replace
from typing import Annotated, Any, TypedDict

import click

from lwr_dyn.arms.loading import load
from lwr_dyn.cli import options
from lwr_dyn.cli.vocabulary import shared
from lwr_dyn.control.controllers import CONTROLLERS, WRAPPERS, faults_in, make_controller, split_name
from lwr_dyn.control.protocol import Controller
from lwr_dyn.design.defaults import LAWS, UsualLaw, UsualTask, move_words, usual_law, usual_task
from lwr_dyn.design.loop_judgement import sampled_notes
from lwr_dyn.design.sampled_stability import StabilityRecord
from lwr_dyn.dynamics.engines import ENGINES, dynamics_of
from lwr_dyn.dynamics.protocol import Dynamics
from lwr_dyn.foundation.document import Document, Fact, Note, Section
from lwr_dyn.foundation.errors import DivergenceError, OptionError
from lwr_dyn.foundation.files import check_writable
from lwr_dyn.foundation.progress import progress
from lwr_dyn.model.arm import Arm, arm_with_payload, arm_with_scaled_inertia
from lwr_dyn.model.passivity import passive_refit
from lwr_dyn.model.run import Event, Reference, Run, format_of
from lwr_dyn.pages.plotting.plots import plot_writer
from lwr_dyn.pages.replay.replayed_runs import facts
from lwr_dyn.simulation.arm_friction import FORMS, FrictionOption
from lwr_dyn.simulation.audit import audit_lines
from lwr_dyn.simulation.contact import ACTIVE_FRICTION
from lwr_dyn.simulation.metrics import MetricsRecord, metrics
from lwr_dyn.simulation.plant import Encoder
from lwr_dyn.simulation.setup import ENCODERS, METHODS, MOST_SUBSTEPS, Loop, RunRecord, Setup, prepare
from lwr_dyn.simulation.simulate import LOOPS, run_setup
from lwr_dyn.simulation.step_and_chirp import response_parts
from lwr_dyn.simulation.substeps import applies, enough_steps, friction_substeps, with_substeps
from lwr_dyn.trajectory.references.references import REFERENCES


class SampledRecord(TypedDict):
    """What sampling makes of the loop at rest."""

    in_box: Annotated[StabilityRecord, "At poses drawn from the joint box."]
    along_reference: Annotated[StabilityRecord, "At poses of the reference."]


def run_document(run: Run, arm: Arm, full: bool = False, sampled: Mapping[str, Any] | None = None) -> Document:
    """Errors, limits, audit and notes of a run, with `full` all errors, and the record of the setup."""
    figures = metrics(run, arm)
    found = Section("", [
        Fact("metrics", figures.to_json(), "Errors and uses of limits.", kind=MetricsRecord),
        *figures.parts(full), Note(audit_lines(run.audit)), Note(friction_lines(run, arm)), *response_parts(run, arm),
        Fact("events", [asdict(one) for one in run.events], "Stops, sticking, saturation in time.", kind=list[Event]),
        Fact("meta", dict(run.meta), "The setup, complete: with it the run can be repeated.", kind=RunRecord),
        Fact("sampled_loop", sampled, "Stability at rest; null where the linear theory does not apply.",
             kind=SampledRecord | None),
    ])  # fmt: skip
    return Document(_title(run, arm), "", [found], "lwr-dyn simulate", "run")


def _title(run: Run, arm: Arm) -> str:
    """The first line: what was simulated."""
    known = facts(run)
    parts = [f"{arm.name}, reading {arm.reading}: {known['controller']}"]
    parts += [f"{name} {known[name]}" for name in ("mount", "tool", "task", "payload", "plant") if name in known]
    return ", ".join([*parts, f"{run.t[-1]:g} s", f"{run.t.size} samples"])


def friction_lines(run: Run, arm: Arm) -> list[str]:
    """The friction of a run in words: its form, what a refit changed, and where it drove instead of braking."""
    form = run.meta["friction_law"]["form"]
    if form == "none":
        return []
    lines = [f"friction of the plant: {form}"]
    for c in run.meta["note"].get("passive_refit", ()):
        before, after = (f"F_c {x['coulomb']:.4f}, sigma {x['viscous']:.4f}" for x in (c["before"], c["after"]))
        cost = f"RMS {c['rms']:.3g} N m up to {c['speed']:g} rad/s"
        lines.append(f"passive refit of {c['joint']}, {c['side']}: {before} -> {after}; {cost}")
    for joint, name in enumerate(arm.joint_names):
        for e in (e for e in run.events if e.kind == ACTIVE_FRICTION and e.joint == joint):
            lines.append(f"warning: friction of {name} feeds energy in from {e.t:g} s on, at {e.value:.4g} rad/s (m/s)")
    return lines


SUBSTEPS = options.Flag("substeps", int)


class NameOrFile(options.OneOf):
    """One of some names, or a Python file, with or without wrappers."""

    def get_metavar(self, param: click.Parameter, *_: Any, **__: Any) -> str:
        """The names, as the help shows them."""
        return f"[{'|'.join(str(name) for name in self.choices)}|FILE.py]"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """The name or path as it stands."""
        law, wrappers = split_name(str(value))
        for wrapper in wrappers:
            WRAPPERS[wrapper]
        if not law.endswith(".py"):
            super().convert(law, param, ctx)
        return value


TASK = options.option("--task", options.TASK_HELP, options.OneOf(REFERENCES.names))
AROUND = f"A name, or a file of your own; behind it +{', +'.join(WRAPPERS.names)}."
CONTROLLER = options.option("--controller", AROUND, NameOrFile(CONTROLLERS.names), LAWS[0])
"""Of a command that judges one law."""
USUAL = f"{AROUND} If not given, the first stable of {', '.join(LAWS)} at this rate."
CHOSEN_CONTROLLER = options.option("--controller", USUAL, NameOrFile(CONTROLLERS.names))
PLANT = [
    options.option("--plant-reading", "Simulate another reading than the controller's.", str),
    options.option("--plant-scale", "Factor on all masses of the plant.", float, 1.0),
    options.option("--payload", "Point mass at the flange, or at the tool centre point, kg.", float, 0.0),
    options.option("--payload-known", "Build the controller's model with the payload."),
    options.option("--friction", "Friction of the plant.", options.OneOf(FORMS), FORMS[0]),
    options.option("--elastic", options.ELASTIC_HELP, str, metavar="K|file"),
    options.option(
        "--encoders", "The side of elastic joints that the controller gets.", options.OneOf(ENCODERS), ENCODERS[0]
    ),
    options.option("--passive-refit", "Use the nearest friction that feeds no energy in."),
]

LOOP = [
    options.option("--no-saturation", "Do not cut torques at the limits."),
    options.option("--no-stops", "Let joints pass their position limits."),
    options.option("--allow-unphysical", "Simulate inertias that no body can have."),
    options.option("--encoder-bits", "2^bits counts a turn; exact if not given.", int),
    options.option("--encoder-noise", "Standard deviation of the readings, rad.", float, 0.0),
    options.option("--velocity-cutoff", "Cut-off of the velocity filter, Hz.", float, 100.0),
    options.option("--seed", "Seed of the encoder's noise.", int, 0),
    options.option("--rate", "Samples a second.", float, 1000.0),
    options.option("--delay", "Delay from a command to its torque, samples.", int, 0),
    options.option("--continuous", "The controller runs at every moment, not at samples."),
    options.option("--method", "Method of integration.", options.OneOf(METHODS), METHODS[0]),
    options.option("--substeps", "RK4 steps a sample; if not given, more where 1 is off by 1e-6 m at the tip.", int, 1),
    options.option(
        "--loop", "compiled: the whole loop in generated code, without stops and stick.", options.OneOf(LOOPS.names)
    ),
    options.option("--engine", "Engine of the dynamics.", options.OneOf(ENGINES.names), "pinocchio"),
    shared("--out", " the run: .npz, .mcap, .parquet, .mat, .csv"),
    options.option("--csv", "File of columns to write, .csv; `lwr-dyn identify` reads it.", str),
    shared("--html", ": the replay of the run"),
    options.option(
        "--plot",
        "Picture: FILE.png, FILE.svg or a quantity, as torque, tip-error. Repeatable.",
        str,
        metavar="NAME|FILE.png",
        multiple=True,
    ),
    options.option("--full", "All errors of the joints: means, extremes, velocities."),
    shared("--json"),
]

RULES = (
    options.OptionRule("payload-known", lambda given: given["payload"] != 0.0, "with --payload"),
    options.OptionRule("seed", lambda given: given["encoder_noise"] != 0.0, "with --encoder-noise"),
    options.OptionRule("substeps", lambda given: given["method"] != "dop853", "with --method rk4 or radau"),
    options.OptionRule("encoders", lambda given: given["elastic"] is not None, "with --elastic"),
    options.OptionRule(
        "velocity-cutoff",
        lambda given: given["encoder_bits"] is not None or given["encoder_noise"] != 0.0,
        "with --encoder-bits or --encoder-noise",
    ),
)


@click.command("simulate")
@options.robot_options
def command(robot: str, loading: options.Loading, **given: Any) -> None:
    """Simulate ROBOT under a controller on a task; print errors, torques against limits, and the audit."""
    if given["task"] is not None:
        TASK_OPTIONS.refuse_unused(given["task"])
    if given["controller"] is not None:
        CONTROLLER_OPTIONS.refuse_unused(split_name(given["controller"])[0])
        options.check_code([given["controller"]], given["no_code"])
    options.refuse_unused(RULES, given)
    out = given["out"]
    _check_targets(given)
    pictures = [plot_writer(wish) for wish in given["plot"]]
    arm = loading.arm(robot, options.used_by(given["elastic"]))
    setup = _setup(arm, robot, given)
    sampled = sampled_notes(setup)
    _note([] if given["json"] else [*setup.record()["note"].get("chosen", ()), *sampled.before])
    run = _simulated(setup, given["controller"] or "", out, [] if given["json"] else sampled.once_begun)
    chosen = [x for x in run.meta["note"].get("chosen", ()) if x.startswith("substeps")]
    _note([] if given["json"] else [*chosen, *(f"note: {line}" for line in filter(None, [run.hint]))])
    others = [*_written(run, arm, given), *(str(draw(run)) for draw in pictures)]
    _note([] if given["json"] else sampled.after)
    options.show(run_document(run, arm, given["full"], sampled.record), given["json"], others)
    if out is not None and not given["json"]:
        seen = f"; see it:  lwr-dyn replay {out} --html {out.removesuffix('.npz')}.html"
        click.echo(f"wrote {out}{seen if out.endswith('.npz') and given['html'] is None else ''}")


def _note(lines: list[str]) -> None:
    click.echo("".join(f"{line}\n" for line in lines), nl=False, err=True)


OWN = [*command.params, TASK, CHOSEN_CONTROLLER, options.NO_CODE, *PLANT, *LOOP]
TASK_OPTIONS = options.row_options(REFERENCES, "task", OWN)
OF_TASK = TASK_OPTIONS.click_options()
CONTROLLER_OPTIONS = options.row_options(CONTROLLERS, "controller", [*OWN, *OF_TASK])
command.params += [
    TASK,
    *OF_TASK,
    CHOSEN_CONTROLLER,
    *CONTROLLER_OPTIONS.click_options(),
    options.NO_CODE,
    *PLANT,
    *LOOP,
]


def _setup(arm: Arm, robot: str, given: dict[str, Any]) -> Setup:
    payload, task = given["payload"], task_of(TASK_OPTIONS, given, arm)
    model = arm_with_payload(arm, payload) if given["payload_known"] else arm
    dynamics = dynamics_of(model, given["engine"])
    law = _law(model, dynamics, task.reference, given)
    words = [*filter(None, [task.words, law.words])]
    plant = arm
    if given["plant_reading"] is not None:
        other = load(robot, given["plant_reading"], **arm.loaded_with)
        plant = options.stands_on(other, options.used_by(given["elastic"]))
    if given["plant_scale"] != 1.0:
        plant = arm_with_scaled_inertia(plant, given["plant_scale"])
    plant_is_model = plant is arm and (given["payload_known"] or not payload)
    engine = dynamics if plant_is_model else given["engine"]
    friction, note = _friction(plant, given["friction"], given["passive_refit"])
    encoder = _encoder(given["encoder_bits"], given["encoder_noise"], given["velocity_cutoff"])
    with faults_in(law.name):
        loop = Loop(
            plant=plant, payload=payload, encoder=encoder, rate=given["rate"],
            method=given["method"], substeps=given["substeps"], continuous=given["continuous"], delay=given["delay"],
            elasticity=options.given_elasticity(given["elastic"]), encoders=given["encoders"], engine=engine,
            loop=given["loop"], seed=given["seed"], saturate=not given["no_saturation"], friction=friction,
            position_limits=not given["no_stops"], allow_unphysical=given["allow_unphysical"],
            meta={"task": getattr(task.reference, "about", {}).get("task", task.name), **_plant_note(given), **note,
                  **({"chosen": words} if words else {})},
        )  # fmt: skip
        return _prepared(arm, law.controller, task.reference, loop)


def task_of(tasks: options.RowOptions, given: options.Given, arm: Arm) -> UsualTask:
    """The task that is asked for, or the usual one of the arm; raises as `usual_task`, `RowOptions`, its factory."""
    name = given["task"]
    if name is None:
        usual = usual_task(arm)
        tasks.refuse_unused(usual.name)
        if not any(flag.is_typed for flag in tasks.flags):
            return usual
        name = usual.name
    reference = tasks.registry.make(name, arm, **tasks.values(name, given, arm))
    return UsualTask(name, reference, move_words(arm, reference) if name == "move" else "")


def _prepared(arm: Arm, controller: Controller, reference: Reference, loop: Loop) -> Setup:
    """The setup; where no substeps were typed, with as many as RK4 needs to follow the plant's friction."""
    try:
        return prepare(arm, controller, reference, loop)
    except OptionError as fault:
        if fault.name != "friction" or SUBSTEPS.is_typed or loop.method != "rk4":
            raise
    setup = prepare(arm, controller, reference, replace(loop, substeps=MOST_SUBSTEPS))
    return with_substeps(setup, friction_substeps(setup))


def _law(model: Arm, dynamics: Dynamics, reference: Reference, given: dict[str, Any]) -> UsualLaw:
    """The law that is asked for, or the first of the usual ones that takes what was typed and is stable."""

    def make(name: str) -> Controller:
        found = CONTROLLER_OPTIONS.values(split_name(name)[0], given, model)
        return make_controller(name, model, dynamics, **found)

    if given["controller"] is not None:
        return UsualLaw(split_name(given["controller"])[0], make(given["controller"]))
    typed = [flag for flag in CONTROLLER_OPTIONS.flags if flag.is_typed]
    laws = [name for name in LAWS if all(name in flag.rows for flag in typed)] or [*LAWS[:1]]
    CONTROLLER_OPTIONS.refuse_unused(laws[0])
    return usual_law(model, dynamics, make, reference, given["rate"], laws[:1] if given["continuous"] else laws)


def _plant_note(given: dict[str, Any]) -> dict[str, Any]:
    """What the plant has that the controller's arm has not, in words, and whether it knows the payload."""
    reading, scale = given["plant_reading"], given["plant_scale"]
    parts = [f"reading {reading}"] if reading is not None else []
    parts += [f"masses times {scale:g}"] if scale != 1.0 else []
    if given["elastic"] is not None:
        stiffness = "" if given["elastic"] == "file" else f" of {given['elastic']} N m/rad"
        parts += [f"elastic joints{stiffness}, {given['encoders']} encoders"]
    known = {"payload_known": True} if given["payload_known"] else {}
    return ({"plant": ", ".join(parts)} if parts else {}) | known


def _check_targets(given: Mapping[str, Any]) -> None:
    """Raise `FileAccessError` where a file cannot be written, `MissingPackageError` if nothing writes its format."""
    for name, ending in (("out", ""), ("csv", ".csv"), ("html", ".html")):
        if given[name] is not None:
            check_writable(given[name], ending)
    if given["out"] is not None:
        format_of(given["out"])


def _written(run: Run, arm: Arm, given: Mapping[str, Any]) -> list[str]:
    """Paths of the columns and the page that are asked for, which are then there."""
    if given["csv"] is not None:
        run.save(given["csv"])
    if given["html"] is not None:
        from lwr_dyn.pages.replay.replay_page import write_replay  # here: no other run needs the page

        write_replay(given["html"], [run], arm)
    return [given[name] for name in ("csv", "html") if given[name] is not None]


def _simulated(setup: Setup, controller: str, out: str | None, notes: list[str]) -> Run:
    """The run, saved in `out`; `controller` is a name or a file, and a run that is not refused has `notes`."""
    try:
        with progress("simulating") as report, faults_in(controller):
            run = run_setup(setup, report)
            if not SUBSTEPS.is_typed and applies(setup):
                found = enough_steps(run, lambda steps: run_setup(with_substeps(setup, steps), report))
                run = _with_words(found.run, found.words)
    except DivergenceError as fault:
        _note(notes)
        if out is not None and isinstance(fault.run, Run):
            fault.run.save(out)
            click.echo(f"kept what was computed in {out}")
        raise
    _note(notes)
    if out is not None:
        run.save(out)
    return run


def _with_words(run: Run, words: str) -> Run:
    """The run with a line of what was chosen for it."""
    if not words:
        return run
    note = run.meta["note"]
    return replace(run, meta={**run.meta, "note": {**note, "chosen": [*note.get("chosen", ()), words]}})


def _friction(plant: Arm, form: str, refit: bool) -> tuple[FrictionOption, dict[str, Any]]:
    """The option `friction` of `simulate`, and a note of what a refit changed; raises as `passive_refit`."""
    if not refit:
        return form, {}
    if form != FORMS[0]:
        raise OptionError("--passive-refit", f"with --friction {form}", f"with --friction {FORMS[0]}")
    if not plant.has_friction:
        raise OptionError("--passive-refit", f"{plant.name} has no friction", "with an arm whose friction is known")
    nearest = passive_refit(plant.friction_models())
    models = tuple(model and replace(model, load=0.0) for model in nearest.models)  # left out, as the first line says
    return models, {"passive_refit": [_change(plant, c) for c in nearest.changes]}


def _change(plant: Arm, c: Any) -> dict[str, Any]:
    before, after = ({"coulomb": d.coulomb, "viscous": d.viscous} for d in (c.before, c.after))
    name = plant.joint_names[c.joint]
    return {"joint": name, "side": c.side, "rms": c.rms, "speed": c.speed, "before": before, "after": after}


def _encoder(bits: int | None, noise: float, cutoff: float) -> Encoder | None:
    if bits is not None and not 1 <= bits <= 40:
        raise OptionError("--encoder-bits", bits, "a whole number from 1 to 40")
    if bits is None:
        return Encoder(0.0, noise, cutoff) if noise else None
    return Encoder.of_bits(bits, noise, cutoff)
