"""The largest inertia seen at a joint over its box, and the proof that there is none larger.

bernstein    B_ii as control values on boxes of the joints: a convex combination of them gives the function, so they
             bound it
certificate  The proven upper bound of B_ii over the joint box: boxes are halved until none can hold more than what is
             known
worst_case   The largest inertia seen at a joint: the maximum of B_ii(q) over the joint box, by a global search
"""
