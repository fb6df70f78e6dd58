"""What engines make of a model file, measured by loading it: Pinocchio, MuJoCo, Drake, PyBullet, yourdfpy.

survey         one file, and its copies without a feature, in every engine; its tables
losses         each feature taken out of the file: does the result change as ours, and what restores it
engine         `ENGINES`, what every loader returns, and the features that an engine may drop
child_process  loads files in a process of its own, its prints kept off the terminal
ENGINE_loader  an engine's reading of a file; Pinocchio's also as verdicts for `lwr-dyn check`
"""
