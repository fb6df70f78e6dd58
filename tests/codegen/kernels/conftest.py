"""A fixture of several tests of kernels."""

import pytest

from tests.codegen.kernels.plain_kernel import kernels_by_python


@pytest.fixture(scope="module")
def by_python():
    """Formulas are those of the text: batches of this module run it by Python, without a compiler."""
    with kernels_by_python():
        yield
