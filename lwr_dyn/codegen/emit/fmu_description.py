"""The modelDescription.xml of an FMU: arrays in FMI 3.0, one scalar variable a number in FMI 2.0.

A value reference is the variable's number in FMI 3, and number * 1000 + place in FMI 2, as `fmu.c` reads them.
References: Modelica Association, FMI 2.0.5 section 2.2 and FMI 3.0.2 section 2.4.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import count
from typing import Self
from xml.sax.saxutils import quoteattr

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.version import VERSION

PLACES = 1000
"""Value references of one variable in FMI 2."""
_UNITS = {
    "rad": 'rad="1"', "rad/s": 'rad="1" s="-1"', "rad/s2": 'rad="1" s="-2"', "N.m": 'kg="1" m="2" s="-2"',
    "m": 'm="1"', "m/s": 'm="1" s="-1"', "m/s2": 'm="1" s="-2"', "N": 'kg="1" m="1" s="-2"', "s": 's="1"',
    "kg": 'kg="1"', "kg.m2": 'kg="1" m="2"',
}  # fmt: skip


@dataclass(frozen=True, slots=True, eq=False)
class FmuVariable:
    """A variable of an FMU: its numbers at the start (width,), in one unit."""

    name: str
    causality: str
    variability: str
    start: Array
    unit: str = ""
    about: str = ""
    calculated: bool = False
    """Whether the FMU gives it: then it has no start value of its own."""
    derivative_of: str = ""
    shape: tuple[int, ...] = ()
    """Of an array with several dimensions."""

    def __repr__(self) -> str:
        return f"{self.name} {self.causality} {self.variability} {self.start.tolist()} {self.unit} {self.about}"

    def derived_from(self, state: str) -> Self:
        """The same as the derivative of a state."""
        return replace(self, derivative_of=state)

    def dimensions(self) -> tuple[int, ...]:
        """Those of an array; none of a number."""
        return self.shape or ((self.start.size,) if self.start.size > 1 else ())

    def scalar_names(self) -> list[str]:
        """The names of its numbers in FMI 2, as name[1] or name[1,1]."""
        if not self.dimensions():
            return [self.name]
        places = np.ndindex(*self.dimensions())
        return [f"{self.name}[{','.join(str(k + 1) for k in place)}]" for place in places]

    def attributes(self) -> str:
        """Those that both versions have."""
        initial = "calculated" if self.calculated else "exact" if self.causality == "parameter" else ""
        words = f'causality="{self.causality}" variability="{self.variability}"'
        words += f' initial="{initial}"' if initial else ""
        return words + (f" description={quoteattr(self.about)}" if self.about else "")


def model_description(
    version: str,
    name: str,
    token: str,
    about: str,
    variables: Sequence[FmuVariable],
    sources: Sequence[str],
    sample: float | None,
) -> str:
    """The text; `sample` [s] is that of a controller, None of a plant."""
    known = {"2": "guid", "3": "instantiationToken"}[version]
    head = f'fmiVersion="{version}.0" modelName={quoteattr(name)} {known}="{token}" description={quoteattr(about)}'
    more = ' numberOfEventIndicators="0"' if version == "2" else ""
    units = sorted({x.unit for x in variables} - {""})
    return "\n".join([
        '<?xml version="1.0" encoding="UTF-8"?>',
        f'<fmiModelDescription {head} generationTool="lwr_dyn {VERSION}" variableNamingConvention="structured"{more}>',
        *_interfaces(version, name, sources, sample),
        *(["<UnitDefinitions>", *(f'<Unit name="{x}"><BaseUnit {_UNITS[x]}/></Unit>' for x in units),
           "</UnitDefinitions>"] if units else []),
        f'<DefaultExperiment startTime="0" stopTime="1" stepSize="{sample or 0.001!r}"/>',
        "<ModelVariables>", *(_arrays(variables) if version == "3" else _scalars(variables)), "</ModelVariables>",
        "<ModelStructure>",
        *(_structure(variables) if version == "3" else _structure_of_scalars(variables)),
        "</ModelStructure>", "</fmiModelDescription>", "",
    ])  # fmt: skip


def build_description(name: str, sources: Sequence[str]) -> str:
    """The buildDescription.xml of FMI 3."""
    listed = "".join(f'<SourceFile name="{x}"/>' for x in sources)
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n<fmiBuildDescription fmiVersion="3.0">'
        f'<BuildConfiguration modelIdentifier="{name}"><SourceFileSet language="C99">{listed}</SourceFileSet>'
        "</BuildConfiguration></fmiBuildDescription>\n"
    )


def _interfaces(version: str, name: str, sources: Sequence[str], sample: float | None) -> Iterator[str]:
    state = "state" if version == "2" else "State"
    can = f'canGetAndSetFMU{state}="true" canSerializeFMU{state}="true"'
    inside = ""
    if sample is None:
        can += f' providesDirectionalDerivative{"" if version == "2" else "s"}="true"'
    if version == "2":
        listed = "".join(f'<File name="{x}"/>' for x in sources)
        inside = f"<SourceFiles>{listed}</SourceFiles>"
    if sample is None:
        yield f'<ModelExchange modelIdentifier="{name}" {can}>{inside}</ModelExchange>'
    steps = f'canHandleVariableCommunicationStepSize="{"true" if sample is None else "false"}"'
    if sample is not None and version == "3":
        steps += f' fixedInternalStepSize="{sample!r}"'
    yield f'<CoSimulation modelIdentifier="{name}" {steps} {can}>{inside}</CoSimulation>'


def _arrays(variables: Sequence[FmuVariable]) -> Iterator[str]:
    numbers = {x.name: k for k, x in enumerate(variables)}
    for k, x in enumerate(variables):
        text = f'<Float64 name="{x.name}" valueReference="{k}" {x.attributes()}'
        text += f' unit="{x.unit}"' if x.unit else ""
        text += f' derivative="{numbers[x.derivative_of]}"' if x.derivative_of else ""
        start = " ".join(repr(float(v)) for v in x.start)
        text += "" if x.calculated else f' start="{start}"'
        dimensions = "".join(f'<Dimension start="{n}"/>' for n in x.dimensions())
        yield f"{text}>{dimensions}</Float64>"
    place = f'valueReference="{len(variables)}"'
    yield f'<Float64 name="time" {place} causality="independent" variability="continuous"/>'


def _indices(variables: Sequence[FmuVariable]) -> dict[str, list[int]]:
    """FmuVariable -> the indices of its numbers, from 1."""
    following = count(1)
    return {x.name: [next(following) for _ in x.start] for x in variables}


def _scalars(variables: Sequence[FmuVariable]) -> Iterator[str]:
    indices = _indices(variables)
    for k, x in enumerate(variables):
        for i, name in enumerate(x.scalar_names()):
            real = f' unit="{x.unit}"' if x.unit else ""
            real += f' derivative="{indices[x.derivative_of][i]}"' if x.derivative_of else ""
            real += "" if x.calculated else f' start="{float(x.start[i])!r}"'
            head = f'<ScalarVariable name="{name}" valueReference="{k * PLACES + i}" {x.attributes()}>'
            yield f"{head}<Real{real}/></ScalarVariable>"


def _structure(variables: Sequence[FmuVariable]) -> Iterator[str]:
    given = {x.name: k for k, x in enumerate(variables) if x.causality == "output" or x.derivative_of}
    for k, x in enumerate(variables):
        if x.causality == "output":
            yield f'<Output valueReference="{k}"/>'
    for k, x in enumerate(variables):
        if x.derivative_of:
            yield f'<ContinuousStateDerivative valueReference="{k}"/>'
    for k in given.values():
        yield f'<InitialUnknown valueReference="{k}"/>'


def _structure_of_scalars(variables: Sequence[FmuVariable]) -> Iterator[str]:
    indices = _indices(variables)
    outputs = [i for x in variables if x.causality == "output" for i in indices[x.name]]
    derivatives = [i for x in variables if x.derivative_of for i in indices[x.name]]
    for tag, rows in (
        ("Outputs", outputs), ("Derivatives", derivatives), ("InitialUnknowns", sorted({*outputs, *derivatives})),
    ):  # fmt: skip
        if rows:
            listed = "".join(f'<Unknown index="{i}"/>' for i in rows)
            yield f"<{tag}>{listed}</{tag}>"
