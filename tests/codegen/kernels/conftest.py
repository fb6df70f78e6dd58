"""A fixture of several tests of kernels."""

import pytest


@pytest.fixture(scope="module")
def by_python():
    """Formulas are those of the text: batches of this module run it by Python, without a compiler."""
    # not above: where llvmlite is not there, the tests of this folder are skipped one by one
    from tests.codegen.kernels.plain_kernel import kernels_by_python

    with kernels_by_python():
        yield
