"""A robot's arm as numbers, in SI units.

arm           Arm: chain, limits, drawing, ratings, friction, and the source of every number
chain         Chain, ChainLink, Body, Rotor: the serial arm in the frames of its source
dh            DH rows in both conventions
spatial       Pose, rotations, inertia tensors
vectors       Vector, Matrix3 of any scalar, for the recursion
transmission  the motor map dq_m = T dq
file_layout   what a URDF file holds beyond the arm, so that it can be written again
written_link  the links of a URDF file one by one
feasibility   whether a body can have its inertia
friction      friction per direction, set-valued or smoothed at rest
run           Motion, Reference, Run: records of movement
shown         how results show themselves, and the other files of a run
"""
