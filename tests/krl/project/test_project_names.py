"""What a module sees, in random projects, against a second way to say it; and text that is broken."""

import random

from lwr_dyn.krl.checks.static_checks import check_project
from lwr_dyn.krl.language.source import parse_bytes
from lwr_dyn.krl.project.project import module_file, project_of
from tests.krl.mutations import SOURCES, mutated
from tests.krl.random_projects import disagreement, files_of, random_modules

COUNT, SEED = 120, 17
"""scripts/soak.py krl_projects tries more."""


def test_names_are_those_of_the_file_that_the_rule_says():
    rng = random.Random(SEED)
    assert [x for x in (disagreement(rng) for _ in range(COUNT)) if x is not None] == []


def test_an_editor_s_text_of_one_file_gives_the_same_project_as_reading_it():
    rng = random.Random(SEED)
    for _ in range(COUNT // 8):
        files = files_of(random_modules(rng))
        one = rng.choice(files)
        without = project_of([x for x in files if x is not one])
        edited = [check_project(x) for x in (without.with_source(one.file), project_of(files))]
        assert len({tuple((x.name, x.diagnostics) for x in files) for files in edited}) == 1


def test_broken_files_in_a_project_are_diagnosed():
    rng = random.Random(SEED)
    for _ in range(COUNT // 8):
        texts = {path.name: mutated(path.read_bytes(), rng) for source in SOURCES for path in with_data(source)}
        checked = check_project(project_of(module_file(*parse_bytes(text, name)) for name, text in texts.items()))
        assert sorted(x.name for x in checked) == sorted(texts)
        assert any(x.diagnostics for x in checked)


def with_data(source):
    """A `.src`, and its `.dat` if it has one."""
    return [x for x in (source, source.with_suffix(".dat")) if x.exists()]
