"""Old names of options are answered with the new ones."""

import pytest

from lwr_dyn.cli.renamed import RENAMED
from tests.custody.test_help_text import SINGLE

ROWS = [(path, old, new) for path, names in RENAMED.items() for old, new in names.items() if path in SINGLE]


@pytest.mark.parametrize(("path", "old", "new"), ROWS)
def test_an_old_name_is_answered_with_the_new_one(path, old, new, lwr_dyn_command):
    """In one line, whatever else is given; the new name is one of the command."""
    for words in ((old, "2"), (f"{old}=2",)):
        assert lwr_dyn_command(*path.split(), *words, "x") == (2, "", f"lwr-dyn: {old} is now {new}\n")
    options = {name.strip("[]") for param in SINGLE[path].params for name in (*param.opts, param.human_readable_name)}
    assert old not in options
    assert new.split()[0].rstrip(",") in options or "ROBOT" in new.split()
    assert "ROBOT" in options or "ROBOT" not in new.split()


def test_a_name_that_never_was_is_no_old_one(lwr_dyn_command):
    for words in (("tune", "x", "--nonsense"), ("fk", "x", "--threads", "2")):
        assert lwr_dyn_command(*words)[2].startswith("lwr-dyn: No such option")
