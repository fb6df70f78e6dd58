"""Statements that some way of a program leads to."""

import pytest

from lwr_dyn.krl.project.program import parse_program
from scripts.studies.krl_reach import reachable_lines


@pytest.mark.parametrize(
    ("lines", "reached"),
    [
        ("A | GOTO X | B | X: | C", "A C"),
        ("A | RETURN | B", "A"),
        ("IF $IN[1] THEN | A | RETURN | ELSE | B | ENDIF | C", "A B C"),
        ("IF $IN[1] THEN | RETURN | ELSE | GOTO X | ENDIF | C | X: | D", "D"),
        ("IF $IN[1] THEN | GOTO X | ELSE | A | ENDIF | B | X: | C", "A B C"),
        ("GOTO X | IF $IN[1] THEN | A | ELSE | B | X: | C | ENDIF | D", "C D"),
        ("LOOP | A | ENDLOOP | B", "A"),
        ("LOOP | A | IF $IN[1] THEN | EXIT | ENDIF | ENDLOOP | B", "A B"),
        ("WHILE $IN[1] | A | ENDWHILE | B", "A B"),
        ("REPEAT | A | UNTIL $IN[1] | B", "A B"),
        ("FOR I = 1 TO 3 | A | ENDFOR | B", "A B"),
        ("SWITCH I | CASE 1 | A | CASE 2 | B | RETURN | DEFAULT | C | ENDSWITCH | D", "A B C D"),
        ("SWITCH I | CASE 1 | RETURN | DEFAULT | RETURN | ENDSWITCH | D", "D"),
        ("IF $IN[1] THEN | LOOP | A | ENDLOOP | B | ENDIF | C", "A C"),
        ("TRIGGER WHEN DISTANCE = 0 DELAY = 0 DO F(1) | A", "A f"),
        ("N = G(2)", "g"),
    ],
)
def test_what_some_way_leads_to(lines, reached):
    body = [f"; {x}" if len(x) == 1 else x for x in lines.split(" | ")]
    more = ["DEF F(K :IN)", "; f", "END", "DEFFCT INT G(K :IN)", "; g", "RETURN 1", "ENDFCT", "DEF never( )", "; x"]
    text = ["DEF a( )", *body, "END", *more, "END"]
    found = reachable_lines(parse_program("\n".join([*text, ""]), name="a"))
    marks = {i: x[2:] for i, x in enumerate(text, 1) if x.startswith("; ")}
    assert {x for i, x in marks.items() if i in found} == set(reached.split())
