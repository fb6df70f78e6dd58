"""A fixture of several tests of kernels."""

import pytest


@pytest.fixture(scope="module")
def by_python():
    """Formulas are those of the text: batches of this module run it by Python, without a compiler."""
    from tests.codegen.kernels.plain_kernel import kernels_by_python  # where llvmlite is not there, its tests are skipped

    with kernels_by_python():
        yield
