"""The runner of pages sees what is wrong, and writes what is right."""

import pytest

from tests.docs.blocks import Block, PageError, blocks, check_marks, matches, updated
from tests.docs.console import run_page


def ran(text, folder, **options):
    """A page, run in a fresh folder."""
    place = folder / "page"
    place.mkdir()
    return run_page(text, place, **options)


def command_of(*output):
    """A command with this promised output."""
    return Block("console", "", ["$ x", *output], 2).commands()[0]


SHOWN = "dB/dt - C - C^T      6.25e-16  at most  1e-12"


@pytest.mark.parametrize(
    ("promised", "actual", "right"),
    [
        ("a", "a", True), ("a", "b", False), ("a", "a|b", False), ("a|b", "a", False), ("", "a", False),
        ("took ... s", "took 0.3 s", True), ("took ... s", "took 0.3 m", False), ("a|...|d", "a|b|c|d", True),
        ("a|...|d", "a|d", True), ("a|...|d", "a|d|e", False), ("...|d|e", "d|x|d|e", True), ("x|...", "y", False),
        ("(x+1)*", "(x+1)*", True), ("a.c", "abc", False),
        # numbers of the size of rounding errors match each other only
        (SHOWN, "dB/dt - C - C^T      1e-15     at most  1e-12", True), (SHOWN, SHOWN.replace("-16", "-06"), False),
        (SHOWN, SHOWN.replace("-12", "-02"), False), ("drift 0.25", "drift 1e-15", False),
    ],
)  # fmt: skip
def test_output_is_held_against_what_is_promised(promised, actual, right):
    assert matches(promised.split("|") if promised else [], actual.split("|")) is right


@pytest.mark.parametrize(
    ("good", "bad", "words"),
    [
        (["a", "b", "c", "..."], ["a", "b", "..."], "1 of 3 output lines are `...`; allowed: a quarter"),
        (["written in ... s"], ["in ... s"], "says too little"),
    ],
)
def test_a_quarter_of_the_lines_may_be_left_out_and_a_line_says_more_than_a_mark(good, bad, words):
    check_marks(command_of(*good))
    with pytest.raises(PageError, match=words):
        check_marks(command_of(*bad))


@pytest.mark.parametrize(
    ("promised", "actual", "shown"),
    [
        (["a"], ["b", "c"], ["b", "c"]),
        (["a", "...", "d"], ["a", "b", "c", "d"], ["a", "...", "d"]),
        (["a", "...", "x"], ["a", "b"], ["a", "b"]),
        (["a", "..."], ["a", "b"], ["a", "..."]),
        (["a", "..."], ["new", "b"], ["new", "b"]),
        (["took ... s", "old"], ["took 3 s", "new"], ["took ... s", "new"]),
    ],
)
def test_update_keeps_marks_where_they_match(promised, actual, shown):
    assert updated(promised, actual) == shown


PAGE = """
Text.

```toml file=parts/a.toml
x = 1
```

1. A list:

   ```console
   $ cat parts/a.toml
   x = 1
   $ echo one \\
     two; exit 3
   one two
   [3]

   $ echo to stderr >&2; pwd | sed 's:.*/::'
   to stderr
   page
   ```

```python
n = 2
```

```pycon
>>> n + 1
3
```

````markdown
```console
$ a block inside a block is text
```
````

```console no-run installs packages: shown, not run
$ pip install lwr_dyn
```
"""


def test_a_page_runs_in_one_folder_with_its_files_and_update_writes_the_real_output_only(tmp_path):
    assert ran(PAGE, tmp_path) == PAGE
    assert (tmp_path / "page" / "parts" / "a.toml").read_text() == "x = 1\n"
    assert [block.reason for block in blocks(PAGE) if block.reason] == ["installs packages: shown, not run"]
    wrong = PAGE.replace("   x = 1\n   $", "   y = 1\n   z\n   $").replace("   [3]\n", "")
    wrong = wrong.replace("to stderr\n   page", "page")
    assert wrong != PAGE
    assert ran(wrong, tmp_path / "page", update=True) == PAGE


@pytest.mark.parametrize(
    ("right", "wrong", "reason"),
    [
        ("   x = 1\n   $", "   x = 2\n   $", "line 11"),
        ("[3]", "[2]", "exit code 3, the page says 2"),
        ("   [3]\n", "", "exit code 3, the page says 0"),
        ("n + 1\n3", "n + 1\n4", "line 28"),
        ("n = 2", "n = missing", "missing"),
        ("installs packages: shown, not run", "", "without a reason"),
        ("parts/a.toml\nx", "../a.toml\nx", "outside the page's folder"),
        ("   $ cat parts", "   cat\n   $ cat parts", "output before the first"),
        ("pip install lwr_dyn\n```", "pip install lwr_dyn", "not closed"),
    ],
)
def test_a_page_that_is_not_true_is_seen(right, wrong, reason, tmp_path):
    assert right in PAGE
    with pytest.raises((PageError, NameError), match=reason):
        ran(PAGE.replace(right, wrong), tmp_path)


@pytest.mark.slow
def test_the_command_is_that_of_the_working_tree(tmp_path):
    python = """python -c 'import lwr_dyn, os; print(os.path.dirname(lwr_dyn.__file__) == os.environ["PWD"])'"""
    shown = "$ lwr-dyn --version\nlwr-dyn, version ...\n$ lwr-dyn chek 2>&1 | cut -c 1-8\nlwr-dyn:\n[2]\n"
    ran(f"```console\n{shown}$ {python}\nFalse\n```\n", tmp_path)


@pytest.mark.parametrize("command", ["seq 1000000 | head -1", "sh -c 'echo 1; exit 141' | head -1"])
def test_a_pipe_that_head_closes_is_no_fault(tmp_path, command):
    page = f"```console\n$ {command}\n1\n```\n"
    assert ran(page, tmp_path) == page


def test_an_example_that_warns_or_writes_elsewhere_and_a_closed_pipe_are_seen(tmp_path):
    warns = "```python file=a.py\nimport warnings\nwarnings.warn('so')\n```\n```console\n$ python a.py\n```\n"
    with pytest.raises(PageError, match="UserWarning: so"):
        ran(warns, tmp_path)
    with pytest.raises(PageError, match="elsewhere"):
        ran("```console\n$ touch x; # python scripts/examples/x.py\n```\n", tmp_path / "page")
    with pytest.raises(PageError, match="exit code 141"):  # a closed pipe without `head`
        ran("```console\n$ sh -c 'echo 1; exit 141' | cat\n1\n```\n", tmp_path / "page" / "page")
