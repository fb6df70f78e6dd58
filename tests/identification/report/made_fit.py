"""A fit made by hand for the tests of the report: an arm off its table, two motions, torques with noise."""

from __future__ import annotations

import numpy as np

import lwr_dyn
from lwr_dyn.dynamics.regressor import body_parameters
from lwr_dyn.foundation.document import Document, Fact, Note, Section
from lwr_dyn.foundation.tables import Heading, Table
from lwr_dyn.identification.report.charts import ShownRecording
from lwr_dyn.identification.report.motion_report import DrawnMotion, figure_sections
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.chain import Body
from lwr_dyn.model.friction import Direction, JointFriction, symmetric
from tests.identification.simulated import fourier_states

NOISE = 0.1
BAD = '<img src=x onerror="alert(1)">'


def moved(body: Body, size: float) -> Body:
    """A body as many times as heavy, its centre moved by 20 mm along x."""
    return Body(size * body.mass, body.com + np.array([0.02, 0.0, 0.0]), size * body.inertia_com)


def made_fit(arm: Arm | None = None, source: str = "log", impossible: int | None = None) -> DrawnMotion:
    """A fit of an arm; the link `impossible` (from 0) has values that no body can have."""
    arm = lwr_dyn.load("lwr4plus", "physical") if arm is None else arm
    rng, dynamics = np.random.default_rng(1), lwr_dyn.dynamics_of(arm, "newton-euler")
    friction = tuple(JointFriction(Direction(3.0 + j, 2.0), Direction(2.5 + j, 2.2), 0.3) for j in range(arm.n))
    recordings, speeds, torques = [], [], []
    for k, seconds in enumerate((12.0, 6.0)):
        t, q, dq, ddq = fourier_states(arm.n, seconds, k)
        q = q + np.resize([0.0, 0.7], arm.n)
        rigid = dynamics.inverse_dynamics(q, dq, ddq)
        predicted = rigid + np.column_stack([one.torque(dq[:, j]) for j, one in enumerate(friction)])
        measured = predicted + rng.normal(0.0, NOISE, q.shape)
        used = np.abs(dq) > 0.05
        recordings.append(ShownRecording(f"{source}_{k + 1}.csv", t, q, measured, predicted, used))
        speeds.append(dq)
        torques.append(np.where(used, measured - rigid, np.nan))
    bodies = [link.body for link in arm.chain.links]
    before = np.array([body_parameters(body) for body in bodies])
    after = np.array([body_parameters(moved(body, 0.8 + 0.05 * i)) for i, body in enumerate(bodies)])
    if impossible is not None:
        after[impossible, 4:] = (1.0, 0.0, 0.0, 0.1, 0.0, 0.1)
    return DrawnMotion(
        arm, tuple(recordings), np.full(arm.n, NOISE), before, after, np.concatenate(speeds), np.concatenate(torques),
        friction, (symmetric(3.0, 1.0), *(None,) * (arm.n - 1)), arm.joint_names,
    )  # fmt: skip


def parameter_table(drawn: DrawnMotion, *more: tuple) -> Table:
    """Parameters of the links, some not excited, with bars and a choice."""
    rows = [
        (f"{name}_{i + 1}", drawn.after[i, p], (drawn.after[i, p] - drawn.before[i, p]) / 0.01, state)
        for i in range(drawn.arm.n)
        for p, name, state in ((0, "m", "identified"), (1, "mx", "identified"), (9, "Izz", "not excited"))
    ]
    heads = (Heading("parameter", cut=60), Heading("value", "", ".4g"), Heading("pull", "sigma", ".2g", bar=10.0),
             Heading("state", pick=True))  # fmt: skip
    return Table("Parameters of the links", heads, [*more, *rows], "A note.")


def made_document(
    drawn: DrawnMotion, title: str = "Identification", said: str = "2 recordings, 18 s.", *rows: tuple
) -> Document:
    """The page of a fit made by hand."""
    left = Table("Torques left", (Heading("joint"), Heading("fitted", "N m", ".3g")), [("1", 0.1), ("2", 0.11)])
    shaded = [Heading(name, "", ".1f", shade=lambda pull: min(abs(pull), 10.0) / 18.0) for name in ("m", "cx", "Ixx")]
    cells = Table("Sigmas off", (Heading("link"), *shaded), [("1", 0.1, -4.0, 30.0), ("2", -12.0, 1.0, 5.0)])
    tiles = [Fact(None, "14 of 21", "", "identified parameters"), Fact(None, "7 of 7", "", "links that can be bodies")]
    sections = [*figure_sections(drawn), Section("Parameters", [parameter_table(drawn, *rows)]),
                Section("Validation", [left, cells, Note("Judged on other logs.")])]  # fmt: skip
    return Document(title, said, sections, "lwr-dyn identify motion", "identification", tiles)
