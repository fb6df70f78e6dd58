"""A table judged by a log: chi squared."""

import numpy as np
import pytest

from lwr_dyn.identification.slips.hypotheses import as_printed, log_evidence
from tests.identification.slip_study import single_faults


def test_chi2_is_that_of_the_log_with_friction_at_its_best(study):
    rng = np.random.default_rng(3)
    information = study.log(0.0, rng)
    fault = single_faults(study.table)[40]
    evidence = log_evidence(information, fault.table, 0.0)
    columns, base, R = information.columns, information.base, information.factor
    own = [*range(70), *columns.rotor_indices]
    others = np.setdiff1d(np.arange(columns.count), own)
    away = R @ (base.grouping[:, own] @ fault.table.parameters() - information.values)
    friction = np.linalg.lstsq(R @ base.grouping[:, others], -away, rcond=None)[0]
    left = away + R @ base.grouping[:, others] @ friction
    assert as_printed(evidence, fault.table).chi2 == pytest.approx(left @ left, rel=1e-7)
    assert evidence.directions == 48  # bodies with rotors: 69 with viscous, Coulomb and offset
