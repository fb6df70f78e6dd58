"""Helpers of several tests of kernels: a function of a batch by its name, derivatives as one array."""

import numpy as np

from lwr_dyn.codegen.kernels.kernel_spec import function_shape


def evaluated(batch, function, *states, **inputs):
    result = getattr(batch, function)(*states[: len(function_shape(function).states)], **inputs)
    if function.endswith("_derivatives"):
        last = result.by_ddq if function.startswith("inverse") else result.by_tau
        result = np.stack([result.by_q, result.by_dq, last], axis=1)
    return result


def states(n, count, seed=0):
    """q, dq, and ddq or tau, (count, n) each."""
    return np.random.default_rng(seed).uniform(-2.5, 2.5, (3, count, n))


def straight_line_values(code, *rows):
    """The results of straight-line code without rarer operations, number by number."""
    apply = {"+": lambda a, b: a + b, "-": lambda a, b: a - b, "*": lambda a, b: a * b, "/": lambda a, b: a / b}
    values = []
    for node in code.nodes:
        if node.op == "in":
            values.append(rows[node.a][node.b])
        elif node.op in ("const", "zero"):
            values.append(node.a)
        else:
            values.append(apply[node.op](values[node.a], values[node.b]))
    return np.array([value.sign * values[value.node] for value in code.results])
