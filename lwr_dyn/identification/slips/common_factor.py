"""One factor on all bodies of an arm: what a log shows when the arm is heavier than its table, or the torques are off.

No cell is wrong then. A search for slips would still blame the cell that bends the table the right way.
"""

import numpy as np

from lwr_dyn.identification.slips.hypotheses import Hypothesis
from lwr_dyn.identification.slips.log_evidence import LogEvidence
from lwr_dyn.identification.slips.printed_cells import MASS, TENSOR

LARGEST = 3.0
"""Factor, or its inverse, beyond which it is a unit, which is a slip."""


def common_factor(evidence: LogEvidence, printed: Hypothesis) -> float | None:
    """The factor of all masses and tensors with which the table as printed meets a log; None where none does.

    To first order in the discrepancy, which is taken at the table as printed.
    """
    table = printed.table
    values = table.values.copy()
    values[:, MASS] *= 2.0
    values[:, TENSOR] *= 2.0
    L = np.linalg.cholesky(np.eye(evidence.directions) + printed.parts.sum(axis=0))
    left = np.linalg.solve(L, evidence.misfit(table))
    change = np.linalg.solve(L, evidence.misfit(table.with_values(values))) - left  # of one table more
    best = -float(change @ left) / float(change @ change)
    factor, chi2 = 1.0 + best, float(np.square(left + best * change).sum())
    if not 1.0 / LARGEST < factor < LARGEST or chi2 > evidence.limit(1):
        return None
    return factor
