"""The commented data file that `lwr-dyn new` writes for a user's own arm; it reads and runs as it stands."""

from __future__ import annotations

from collections.abc import Iterable

from lwr_dyn.errors import OptionError

_HEAD = """# A robot for lwr_dyn. Write what your source prints, in its own units and order; the reader converts.
# Every column says where its numbers stand (page, table) and what kind they are:
#   printed, computed, datasheet, fitted (to which number), estimated (how), assumed
# Unknown things are left out, never set to zero. Try:  lwr-dyn check {file}
schema = 1
name = "{name}"
title = "My arm"

[document]
title = "The paper or data sheet"
origin = "Who published it"

[joints]
# One word per joint, from the base outward: "revolute" or "prismatic".
kinds = {kinds}
# names = ["A1", "A2"]            # joint_1, joint_2, ... if left out

[base]
gravity = {{ values = [0, 0, -9.81], unit = "m/s^2", where = "not given", kind = "assumed" }}

[dh]
# "standard": T = Rz(theta) Tz(d) Tx(a) Rx(alpha); "modified" (Craig): T = Rx(alpha) Tx(a) Rz(theta) Tz(d)
convention = "{convention}"
alpha = {{ values = {alpha}, unit = "deg", where = "fill in", kind = "assumed" }}
a = {{ values = {a}, unit = "m", where = "fill in", kind = "assumed" }}
d = {{ values = {d}, unit = "m", where = "fill in", kind = "assumed" }}
# Optional: the constant part of theta, and -1 where the maker counts a joint against the DH axis.
# theta_offset = {{ values = {zeros}, unit = "deg", where = "", kind = "assumed" }}
# sign = {{ values = {ones}, unit = "1", where = "", kind = "assumed" }}

[flange]
# Pose of the flange in the last DH frame; leave the table out if they are the same.
xyz = {{ values = [0, 0, 0.1], unit = "m", where = "fill in", kind = "assumed" }}
rpy = {{ values = [0, 0, 0], unit = "deg", where = "fill in", kind = "assumed" }}

[limits]
# Units of a prismatic joint are m, m/s, N; a column may give one unit per joint: unit = ["deg", "m"]
lower = {{ values = {lower}, unit = {angle}, where = "fill in", kind = "assumed" }}
upper = {{ values = {upper}, unit = {angle}, where = "fill in", kind = "assumed" }}
velocity = {{ values = {velocity}, unit = {speed}, where = "fill in", kind = "assumed" }}
effort = {{ values = {effort}, unit = {force}, where = "fill in", kind = "assumed" }}
# Optional: zero = the DH coordinate at which the printed coordinate reads zero.

[inertial]
# Leave the table out if the source gives no masses: kinematics still works.
mass = {{ values = {mass}, unit = "kg", where = "fill in", kind = "assumed" }}
# Centre of mass in DH frame i, from its origin.
com = {{ values = {com}, unit = "m", where = "fill in", kind = "assumed" }}
# About "com" or "origin" of DH frame i; axes of that frame; products as "tensor" (-integral) or "integral" (+integral).
inertia = {{ values = [
{inertia}], unit = "kg m^2", about = "com", axes = "frame", products = "tensor", where = "fill in", kind = "assumed" }}

# [rotors]                        # seen at the joint as gear_ratio^2 * inertia
# gear_ratio = {{ values = {ones}, unit = "1", where = "", kind = "assumed" }}
# inertia = {{ values = {zeros}, unit = "kg m^2", where = "", kind = "assumed" }}
# or, where the source gives it as the joint feels it:  armature = {{ ... unit = "kg m^2" ... }}

# [transmission]                  # motors turn by dq_m = T dq, T_ij = signs_ij ratio_j / stage_j
# ratio = {{ values = {ones}, unit = "1", where = "", kind = "assumed" }}
# signs = {{ values = [[1, 0, ...], ...], unit = "1", where = "", kind = "assumed" }}

# [friction]
# viscous = {{ values = {zeros}, unit = "N m s/rad", where = "", kind = "assumed" }}
# coulomb = {{ values = {zeros}, unit = "N m", where = "", kind = "assumed" }}
# or per direction: positive_coulomb, positive_viscous, negative_coulomb, negative_viscous, and optionally
# ..._static, ..._stribeck_velocity, offset, covered (the speed up to which it was measured)

# [gains]                         # of the arm's own joint controller: kp, kd, and optionally ki, effort
# kp = {{ values = {ones}, unit = "N m/rad", where = "", kind = "assumed" }}
# kd = {{ values = {ones}, unit = "N m s/rad", where = "", kind = "assumed" }}

# A slip in the source is not edited above but written here, and a reading lists the errata it applies:
# [[erratum]]
# id = "mass-2"
# where = "Table 1, row 2"
# printed = "30"
# read_as = "3.0"
# why = "the total of 8.0 kg is printed two lines below"
# effect = "torque at joint 1 halves"
# status = "proven"               # proven, likely or open
# patch = [{{ at = "inertial.mass.values[1]", printed = 30, read = 3.0 }}]
# [reading.printed]
# about = "as printed"
# [reading.corrected]
# about = "with the mass put right"
# errata = ["mass-2"]
"""


def template(file: str, name: str, joints: str = "RRRRRR", convention: str = "standard") -> str:
    """The text of a new data file.

    Parameters
    ----------
    file : str
        Its path, for the comment.
    name : str
        The robot's name.
    joints : str
        R or P per joint from the base outward, at least one.
    convention : {"standard", "modified"}

    Raises
    ------
    OptionError
        Other letters or another convention.

    >>> 'kinds = ["revolute", "prismatic"]' in template("x.toml", "x", "RP")
    True
    """
    if not joints or set(joints) - set("RP"):
        raise OptionError("joints", repr(joints), "R or P per joint, such as RRRRRR or RRP")
    if convention not in ("standard", "modified"):
        raise OptionError("convention", repr(convention), "standard, modified")
    n = len(joints)
    sliding = [letter == "P" for letter in joints]

    def pick(turning: object, straight: object) -> str:
        return _list(straight if s else turning for s in sliding)

    def unit(turning: str, straight: str) -> str:
        return f'"{turning}"' if not any(sliding) else pick(turning, straight)

    alpha = [(90, -90)[i % 2] if i < n - 1 else 0 for i in range(n)]
    tensor = "    [[0.01, 0, 0], [0, 0.01, 0], [0, 0, 0.004]],\n"
    return _HEAD.format(
        file=file, name=name, convention=convention, kinds=_list("prismatic" if s else "revolute" for s in sliding),
        alpha=_list(alpha), a=_list([0] * n), d=_list(0.3 if i % 2 == 0 else 0 for i in range(n)),
        zeros=_list([0] * n), ones=_list([1] * n), lower=pick(-170, 0), upper=pick(170, 0.5),
        velocity=pick(120, 0.5), effort=_list([100] * n), angle=unit("deg", "m"), speed=unit("deg/s", "m/s"),
        force=unit("N m", "N"), mass=_list([2.0] * n), com=_list([[0, 0, -0.05]] * n), inertia=tensor * n,
    )  # fmt: skip


def _list(values: Iterable[object]) -> str:
    """A TOML list."""
    return "[" + ", ".join(f'"{v}"' if isinstance(v, str) else str(v) for v in values) + "]"
