"""Symbolic equations of motion against Pinocchio on the reduced model, for random lengths, bodies and states."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from lwr_dyn.arms.papers.assembly import dh_rows
from lwr_dyn.arms.papers.schema import Paper
from lwr_dyn.checks.arm.model_laws import ACCELERATION, SPEED
from lwr_dyn.checks.arm.verdict import Verdict
from lwr_dyn.dynamics.pinocchio_engine import pinocchio_dynamics
from lwr_dyn.dynamics.symbolic.arm_equations import equations_of_motion, reduced_arm, symbol_values
from lwr_dyn.dynamics.symbolic.equation_forms import compile_equations
from lwr_dyn.dynamics.symbolic.link_motion import length_letters
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.chain import Body, Chain

SYMBOLIC = 1e-10
"""[kg m^2, N m s, N m] Largest difference allowed, of numbers up to some hundreds."""
QUANTITIES = {"mass_matrix": 1, "coriolis_matrix": 2, "gravity_vector": 1, "inverse_dynamics": 3}
"""Function -> the number of its arguments."""


def symbolic_verdicts(
    arm: Arm,
    paper: Paper,
    joints: Sequence[str],
    held: Mapping[str, float] | None = None,
    count: int = 100,
    seed: int = 20240607,
) -> tuple[Verdict, ...]:
    """B, C, g and tau from Euler-Lagrange less Pinocchio's, the largest over `count` random arms and states.

    Lengths, masses, centres of mass, tensors, joint states and the size of gravity are random each time; the arm has no
    rotors, and the equations are derived once. Raises as `equations_of_motion`.
    """
    bare = replace(arm, chain=replace(arm.chain, links=tuple(replace(x, rotor=None) for x in arm.chain.links)))
    derived = equations_of_motion(bare, joints, held, paper)
    compiled, rng = compile_equations(derived.equations), np.random.default_rng(seed)
    moving = [arm.joint_names.index(name) for name in joints]
    fixed = {arm.joint_names.index(name): value for name, value in (held or {}).items()}
    worst = dict.fromkeys(QUANTITIES, 0.0)
    for _ in range(count):
        chain, lengths = _random_chain(bare.chain, paper, rng)
        symbolic = compiled.at(symbol_values(chain) | lengths)
        engine = pinocchio_dynamics(reduced_arm(replace(bare, chain=chain), moving, fixed))
        q = rng.uniform(-np.pi, np.pi, len(moving))
        state = (q, rng.uniform(-SPEED, SPEED, q.size), rng.uniform(-ACCELERATION, ACCELERATION, q.size))
        for name, takes in QUANTITIES.items():
            difference = getattr(symbolic, name)(*state[:takes]) - getattr(engine, name)(*state[:takes])
            worst[name] = max(worst[name], float(np.abs(difference).max()))
    head = f"{', '.join(joints)}: Euler-Lagrange - Pinocchio, {count} random arms and states"
    residual = sum(1 for entry in derived.equations.residual() if entry != 0)
    return (
        *(Verdict(f"{head}: {name}", value, SYMBOLIC, "SI") for name, value in worst.items()),
        Verdict(f"{', '.join(joints)}: tau of L - (B ddq + C dq + g), entries not 0", float(residual), 0.0, ""),
    )


def _random_chain(chain: Chain, paper: Paper, rng: np.random.Generator) -> tuple[Chain, dict[str, float]]:
    """The same joints with other lengths [m], bodies and gravity, and the lengths by their letters."""
    letters = length_letters(paper)
    names = sorted({x.name for column in letters.values() for x in column if x != 0})
    lengths = {name: float(rng.uniform(0.1, 1.0)) for name in names}
    links = []
    for i, (row, link) in enumerate(zip(dh_rows(paper), chain.links, strict=True)):
        a, d = (0.0 if letters[x][i] == 0 else lengths[letters[x][i].name] for x in ("a", "d"))
        before, after = replace(row, a=a, d=d).fixed_poses(paper.convention)
        links.append(replace(link, before=before, after=after, body=_random_body(rng)))
    gravity = chain.gravity / np.linalg.norm(chain.gravity) * rng.uniform(1.0, 20.0)
    return Chain(tuple(links), chain.flange, gravity), lengths


def _random_body(rng: np.random.Generator) -> Body:
    """Five random mass points: a feasible body."""
    points: Array = rng.uniform(-0.5, 0.5, (5, 3))
    body = Body.massless()
    for mass, point in zip(rng.uniform(0.5, 5.0, 5), points, strict=True):
        body = body + Body(float(mass), point, np.zeros((3, 3)))
    return body
