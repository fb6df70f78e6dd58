"""mjbatch: all runs of the case at once, RK4, one thread; computed torque from a second, nominal batch.

python mjbatch_loop.py FOLDER RUNS
"""

import sys
from pathlib import Path

import mjbatch
import mujoco
import numpy as np
from turns import serve

folder, runs = Path(sys.argv[1]), int(sys.argv[2])
case = np.load(folder / "case.npz")
(kp, kd), h = case["gains"], 1.0 / float(case["rate"])


def batch(name: str) -> tuple[mujoco.MjModel, mjbatch.Batch]:
    """A batch without contacts, limits and other constraints."""
    model = mujoco.MjModel.from_xml_path(str(folder / f"{name}.xml"))
    model.opt.timestep, model.opt.integrator = h, mujoco.mjtIntegrator.mjINT_RK4
    model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONTACT) | int(mujoco.mjtDisableBit.mjDSBL_LIMIT)
    model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONSTRAINT)
    return model, mjbatch.Batch(model, runs, 1)


_, plant = batch("law")
for field in ("body_mass", "body_inertia", "body_ipos", "body_iquat"):
    plant.expand(field, np.float64)[:] = case[field][:runs]
plant.set_const()
model, law = batch("law")
q, dq, force = (plant.bind(name, np.float64) for name in ("qpos", "qvel", "qfrc_applied"))
law_q, law_dq, bias, packed = (law.bind(name, np.float64) for name in ("qpos", "qvel", "qfrc_bias", "M"))
rows = np.repeat(np.arange(model.nv), model.M_rownnz)
columns = np.array(model.M_colind)
B = np.zeros((runs, model.nv, model.nv))


def loop() -> np.ndarray:
    """The whole motion; the final positions (runs, n)."""
    plant.reset()
    q[:], dq[:] = case["q"][0], case["dq"][0]
    for q_ref, dq_ref, ddq_ref in zip(case["q"][:-1], case["dq"][:-1], case["ddq"][:-1], strict=True):
        law_q[:], law_dq[:] = q, dq
        law.forward()
        B[:, rows, columns] = packed
        B[:, columns, rows] = packed
        y = kp * (q_ref - q) + kd * (dq_ref - dq) + ddq_ref
        force[:] = np.einsum("nij,nj->ni", B, y) + bias
        plant.step()
    return np.array(q)


if __name__ == "__main__":
    serve(("mjbatch", "mujoco", "numpy"), loop, folder)
