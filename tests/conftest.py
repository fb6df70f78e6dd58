"""Hypothesis runs a seeded share of its examples here; `scripts/soak.py` runs the full counts."""

import os

from hypothesis import HealthCheck, settings

slow_machine = [HealthCheck.too_slow, HealthCheck.data_too_large]
settings.register_profile("ci", max_examples=25, deadline=None, derandomize=True, suppress_health_check=slow_machine)
settings.register_profile("soak", max_examples=2000, deadline=None, suppress_health_check=slow_machine)
settings.load_profile(os.environ.get("LWR_DYN_HYPOTHESIS", "ci"))
