"""Programs written from other data: a list of points, a run, a table of poses or axes.

motion_program  A sampled path -> a program of PTP, LIN and CIRC that follows it within a tolerance, with its `.dat`
path_fit        Motions of KRL that follow a sampled path within a tolerance, each as long as it can be; and how far a
                run is off
path_program    Writes a sampled path as a program, runs the program, and keeps what stays within the tolerance
point_program   A list of points -> a `.src` and `.dat` as a KUKA controller expects them, with Status and Turn from
                the model
sampled_path    A path that an arm has taken or shall take, as samples: from a run, a motion, or a table of poses or
                axes
"""
