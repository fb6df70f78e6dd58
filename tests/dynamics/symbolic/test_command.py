"""`lwr-dyn fk --symbolic` prints the DH matrices and the position by two routes."""

import numpy as np

import lwr_dyn
from lwr_dyn.model.chain import link_frames


def test_symbols_print(lwr_dyn_command):
    lines = lwr_dyn_command("fk", "lwr4", "--symbolic")[1].splitlines()
    costs = ["full product: 68 products, 31 sums", "vector route: 12 products, 5 sums"]
    (at,) = (k for k, line in enumerate(lines) if line == f"origin of frame 7 by {costs[0]}")
    assert lines[at + 1] == f"origin of frame 7 by {costs[1]}"
    q = np.array([0.3, -0.7, 0.5, 1.1, 0.2, -0.4, 0.9])
    names = {"sin": np.sin, "cos": np.cos, "L": 0.4, "M": 0.39, **{f"q{i + 1}": x for i, x in enumerate(q)}}
    *_, last, _ = link_frames(lwr_dyn.load("lwr4").chain, q)
    for k, axis in enumerate("xyz"):
        name, _, expression = lines[at + 2 + k].strip().partition(" = ")
        assert name == axis
        assert abs(eval(expression, names) - last[k, 3]) < 1e-12
