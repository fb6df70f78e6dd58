"""Plants by name: each is the arm of the controllers' model, changed in one thing that they do not know of.

`payload=3` gives a row its value; `payload=3+friction` changes two things.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from lwr_dyn.arms.loading import load_with_paper
from lwr_dyn.control.laws.friction_compensation import coulomb_friction
from lwr_dyn.foundation.arrays import number_of
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.foundation.registry import Registry, Row
from lwr_dyn.model.arm import Arm, arm_with_scaled_inertia
from lwr_dyn.simulation.plant import Encoder
from lwr_dyn.simulation.setup import ENCODERS
from lwr_dyn.simulation.walls_and_pushes import Wall

ASSUMED = "0.05"
"""Share of the torque limits that is Coulomb friction where the arm has none of its own and no share is given."""
FRICTIONLESS: Mapping[str, Any] = {"friction": "none"}


@dataclass(frozen=True, slots=True, eq=False)
class PlantCase:
    """A plant: `options` of `simulate` beside the controllers' arm; `words` for what a run does not record."""

    arm: Arm
    options: Mapping[str, Any] = field(default_factory=lambda: FRICTIONLESS)
    words: tuple[str, ...] = ()

    @property
    def plant(self) -> Arm:
        """The arm that is simulated."""
        arm: Arm = self.options.get("plant", self.arm)
        return arm

    def changed(self, words: str = "", **options: Any) -> "PlantCase":
        """The same with more options."""
        said = (*self.words, words) if words else self.words
        return replace(self, options={**self.options, **options}, words=said)


PLANTS: Registry[Callable[[PlantCase, str], PlantCase]] = Registry(
    "plant",
    {
        "nominal": Row("lwr_dyn.studies.compare.plants:nominal", "the model itself, without friction"),
        "payload": Row("lwr_dyn.studies.compare.plants:payload", "kg at the flange, as payload=3"),
        "scale": Row("lwr_dyn.studies.compare.plants:scale", "all masses times a factor, as scale=1.1"),
        "reading": Row("lwr_dyn.studies.compare.plants:reading", "another reading, as reading=printed"),
        "friction": Row(
            "lwr_dyn.studies.compare.plants:friction",
            "the arm's own, else Coulomb's; a share of the torque limits, as friction=0.05",
        ),
        "encoder": Row("lwr_dyn.studies.compare.plants:encoder", "bits a turn, as encoder=16"),
        "noise": Row(
            "lwr_dyn.studies.compare.plants:noise", "of the encoders, rad (m), one standard deviation, as noise=1e-5"
        ),
        "elastic": Row(
            "lwr_dyn.studies.compare.plants:elastic",
            "gears with the springs of the arm's file; the largest stiffness in N m/rad, as elastic=3e4",
        ),
        "encoders": Row("lwr_dyn.studies.compare.plants:encoders", "of elastic joints, as elastic+encoders=link"),
        "delay": Row("lwr_dyn.studies.compare.plants:delay", "samples from a command to its torque, as delay=2"),
        "table": Row("lwr_dyn.studies.compare.plants:table", "a compliant table below the tip, z in m, as table=0.1"),
    },
)
"""Each row changes a case: `factory(case, value)`, value as text, "" where none is given."""


def plant_case(arm: Arm, text: str) -> PlantCase:
    """The plant of a text such as "payload=3+friction".

    Raises
    ------
    UnknownNameError
        No plant or reading of that name.
    OptionError
        A value that is missing, not needed, or outside what is allowed; the same plant twice.

    >>> from lwr_dyn import load
    >>> case = plant_case(load("lwr4plus"), "payload=3+scale=1.1")
    >>> case.words, case.options["payload"]
    (('masses times 1.1',), 3.0)
    """
    case, names = PlantCase(arm), []
    for part in text.split("+"):
        name, _, value = (piece.strip() for piece in part.partition("="))
        change = PLANTS.load(name)
        if name in names:
            raise OptionError(f"plant {text!r}", f"{name} twice", "each change once")
        names.append(name)
        case = change(case, value)
    return case


def nominal(case: PlantCase, value: str) -> PlantCase:
    """As the model has it."""
    if value:
        raise OptionError("plant nominal", f"with the value {value!r}", "nominal, without a value")
    return case


def payload(case: PlantCase, value: str) -> PlantCase:
    """A point mass [kg] at the flange, or at the tool centre point."""
    mass = _number("payload", value, "a mass in kg above 0, as payload=3")
    return case.changed(payload=mass)


def scale(case: PlantCase, value: str) -> PlantCase:
    """All masses and inertias times a factor."""
    factor = _number("scale", value, "a factor above 0, as scale=1.1")
    return case.changed(f"masses times {factor:g}", plant=arm_with_scaled_inertia(case.plant, factor))


def reading(case: PlantCase, value: str) -> PlantCase:
    """The arm as another reading of its source has it."""
    if not value:
        raise OptionError("plant reading", "no name", "a reading of the robot, as reading=printed")
    if "plant" in case.options:
        raise OptionError("plant reading", "after a change of masses", "the reading first: reading=NAME+scale=FACTOR")
    other, _ = load_with_paper(case.arm.file or case.arm.name, value, **case.arm.loaded_with)
    return case.changed(f"reading {value}", plant=other)


def friction(case: PlantCase, value: str) -> PlantCase:
    """The arm's own friction, or Coulomb friction as a share of each joint's torque limit."""
    if not value and case.plant.has_friction:
        return case.changed(friction="set-valued")
    share = _number("friction", value or ASSUMED, "a share of the torque limits above 0, as friction=0.05")
    models = coulomb_friction(case.plant, share)
    assumed = "" if value else "assumed "
    return case.changed(f"{assumed}Coulomb friction, {100 * share:.3g} % of the torque limits", friction=models)


def encoder(case: PlantCase, value: str) -> PlantCase:
    """Positions rounded to the counts of an encoder, speeds from filtered differences."""
    bits = _whole("encoder", value, 40, "a number of bits from 1 to 40, as encoder=16")
    given: Encoder = case.options.get("encoder") or Encoder()
    return case.changed(f"encoder of {bits} bits", encoder=replace(Encoder.of_bits(bits), noise=given.noise))


def noise(case: PlantCase, value: str) -> PlantCase:
    """Positions with Gaussian noise, the same at every run; speeds from filtered differences."""
    deviation = _number("noise", value, "a standard deviation above 0, in rad or m, as noise=1e-5")
    given: Encoder = case.options.get("encoder") or Encoder()
    return case.changed(f"encoder noise of {deviation:g} rad or m", encoder=replace(given, noise=deviation))


def delay(case: PlantCase, value: str) -> PlantCase:
    """Torques that act some samples after their command."""
    samples = _whole("delay", value, 1000, "a number of samples from 1 to 1000, as delay=2")
    return case.changed(f"delay of {samples} sample{'s' if samples > 1 else ''}", delay=samples)


def elastic(case: PlantCase, value: str) -> PlantCase:
    """Joints whose gears are springs, as the arm's file has them or of another stiffness; laws read the motors."""
    if not value:
        return case.changed("elastic joints", elasticity="file")
    stiffness = _number("elastic", value, "the largest stiffness above 0, in N m/rad, as elastic=3e4")
    return case.changed(f"elastic joints, {stiffness:g} N m/rad", elasticity=stiffness)


def encoders(case: PlantCase, value: str) -> PlantCase:
    """Elastic joints whose encoders are on the side of the links, or of the motors."""
    if "elasticity" not in case.options:
        raise OptionError("plant encoders", "on rigid joints", "after elastic: elastic+encoders=link")
    if value not in ENCODERS:
        raise OptionError("plant encoders", repr(value) if value else "no value", " or ".join(ENCODERS))
    return case.changed(f"encoders on the {value} side", encoders=value)


def table(case: PlantCase, value: str) -> PlantCase:
    """A horizontal `Wall` with its defaults, at a height z [m] in the base, under the tip."""
    height = _number("table", value, "a height in m, as table=0.1", above=-np.inf)
    wall = Wall(case.plant, [0.0, 0.0, height], [0.0, 0.0, 1.0])
    return case.changed(f"a table at {height:g} m", external=wall)


def _number(name: str, value: str, allowed: str, above: float = 0.0) -> float:
    try:
        number = number_of(value)
    except ValueError:
        number = np.nan
    if not (np.isfinite(number) and number > above):
        raise OptionError(f"plant {name}", repr(value) if value else "no value", allowed)
    return number


def _whole(name: str, value: str, most: int, allowed: str) -> int:
    number = _number(name, value, allowed)
    if number != int(number) or number > most:
        raise OptionError(f"plant {name}", repr(value), allowed)
    return int(number)
