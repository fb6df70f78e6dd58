"""One server for the tests of its answers: a small backup with one program open."""

import pytest

from tests.krl.language_client import LanguageClient
from tests.krl.small_backup import FILES, MAIN, write_backup


@pytest.fixture(scope="package")
def backup(tmp_path_factory):
    return write_backup(tmp_path_factory.mktemp("backup").resolve())


@pytest.fixture(scope="package")
def client(backup):
    with LanguageClient(backup) as client:
        client.open(backup / MAIN, FILES[MAIN])
        assert client.diagnostics(backup / MAIN)[1] == []
        yield client


@pytest.fixture
def edited(client, backup):
    """Another text of the program for one test: a function that takes it and gives the diagnoses."""

    def edit(text):
        client.change(backup / MAIN, text)
        return client.diagnostics(backup / MAIN)[1]

    yield edit
    assert edit(FILES[MAIN]) == []
