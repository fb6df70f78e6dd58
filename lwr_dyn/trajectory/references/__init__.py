"""References for the joints of an arm: moves in joint space, and paths of poses through inverse kinematics.

chosen_move          The task `move`: a move between two poses that are chosen inside the arm's own limits of
                     position, speed and torque
excitations          The tasks `step` and `chirp`: positions that a loop is asked for, of one joint or of each in turn
function_reference   A function q(t) as a reference: its speeds and accelerations are found, or given as functions, and
                     checked
ist                  The IST path of the LWR 4+ paper: its points as printed, the path through them, its timing; and
                     `ist-clear`
joint_moves          Moves in joint space: point to point by quintics, LSPB moves of all joints together, and standing
                     still
pose_path_reference  A reference for the joints from a timed pose path, the arm's inverse kinematics and an arm angle
position_limits      Position limits that a reference must keep: the largest violation, and the smallest distance from
                     one
recorded_motion      The task `csv`: a motion that a person brings, through its rows by a spline of degree 5 in time
references           References for the joints by name, as `simulate --task` takes them
time_derivatives     Derivatives of a function of time that a person brings: by complex step where it takes complex
                     numbers, else finite
"""
