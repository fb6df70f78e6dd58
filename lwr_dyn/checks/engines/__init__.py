"""What engines make of a model file, measured by loading it: Pinocchio, MuJoCo, Drake, PyBullet, yourdfpy.

engine         `ENGINES`, and what every loader returns; one module a loader
engine_prints  an engine's own prints kept off the terminal
child_process  loads files in a process of its own, so that an engine that aborts ends that process alone
features       what a URDF says that an engine may drop, each as a change of the file
reference      the torque that the file asks for, by our own recursion
losses         each feature taken out of the file: does the engine's result change as it should, and what restores it
agreement      mass, B, C dq, g and the flange in an engine against ours
candidates     the files and options that may restore what is lost
survey         one file, and its copies without a feature, in every engine
report         all of it for one model as tables
command        `lwr-dyn parity`
file_check     Pinocchio on a foreign file itself against our reading of it, for `lwr-dyn check`
"""
