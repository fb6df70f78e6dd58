"""The page of a ranking has each set's torques, joint by joint."""

from lwr_dyn.identification.ranking.rank import rank
from lwr_dyn.identification.ranking.ranking_page import ranking_page
from lwr_dyn.pages.document import page_html


def test_each_set_has_a_chart_of_each_joint():
    found = rank("panda", "panda_salerno", ["gaz", "fer"], free=["load"])
    html = page_html(ranking_page(found))
    assert html.count('class="who"') == 2 * 7
    assert html.count("torques against measurement, freed: load") == 2
    assert "<script src" not in html
    assert "http://" not in html.replace("http://www.w3.org", "")
