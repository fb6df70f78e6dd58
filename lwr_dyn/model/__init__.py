"""A robot's arm as numbers, in SI units.

arm             Arm: chain, limits, ratings, friction, and the source of every number; arms with a payload
chain           Chain, ChainLink, Body, Rotor: the serial arm in the frames of its source; DH rows, mount and tool
spatial         Pose, rotations, inertia tensors; Vector, Matrix3 of any scalar, for the recursion
transmission    the motor map dq_m = T dq, and the springs of the gears
friction        friction per direction, set-valued or smoothed at rest
passivity       speeds at which a friction model adds energy, and the nearest that does not
file_layout     how an arm is drawn, and what its URDF file holds beyond it
run             Motion, Reference, Run: records of movement
printed_number  a number as it is printed, with half a unit of its last digit
"""
