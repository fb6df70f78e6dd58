"""The tree of a file: routines, blocks and folds within one another, and what a `.dat` declares."""

from lwr_dyn.krl.editor.edited_project import folds_of, outline_items
from lwr_dyn.krl.language.blocks import outline_of
from lwr_dyn.krl.language.source import parse_text
from tests.krl.small_backup import CONFIG, FILES, MAIN


def tree(items):
    return [(x.kind, x.name, x.first + 1, x.last + 1, *([tree(x.items)] if x.items else [])) for x in items]


def read(text, name="a.src"):
    file, _ = parse_text(text, name)
    return file, outline_of(file)


def test_blocks_and_folds_stand_in_their_routine():
    loop = ("block", "FOR i = 1 TO 3", 10, 15, [("block", "IF grip.state == #OPEN THEN", 12, 14)])
    main = ("routine", "main", 2, 20, [("fold", "INI", 5, 7), loop])
    assert tree(outline_items(*read(FILES[MAIN]))) == [main, ("routine", "helper", 22, 26)]


def test_a_data_file_shows_its_names_with_their_types():
    items = outline_items(*read(FILES[CONFIG], "$config.dat"))
    assert [(x.kind, x.name, x.detail) for x in items] == [
        ("type", "STATE_E", "ENUM"),
        ("type", "GRIP_T", "STRUC"),
        ("variable", "XHOME", "E6AXIS"),
        ("variable", "TOOL_DATA", "FRAME[]"),
        ("variable", "SPEED", "REAL"),
    ]


def test_names_of_one_line_stand_beside_each_other_in_their_fold():
    text = "DEFDAT a\n;FOLD points;%{PE}\nDECL INT i, k\nDECL INT n\n;ENDFOLD\nENDDAT\n"
    (fold,) = outline_items(*read(text, "a.dat"))
    assert (fold.name, [x.name for x in fold.items]) == ("points", ["i", "k", "n"])


def test_what_crosses_is_cut_and_what_has_no_end_is_left_out():
    text = "DEF a( )\n;FOLD x\nLOOP\n;ENDFOLD\nENDLOOP\n;FOLD y\nHALT\nEND\n;ENDFOLDER\n"
    assert tree(outline_items(*read(text))) == [
        ("routine", "a", 1, 8, [("fold", "x", 2, 4, [("block", "LOOP", 3, 4)])])
    ]


def test_a_block_that_is_still_open_while_it_is_written_is_shown():
    text = "DEF a( )\nWHILE TRUE\n  IF TRUE THEN\n    HALT\n"
    shown = tree(outline_items(*read(text)))
    assert shown == [("routine", "a", 1, 4, [("block", "WHILE TRUE", 2, 4, [("block", "IF TRUE THEN", 3, 4)])])]


def test_what_can_be_folded_has_more_than_one_line():
    folds = folds_of(*read(FILES[MAIN]))
    ranges = [("block", 10, 15), ("block", 12, 14), ("fold", 5, 7), ("routine", 2, 20), ("routine", 22, 26)]
    assert sorted((x.kind, x.first + 1, x.last + 1) for x in folds) == ranges
