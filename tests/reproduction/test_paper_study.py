"""One source for every figure: `figures.json`, the PNG's lines, the SVG's paths and the page's numbers are the same."""

import base64
import gzip
import json
import re
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.model.run import Run
from lwr_dyn.pages.figures.figure import Series
from lwr_dyn.pages.plotting.plots import draw
from lwr_dyn.pages.replay.replayed_runs import replayed_runs
from lwr_dyn.reproduction.kr30ha.study import envelope_figures
from lwr_dyn.reproduction.lwr4plus.study import _figures
from lwr_dyn.reproduction.paper_study import FIGURES, Pictures, read_figures
from lwr_dyn.reproduction.report.content import Page, Replay
from lwr_dyn.reproduction.report.page import report_html
from lwr_dyn.reproduction.wam7.study import _friction_maps, _lspb

PACKED = 1e-9
"""Of the largest number: what 32 bits on the page leave."""
DRAWN = 5e-3
"""Of a curve's height: Matplotlib leaves out points of an SVG path that are not seen."""


def wam7(_):
    return Pictures(figures={"figure_4": [_lspb()], "figure_6": [_friction_maps(lwr_dyn.load("wam7"))]})


def kr30ha(_):
    return Pictures(figures={"envelope": envelope_figures(lwr_dyn.load("kr30ha"), {"P1": (1.0, 0.2, 1.0)})})


def lwr4plus(two_runs):
    shown = replayed_runs([*two_runs, two_runs[0]], lwr_dyn.load("lwr4plus"), ["pd", "id", "as Table VIII"])
    return Pictures(shown=shown, figures={file: [figure] for file, figure in _figures(shown).items()})


STUDIES = [pytest.param(lwr4plus, marks=pytest.mark.slow), wam7, kr30ha]


@pytest.fixture(scope="module", params=STUDIES, ids=lambda make: make.__name__)
def written(request, tmp_path_factory, two_runs):
    """The pictures of a study, as described and as read back, and their folder."""
    folder = tmp_path_factory.mktemp("pictures") / "out"
    described = request.param(two_runs)
    return described, described.write(folder), folder


def curves_of(pictures, on_page=False):
    for drawn in pictures.figures.values():
        for figure in drawn:
            for p, panel in enumerate(figure.panels if figure.id or not on_page else ()):
                yield from ((figure, p, c, curve) for c, curve in enumerate(panel.curves))


def test_what_is_read_back_is_what_was_described(written):
    described, read, folder = written
    for (*before, a), (*after, b) in zip(curves_of(described), curves_of(read), strict=True):
        assert (before[0].title, before[1:]) == (after[0].title, after[1:])
        for one, two in zip(a.points(described.shown), b.points(read.shown), strict=True):
            np.testing.assert_array_equal(one, two)
        assert (a.label, a.text, a.style, a.colour) == (b.label, b.text, b.style, b.colour)
    again = read_figures(folder / FIGURES)
    assert [f.panels[0].levels for x in again.values() for f in x] == [
        f.panels[0].levels for x in described.figures.values() for f in x
    ]


@pytest.mark.slow
def test_the_run_files_that_series_name_hold_the_runs(written):
    described, _, folder = written
    files = json.loads((folder / FIGURES).read_text())["runs"]
    assert len(files) == len(described.shown)
    for file, shown in zip(files, described.shown, strict=True):
        np.testing.assert_array_equal(Run.load(folder / file).q, shown.run.q)


@pytest.mark.slow
def test_the_lines_of_the_drawing_are_those_of_the_file(written):
    _, read, _ = written
    for drawn in read.figures.values():
        drawing = draw(drawn, read.shown)
        lines = {line.get_gid(): line for axes in drawing.axes for line in axes.lines if line.get_gid()}
        for figure in drawn:
            for p, panel in enumerate(figure.panels):
                for c, curve in enumerate(curve for curve in panel.curves if not curve.text):
                    line = lines[f"{figure.id or 'figure'}-{p}-{c}"]
                    np.testing.assert_array_equal(line.get_xydata(), np.column_stack(curve.points(read.shown)))


@pytest.mark.slow
def test_the_paths_of_the_svg_go_as_the_numbers_of_the_file(written):
    """x to the right and y up, each by one scale: a figure that falls in one place and rises in another is found."""
    _, read, folder = written
    compared = 0
    for file, drawn in read.figures.items():
        tree = ElementTree.parse(folder / "plots" / f"{file}.svg")
        groups = {group.get("id"): group for group in tree.iter("{http://www.w3.org/2000/svg}g")}
        for figure in drawn:
            for p, panel in enumerate(figure.panels):
                for c, curve in enumerate(panel.curves):
                    x, y = curve.points(read.shown)
                    if not curve.text and np.ptp(x) > 0 and np.ptp(y) > 0 and np.isfinite(y).all() and figure.over_time:
                        path = groups[f"{figure.id or 'figure'}-{p}-{c}"].find("{http://www.w3.org/2000/svg}path")
                        points = np.array(re.findall(r"[ML] (\S+) (\S+)", path.get("d")), dtype=float)
                        assert misfit(points, x, y) < DRAWN
                        compared += 1
    assert compared > 2 or not any(figure.over_time for drawn in read.figures.values() for figure in drawn)


def misfit(points, x, y):
    """How far a drawn path is from a curve over time, over the curve's height; y of SVG counts downward."""
    across = np.interp(points[:, 0], points[[0, -1], 0], x[[0, -1]])
    up = np.interp(across, x, y)
    scale, shift = np.polyfit(up, points[:, 1], 1)
    assert scale < 0.0
    return np.abs((points[:, 1] - shift) / scale - up).max() / np.ptp(y)


@pytest.mark.slow
def test_the_numbers_of_the_page_are_those_of_the_file(written):
    _, read, _ = written
    figures = tuple(figure for drawn in read.figures.values() for figure in drawn if figure.id)
    page = report_html(Page("p", figures=figures, replay=Replay(read.shown) if read.shown else None))
    packed = re.search(r'id="packed-numbers">([^<]*)<', page).group(1)
    data = json.loads(gzip.decompress(base64.b64decode(packed)))
    records = [curve for figure in data["figures"] for panel in figure["panels"] for curve in panel["curves"]]
    mine = [curve for *_, curve in curves_of(read, on_page=True)]
    for record, curve in zip(records, mine, strict=True):
        for axis in "xy":
            value = getattr(curve, axis)
            if isinstance(value, Series):
                assert record[axis] == {
                    "run": value.run,
                    "quantity": value.quantity,
                    "joint": value.joint,
                    "scale": value.scale,
                }
            elif value is not None:
                shown = numbers(data["numbers"][record[axis]])
                np.testing.assert_allclose(shown, value, rtol=0, atol=PACKED * np.nanmax(np.abs(value)))


def numbers(record):
    """A curve of the page's pool."""
    if isinstance(record, list):
        return np.array([np.nan if x is None else x for x in record], dtype=float)
    values = np.frombuffer(base64.b64decode(record["data"]), dtype="<i4") * record["step"]
    values[record["gaps"]] = np.nan
    return values


def test_the_replay_has_the_first_runs_and_is_left_out_where_none_is_asked_for(two_runs, tmp_path):
    shown = replayed_runs(two_runs, lwr_dyn.load("lwr4plus"), ["the-first", "the-second"])
    for replayed, names in ((1, ["replay.html", "runs"]), (0, ["runs"])):
        folder = tmp_path / str(replayed)
        folder.mkdir()
        Pictures(shown=shown, title="A title", replayed=replayed).write(folder)
        assert sorted(path.name for path in folder.iterdir()) == names
        assert sorted(path.name for path in (folder / "runs").iterdir()) == ["the-first.npz", "the-second.npz"]
    text = (tmp_path / "1" / "replay.html").read_text(encoding="utf-8")
    assert ("A title" in text, "the-first" in text, "the-second" in text) == (True, True, False)
