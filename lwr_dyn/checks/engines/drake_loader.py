"""Drake's reading of a file, the first link welded to the world; rotors come with its actuators."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from lwr_dyn.checks.engines.engine import ArmInFile
from lwr_dyn.foundation.arrays import Array


class DrakeFile:
    """A continuous plant with the model alone."""

    def __init__(self, path: Path, scope: ArmInFile) -> None:
        from pydrake.multibody.parsing import Parser
        from pydrake.multibody.plant import MultibodyPlant

        plant = self.plant = MultibodyPlant(0.0)
        parser = Parser(plant)
        parser.package_map().PopulateFromFolder(path.parent)
        (model,) = parser.AddModels(path)
        bodies = plant.GetBodyIndices(model)
        self.root = plant.get_body(bodies[0])
        if path.suffix == ".urdf":  # an MJCF has it in its world
            children = {plant.get_joint(k).child_body().index() for k in plant.GetJointIndices(model)}
            free = [k for k in bodies if k not in children]  # none where the file's root is called world
            self.root = plant.get_body(free[0]) if free else plant.world_body()
            if self.root.index() != plant.world_body().index():
                plant.WeldFrames(plant.world_frame(), self.root.body_frame())
        plant.mutable_gravity_field().set_gravity_vector(np.array(scope.gravity))
        plant.Finalize()
        self.context, self.tip = plant.CreateDefaultContext(), plant.GetBodyByName(scope.tip)
        self.bodies = [plant.get_body(k) for k in bodies]
        self.mass = float(sum(body.default_mass() for body in self.bodies))
        self.joints = [plant.GetJointByName(name) for name in scope.joints]
        self.places = [joint.position_start() for joint in self.joints]
        self.dofs = [joint.velocity_start() for joint in self.joints]
        self.actuators = {plant.get_joint_actuator(k).joint().name(): k for k in plant.GetJointActuatorIndices()}
        self.rest = np.array(plant.GetPositions(self.context))
        for name, value in scope.held.items():
            self.rest[plant.GetJointByName(name).position_start()] = value

    def mass_matrix(self, q: Array) -> Array:
        """B with the rotors' reflected inertia."""
        self._at(q, np.zeros_like(q))
        return np.array(self.plant.CalcMassMatrix(self.context))[np.ix_(self.dofs, self.dofs)]

    def velocity_torque(self, q: Array, dq: Array) -> Array:
        """C dq, without gravity."""
        self._at(q, dq)
        return np.array(self.plant.CalcBiasTerm(self.context))[self.dofs]

    def gravity_torque(self, q: Array) -> Array:
        """g."""
        self._at(q, np.zeros_like(q))
        return -np.array(self.plant.CalcGravityGeneralizedForces(self.context))[self.dofs]

    def torque(self, q: Array, dq: Array, ddq: Array) -> Array:
        """B (ddq - ddq0), where ddq0 is how the plant moves without torque: damping counts there.

        NaN where Drake cannot say, since a joint moves no inertia.
        """
        self._at(q, dq)
        nv = self.plant.num_velocities()
        self.plant.get_actuation_input_port().FixValue(self.context, np.zeros(self.plant.num_actuated_dofs()))
        try:
            free = self.plant.EvalTimeDerivatives(self.context).get_generalized_velocity().CopyToVector()
        except RuntimeError:
            return np.full(len(q), np.nan)
        wanted = np.zeros(nv)
        wanted[self.dofs] = ddq
        return np.array(self.plant.CalcMassMatrix(self.context) @ (wanted - free))[self.dofs]

    def flange(self, q: Array) -> Array:
        """Pose of the tip."""
        self._at(q, np.zeros_like(q))
        pose = self.plant.CalcRelativeTransform(self.context, self.root.body_frame(), self.tip.body_frame())
        return np.array(pose.GetAsMatrix4())

    def held(self) -> dict[str, Array]:
        """Limits and damping of joints, efforts of actuators; there is no dry friction."""
        names = {"lower": "position_lower_limits", "upper": "position_upper_limits"}
        names |= {"velocity": "velocity_upper_limits", "viscous": "default_damping_vector"}
        out = {x: np.array([float(getattr(j, theirs)()[0]) for j in self.joints]) for x, theirs in names.items()}
        actuators = [self.actuators.get(joint.name()) for joint in self.joints]
        found = [None if k is None else self.plant.get_joint_actuator(k) for k in actuators]
        return out | {"effort": np.array([np.inf if x is None else x.effort_limit() for x in found])}

    def links(self) -> list[str]:
        """All bodies."""
        return [body.name() for body in self.bodies]

    def _at(self, q: Array, dq: Array) -> None:
        positions: Any = self.rest.copy()
        rates: Any = np.zeros(self.plant.num_velocities())
        positions[self.places], rates[self.dofs] = q, dq
        self.plant.SetPositions(self.context, positions)
        self.plant.SetVelocities(self.context, rates)


def load(path: Path, scope: ArmInFile, options: Mapping[str, Any]) -> DrakeFile:
    """The file; there are no options."""
    return DrakeFile(path, scope)
