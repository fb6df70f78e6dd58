"""The judge of pages sees what it is there for."""

import pytest

from tests.axe import FEW, faint_texts, seen, sideways, violations

PAGE = """<!doctype html><html lang="en"><head><meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1"><title>t</title><style>
:root {{ color-scheme: light dark; }}
body {{ background: light-dark(#ffffff, #151a20); color: light-dark(#000, #fff); }}
.good {{ fill: light-dark(#14191f, #e8ecf0); }}
.faint {{ fill: light-dark(#bbbbbb, #47525e); }}
.day {{ fill: #14191f; }}
</style></head><body><main><h1>t</h1>{}</main></body></html>"""


@pytest.fixture
def judged(browser, tmp_path):
    def judge(body, dark=False, width=1600):
        path = tmp_path / "page.html"
        path.write_text(PAGE.format(body), encoding="utf-8")
        browser.get(path.as_uri())
        with seen(browser, width, dark):
            return violations(browser), faint_texts(browser), sideways(browser)

    return judge


@pytest.mark.slow
@pytest.mark.parametrize("dark", [False, True])
def test_a_good_page_has_no_fault(judged, dark):
    assert judged('<svg><text class="good" y="20">word</text></svg>', dark) == ([], [], 0)


@pytest.mark.slow
def test_faults_are_named_with_their_rule_and_place(judged):
    found, _, _ = judged('<button id="empty"></button>')
    assert [line.split(":")[0] for line in found] == ["button-name (critical)"]
    assert "#empty" in found[0]


@pytest.mark.slow
def test_faint_text_in_svg_is_seen_in_the_scheme_in_which_it_is_faint(judged):
    body = '<svg><text class="{}" y="20">word</text></svg>'
    assert judged(body.format("faint"))[1] == ["word: 1.92 (rgb(187, 187, 187) on 255,255,255)"]
    assert judged(body.format("day"))[1] == []
    assert judged(body.format("day"), dark=True)[1] == ["word: 1.01 (rgb(20, 25, 31) on 21,26,32)"]
    assert judged('<svg style="display:none"><text class="faint" y="20">word</text></svg>')[1] == []
    assert judged('<svg opacity="0.4"><text class="good" y="20">word</text></svg>')[1] != []


@pytest.mark.slow
@pytest.mark.parametrize("look", ["color: #bbb", "background: #555", "opacity: 0.4"])
def test_one_faint_text_among_many_good_ones_is_seen(judged, look):
    """Of texts that look the same not all are judged."""
    good = '<p style="font-size: 14px">word</p>' * 40
    found, _, _ = judged(f'{good}<div style="{look}"><p id="odd" style="font-size: 14px">word</p></div>{good}')
    assert [line.split(":")[0] for line in found] == ["color-contrast (serious)"]
    assert "#odd" in found[0]


@pytest.mark.slow
def test_a_look_that_is_faint_is_seen_though_it_is_frequent(judged):
    found, _, _ = judged('<p style="color: #bbb">word</p>' * 40)
    assert len(found) == 2 * FEW


def test_a_page_that_scrolls_sideways_is_seen(judged):
    assert judged('<p style="width:500px">wide</p>', width=420)[2] > 0
