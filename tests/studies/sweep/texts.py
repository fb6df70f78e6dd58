"""Texts of short studies, for tests."""

HEAD = """
robot = "lwr4plus"
reading = "physical"
controllers = ["inverse-dynamics", "robust:omega_n=20"]
[task]
name = "hold"
from-deg = [0, 30, 0, -60, 0, 30, 0]
duration = 0.5
"""
PAYLOAD = """
[[parameter]]
path = "payload.mass"
low = 0
high = 7
"""


def parameter(path, rest):
    return f'{HEAD}[[parameter]]\npath = "{path}"\n{rest}\n'
