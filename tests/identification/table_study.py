"""Right tables of arms that are off them as a maker's arms are, and cells of them that are wrong: what a log says.

    study = TableStudy.of("panda")
    study.log("natural", "white", run=0)    # what a log of 12 s says of an arm 5 % and 3 mm off its table

Motions, arms and noise are those of `cover_truths`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lwr_dyn.dynamics.regressor import body_parameters
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.identification.bodies.body_prior import body_prior
from lwr_dyn.identification.logs.joint_log import JointLog
from lwr_dyn.identification.motion.validation import inflation_of, residuals_of, whiteness_of
from lwr_dyn.identification.payload.identify_load import RULES, identify_load, load_shift
from lwr_dyn.identification.regression.information import Information, information_of, widened
from lwr_dyn.identification.regression.samples import exact_samples
from lwr_dyn.identification.regression.torque_columns import TorqueColumns
from lwr_dyn.identification.slips.hypotheses import Hypothesis, as_printed, log_evidence
from lwr_dyn.identification.slips.printed_cells import PrintedCells, printed_cells
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.chain import Body
from lwr_dyn.model.run import Motion
from tests.identification import cover_truths
from tests.identification.cover_truths import Natural, cover_arm, cover_motion, cover_noise
from tests.identification.plants import congruent, torques

OFF = ("natural", "congruent", "exact")
"""5 % of masses and tensors, 3 mm of centres, .05 rad of axes; 5 % in the log-det metric; the table itself."""
SHARE, CENTRE, TURNED = 0.05, 0.003, 0.05
LOAD = 2.0
"""[kg]"""
SLOWEST = 0.05
"""[rad/s or m/s] Equations of slower joints are left out."""


@dataclass(frozen=True)
class TableStudy:
    """An arm, its cells, and a motion with the torques that its table gives."""

    name: str
    arm: Arm
    cells: PrintedCells
    columns: TorqueColumns
    motions: tuple[Motion, ...]

    @classmethod
    def of(cls, name: str) -> TableStudy:
        """One of the arms of `cover_truths`."""
        arm = cover_arm(name)
        motions = tuple(cover_motion(name, number) for number in range(cover_truths.MOTIONS))
        return cls(name, arm, printed_cells(arm), TorqueColumns(arm.chain, "directions"), motions)

    def truth(self, off: str, rng: np.random.Generator) -> Array:
        """Parameters (p,) of the arm itself, with friction that no table has."""
        own = self.columns.own(self.arm)
        out, table, rotors = own.copy(), body_prior(self.columns, own).table, self.columns.rotor_indices
        for i in range(self.arm.n if off != "exact" else 0):
            ten = slice(10 * i, 10 * i + 10)
            if off == "natural":
                out[ten] = cover_truths.moved(table[ten], Natural(SHARE, CENTRE, TURNED), rng)
            else:
                out[ten] = congruent(table[ten], rng, SHARE)
        out[rotors] *= np.exp(rng.normal(0.0, SHARE * (off != "exact"), self.arm.n))
        friction = self.columns.friction_indices
        out[friction] = rng.uniform(0.4, 3.0, friction.size)
        return out

    def log(self, off: str, noise: str, run: int) -> Information:
        """What `identify table` takes from a log of 12 s."""
        rng = np.random.default_rng([run, *map(ord, self.name + off + noise)])
        motion, truth = self.motions[run % len(self.motions)], self.truth(off, rng)
        tau = torques(self.columns, truth, motion) + cover_noise(motion.q.shape, noise, rng)
        samples = exact_samples(motion.t, motion.q, motion.dq, motion.ddq, tau, SLOWEST)
        found = information_of(samples, self.columns)
        left = residuals_of(samples, self.columns, found.values)
        return widened(found, inflation_of(whiteness_of(left, samples.recording, found.paid), self.arm.n))

    def printed(self, off: str, noise: str, run: int, deviation: float = SHARE) -> Hypothesis:
        """The right table against such a log."""
        return as_printed(log_evidence(self.log(off, noise, run), self.cells, deviation), self.cells)

    def loaded(self, off: str, run: int) -> tuple[JointLog, Array, JointLog]:
        """A log of such an arm with a drawn load of 2 kg, the load (10,) about the flange, a log without it."""
        rng = np.random.default_rng([run, *map(ord, self.name + off + "load")])
        motion, truth = self.motions[run % len(self.motions)], self.truth(off, rng)
        x, y, z = rng.uniform(0.004, 0.01, 3)  # second moments about its centre: any are a body's
        load = body_parameters(Body(LOAD, rng.normal(0.0, 0.05, 3), np.diag([y + z, x + z, x + y])))
        full = truth.copy()
        full[self.columns.bodies - 10 : self.columns.bodies] += load_shift(self.arm.chain.flange) @ load
        joints = tuple(range(1, self.arm.n + 1))
        logs = [
            JointLog(source, joints, motion.t, motion.q,
                     torques(self.columns, each, motion) + cover_noise(motion.q.shape, "white", rng))
            for source, each in (("loaded", full), ("bare", truth))
        ]  # fmt: skip
        return logs[0], load, logs[1]

    def load_pulls(self, off: str, run: int) -> Array:
        """Sigmas by which each of the ten parameters of the load is off, (10,)."""
        log, load, _ = self.loaded(off, run)
        found = identify_load([log], self.arm, RULES[:1])
        return (found.parameters - load) / found.sigma
