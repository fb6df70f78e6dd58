"""Runs that look like an arm at work, without a simulation."""

import numpy as np

from lwr_dyn.model.run import Event, Run

AMPLITUDES = np.array([0.5, 0.35, 0.3, 0.5, 0.4, 0.3, 0.6])
MIDDLE = np.array([-0.9, 0.7, 0.3, 1.2, -0.4, -0.6, 0.2])


def lagging_run(arm, lag: float, controller: str, k: int = 3001, duration: float = 6.0) -> Run:
    """A smooth wave of all joints, followed `lag` seconds late."""
    t = np.linspace(0.0, duration, k)
    n = arm.n

    def wave(times):
        phase = np.outer(times, 0.6 + 0.15 * np.arange(n)) + 0.4 * np.arange(n)
        speed = 0.6 + 0.15 * np.arange(n)
        return MIDDLE[:n] + AMPLITUDES[:n] * np.sin(phase), AMPLITUDES[:n] * speed * np.cos(phase)

    q_ref, dq_ref = wave(t)
    q, dq = wave(t - lag * (1.0 - np.exp(-3.0 * t)))
    tau = 40.0 * (q_ref - q) + 5.0 * np.cos(q)
    meta = {"robot": arm.name, "reading": arm.reading, "controller": controller, "task": "wave"}
    still = np.zeros_like(q)
    events = (Event(2.5, "torque limit", 1),)
    return Run(t, q, dq, q_ref, dq_ref, tau, tau, still, np.zeros(k), {"motor": np.zeros(k)}, events, meta)
