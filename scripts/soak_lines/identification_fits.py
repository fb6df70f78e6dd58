"""Thousands of fits with a known truth: what sigma says, what a long log costs."""

from __future__ import annotations

import numpy as np

import lwr_dyn

FITS = 1000
PLANTS = 20
LOGS = 15


def base_fits() -> tuple[str, bool]:
    """1000 fits each of LWR and WAM, encoders of 1e-5 rad at 1 kHz, filtered: 3-sigma intervals and bias."""
    from tests.identification.coverage_study import coverage_study
    from tests.identification.plants import inside

    said, good = [], True
    for robot in ("lwr4plus", "wam7"):
        z, _ = coverage_study(lwr_dyn.load(robot), range(FITS))
        worst, share = float(np.abs(z.mean(axis=0)).max()), inside(z)
        said.append(f"{robot} {share:.2%} within 3 sigma, largest bias {worst:.2f} sigma")
        good &= 0.995 <= share <= 0.999 and worst <= 0.2
    return "; ".join(said), good


def fits_cover() -> tuple[str, bool, str]:
    """Bodies, rotors, friction of eight arms, three truths, two noises, 20 logs a cell: 97 % inside 3 sigma, rms z."""
    from tests.identification import cover_truths as of
    from tests.identification.cover_study import KINDS, cover_cell

    lines = [f"| arm, truth, noise | {' | '.join(KINDS)} | all [%] | held out [N m] | refused |", "|---" * 10 + "|"]
    inside: list[float] = []
    spread: list[float] = []
    for arm in (*of.TUNED, *of.NEW):
        for truth in (*of.TRUTHS, *of.OFF_MODEL):
            cells = [cover_cell(arm, truth, noise, range(of.RUNS)) for noise in of.NOISES]
            for noise, cell in zip(of.NOISES, cells, strict=True):
                held = float(np.median(cell.held_out))
                judged = f"{100 * cell.inside:.1f} | {held:.4f} | {cell.refused}"
                lines.append(f"| {arm}, {truth}, {noise} | {cell.row()} | {judged} |")
            if truth in of.TRUTHS:
                inside.append(float(np.mean([cell.inside for cell in cells])))
                spread += [cell.of_kind(kind)[0] for cell in cells for kind in KINDS]
    z = np.array(spread)
    usual = float(np.mean((z >= 0.7) & (z <= 1.3)))
    said = (
        f"at least {min(inside):.1%} inside 3 sigma; rms z {z.min():.2f} to {z.max():.2f}, {usual:.0%} of {z.size} "
        "cells in 0.7 to 1.3"
    )
    good = min(inside) >= 0.97 and usual >= 0.95 and z.min() >= 0.5 and z.max() <= 1.5
    return said, good, "\n".join(lines)


def gains_cover() -> tuple[str, bool, str]:
    """Gains off by 10 % on three arms, three truths, two noises, 20 logs a cell: gains, bodies inside 3 sigma."""
    from tests.identification import cover_truths as of
    from tests.identification.gain_study import gain_cell, row
    from tests.identification.plants import inside, rms

    lines = ["| arm, truth, noise | gains | all parameters | total mass | refused |", "|---" * 5 + "|"]
    cells = []
    for arm in ("panda", "ur10", "wam7"):
        for truth in of.TRUTHS:
            for noise in of.NOISES:
                cell = gain_cell(arm, truth, noise, range(of.RUNS))
                cells.append(cell)
                lines.append(f"| {arm}, {truth}, {noise} | {row(cell)} | {cell.refused} |")
    least = min(inside(np.hstack([cell.gains, cell.others])) for cell in cells)
    gains = min(inside(cell.gains) for cell in cells)
    z = np.array([[rms(cell.gains), rms(cell.others)] for cell in cells])
    usual = float(np.mean((z >= 0.7) & (z <= 1.3)))
    said = (
        f"at least {least:.1%} inside 3 sigma, of gains alone {gains:.1%}; rms z of gains {z[:, 0].min():.2f} to "
        f"{z[:, 0].max():.2f}, of all {z[:, 1].min():.2f} to {z[:, 1].max():.2f}; {usual:.0%} in 0.7 to 1.3"
    )
    good = min(least, gains) >= 0.97 and usual >= 0.95 and z.min() >= 0.5 and z.max() <= 1.5
    return said, good, "\n".join(lines)


def gains_and_loads_cover() -> tuple[str, bool, str]:
    """Both together, two arms, two noises, 20 logs a cell: gains, shares and all other parameters inside 3 sigma."""
    from tests.identification import cover_truths as of
    from tests.identification.gain_study import gain_cell, row
    from tests.identification.plants import inside, rms

    lines = ["| arm, noise | gains | shares | all other parameters | total mass | refused |", "|---" * 6 + "|"]
    cells = []
    for arm in ("panda", "ur10"):
        for noise in of.NOISES:
            cells.append(gain_cell(arm, "natural", noise, range(of.RUNS), load=True))
            lines.append(f"| {arm}, {noise} | {row(cells[-1])} | {cells[-1].refused} |")
    every = [np.concatenate([np.ravel(getattr(cell, x)) for cell in cells]) for x in ("gains", "shares", "others")]
    shares = [inside(z) for z in every]
    z = np.array([[rms(cell.gains), rms(cell.shares), rms(cell.others)] for cell in cells])
    said = (
        f"inside 3 sigma: {shares[0]:.1%} of gains, {shares[1]:.1%} of shares, {shares[2]:.1%} of the others; rms z "
        f"{z.min():.2f} to {z.max():.2f}"
    )
    return said, min(shares) >= 0.97 and z.min() >= 0.5 and z.max() <= 1.5, "\n".join(lines)


def load_friction_cover() -> tuple[str, bool, str]:
    """Friction of 2 to 20 % of the load on four arms, 20 logs each: base parameters and shares inside 3 sigma."""
    from tests.identification import cover_truths as of
    from tests.identification.gain_study import load_misses, of_shares
    from tests.identification.plants import rms

    lines = ["| arm | RMS miss | % inside 3 sigma | largest | shares: RMS miss | % inside |", "|---" * 6 + "|"]
    inside, spread = [], []
    for arm in ("panda", "ur10", "wam7", "iiwa14"):
        z = load_misses(arm, range(of.RUNS))
        shares = of_shares(arm, z)
        inside += [float(np.mean(np.abs(x) <= 3.0)) for x in (z, shares)]
        spread.append(rms(z))
        lines.append(f"| {arm} | {spread[-1]:.2f} | {100 * inside[-2]:.1f} | {np.abs(z).max():.1f} | "
                     f"{rms(shares):.2f} | {100 * inside[-1]:.1f} |")  # fmt: skip
    said = f"at least {min(inside):.1%} inside 3 sigma; rms z {min(spread):.2f} to {max(spread):.2f}"
    return said, min(inside) >= 0.97 and min(spread) >= 0.7 and max(spread) <= 1.3, "\n".join(lines)


def mujoco_logs() -> tuple[str, bool, str]:
    """Logs of a Panda near its table and of an iiwa 14 with large rotors, each moved by MuJoCo, by the defaults."""
    from tests.identification.mujoco_study import mujoco_fit, spread

    panda = [mujoco_fit("panda", "natural", run) for run in range(LOGS)]
    iiwa = [mujoco_fit("iiwa14", "rotors", run) for run in range(LOGS)]
    rms, inside, most = spread(panda)
    rotors = np.array([fit.rotors for fit in iiwa])
    gains = np.array([fit.gains for fit in iiwa]) - 1.0
    said = (
        f"panda: rms z {rms:.2f}, {inside:.1%} inside 3 sigma, largest {most:.1f}; iiwa14: rotors "
        f"{np.mean(np.abs(rotors) <= 3.0):.1%} inside 3 sigma, largest inertias (so gains) at most "
        f"{np.abs(gains).max():.1%} off"
    )
    every = [("panda", panda), ("iiwa14", iiwa)]
    lines = [f"{name}, log {i}: rms z {spread([fit])[0]:.2f}, rotors {np.round(fit.armature, 3)}, base "
             f"{np.sqrt(np.mean(fit.base**2)):.2f}" for name, fits in every for i, fit in enumerate(fits)]  # fmt: skip
    return said, rms <= 1.2 and inside >= 0.97 and np.mean(np.abs(rotors) <= 3.0) >= 0.97, "\n".join(lines)


def fresh_torques() -> tuple[str, bool]:
    """Torque error on fresh motions, fitted to an optimised 10 s: under 0.12 of the noise; with Stribeck beside it."""
    from lwr_dyn.identification.excitation.design import design_excitation
    from tests.identification.coverage_study import fresh_errors

    said, good = [], True
    for robot in ("lwr4plus", "wam7"):
        arm = lwr_dyn.load(robot)
        errors = fresh_errors(arm, design_excitation(arm, 10.0).sampled(1000.0), range(PLANTS))
        plain, outside, column = np.median(errors, axis=0)
        said.append(
            f"{robot} {plain:.3f} of the noise (median of {PLANTS}, worst {errors[:, 0].max():.3f}); with Stribeck "
            f"friction {outside:.3f} beyond three v_s, {column:.3f} at all speeds with its column"
        )
        good &= bool(plain < 0.12 and outside < 0.12)
    return "; ".join(said), good


def million_rows() -> tuple[str, bool]:
    """Base parameters and sigma of 1 000 000 rows of 7 joints on one core, in a process of its own (4 s, 100 MB)."""
    from benchmarks.identification import long_log

    runs = [long_log("lwr4plus", form) for form in ("states", "positions")]
    said = ", ".join(f"{run['processor']:.2f} s and {run['beyond'] / 1e6:.0f} MB beyond the log" for run in runs)
    good = all(run["processor"] < 4.0 and run["beyond"] < 100e6 and run["z"] < 4.5 for run in runs)
    return f"{said} (from states, from positions)", good
