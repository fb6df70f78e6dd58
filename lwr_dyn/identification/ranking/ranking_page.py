"""The page of a ranking: its document, and the torques of each set against measurement, joint by joint."""

from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from html import escape

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.document import Document, Note, PageFigure, Section
from lwr_dyn.identification.ranking.ranking_result import Ranking, SetScore
from lwr_dyn.identification.report import charts
from lwr_dyn.pages.replay.replay_page import resource_text

MOST_ROWS = 3000
"""Of a set that the page draws."""
LINES = (
    "Lines: measured and predicted torque of the rows that test, with what is fitted beside the set. Below: what is "
    "left, over a band of three times what least squares leave."
)


def ranking_page(found: Ranking) -> Document:
    """The document with the figures, drawn when the page is written."""
    document = found.document
    return replace(document, sections=[*document.sections, *_drawn_sections(found)])


def _drawn_sections(found: Ranking) -> Iterator[Section]:
    floor = np.sqrt(np.mean(np.square(found.floors[-1]), axis=0))
    every = -(-len(found.test) // MOST_ROWS)
    for one in found.scores:
        first, free = one is found.scores[0], one.fits[-1].free
        yield Section(
            f"{one.name}: torques against measurement" + (f", freed: {', '.join(free)}" if free else ""),
            [
                Note(LINES, first),
                Note(f"One in {every} rows is drawn.", first and every > 1),
                PageFigure(partial(_rows_html, found, one, floor, every), resource_text("report.css", charts.PACKAGE)),
            ],
            page=True,
        )


def _rows_html(found: Ranking, one: SetScore, floor: Array, every: int) -> str:
    test, predicted = found.test, one.fits[-1].predicted[1][::every]
    t, measured = test.t[::every] - test.t[0], test.tau[::every]
    used = np.ones(measured.shape, dtype=np.bool_)
    shown = charts.ShownRecording(one.name, t, test.q[::every], measured, predicted, used)
    rows = charts.torque_rows_html(shown, floor, one.arm.joint_names, (found.unit,) * one.arm.n)
    return f'<div aria-label="{escape(one.name)}">{charts.KEY}{rows}</div>'
