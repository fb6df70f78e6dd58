"""A function of a batch by its name, derivatives as one array; what several tests of kernels call."""

import numpy as np

from lwr_dyn.codegen.kernel_spec import function_shape


def evaluated(batch, function, *states, **inputs):
    found = getattr(batch, function)(*states[: len(function_shape(function).states)], **inputs)
    if function.endswith("_derivatives"):
        last = found.by_ddq if function.startswith("inverse") else found.by_tau
        found = np.stack([found.by_q, found.by_dq, last], axis=1)
    return found


def states(n, count, seed=0):
    """q, dq, and ddq or tau, (count, n) each."""
    return np.random.default_rng(seed).uniform(-2.5, 2.5, (3, count, n))
