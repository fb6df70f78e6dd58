"""A designed motion in words and as a record."""

from typing import Any

import numpy as np

from lwr_dyn.foundation.tables import Heading, Table
from lwr_dyn.identification.excitation.design import Excitation
from lwr_dyn.identification.excitation.motion_design import CHECK_RATE, MOST_CHECKS
from lwr_dyn.identification.excitation.motion_score import SCORE_RATE
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.dh import JointKind

KINDS = {name: "first moments" for name in ("mx", "my", "mz")}
KINDS |= {name: "tensors" for name in ("Ixx", "Ixy", "Ixz", "Iyy", "Iyz", "Izz")} | {"m": "masses"}
"""The kind of a column of a body; columns of joints are their own kind."""


def excitation_text(found: Excitation) -> str:
    """Head lines, how the limits are used, and the parameters that are known least."""
    arm, motion, score = found.arm, found.motion, found.score
    clear = f"at least {found.clear:.3f} m between {found.nearest}" if found.nearest else "nothing to keep clear of"
    lines = [
        f"{arm.name}, reading {arm.reading}: {motion.duration:g} s at rest at both ends, {len(motion.sines)} harmonics"
        f", objective {found.objective}, best of {len(found.starts)} starts in {found.seconds:.1f} s",
        f"-log det of the information per parameter: {score.d:.3f} ({len(score.sigma)} base parameters)",
        f"geometric mean of their sigmas: {score.mean_sigma:.3g} (SI)",
        f"condition number of the scaled columns: {score.condition:.2f}",
        f"checked at {_check_rate(motion.duration)}: {clear}",
        *([found.column] if found.column else []),
        "",
        use_table(found).text(),
        "",
        sigma_table(found).text(),
    ]
    return "\n".join(lines)


def _check_rate(duration: float) -> str:
    rate = min(CHECK_RATE, MOST_CHECKS / duration)
    return "1 kHz" if rate == CHECK_RATE else f"{rate:.3g} Hz"


def use_table(found: Excitation) -> Table:
    """Range and use of the limits, joint by joint."""
    q = found.sampled().q
    rows = []
    for j, link in enumerate(found.arm.chain.links):
        factor, unit = (180.0 / np.pi, "deg") if link.kind is JointKind.REVOLUTE else (1.0, "m")
        low, high = factor * q[:, j].min(), factor * q[:, j].max()
        use = [_percent(x[j]) for x in (found.position_use, found.speed_use, found.torque_use)]
        rows.append((link.joint, f"{low:.4g} to {high:.4g} {unit}", *use))
    head = ("joint", "from, to", "position", "speed", "torque")
    return Table("Use of the arm's limits", head, rows, without_friction(found.arm))


def without_friction(arm: Arm) -> str:
    """What the torques leave out, in words; empty where every joint's friction is known."""
    models = zip(arm.joint_names, arm.friction_models(), strict=True)
    names = [name for name, model in models if model is None]
    of = "" if len(names) == arm.n else f" of {', '.join(names)}"
    return f"torques without friction{of}, which the arm's file does not give: keep room for it" if names else ""


def sigma_table(found: Excitation) -> Table:
    """What noise leaves of the base parameters, kind by kind, and the one of each kind that is known least."""
    sigma, own, names = found.score.sigma, np.abs(own_values(found)), found.score.names
    kinds = np.array([KINDS.get(name.split("_")[0], name.split("_")[0]) for name in names])
    rows = []
    for kind in dict.fromkeys(kinds.tolist()):
        of_kind = np.flatnonzero(kinds == kind)
        worst = of_kind[int(np.argmax(sigma[of_kind]))]
        rows.append((kind, len(of_kind), np.median(sigma[of_kind]), sigma[worst], names[worst], own[of_kind].max()))
    head = (
        Heading("base parameters"), Heading("number"), Heading("median sigma", "SI", ".2g"),
        Heading("largest", "SI", ".2g"), Heading("of"), Heading("largest in the table", "SI", ".2g"),
    )  # fmt: skip
    noise = ", ".join(f"{x:g}" for x in dict.fromkeys(found.noise.tolist()))
    title = f"Sigma from torque noise of {noise} N m, {SCORE_RATE:g} rows a second"
    return Table(title, head, rows, "--json has all of them")


def own_values(found: Excitation) -> Any:
    """The base parameters (b,) of the arm's own table and friction."""
    return found.columns.base().of(found.columns.own(found.arm))


def excitation_record(found: Excitation) -> dict[str, Any]:
    """The result as JSON values."""
    arm, motion, score = found.arm, found.motion, found.score
    rows = zip(score.names, found.columns.base().statements(), own_values(found), score.sigma, strict=True)
    uses = zip(arm.joint_names, found.position_use, found.speed_use, found.torque_use, strict=True)
    return {
        "robot": arm.name, "reading": arm.reading, "duration": motion.duration, "harmonics": len(motion.sines),
        "objective": found.objective, "d": score.d, "condition": score.condition, "mean_sigma": score.mean_sigma,
        "noise": found.noise, "clearance": found.clear, "check_rate": found.check_rate,
        "nearest": found.nearest, "seconds": found.seconds,
        "series": {"centre": motion.centre, "sines": motion.sines, "cosines": motion.cosines},
        "joints": [{"joint": j, "position": p, "speed": v, "torque": t} for j, p, v, t in uses],
        "parameters": [{"name": n, "combination": s, "table": own, "sigma": x} for n, s, own, x in rows],
        "starts": [{"value": one.value, "clearance": one.clear, "seconds": one.seconds} for one in found.starts],
    }  # fmt: skip


def _percent(share: float) -> str:
    return "unknown" if np.isnan(share) else f"{100.0 * share:.0f} %"
