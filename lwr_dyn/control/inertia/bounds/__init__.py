"""Proven bounds of the inertia seen at a joint, over the whole joint box.

bernstein    one joint's factor as control values: matrices in closed form
samples      B_ii as a table of values, from which control values on every box follow
branching    boxes halved until none can hold more than is known (numba)
certificate  certify: the proven upper bound beside the value that the search found
"""
