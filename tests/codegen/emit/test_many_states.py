"""A share of `scripts/soak.py emitted_states`: emitted C beside Pinocchio at random states."""

import pytest

from tests.codegen.emit.emitted_robots import ARMS
from tests.codegen.emit.many_states import COMPARED, SHARE, differences


@pytest.mark.slow
@pytest.mark.parametrize(("arm", "flags"), [
    (ARMS[0], ("-O0", "-std=c99")), (ARMS[2], ("-O1", "-march=native", "-ffp-contract=fast"))
])  # fmt: skip
def test_c_is_pinocchio_to_1e_14_of_the_largest_number(arm, flags, tmp_path):
    found = differences(arm, 500, tmp_path, *flags)
    assert set(found) == set(COMPARED)
    assert max(found.values()) < SHARE, found
    assert min(found.values()) > 0.0
