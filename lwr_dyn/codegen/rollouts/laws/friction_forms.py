"""Kernel forms of what stands around a law: friction compensation on the reference or on the measured speed."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from lwr_dyn.codegen.kernels.parameters import FRICTION
from lwr_dyn.codegen.rollouts.laws.protocol import Column, LawForm, LawInputs
from lwr_dyn.codegen.rollouts.smooth_friction import friction_column, friction_models, friction_table
from lwr_dyn.codegen.rollouts.symbolic_model import SymbolicModel
from lwr_dyn.control.laws.friction_compensation import FrictionCompensation
from lwr_dyn.control.protocol import Controller
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.model.arm import Arm


@dataclass(frozen=True, slots=True, eq=False)
class FrictionForm:
    """tau = inner's + tau_f(dq_ref), or tau_f(dq): `feedback.friction_compensation`."""

    law: FrictionCompensation
    inner: LawForm

    @classmethod
    def of(cls, law: FrictionCompensation, inner: LawForm) -> "FrictionForm":
        """The form of a wrapper around a law of this form; raises `OptionError` for a Stribeck curve."""
        friction_table(law.models)
        return cls(law, inner)

    @property
    def name(self) -> str:
        """The controller's name."""
        return f"{self.inner.name}+{self.law.word}"

    @property
    def memory(self) -> int:
        """The inner law's."""
        return self.inner.memory

    @property
    def parameters(self) -> Mapping[str, tuple[int, ...]]:
        """The inner law's, the friction that the law knows (5, n), and the width of its tanh [rad/s or m/s]."""
        shape = (len(FRICTION), len(self.law.models))
        return {**self.inner.parameters, "law_friction": shape, "law_friction_width": ()}

    @property
    def digest(self) -> str:
        """The inner law's, and the variant."""
        return f"{self.inner.digest} + {self.law.word}"

    def values(self) -> Mapping[str, Array]:
        """The inner law's and the wrapper's own."""
        own = {"law_friction": friction_table(self.law.models), "law_friction_width": np.array(self.law.width)}
        return {**self.inner.values(), **own}

    def start(self) -> Array:
        """The inner law's."""
        return self.inner.start()

    def torque(self, model: SymbolicModel, x: LawInputs) -> tuple[Column, Column]:
        """See `LawForm`."""
        tau, memory = self.inner.torque(model, x)
        speed = x.dq if self.law.measured else x.dq_ref
        return tau + friction_column(speed, x.parameters["law_friction"], x.parameters["law_friction_width"]), memory

    def __getattr__(self, name: str) -> Any:
        if name != "signals":  # those of the inner law, where it has any
            raise AttributeError(name)
        return getattr(self.inner, name)

    def controller(self, arm: Arm, values: Mapping[str, Array]) -> Controller:
        """See `LawForm`."""
        models = friction_models(values["law_friction"])
        inner = self.inner.controller(arm, values)
        return FrictionCompensation(inner, models, float(values["law_friction_width"]), self.law.measured)
