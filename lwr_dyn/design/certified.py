"""The largest inertias with what is proven of them, where the package that proves it can be used."""

from collections.abc import Sequence
from typing import Any

from lwr_dyn.control.inertia.worst_case import InertiaMaximum
from lwr_dyn.foundation.errors import MissingPackageError, OptionError, needs_extra
from lwr_dyn.model.arm import Arm


def certificates(arm: Arm, maxima: Sequence[InertiaMaximum]) -> Sequence[Any] | None:
    """A proven bound for each maximum (`lwr_dyn.control.inertia.bounds.certificate.InertiaCertificate`).

    None without the extra `batch`, and for an arm with too many joints for it.
    """
    try:
        with needs_extra("batch"):
            from lwr_dyn.control.inertia.bounds.certificate import inertia_certificates
        found: Sequence[Any] = inertia_certificates(arm, maxima)
    except (MissingPackageError, OptionError):
        return None
    return found


def certified(arm: Arm, proven: Sequence[Any]) -> list[str]:
    """What is proven, in a line for all joints; one for each joint whose bound is not as near as asked."""
    closed = [x.gap for x in proven if x.holds]
    boxes = sum(x.boxes for x in proven)
    words = f"more than {max(closed):.1e} above these values" if closed else "above the bounds that follow"
    lines = [f"certified: nowhere in the joint box {words} ({boxes} boxes; rounding is in it)" + _but(proven, closed)]
    return [*lines, *(f"  {arm.joint_names[x.joint]}: {x.statement()}" for x in proven if not x.holds)]


def _but(proven: Sequence[Any], closed: Sequence[float]) -> str:
    return ", except:" if closed and len(closed) < len(proven) else ""
