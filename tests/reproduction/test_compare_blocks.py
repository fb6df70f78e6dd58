"""Each printed or derived block by itself: recomputed to its digits, after the fewest errata; none differs."""

import pytest

from lwr_dyn.reproduction.compare import AFTER, ASSUMED, REPRODUCED, BlockComparer
from lwr_dyn.reproduction.kr30ha import formulas as kr30ha
from lwr_dyn.reproduction.lwr4 import study as lwr4
from lwr_dyn.reproduction.lwr4plus import formulas as lwr4plus
from lwr_dyn.reproduction.lwr4plus import worst_cases
from lwr_dyn.reproduction.paper_study import paper_study
from lwr_dyn.reproduction.papers import studies
from lwr_dyn.reproduction.wam7 import formulas as wam7

FORMULAS = {"kr30ha": kr30ha, "lwr4": lwr4, "lwr4plus": lwr4plus, "wam7": wam7}
LONG = {"table_iv", "b_as_printed"}
"""Blocks that take more than half a second, as many errata are tried."""
ASSUMING = {"figure_7"}
"""Blocks that need what is not printed: their numbers are near or not, never reproduced."""
BLOCKS = [
    pytest.param(paper, name, marks=[pytest.mark.slow] if name in LONG else [])
    for paper in studies()
    for name, block in paper_study(paper).data.results.blocks.items()
    if not paper_study(paper).formulas[block.compute].slow
]


@pytest.mark.parametrize(("paper", "name"), BLOCKS)
def test_a_block_is_recomputed_to_its_digits(paper, name):
    study = paper_study(paper)
    assert study.formulas is FORMULAS[paper].FORMULAS
    block = study.data.results.blocks[name]
    verdicts = {ASSUMED} if name in ASSUMING else {REPRODUCED, AFTER}
    found = list(BlockComparer(study, from_known_maxima=True).block(block, None))
    assert [n.cell.path for n in found] == [cell.path for cell in block.cells]
    assert {n.cell.path: n.verdict for n in found if n.verdict not in verdicts} == {}


def test_a_searched_maximum_is_found_again_from_where_it_was():
    arm = worst_cases.arms()["computed"]
    assert worst_cases.largest(arm, 6, True) == pytest.approx(worst_cases.largest(arm, 6, False), rel=1e-9)
