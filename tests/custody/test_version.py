"""The version stands in `lwr_dyn/foundation/version.py`; the citation and the changelog follow it."""

import re
from pathlib import Path

import lwr_dyn
from lwr_dyn.foundation.version import VERSION

ROOT = Path(__file__).resolve().parents[2]


def test_the_citation_has_the_version():
    assert re.findall(r"^version: (.*)$", (ROOT / "CITATION.cff").read_text(encoding="utf-8"), re.M) == [VERSION]
    assert lwr_dyn.__version__ == VERSION
    assert re.fullmatch(r"\d+\.\d+\.\d+", VERSION)


def test_the_project_reads_its_version_from_there():
    project = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    assert 'version = { attr = "lwr_dyn.foundation.version.VERSION" }' in project
    assert not re.search(r"^version = \"", project, re.M)
