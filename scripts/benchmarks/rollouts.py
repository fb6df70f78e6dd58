"""Whole closed loops, a block of runs at once, against MuJoCo, mjbatch, mujoco.rollout, Drake and our Python loop.

Times are processor time of one thread; every engine runs once a round, and ratios are medians over the rounds. Every
run has bodies of its own, which the law does not know. The reference is sampled once before, for all.
"""

from __future__ import annotations

import statistics
import sys
import tempfile
import time
from collections.abc import Callable
from contextlib import ExitStack
from inspect import signature
from pathlib import Path

import numpy as np

from benchmarks.fused_rate import fused_rate
from benchmarks.peer_process import PEERS, PeerProcess, interpreter
from benchmarks.rollout_case import KD, KP, RATE, RolloutCase
from benchmarks.timing import Call, installed
from lwr_dyn.arms.export.mjcf import mjcf_text
from lwr_dyn.codegen.kernels.machine_code import lanes_of
from lwr_dyn.codegen.rollouts.kernel import PlanLoop, rollout_kernel, rollout_loop
from lwr_dyn.codegen.rollouts.kernel_task import plan_of, task_of
from lwr_dyn.codegen.rollouts.law_forms import law_form
from lwr_dyn.codegen.rollouts.loop_setup import loop_setup
from lwr_dyn.simulation.setup import Loop
from lwr_dyn.simulation.simulate import simulate

RUNS, SECONDS, OPEN_RUNS = 256, 14.0, 4
SHORT = 2.0
"""[s] Of the motion that a batcher from outside follows with all runs; its time is scaled to the whole."""
OURS, ALONE = f"lwr_dyn, {RUNS} runs by `rollouts`", "lwr_dyn, one run by its scalar kernel"
Turn = Callable[[], tuple[float, np.ndarray | None]]
"""One loop: processor time a run [s], and where its first run ended (n,)."""


def turn(call: Callable[[], np.ndarray | None], runs: int = 1) -> Turn:
    """A loop of this process."""

    def timed() -> tuple[float, np.ndarray | None]:
        start = time.process_time()
        end = call()
        return (time.process_time() - start) / runs, end

    return timed


def mujoco_loop(case: RolloutCase, seconds: float, is_bare: bool) -> Call:
    """The loop in Python around mj_step, RK4; the law by mj_inverse of a nominal model.

    `is_bare`: without contacts, limits and other constraints, which it has none of, but looks for.
    """
    import mujoco

    plant, law = (mujoco.MjModel.from_xml_string(mjcf_text(arm)) for arm in (case.arms[0], case.arm))
    for model in (plant, law):
        model.opt.timestep, model.opt.integrator = 1.0 / RATE, mujoco.mjtIntegrator.mjINT_RK4
        if is_bare:
            for name in ("CONTACT", "LIMIT", "CONSTRAINT"):
                model.opt.disableflags |= int(getattr(mujoco.mjtDisableBit, f"mjDSBL_{name}"))
    data, other, motion = mujoco.MjData(plant), mujoco.MjData(law), case.motion(seconds)

    def loop() -> np.ndarray:
        mujoco.mj_resetData(plant, data)
        data.qpos[:], data.qvel[:] = motion.q[0], motion.dq[0]
        for k in range(len(motion.q) - 1):
            other.qpos[:], other.qvel[:] = data.qpos, data.qvel
            other.qacc[:] = KP * (motion.q[k] - data.qpos) + KD * (motion.dq[k] - data.qvel) + motion.ddq[k]
            mujoco.mj_inverse(law, other)
            data.qfrc_applied[:] = other.qfrc_inverse
            mujoco.mj_step(plant, data)
        return np.array(data.qpos)

    return loop


def mujoco_rollout(case: RolloutCase, seconds: float) -> Call:
    """`mujoco.rollout`: the torques of our runs replayed, with no feedback, so that its runs drift away."""
    import mujoco
    from mujoco import rollout

    models, motion = [], case.motion(seconds)
    for arm in case.arms[:OPEN_RUNS]:
        model = mujoco.MjModel.from_xml_string(mjcf_text(arm))
        model.opt.timestep, model.opt.integrator = 1.0 / RATE, mujoco.mjtIntegrator.mjINT_RK4
        models.append(model)
    data = [mujoco.MjData(models[0])]
    tau = case.rollouts(OPEN_RUNS, seconds, record=1).tau[:, :-1]
    start = np.tile(np.concatenate([[0.0], motion.q[0], motion.dq[0]]), (OPEN_RUNS, 1))
    force = mujoco.mjtState.mjSTATE_QFRC_APPLIED

    def call() -> None:
        rollout.rollout(models, data, start, tau, control_spec=int(force), persistent_pool=False)

    return call


def scalar_kernel(case: RolloutCase, seconds: float) -> tuple[Call, PlanLoop, PlanLoop]:
    """One run by scalar code, from the parameters on; the sources of the kernels of one run and of a block."""
    loop, form = Loop(friction="none", duration=seconds), law_form(case.law, case.arm)
    setup = loop_setup(case.arm, case.law, case.reference, loop)
    given = {"inertia": case.inertia[:1]}
    plan = plan_of(setup, form, given)
    kernel, sources = rollout_kernel(plan, lanes=1), [rollout_loop(plan, lanes) for lanes in (1, lanes_of("float64"))]

    def call() -> None:
        kernel.run(task_of(setup, plan, kernel, given, 1, None, (), 0, 0))

    return call, sources[0], sources[1]


def in_this_process(case: RolloutCase, seconds: float) -> dict[str, Turn]:
    """All loops that need no environment of their own, ours first."""
    options = {"plant": case.arms[0], "duration": seconds, "allow_unphysical": True}
    last = round(seconds * RATE)
    turns = {
        OURS: turn(lambda: case.rollouts(RUNS, seconds, record=last).q[0, -1], RUNS),
        ALONE: turn(scalar_kernel(case, seconds)[0]),
        "lwr_dyn, one run by `rollouts`": turn(lambda: case.rollouts(1, seconds, record=last).q[0, -1]),
    }
    if "loop" in signature(simulate).parameters:
        turns["lwr_dyn, `simulate(loop='compiled')`, audit included"] = turn(
            lambda: simulate(case.arm, case.law, case.reference, loop="compiled", **options).q[-1]
        )
    turns["lwr_dyn, `simulate`, Python loop, audit included"] = turn(
        lambda: simulate(case.arm, case.law, case.reference, **options).q[-1]
    )
    if installed("mujoco"):
        turns["MuJoCo, Python loop"] = turn(mujoco_loop(case, seconds, False))
        turns["MuJoCo, Python loop, contacts, limits, constraints off"] = turn(mujoco_loop(case, seconds, True))
        turns[f"mujoco.rollout, {OPEN_RUNS} runs, torques replayed"] = turn(mujoco_rollout(case, seconds), OPEN_RUNS)
    return turns


def arithmetic(case: RolloutCase, seconds: float, times: dict[str, float]) -> None:
    """Fused operations of a sample at the rate of a loop of nothing else, against the time it takes."""
    _, one, block = scalar_kernel(case, seconds)
    wide, samples = lanes_of("float64"), round(seconds * RATE) + 1
    each = fused_rate() / wide
    print(f"\nArithmetic limit at {each / 1e9:.2f} fused operations a lane and ns:")
    for name, source, lanes in ((OURS, block, wide), (ALONE, one, 1)):
        limit, took = source.fused / (lanes * each), times[name] / samples
        print(
            f"- {name}: {source.operations} operations a sample, {source.fused} fused: {limit * 1e9:.0f} ns "
            f"on {lanes} lane(s); measured {took * 1e9:.0f} ns, {took / limit:.2f} times that"
        )


def closed_loops(pairs: int, peers: str | None = None, seconds: float = SECONDS) -> None:
    """The table; `peers` is the folder of the environments of mjbatch and Drake, which are left out without it."""
    case = RolloutCase.of(RUNS)
    print(
        f"\n### Closed loops: IST for {seconds:g} s at 1 kHz, inverse dynamics, RK4, bodies of its own for every run\n"
    )
    with tempfile.TemporaryDirectory() as place, ExitStack() as stack:
        turns = in_this_process(case, seconds)
        if peers is None:
            print("(mjbatch and Drake are left out: name a folder for their environments with --peers)")
        for peer in PEERS if peers else ():
            runs, length = (RUNS, min(SHORT, seconds)) if peer == "mjbatch" else (1, seconds)
            folder = Path(place) / peer
            folder.mkdir()
            case.write(folder, length)
            process = stack.enter_context(PeerProcess(interpreter(Path(peers), peer), peer, folder, runs))
            about = ", ".join(f"{name} {number}" for name, number in process.versions.items())
            order = f"{RUNS} runs, RK4, {length:g} s scaled" if peer == "mjbatch" else "RK3 of fixed step"
            share = length / seconds
            turns[f"{peer} ({about}), {order}"] = lambda p=process, k=runs * share, whole=share == 1.0: (
                p.seconds() / k,
                p.end()[0] if whole else None,
            )
        ends = {name: one()[1] for name, one in turns.items()}
        rounds = []
        for _ in range(pairs):
            rounds.append({name: one()[0] for name, one in turns.items()})
            print(".", end="", file=sys.stderr, flush=True)
    print_table(rounds, ends)
    arithmetic(case, seconds, {name: statistics.median(r[name] for r in rounds) for name in turns})


def print_table(rounds: list[dict[str, float]], ends: dict[str, np.ndarray | None]) -> None:
    """Medians over the rounds."""
    print("| loop | ms a run | / block of ours | lowest | / one run of ours | first run ends elsewhere by [rad] |")
    print("|---|---|---|---|---|---|")
    for name in rounds[0]:
        block, one = ([r[name] / r[ours] for r in rounds] for ours in (OURS, ALONE))
        end = ends[name]
        off = "-" if end is None else f"{np.abs(end - ends[OURS]).max():.1e}"
        took = 1e3 * statistics.median(r[name] for r in rounds)
        print(f"| {name} | {took:.3g} | {statistics.median(block):.3g} | {min(block):.3g} "
              f"| {statistics.median(one):.3g} | {off} |")  # fmt: skip
