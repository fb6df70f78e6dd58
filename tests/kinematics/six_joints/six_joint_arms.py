"""Six-joint arms as their makers' numbers give them, rounded and calibrated ones too, and a search of all solutions.

Standard DH: alpha [deg], a [m], d [m]. Universal Robots: "DH parameters for calculations of kinematics and dynamics".
KUKA, ABB, Staubli, Doosan, UFACTORY, Kinova, Unitree: lengths of the makers' drawings as their public URDFs carry them.
"""

import numpy as np

import lwr_dyn
from lwr_dyn.kinematics.inverse import inverse_kinematics, search
from lwr_dyn.kinematics.solution import wrap
from lwr_dyn.model.arm import Arm, JointLimits
from lwr_dyn.model.chain import Chain, ChainLink, JointKind
from lwr_dyn.model.spatial import Pose, from_rpy

UR_ALPHA = (90, 0, 0, 90, -90, 0)
WRIST_ALPHA = (-90, 0, -90, 90, -90, 0)


def _ur(d1, a2, a3, d4, d5, d6):
    return UR_ALPHA, (0, a2, a3, 0, 0, 0), (d1, 0, 0, d4, d5, d6)


def _wrist(a1, a2, a3, d1, d3, d4, d6, alpha=WRIST_ALPHA):
    return alpha, (a1, a2, a3, 0, 0, 0), (d1, 0, d3, d4, 0, d6)


TABLES = {
    "ur3": _ur(0.1519, -0.24365, -0.21325, 0.11235, 0.08535, 0.0819),
    "ur5": _ur(0.089159, -0.425, -0.39225, 0.10915, 0.09465, 0.0823),
    "ur10": _ur(0.1273, -0.612, -0.5723, 0.163941, 0.1157, 0.0922),
    "ur3e": _ur(0.15185, -0.24355, -0.2132, 0.13105, 0.08535, 0.0921),
    "ur5e": _ur(0.1625, -0.425, -0.3922, 0.1333, 0.0997, 0.0996),
    "ur10e": _ur(0.1807, -0.6127, -0.57155, 0.17415, 0.11985, 0.11655),
    "ur16e": _ur(0.1807, -0.4784, -0.36, 0.17415, 0.11985, 0.11655),
    "ur20": _ur(0.2363, -0.862, -0.7287, 0.2010, 0.1593, 0.1543),
    "ur30": _ur(0.2363, -0.637, -0.5037, 0.2010, 0.1593, 0.1543),
    "z1": ((90, 180, 0, 90, -90, 0), (0, 0.35, 0.2179, 0.07, 0, 0), (0.1035, 0, 0, 0, 0, 0.0492)),
    "kr210": _wrist(0.35, 1.25, -0.054, 0.75, 0, 1.5, 0.303),
    "irb120": _wrist(0, 0.27, 0.07, 0.29, 0, 0.302, 0.072),
    "irb1200": _wrist(0, 0.448, 0.042, 0.3991, 0, 0.451, 0.082),
    "tx60": _wrist(0, 0.29, 0, 0.375, 0.02, 0.31, 0.07),
    "m1013": _wrist(0, 0.62, 0, 0.1525, 0.0345, 0.559, 0.121, np.degrees((-1.571, 0, -1.571, 1.571, -1.571, 0))),
    "lite6": _wrist(
        0, 0.2, 0.087, 0.2433, 0, 0.2276, 0.0615, np.degrees((-1.5708, 3.1416, 1.5708, 1.5708, -1.5708, 0))
    ),
}
PARALLEL = tuple(name for name, (alpha, _, _) in TABLES.items() if abs(alpha[2]) < 1.0)
WHOLE_TURN = 2.0 * np.pi


def six_joint_arm(name, error=0.0, seed=0, reach=WHOLE_TURN, table=None):
    """The arm of the table with limits of +-`reach` [rad]; each joint's frame is off by up to `error` [rad, m]."""
    rng = np.random.default_rng(seed)
    links = []
    for i, (alpha, a, d) in enumerate(zip(*(table or TABLES[name]), strict=True)):
        off = Pose(from_rpy(rng.uniform(-error, error, 3)), rng.uniform(-error, error, 3))
        after = Pose(from_rpy((np.radians(alpha), 0.0, 0.0)), np.array([a, 0.0, d])) @ off
        links.append(ChainLink(f"joint_{i + 1}", f"link_{i + 1}", JointKind.REVOLUTE, Pose.identity(), after))
    limits = (JointLimits(-reach, reach),) * 6
    return Arm(name, "none", name, Chain(tuple(links), Pose.identity(), np.zeros(3)), limits)


def against_search(arm, T, starts=300, seed=1, apart=1e-4):
    """Branches found, those that a search from many starts finds too, those that only it finds, largest difference.

    Whole turns do not count; solutions are matched to `apart` [rad].
    """
    anywhere = np.full(6, np.inf)
    searched = search(arm.chain, -anywhere, anywhere, T, starts, seed)
    found = np.array([s.q for s in inverse_kinematics(arm, T, limits=False).solutions]).reshape(-1, 6)
    if len(found):
        found = found[np.unique(np.round(np.hstack([np.cos(found), np.sin(found)]), 4), axis=0, return_index=True)[1]]
    gaps = np.abs(wrap(found[:, None] - searched)).max(axis=2)
    nearest = gaps.min(axis=0, initial=np.inf)
    shared = nearest < apart
    return len(found), int(shared.sum()), int((~shared).sum()), float(nearest[shared].max(initial=0.0))


def assert_recovered(arm, result, q, clear_of, within, shown):
    """Where clear of singularities, a share above `shown`, q is a branch to `within`; each branch gives its pose."""
    gap = np.abs(wrap(result.q - q[:, None])).max(axis=2)
    gap = np.where(np.isnan(gap), np.inf, gap)
    clear = (result.clearance[np.arange(len(q)), gap.argmin(axis=1)] >= clear_of).all(axis=1)
    assert clear.mean() > shown
    assert gap.min(axis=1)[clear].max() < within
    back, T = (lwr_dyn.forward_kinematics(arm, x) for x in (np.nan_to_num(result.q), q))
    assert np.abs(back - T[:, None])[result.reachable].max() < 1e-9
