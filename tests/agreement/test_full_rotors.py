"""The paper's full rotor terms against Pinocchio with seven explicit rotor bodies, the exact model of geared motors."""

import numpy as np
import pinocchio as pin
import pytest

import lwr_dyn
from lwr_dyn.model.arm import Arm
from tests.tolerances import FULL_ROTOR

TINY = 1e-3
"""Mass [kg] given to each rotor body and taken from the link that carries it."""


def geared_model(arm: Arm):
    """Links with the rotors taken out, and the rotors as bodies of their own that turn about the joint axes.

    Returns the model and J with dq_all = J dq_links: a rotor turns k_r times as fast, relative to its carrier.
    """
    model, parent, data = pin.Model(), 0, []
    model.gravity.linear = np.array(arm.chain.gravity)
    bodies = [pin.Inertia(b.mass, np.array(b.com), np.array(b.inertia_com)) for b in arm.bodies()]
    for i, joint in enumerate(arm.joints()):
        rotor = arm.chain.links[i].rotor
        origin = pin.SE3(np.array(joint.origin.rotation), np.array(joint.origin.position))
        spin = rotor.inertia
        body = pin.Inertia(TINY, np.zeros(3), np.diag([spin, spin, spin]))
        if i > 0:
            carried = bodies[i - 1] - origin.act(body)
            model.inertias[parent] = carried
        rotor_id = model.addJoint(parent, pin.JointModelRZ(), origin, f"rotor_{i}")
        model.appendBodyToJoint(rotor_id, body, pin.SE3.Identity())
        parent = model.addJoint(parent, pin.JointModelRZ(), origin, f"link_{i}")
        model.appendBodyToJoint(parent, bodies[i], pin.SE3.Identity())
        data.append((model.joints[rotor_id].idx_v, model.joints[parent].idx_v, rotor.gear_ratio))
    J = np.zeros((model.nv, arm.n))
    for i, (rotor_v, link_v, ratio) in enumerate(data):
        J[rotor_v, i], J[link_v, i] = ratio, 1.0
    return model, J


@pytest.mark.parametrize("reading", ["printed", "computed", "physical"])
def test_full_rotor_torque_is_that_of_explicit_rotors(reading):
    arm = lwr_dyn.load("lwr4plus", reading)
    model, J = geared_model(arm)
    data = model.createData()
    full = lwr_dyn.dynamics_of(arm, "newton-euler", rotors="full")
    rng = np.random.default_rng(11)
    worst = 0.0
    for q, dq, ddq in zip(*(rng.uniform(-s, s, (200, 7)) for s in (2.5, 2.0, 10.0)), strict=True):
        tau = J.T @ pin.rnea(model, data, J @ q, J @ dq, J @ ddq)
        worst = max(worst, np.abs(tau - full.inverse_dynamics(q, dq, ddq)).max())
    assert worst < FULL_ROTOR


def test_spin_couplings_are_what_armature_drops():
    arm = lwr_dyn.load("lwr4plus", "physical")
    rng = np.random.default_rng(3)
    q, dq, ddq = (rng.uniform(-s, s, (500, 7)) for s in (2.5, 2.0, 10.0))
    full, armature = (
        lwr_dyn.dynamics_of(arm, "newton-euler", rotors=x).inverse_dynamics(q, dq, ddq) for x in ("full", "armature")
    )
    difference = np.abs(full - armature).max()
    assert 0.01 < difference < 0.04  # up to 0.039 N m with the formula's own I_m
