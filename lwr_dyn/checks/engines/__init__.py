"""What engines make of a model file, measured by loading it: Pinocchio, MuJoCo, Drake, PyBullet, yourdfpy.

child_process     Loads files in a process of its own: an engine that aborts, crashes or hangs ends that process alone
engine            The engines, what the model of each computes, and the features of a URDF that an engine may drop or
                  misread
loaders           MuJoCo's, Drake's, PyBullet's and yourdfpy's reading of a file: each engine is imported where its
                  model is made
losses            What an engine loses of a file: each feature is taken out of the file, and the engine's result must
                  change as ours
pinocchio_loader  Pinocchio's own reading of a file, through the only door to Pinocchio, and its agreement with ours
survey            One model file in every engine, as tables: how far each is from ours, what it loses, and what
                  restores it
"""
