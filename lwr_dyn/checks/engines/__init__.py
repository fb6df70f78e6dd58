"""What engines make of a model file, measured by loading it: Pinocchio, MuJoCo, Drake, PyBullet, yourdfpy.

child_process     Loads files in a process of its own: an engine that aborts, crashes or hangs ends that process alone
drake_loader      Drake's reading of a file, the first link welded to the world; rotors come with its actuators
engine            The engines, what the loader of each returns, and the features of a URDF that an engine may drop or
                  misread
losses            What an engine loses of a file: each feature is taken out of the file, and the engine's result must
                  change as ours
mujoco_loader     MuJoCo's reading of a file. From a URDF it merges fixed links; the tip is then found in a second,
                  unmerged model
pinocchio_loader  Pinocchio's own reading of a file, through the only door to Pinocchio, and its agreement with ours
pybullet_loader   PyBullet's reading of a file: base fixed, inertia as written and not from the collision shapes
survey            One model file in every engine, as tables: how far each is from ours, what it loses, and what
                  restores it
yourdfpy_loader   yourdfpy's reading of a file: kinematics, limits and masses; it has no dynamics
"""
