"""The largest omega_n of each controller that keeps a stated margin, rigid and elastic, for the command `gains`."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from lwr_dyn.control.gains import Gains
from lwr_dyn.design.gain_search import TunedFrequency, largest_omega_n
from lwr_dyn.design.loop_case import LoopCase
from lwr_dyn.design.sampled_stability import pose_text
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.tables import Heading, Table
from lwr_dyn.model.arm import Arm

LAWS = ("pd-gravity", "pid", "inverse-dynamics")
OF_INERTIA = LAWS[:2]
"""Those whose gains are made of the largest inertias."""


@dataclass(frozen=True, slots=True, eq=False)
class MarginGains:
    """The frequencies found, by (controller, case in words)."""

    arm: Arm
    limit: float
    where: str
    found: Mapping[tuple[str, str], TunedFrequency]

    @property
    def table(self) -> Table:
        """One row a controller and case: omega_n, and where a larger one would break the margin."""
        title = (
            f"Largest omega_n with |S_ii| <= {self.limit:g}, {self.where}; linear and at rest, without friction and"
            " torque limits"
        )
        headings = ("controller", "plant", Heading("omega_n", "rad/s"), "stopped by")
        return Table(title, headings, [self._row(*key, each) for key, each in self.found.items()])

    def _row(self, controller: str, case: str, each: TunedFrequency) -> tuple[str, str, str, str]:
        pose = f"{self.arm.joint_names[each.joint]} at {pose_text(each.q, self.arm)}"
        if each.omega_n is None:
            return controller, case, "none", pose
        if each.at_most:
            return controller, case, f"over {each.omega_n:.4g}", "nothing that was tried"
        return controller, case, f"{each.omega_n:.1f}", pose

    def record(self) -> dict[str, Any]:
        """The table as JSON values."""
        rows = [{"controller": name, **each.to_json()} for (name, _), each in self.found.items()]
        return {"limit": self.limit, "where": self.where, "controllers": rows}


def margin_gains(
    arm: Arm, limit: float, cases: Sequence[LoopCase], gains: Gains, q: Array | None = None, **options: Any
) -> MarginGains:
    """The largest omega_n of each controller in each case, over the joint box or at the poses q (k, n).

    `gains` say of which largest inertias and damping ratio the controllers are made; `options` are those of
    `largest_omega_n`, which says what is raised.
    """
    inertia = gains.Kp / gains.omega_n**2
    found: dict[tuple[str, str], TunedFrequency] = {}
    for name in LAWS:
        own: dict[str, Any] = {"inertia": inertia} if name in OF_INERTIA else {}
        for case in cases:
            found[name, case.words] = largest_omega_n(arm, name, [case], q=q, peak=limit, xi=gains.xi, **own, **options)
    poses = max(each.poses for each in found.values())
    where = f"over the joint box ({poses} poses)" if q is None else f"at {poses} poses of the task"
    return MarginGains(arm, limit, where, found)
