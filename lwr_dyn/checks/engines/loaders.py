"""MuJoCo's, Drake's, PyBullet's and yourdfpy's reading of a file: each engine is imported where its model is made."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from lwr_dyn.checks.engines.engine import ArmInFile
from lwr_dyn.foundation.arrays import Array

STEP = 1e-5
"""[s] Length of PyBullet's step that shows how the model moves: rates are returned in double precision, and damping of
the whole step is of its order."""


class MujocoFile:
    """MuJoCo. From a URDF it merges fixed links; the tip is then found in a second, unmerged model.

    The option `whole` is the compiler's fusestatic="false".
    """

    def __init__(self, path: Path, scope: ArmInFile, options: Mapping[str, Any]) -> None:
        import mujoco

        self.mujoco = mujoco
        spec = mujoco.MjSpec.from_file(str(path))
        spec.compiler.fusestatic = False
        self.whole = spec.compile()
        self.model = self.whole if options.get("whole") else mujoco.MjModel.from_xml_path(str(path))
        self.data, self.whole_data = mujoco.MjData(self.model), mujoco.MjData(self.whole)
        # contacts and stops push too, and are not part of an arm's equation
        self.model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT | mujoco.mjtDisableBit.mjDSBL_LIMIT
        self.gravity, self.tip, self.scope = np.array(scope.gravity), scope.tip, scope
        self.joints = [self.model.joint(name) for name in scope.joints]
        self.dofs = [int(joint.dofadr[0]) for joint in self.joints]
        self.mass = float(self.model.body_mass.sum())

    def mass_matrix(self, q: Array) -> Array:
        """B, a column a unit acceleration."""
        self._at(q, 0.0, np.zeros(3))
        out, unit = np.zeros((len(q), self.model.nv)), np.zeros(self.model.nv)
        for row, dof in zip(out, self.dofs, strict=True):
            unit[:] = 0.0
            unit[dof] = 1.0
            self.mujoco.mj_mulM(self.model, self.data, row, unit)
        return out.T[self.dofs]

    def velocity_torque(self, q: Array, dq: Array) -> Array:
        """qfrc_bias without gravity."""
        self._at(q, dq, np.zeros(3))
        return np.array(self.data.qfrc_bias)[self.dofs]

    def gravity_torque(self, q: Array) -> Array:
        """qfrc_bias at rest."""
        self._at(q, 0.0, self.gravity)
        return np.array(self.data.qfrc_bias)[self.dofs]

    def torque(self, q: Array, dq: Array, ddq: Array) -> Array:
        """mj_inverse, which counts damping and dry friction (the latter as a soft constraint)."""
        self._at(q, dq, self.gravity)
        self.data.qacc[:] = 0.0
        self.data.qacc[self.dofs] = ddq
        self.mujoco.mj_inverse(self.model, self.data)
        return np.array(self.data.qfrc_inverse)[self.dofs]

    def flange(self, q: Array) -> Array:
        """Pose of the tip, by the unmerged model."""
        self._place(self.whole, self.whole_data, q)
        self.mujoco.mj_kinematics(self.whole, self.whole_data)
        body = self.whole_data.body(self.tip)
        pose = np.eye(4)
        pose[:3, :3], pose[:3, 3] = body.xmat.reshape(3, 3), body.xpos
        return pose

    def held(self) -> dict[str, Array]:
        """Ranges, damping, dry friction, and efforts of joints or of their motors; there is no speed limit."""
        m, ids = self.model, [joint.id for joint in self.joints]
        limited = m.jnt_limited[ids].astype(bool)
        effort = np.where(m.jnt_actfrclimited[ids].astype(bool), m.jnt_actfrcrange[ids, 1], np.inf)
        for k in range(m.nu):
            if m.actuator_ctrllimited[k] and int(m.actuator_trnid[k, 0]) in ids:
                effort[ids.index(int(m.actuator_trnid[k, 0]))] = m.actuator_ctrlrange[k, 1]
        return {
            "lower": np.where(limited, m.jnt_range[ids, 0], -np.inf),
            "upper": np.where(limited, m.jnt_range[ids, 1], np.inf),
            "effort": effort,
            "viscous": m.dof_damping[self.dofs],
            "coulomb": m.dof_frictionloss[self.dofs],
        }

    def links(self) -> list[str]:
        """Bodies that are left after merging."""
        return [self.model.body(k).name for k in range(self.model.nbody)]

    def _at(self, q: Array, dq: Array | float, gravity: Array) -> None:
        self.model.opt.gravity[:] = gravity
        self._place(self.model, self.data, q)
        self.data.qvel[:] = 0.0
        self.data.qvel[self.dofs] = dq
        self.mujoco.mj_forward(self.model, self.data)

    def _place(self, model: Any, data: Any, q: Array) -> None:
        for name, value in (*self.scope.held.items(), *zip(self.scope.joints, q, strict=True)):
            data.qpos[model.joint(name).qposadr[0]] = value


class DrakeFile:
    """Drake: a continuous plant with the model alone, its first link welded to the world; rotors are its actuators'."""

    def __init__(self, path: Path, scope: ArmInFile, options: Mapping[str, Any]) -> None:
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
        self._at(q)
        return np.array(self.plant.CalcMassMatrix(self.context))[np.ix_(self.dofs, self.dofs)]

    def velocity_torque(self, q: Array, dq: Array) -> Array:
        """C dq, without gravity."""
        self._at(q, dq)
        return np.array(self.plant.CalcBiasTerm(self.context))[self.dofs]

    def gravity_torque(self, q: Array) -> Array:
        """g."""
        self._at(q)
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
        self._at(q)
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

    def _at(self, q: Array, dq: Array | float = 0.0) -> None:
        positions: Any = self.rest.copy()
        rates: Any = np.zeros(self.plant.num_velocities())
        positions[self.places], rates[self.dofs] = q, dq
        self.plant.SetPositions(self.context, positions)
        self.plant.SetVelocities(self.context, rates)


class BulletFile:
    """PyBullet: one multibody in a client of its own, base fixed, inertia as written and not from the collision shapes.

    The option `still` turns off the default damping of 0.04 of every link.
    """

    def __init__(self, path: Path, scope: ArmInFile, options: Mapping[str, Any]) -> None:
        import pybullet

        self.bullet = pybullet
        self.client, self.gravity = self.bullet.connect(self.bullet.DIRECT), scope.gravity
        flags = self.bullet.URDF_USE_INERTIA_FROM_FILE
        self.body = self.bullet.loadURDF(str(path), useFixedBase=True, flags=flags, physicsClientId=self.client)
        joints = range(self.bullet.getNumJoints(self.body, self.client))
        self.infos = {k: self.bullet.getJointInfo(self.body, k, self.client) for k in joints}
        names = {info[1].decode(): k for k, info in self.infos.items()}
        links = {info[12].decode(): k for k, info in self.infos.items()}
        self.moving = [k for k, info in self.infos.items() if info[2] != self.bullet.JOINT_FIXED]
        self.at = [names[name] for name in scope.joints]
        self.dofs = [self.moving.index(k) for k in self.at]
        self.held_at = {names[name]: value for name, value in scope.held.items() if names[name] in self.moving}
        self.tip, self.names = links[scope.tip], list(links)
        self.mass = float(sum(self.bullet.getDynamicsInfo(self.body, k, self.client)[0] for k in (-1, *joints)))
        base = self.bullet.getDynamicsInfo(self.body, -1, self.client)
        centre = self.bullet.getBasePositionAndOrientation(self.body, self.client)
        self.root = _pose(*centre) @ np.linalg.inv(_pose(base[3], base[4]))
        if options.get("still"):
            none = {"linearDamping": 0.0, "angularDamping": 0.0, "physicsClientId": self.client}
            self.bullet.changeDynamics(self.body, -1, **none)
        self.names.append(self.bullet.getBodyInfo(self.body, self.client)[0].decode())

    def mass_matrix(self, q: Array) -> Array:
        """B."""
        matrix = self.bullet.calculateMassMatrix(self.body, self._whole(q), physicsClientId=self.client)
        return np.array(matrix)[np.ix_(self.dofs, self.dofs)]

    def velocity_torque(self, q: Array, dq: Array) -> Array:
        """C dq."""
        return self._inverse(q, dq, (0.0, 0.0, 0.0))

    def gravity_torque(self, q: Array) -> Array:
        """g."""
        return self._inverse(q, np.zeros_like(q), self.gravity)

    def torque(self, q: Array, dq: Array, ddq: Array) -> Array:
        """B (ddq - ddq0), where ddq0 is how the model moves in one step without torque; its default motors are off."""
        self.bullet.setGravity(*self.gravity, physicsClientId=self.client)
        self.bullet.setTimeStep(STEP, physicsClientId=self.client)
        off, none = self.bullet.VELOCITY_CONTROL, [0.0] * len(self.moving)
        self.bullet.setJointMotorControlArray(self.body, self.moving, off, forces=none, physicsClientId=self.client)
        rates, wanted = self._rates(dq), np.array(self._rates(ddq))
        for k, position, rate in zip(self.moving, self._whole(q), rates, strict=True):
            self.bullet.resetJointState(self.body, k, position, rate, physicsClientId=self.client)
        self.bullet.stepSimulation(physicsClientId=self.client)
        after = [x[1] for x in self.bullet.getJointStates(self.body, self.moving, physicsClientId=self.client)]
        free = (np.array(after) - np.array(rates)) / STEP
        matrix = self.bullet.calculateMassMatrix(self.body, self._whole(q), physicsClientId=self.client)
        return np.asarray((np.array(matrix) @ (wanted - free))[self.dofs])

    def flange(self, q: Array) -> Array:
        """Pose of the tip."""
        for k, value in zip(self.moving, self._whole(q), strict=True):
            self.bullet.resetJointState(self.body, k, value, physicsClientId=self.client)
        state = self.bullet.getLinkState(self.body, self.tip, computeForwardKinematics=1, physicsClientId=self.client)
        return np.asarray(np.linalg.inv(self.root) @ _pose(state[4], state[5]))

    def held(self) -> dict[str, Array]:
        """What getJointInfo lists; an upper limit below the lower one is none."""
        rows = [self.infos[k] for k in self.at]
        columns = {"lower": 8, "upper": 9, "velocity": 11, "effort": 10, "viscous": 6, "coulomb": 7}
        out = {name: np.array([float(row[i]) for row in rows]) for name, i in columns.items()}
        endless = out["lower"] >= out["upper"]
        out["lower"], out["upper"] = np.where(endless, -np.inf, out["lower"]), np.where(endless, np.inf, out["upper"])
        return out

    def links(self) -> list[str]:
        """All links."""
        return self.names

    def _inverse(self, q: Array, dq: Array, gravity: tuple[float, ...]) -> Array:
        self.bullet.setGravity(*gravity, physicsClientId=self.client)
        zero = [0.0] * len(self.moving)
        torque = self.bullet.calculateInverseDynamics(
            self.body, self._whole(q), self._rates(dq), zero, physicsClientId=self.client
        )
        return np.array(torque)[self.dofs]

    def _whole(self, q: Array) -> list[float]:
        places = self.held_at | dict(zip(self.at, map(float, q), strict=True))
        return [places.get(k, 0.0) for k in self.moving]

    def _rates(self, values: Array) -> list[float]:
        rates = dict(zip(self.at, map(float, values), strict=True))
        return [rates.get(k, 0.0) for k in self.moving]


def _pose(position: tuple[float, ...], quaternion: tuple[float, ...]) -> Array:
    from scipy.spatial.transform import Rotation

    pose = np.eye(4)
    pose[:3, :3] = Rotation.from_quat(quaternion).as_matrix()
    pose[:3, 3] = position
    return pose


class YourdfpyFile:
    """yourdfpy: the parsed file with its graph of frames, without meshes; it has no dynamics."""

    def __init__(self, path: Path, scope: ArmInFile, options: Mapping[str, Any]) -> None:
        import yourdfpy

        self.urdf = yourdfpy.URDF.load(str(path), build_scene_graph=True, load_meshes=False)
        self.scope = scope
        self.mass = float(sum(link.inertial.mass for link in self.urdf.robot.links if link.inertial is not None))

    def flange(self, q: Array) -> Array:
        """Pose of the tip in the base link."""
        places = dict(self.scope.held) | dict(zip(self.scope.joints, map(float, q), strict=True))
        known = self.urdf.actuated_joint_names
        self.urdf.update_cfg({name: value for name, value in places.items() if name in known})
        return np.array(self.urdf.get_transform(self.scope.tip, self.urdf.base_link))

    def held(self) -> dict[str, Array]:
        """Limits, damping and friction as parsed."""
        joints = [self.urdf.joint_map[name] for name in self.scope.joints]
        out = {}
        for name in ("lower", "upper", "velocity", "effort"):
            endless = ("continuous",) if name in ("lower", "upper") else ()
            values = [None if j.limit is None or j.type in endless else getattr(j.limit, name) for j in joints]
            none = -np.inf if name == "lower" else np.inf
            out[name] = np.array([none if value is None else float(value) for value in values])
        for name, theirs in (("viscous", "damping"), ("coulomb", "friction")):
            values = [None if j.dynamics is None else getattr(j.dynamics, theirs) for j in joints]
            out[name] = np.array([float(value or 0.0) for value in values])
        return out

    def links(self) -> list[str]:
        """All links."""
        return list(self.urdf.link_map)
