"""Planted slips: a module with one piece of its text replaced, which the check of that module must not pass.

SLIPS = (("+ self._gravity(q)", "- self._gravity(q)"), ...)
def check(law: ModuleType) -> None: ...  # asserts; reads the law from the module that it is given
def test_planted_slips_are_caught() -> None:
    assert not uncaught("lwr_dyn.control.paper_laws", SLIPS, check)
"""

import sys
from collections.abc import Callable, Iterable
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from types import ModuleType

import numpy as np

from lwr_dyn.foundation.errors import LwrDynError

Slip = tuple[str, str]
"""The text that is replaced, which stands in the module once, and what stands there instead."""
Check = Callable[[ModuleType], None]
SEEN = (AssertionError, LwrDynError, ArithmeticError, np.linalg.LinAlgError)
"""What a check may raise over a slip; anything else, such as a `NameError`, is a slip that is badly written."""


def slipped(module_name: str, old: str, new: str) -> ModuleType:
    """The module with `old`, which must stand in its text exactly once, replaced by `new`; `sys.modules` is unchanged.

    >>> slipped("lwr_dyn.control.gains", "omega_n**2 * b", "omega_n * b").second_order_gains([2.0], 10.0).Kp
    array([20.])
    """
    spec = find_spec(module_name)
    assert spec is not None
    assert spec.origin is not None
    text = Path(spec.origin).read_text(encoding="utf-8")
    assert text.count(old) == 1, f"{module_name}: {old!r} stands {text.count(old)} times in it"
    assert old != new, old
    module = ModuleType(f"slipped_{module_name.replace('.', '_')}")
    module.__file__, module.__package__ = spec.origin, module_name.rpartition(".")[0]
    sys.modules[module.__name__] = module  # dataclasses look their module up there
    try:
        exec(compile(text.replace(old, new), f"{spec.origin} with a slip", "exec"), module.__dict__)
    finally:
        del sys.modules[module.__name__]
    return module


def uncaught(module_name: str, slips: Iterable[Slip], check: Check) -> list[str]:
    """The slips that the check passes all the same; the module as it stands must pass it."""
    _forget()
    check(import_module(module_name))
    passed = []
    for old, new in slips:
        _forget()
        try:
            with np.errstate(all="ignore"):
                check(slipped(module_name, old, new))
        except SEEN:
            continue
        finally:
            _forget()
        passed.append(f"{old!r} -> {new!r}")
    return passed


def _forget() -> None:
    """Traced forms of laws are kept by the law's name: that of a slipped law must serve no other test."""
    if (forms := sys.modules.get("lwr_dyn.codegen.rollouts.law_forms")) is not None:
        forms._functions.clear()
