"""An invented report: every kind of part, verdict and plot, and hostile names where asked for."""

from dataclasses import replace

import numpy as np

from lwr_dyn.arms.papers.schema import Erratum
from lwr_dyn.foundation.tables import Heading, Table
from lwr_dyn.pages.figures.figure import Curve, Figure, Level, Panel, Series
from lwr_dyn.pages.replay.replayed_runs import replayed_runs
from lwr_dyn.reproduction.case import LedgerEntry, Proof
from lwr_dyn.reproduction.report import content
from lwr_dyn.reproduction.report.content import Check, ReportCell, ReportRow, ReportTable

HOSTILE = "</script><img src=x onerror=\"window.broken=1\"><svg onload='window.broken=1'>${1}@@data@@&amp;<b>"
CONTROLLERS = ("pd-gravity", "inverse-dynamics")


def inertia_table(name=""):
    cells = [
        ("2.924", "2.92437", "after erratum", ("E2", "E9"), 0.37),
        ("2.908", "2.90821", "reproduced", (), 0.21),
        (".4903", "0.49035", "reproduced", (), 0.5),
        (".0333", "0.0412", "differs", (), 79.0),
        ("-", "", "not reproducible", (), None),
        ("12.5", "", "", (), None),
    ]
    about = ("max over q of B_ii + k_r^2 I_m" + name, "kg mm^2 -> kg m^2" + name, "q2 counted from the vertical")

    def row(j):
        shown = (ReportCell(*texts, f"Table IV, row {j}", *about, errata, digits) for *texts, errata, digits in cells)
        return ReportRow(f"joint {j}", tuple(shown))

    columns = ("b [kg m^2]", "mass", "x", "y", "z", "q" + name)
    rows = tuple(map(row, range(1, 5)))
    return ReportTable("IV", "Greatest inertias" + name, "Table IV, page 3", columns, rows, "kg m^2")


def expressions(name=""):
    """Assumed numbers, and an expression that is longer than a number."""
    cells = (
        ReportCell("K = 1/2 m v**2 + 1/2 I w**2" + name, "I*w**2/2 + m*v**2/2", "after erratum", errata=("E1" + name,)),
        ReportCell("4.6", "4.7", "under assumed conditions", digits=1.0, near=True),
        ReportCell("4.6", "0.8", "under assumed conditions", digits=-38.0, near=False),
        ReportCell("1", "1", "structural"),
        ReportCell(""),
    )
    rows = tuple(ReportRow(f"line {i + 1}" + name, (cell,)) for i, cell in enumerate(cells))
    return ReportTable("K", "Energies" + name, "below Table IV", ("K",), rows)


def errata(name=""):
    computation = Proof("B_11 with I2 as printed: 2.879\nB_11 with y and z exchanged: 2.908" + name, True)
    failing = replace(computation, holds=False)

    def entry(id, where, printed, right, effect, severity, status, proof):
        erratum = Erratum(id, where, printed, right, "the tables disagree" + name, effect, status, (), severity)
        return LedgerEntry(erratum, proof)

    return (
        entry("E1" + name, "Table II" + name, "(0, -0.4, 0)", "one row lower", "none", "high", "proven", computation),
        entry("E2", "Table I, link 2", "I_yy 0.0195", "0.0068", "b22 by 0.03", "high", "proven", computation),
        entry("E3", "Table V", "14 s", "12 s", "timing", "low", "proven", failing),
        entry("E4", "Table V", "3 s", "4 s", "timing", "low", "likely", None),
    )


def run_plots(arm, name=""):
    errors, joints = [], []
    for i, label in enumerate(CONTROLLERS):
        all_joints = enumerate(arm.joint_names)
        curves = tuple(Curve(joint + name, Series(i, "position error", j, 1e3)) for j, joint in all_joints)
        errors.append(Panel(label + name, "position error", "mrad" + name, curves, (Level("printed", 8.0),)))
    for j, joint in enumerate(arm.joint_names):
        curves = tuple(Curve(label, Series(i, "torque", j)) for i, label in enumerate(CONTROLLERS))
        joints.append(Panel(joint, "torque", "N m", curves))
    wanted = Curve("asked for", Series(0, "reference z"), Series(0, "reference x"), dashed=True, colour=7)
    drawn = (Curve(label, Series(i, "flange z"), Series(i, "flange x")) for i, label in enumerate(CONTROLLERS))
    path, errors, joints = Panel("", "z", "m", (wanted, *drawn)), tuple(errors), tuple(joints)
    return (
        Figure("errors", "Joint errors" + name, "Figure 6", "time" + name, "s", errors, over_time=True, note="[mrad]"),
        Figure("torque", "Torque of both", "", "time", "s", joints, over_time=True, columns=2),
        Figure("path", "Path of the flange", "Figure 7", "x", "m", (path,), equal_aspect=True),
    )


def map_plot(name=""):
    v = np.linspace(-0.4, 0.4, 81)
    law = np.where(v == 0, np.nan, 2.0 * np.sign(v) + 3.0 * v)
    measured = Curve("mean of a cruise" + name, law[::10] + 0.1, v[::10], "points", text=("run" + name,) * 9)
    panel = Panel("J1" + name, "friction", "N m", (Curve("law", law, v), measured), (Level("v", 0.1, "x"),))
    return Figure("map" + name, "Friction map" + name, "Figure 6", "velocity", "rad/s", (panel, panel), columns=2)


def report(arm, runs, name="", stills=True):
    """A page of every kind of part; `name` is put into every text."""
    tinted = [Heading(column, format=".1f", shade=lambda value: value - 1.0) for column in "ab"]
    spread = Table("Spread" + name, ("plant" + name, *tinted), (("printed" + name, 1.0, 2.0),))
    text = "What holds.\n\nAnd why." + name
    section = content.ReportSection("spread", "Model spread" + name, text, (spread,), (map_plot(name),))
    pose = content.Still("Figure 2" + name, arm, np.zeros(arm.n), "DH frames, arm stretched up" + name)
    return content.Page(
        title="A paper with tables" + name,
        subtitle="recomputed" + name,
        byline="Authors" + name,
        verdict=(("8 of 24" + name, True), (" come out.", False)),
        words="Most of it holds." + name,
        document=(("title", "A paper" + name), ("pages", "6")),
        tables=(inertia_table(name), expressions(name)),
        derived=(replace(inertia_table(name), id="derived"),),
        errata=errata(name),
        figures=run_plots(arm, name),
        replay=content.Replay(replayed_runs(runs, arm, [c + name for c in CONTROLLERS]), (pose,) if stills else ()),
        checks=(Check("mass matrix" + name, "1.2e-15", "1e-12 of the largest" + name, True, "two roads" + name),),
        audit=(Check("energy", "3e-3 J", "1e-3 J", False),),
        sections=(section,),
        files=(content.FileFact("results.json" + name, 12345, "ab" * 32, "every number" + name),),
        versions=(("lwr_dyn" + name, "1.0"),),
    )  # fmt: skip
