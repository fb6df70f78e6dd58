"""The controller's own variables while a program runs: frames, speeds, blends, inputs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from lwr_dyn.arrays import Array
from lwr_dyn.errors import MissingDataError, OptionError
from lwr_dyn.kinematics.kuka_pose import has_kuka_axes, status, turn
from lwr_dyn.krl.known import CONFIG, SYSTEM
from lwr_dyn.krl.planner import Blend, Speeds, tool_pose
from lwr_dyn.krl.settings import Settings
from lwr_dyn.krl.types import UNKNOWN
from lwr_dyn.krl.values import (
    HaltError,
    Many,
    Slot,
    Struct,
    Value,
    axes_value,
    filled,
    null_frame,
    pose_matrix,
    pose_value,
    struct,
)
from lwr_dyn.model.arm import Arm

INPUTS = ("$IN", "$ANIN", "$DIGIN1", "$DIGIN2", "$DIGIN3", "$DIGIN4", "$DIGIN5", "$DIGIN6", "$STOPMESS")
"""What the world sets: unknown unless given."""
AXES_SET, CP_SET = frozenset({"$VEL_AXIS"}), frozenset({"$VEL"})


@dataclass(slots=True, eq=False)
class Controller:
    """System variables, where the arm stands (q (n,) [rad], None before the first motion), inputs that are given."""

    arm: Arm
    settings: Settings
    given: Mapping[str, Value] = field(default_factory=dict)
    """`$IN[3]` -> value; names in capitals without spaces."""
    slots: dict[str, Slot] = field(default_factory=dict)
    q: Array | None = None
    speed_set: set[str] = field(default_factory=set)
    """Which speeds the program has set: "PTP", "CP"."""

    def __post_init__(self) -> None:
        if not has_kuka_axes(self.arm):
            raise OptionError("robot", self.arm.name, "an arm with KUKA's axes A1 to A6 (kr30ha)")
        if not np.isfinite(self.arm.velocity).all():
            raise MissingDataError(self.arm.name, "axis speeds", "the timing of motions")
        self.initialise()

    def initialise(self) -> None:
        """What the machine data say, which BAS(#INITMOV, 0) restores."""
        s = self.settings
        values: dict[str, Value] = {
            "$BASE": null_frame(), "$TOOL": null_frame(), "$NULLFRAME": null_frame(), "$WORLD": null_frame(),
            "$ROBROOT": null_frame(),
            "$VEL": struct("CP", CP=s.vel_cp, ORI1=s.vel_ori, ORI2=s.vel_ori),
            "$ACC": struct("CP", CP=s.acc_cp, ORI1=s.acc_ori, ORI2=s.acc_ori),
            "$VEL_AXIS": filled("INT", [100] * 6), "$ACC_AXIS": filled("INT", [100] * 6),
            "$APO": struct("APO_T", CDIS=0.0, CORI=0.0, CPTP=0.0, CVEL=0.0),
            "$OV_PRO": 100, "$ADVANCE": 3,
        }  # fmt: skip
        for name, value in values.items():
            self.slots[name] = Slot(SYSTEM[name], value)

    def slot(self, name: str) -> Slot | None:
        """A system variable or one of the standard `$config.dat`; None for another name."""
        key = name.upper()
        if key in ("$POS_ACT", "$POS_INT", "$POS_ACT_MES", "$AXIS_ACT", "$AXIS_INT", "$AXIS_ACT_MES"):
            return Slot(SYSTEM[key], self.position(key))
        if key not in self.slots and key in self.given:
            self.slots[key] = Slot(SYSTEM.get(key, UNKNOWN), self.given[key])
        if key not in self.slots and (key.startswith("$") or key in CONFIG):
            self.slots[key] = self._fresh(key)
        return self.slots.get(key)

    def _fresh(self, key: str) -> Slot:
        kind = SYSTEM.get(key) or CONFIG.get(key) or UNKNOWN
        if key.startswith("XHOME") or key == "$H_POS":
            return Slot(kind, axes_value(self.home()))
        if key in ("$FLAG", "$CYCFLAG", "$OUT", "$TIMER", "$TIMER_STOP"):
            return Slot(kind, Many(kind.name, ()))
        if key in ("$TRUE", "$FALSE"):
            return Slot(kind, key == "$TRUE")
        if key in ("PDAT_ACT", "PDEFAULT"):
            return Slot(kind, struct("PDAT", VEL=100.0, ACC=100.0, APO_DIST=100.0))
        if key in ("LDAT_ACT", "LDEFAULT"):
            return Slot(kind, struct("LDAT", VEL=2.0, ACC=100.0, APO_DIST=100.0))
        if key == "FDAT_ACT" or key.startswith("FHOME"):
            return Slot(kind, struct("FDAT", TOOL_NO=0, BASE_NO=0))
        return Slot(kind)

    def home(self) -> Array:
        """The mastering position (n,) [rad], which a fresh `$config.dat` has as home; raises `HaltError`."""
        if not self.arm.mastering:
            raise HaltError("no-value", "the home position is not known", "give XHOME a value")
        return np.array(self.arm.mastering)

    def element(self, name: str, index: tuple[int, ...]) -> Value | None:
        """An input's element, a flag's default; None for an ordinary variable; raises `HaltError` when unknown."""
        key = name.upper()
        text = f"{key}[{','.join(map(str, index))}]"
        if text in self.given:
            return self.given[text]
        if key == "$IN" and index == (1025,):
            return True
        if key == "$IN" and index == (1026,):
            return False
        if key in INPUTS:
            raise HaltError("unknown-input", f"the input {text} has no value", f"give one: --set '{text}=TRUE'")
        if key in ("$OUT", "$FLAG", "$CYCFLAG", "$TIMER_STOP", "$TIMER", "$ANOUT"):
            slot = self.slot(key)
            known = slot.value.items.get(index) if slot is not None and isinstance(slot.value, Many) else None
            default: Value = 0 if key in ("$TIMER", "$ANOUT") else False
            return default if known is None else known
        return None

    def position(self, key: str) -> Value | None:
        """`$POS_ACT` or `$AXIS_ACT`; before the first motion the arm is taken to stand at mastering."""
        q = self.home() if self.q is None else self.q
        if key.startswith("$AXIS"):
            return axes_value(q)
        T = np.linalg.inv(self.base) @ tool_pose(self.arm, q, self.tool)
        return pose_value(T, "E6POS", {"S": status(self.arm, q), "T": turn(q)})

    @property
    def base(self) -> Array:
        """(4, 4) [m]"""
        return pose_matrix(self.slots["$BASE"].value, "$BASE")

    @property
    def tool(self) -> Array:
        """(4, 4) [m]"""
        return pose_matrix(self.slots["$TOOL"].value, "$TOOL")

    def speeds(self) -> Speeds:
        """What holds now; raises `HaltError` for speeds that are not positive."""
        vel, acc = self._percents("$VEL_AXIS"), self._percents("$ACC_AXIS")
        override = self._between("$OV_PRO", self.slots["$OV_PRO"].value, 100.0) / 100.0
        rated = self.arm.velocity
        cp, ori = self._part("$VEL", "CP", 100.0), np.radians(self._part("$VEL", "ORI1", 1e5))
        cp_ramp, ori_ramp = self._part("$ACC", "CP", 1e3), np.radians(self._part("$ACC", "ORI1", 1e6))
        return Speeds(
            rated * vel * override, rated / self.settings.ramp * acc, cp * override, cp_ramp, ori * override, ori_ramp
        )

    def _percents(self, name: str) -> Array:
        values = self.slots[name].value
        assert isinstance(values, Many)
        return np.array([self._between(f"{name}[{i}]", values.items.get((i,)), 100.0) for i in range(1, 7)]) / 100.0

    def _part(self, name: str, part: str, most: float) -> float:
        whole = self.slots[name].value
        return self._between(f"{name}.{part}", whole.parts.get(part) if isinstance(whole, Struct) else None, most)

    @staticmethod
    def _between(what: str, value: Value | None, most: float) -> float:
        if isinstance(value, bool) or not isinstance(value, int | float) or not 1e-6 <= value <= most:
            raise HaltError("speed-range", f"{what} = {value}", f"more than 0, at most {most:g}")
        return float(value)

    def blend(self, kinds: tuple[str, ...]) -> Blend | None:
        """How a point may be passed with what `$APO` holds now; None without a word of it."""
        if not kinds:
            return None
        apo = self.slots["$APO"].value
        parts = apo.parts if isinstance(apo, Struct) else {}
        values = [
            float(x) if isinstance(x, int | float) else 0.0 for x in map(parts.get, ("CDIS", "CPTP", "CORI", "CVEL"))
        ]
        cdis, cptp, cori, cvel = (max(x, 0.0) for x in values)
        return Blend(kinds, cdis / 1e3, cptp, float(np.radians(cori)), cvel)

    def written(self, name: str) -> None:
        """Remember that a speed was set."""
        if name.upper() in AXES_SET:
            self.speed_set.add("PTP")
        if name.upper() in CP_SET:
            self.speed_set.add("CP")
