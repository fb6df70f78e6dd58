"""The small backup as an editor has it, anew for each test."""

import pytest

from lwr_dyn.krl.editor.edited_project import EditedProject
from tests.krl.small_backup import write_backup


@pytest.fixture
def project(tmp_path):
    return EditedProject(write_backup(tmp_path))
