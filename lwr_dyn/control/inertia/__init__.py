"""The largest inertia seen at a joint over its box, and the proof that there is none larger.

worst_case   the largest inertia, by a global search; maxima along one joint, and local ones
bernstein    B_ii as control values over boxes of the joints, which bound it
certificate  the proven upper bound: boxes are halved until none can hold more
"""
