"""Random edits of a backup in an editor: whatever was edited and closed, answers are those of a fresh project."""

import contextlib
import random

from lwr_dyn.krl.editor.calls import open_call
from lwr_dyn.krl.editor.coloring import colored
from lwr_dyn.krl.editor.completions import completions
from lwr_dyn.krl.editor.edited_project import EditedProject
from lwr_dyn.krl.editor.outlines import folds_of, outline_items
from lwr_dyn.krl.editor.quick_fixes import quick_fix
from lwr_dyn.krl.editor.referents import hover_text, line_context, name_column
from lwr_dyn.krl.editor.renaming import KeptNameError, renamable, renamed
from lwr_dyn.krl.editor.signal_hints import signal_hints
from tests.krl.mutations import mutated
from tests.krl.small_backup import FILES, write_backup


def edits_agree(folder, seed, steps):
    """Number of diagnoses compared; a project that was edited says what one says that reads the same texts anew."""
    rng = random.Random(seed)
    project, names, compared = EditedProject(write_backup(folder)), sorted(FILES), 0
    for _ in range(steps):
        name = rng.choice(names)
        if rng.random() < 0.2:
            project.close(name)
        else:
            text = project.texts.get(name, FILES[name]).encode("latin-1")
            project.set_text(name, mutated(text, rng).decode("latin-1"))
        fresh = EditedProject(folder, texts=dict(project.texts))
        for each in names:
            found = project.diagnostics(each)
            assert found == fresh.diagnostics(each), (seed, each, project.texts)
            compared += sum(map(len, found.values()))
        assert_answers(project, name, rng)
    return compared


def assert_answers(project, name, rng, places=20):
    """Outline and folds lie in the file, and each name is among the uses of what it means; nothing raises."""
    file = project.project.file(name)
    last = max(len(file.file.lines) - 1, 0)
    assert_inside(outline_items(file.file, file.outline), 0, last)
    assert all(0 <= x.first < x.last <= last for x in folds_of(file.file, file.outline))
    program = project.program(name)
    for i, column, length, _, _ in colored(program, file):
        assert 0 <= column < column + length <= len(file.file.lines[i].shown)
    assert all(0 < column <= len(file.file.lines[i].shown) for i, column, _ in signal_hints(program, file, 0, last))
    for found in project.diagnostics(name)[name]:
        assert_fix(file.file, found)
    for _ in range(places):
        line = rng.randrange(last + 2)
        if file.file.lines and line <= last:
            assert_help(project, name, line, rng.randrange(len(file.file.lines[line].shown) + 1))
        found = project.at(name, line, rng.randint(1, 40))
        if found is not None:
            context, token, referent = found
            assert hover_text(context, referent).startswith("```krl")
            assert file.file.position(line, name_column(token)) in project.uses(referent)


def assert_fix(file, diagnostic):
    """A quick fix replaces a word of its line."""
    line = diagnostic.position.line - 1
    text = file.lines[line].shown if line < len(file.lines) else ""
    fix = quick_fix(text, diagnostic)
    assert fix is None or 0 <= fix[0] < fix[1] <= len(text)


def assert_help(project, name, line, column):
    """Help at a place begins in front of it; a rename is made or refused; nothing else raises."""
    context = line_context(project.program(name), project.project.file(name), line)
    start, found = completions(context, column)
    assert 0 <= start <= column
    assert len({x.text.upper() for x in found}) == len(found)
    call = open_call(context, column)
    assert call is None or call.at >= 0
    with contextlib.suppress(KeptNameError):
        assert renamed(project, renamable(project, name, line, column + 1), "zz_9")


def assert_inside(items, first, last):
    for item in items:
        assert first <= item.first <= item.last <= last
        assert_inside(item.items, item.first, item.last)
