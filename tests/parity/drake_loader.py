"""Drake's reading of a file, the first link welded to the world; rotors come with its actuators."""

from pathlib import Path

import numpy as np
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant


class _Model:
    def __init__(self, path: Path, gravity: np.ndarray, tip: str) -> None:
        plant = self.plant = MultibodyPlant(0.0)
        parser = Parser(plant)
        parser.package_map().PopulateFromFolder(str(path.parent))
        (model,) = parser.AddModels(str(path))
        self.root = plant.get_body(plant.GetBodyIndices(model)[0])
        if path.suffix == ".urdf":  # an MJCF has it in its world
            plant.WeldFrames(plant.world_frame(), self.root.body_frame())
        plant.mutable_gravity_field().set_gravity_vector(gravity)
        plant.Finalize()
        self.context, self.tip = plant.CreateDefaultContext(), plant.GetBodyByName(tip)
        self.mass = sum(plant.get_body(i).default_mass() for i in plant.GetBodyIndices(model))
        self.actuators = plant.num_actuators()

    def mass_matrix(self, q):
        self._at(q, np.zeros_like(q))
        return self.plant.CalcMassMatrix(self.context)

    def velocity_torque(self, q, dq):
        self._at(q, dq)
        return self.plant.CalcBiasTerm(self.context)

    def gravity_torque(self, q):
        self._at(q, np.zeros_like(q))
        return -self.plant.CalcGravityGeneralizedForces(self.context)

    def flange(self, q):
        self._at(q, np.zeros_like(q))
        pose = self.plant.CalcRelativeTransform(self.context, self.root.body_frame(), self.tip.body_frame())
        return pose.GetAsMatrix4()

    def _at(self, q, dq):
        self.plant.SetPositions(self.context, q)
        self.plant.SetVelocities(self.context, dq)


def load(path: Path, gravity: np.ndarray, tip: str) -> _Model:
    return _Model(path, gravity, tip)
