"""Arm to URDF and SRDF with the source of every number, and foreign URDFs back to Arm.

elements           Elements of a URDF, each number with its source, and what all written files share: numbers,
                   comments, header
geometry           Default shapes of an arm without a drawing: cylinders along its joints
model_files        All files of an arm: URDF, SRDF with the rotors, MJCF, and the sidecar with the source of every
                   number
parse              URDF file -> parsed URDF by yourdfpy, after checks of our own, with one error that names the faulty
                   element
reader             Reads a foreign URDF as an Arm: the chain from root to tip, fixed links merged
tree               The link tree of a URDF: parents, fixed joints, path from root to tip, and the layout that an arm
                   keeps of it
writer             Arm -> URDF text, together with the source of every number in it
xacro_bounds       What a foreign xacro file may cost: loops, patterns and files of xacro within bounds
xacro_expressions  Expressions of xacro files, read node by node: none of a foreign file's code runs
xacro_files        A `.xacro` file is expanded to a URDF; the folders of its packages
"""
