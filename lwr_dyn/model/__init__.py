"""A robot's arm as numbers, in SI units.

arm                  `Arm`: one robot in SI units, with its chain in the source's frames and its joints and bodies in
                     URDF frames
caveats              What stands before an arm's numbers: proven errors that its reading leaves in place, numbers
                     estimated or assumed
chain                `Chain`: the serial arm in the frames of its source; both roads to the dynamics start from it
ellipsoid            The solid ellipsoid of one density that has a body's mass, centre of mass and inertia
file_layout          What a file holds beyond the arm in it: how it is drawn, and of a URDF its own links, frames,
                     axes and shapes
friction             Friction of one joint: Coulomb, viscous, static and Stribeck per direction, and an offset
inertial_parameters  The ten inertial parameters of a body as its pseudo-inertia, and in another frame
passivity            Passivity of friction: the speeds at which it adds energy instead of dissipating it, and the
                     nearest that never does
printed_number       A number as it is printed: its text, its value, and half a unit of its last digit
run                  Records of movement: `Motion` is a reference, `Run` a simulated result; a run file carries its
                     own metadata
run_formats          A run as the bytes of a file for other programs: CSV, Parquet (extra `logs`), MATLAB
spatial              Rotations, poses and inertia tensors as NumPy arrays, and 3-vectors and 3x3 matrices of any
                     scalar
transmission         The motor map dq_m = T dq of an arm, whose motors may drive several joints, and the springs of
                     its gears
"""
