"""Curves of a panel as SVG paths in a plane that stretches with the page: no text in it, line widths that stay."""

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.pages.plotting.axes import Axis
from lwr_dyn.reproduction.report.markup import Html

WIDTH, HEIGHT = 2000, 1000
"""Of the plane, in its own units; a page shows it 150 to 600 px wide."""
TOLERANCE = 1.5
"""Largest distance between a curve and its drawn path, in these units: half a pixel."""


def line_path(x: Axis, y: Axis, points: tuple[Array, Array]) -> str:
    """The path of a curve: straight pieces, gaps where there is no number."""
    across, down = _placed(x, y, points)
    pieces = []
    for part in _whole_pieces(across, down):
        kept = simplified(part, TOLERANCE)
        written = np.rint(kept).astype(int)
        fresh = np.concatenate([[True], (np.diff(written, axis=0) != 0).any(axis=1)])
        pieces.append("M" + " ".join(f"{a},{b}" for a, b in written[fresh].tolist()))
        if fresh.sum() == 1:
            pieces[-1] += "h0"
    return "".join(pieces)


def dots_path(x: Axis, y: Axis, points: tuple[Array, Array]) -> str:
    """The path of single points: pieces without length, which a round line end makes dots."""
    placed = np.rint(np.column_stack(_placed(x, y, points)))
    return "".join(f"M{a:.0f},{b:.0f}h0" for a, b in placed if np.isfinite(a + b))


def plane_html(content: str) -> Html:
    """The plane around its paths."""
    return Html(
        f'<svg class="lines" viewBox="0 0 {WIDTH} {HEIGHT}" preserveAspectRatio="none" aria-hidden="true">'
        f"{content}</svg>"
    )


def _placed(x: Axis, y: Axis, points: tuple[Array, Array]) -> tuple[Array, Array]:
    return WIDTH * x.share(points[0]), HEIGHT * (1.0 - y.share(points[1]))


def _whole_pieces(across: Array, down: Array) -> list[Array]:
    """Runs of points without a gap, (k, 2) each."""
    points = np.column_stack([across, down])
    finite = np.isfinite(points).all(axis=1)
    cuts = np.flatnonzero(np.diff(finite)) + 1
    return [part for part in np.split(points, cuts) if np.isfinite(part[0]).all()]


def simplified(points: Array, tolerance: float) -> Array:
    """The fewest of the points (k, 2), in their order, from whose path none is farther than about `tolerance`.

    References
    ----------
    Douglas and Peucker, "Algorithms for the reduction of the number of points required to represent a digitized line",
    Cartographica 10 (1973).

    >>> simplified(np.array([[0.0, 0.0], [1.0, 0.01], [2.0, 0.0], [2.0, 5.0]]), 0.1).tolist()
    [[0.0, 0.0], [2.0, 0.0], [2.0, 5.0]]
    """
    kept = np.zeros(len(points), dtype=bool)
    kept[[0, -1]] = True
    stretches = [(0, len(points) - 1)]
    while stretches:
        first, last = stretches.pop()
        if last - first < 2:
            continue
        away = _distances(points[first : last + 1])
        worst = int(away.argmax())
        if away[worst] > tolerance:
            kept[first + worst] = True
            stretches += [(first, first + worst), (first + worst, last)]
    return points[kept]


def _distances(points: Array) -> Array:
    """Of points (k, 2) from the piece between the first and the last."""
    start, along = points[0], points[-1] - points[0]
    offset = points - start
    square = float(along @ along)
    if square == 0.0:
        return np.asarray(np.hypot(*offset.T))
    part = np.clip(offset @ along / square, 0.0, 1.0)
    return np.asarray(np.hypot(*(offset - part[:, None] * along).T))
