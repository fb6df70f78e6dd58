"""A controller from a Python file of a user's own; whatever fails in the file becomes one line that says where."""

import inspect
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from traceback import extract_tb
from types import ModuleType
from typing import Any, cast

from lwr_dyn.control.protocol import Controller
from lwr_dyn.dynamics.protocol import Dynamics
from lwr_dyn.foundation.errors import FileAccessError, LwrDynError
from lwr_dyn.foundation.files import read_text
from lwr_dyn.foundation.registry import check_options
from lwr_dyn.model.arm import Arm

NEEDED = "a Python file with controller(t, q, dq, q_ref, dq_ref, ddq_ref), or make(arm, dynamics) that returns one"


def controller_from_file(path: str, arm: Arm, dynamics: Dynamics, **options: Any) -> Controller:
    """The controller of a Python file: its function `controller`, or what its function `make` returns.

    The file holds `make(arm, dynamics)`, or else `controller(t, q, dq, q_ref, dq_ref, ddq_ref)` itself. A function
    without a `name` of its own is named as the file, such as "mine.py".

    Raises
    ------
    FileAccessError
        The file cannot be read, an error is raised in it (says in which line), or it holds no controller.
    OptionError
        An option that `make` does not know.
    """
    module = _run(path)
    controller, make = getattr(module, "controller", None), getattr(module, "make", None)
    if make is not None:
        if not _takes(make, 2):
            raise FileAccessError(path, "make does not take two arguments", NEEDED)
        check_options(f"make in {path}", make, 2, options)
        with faults_in(path):
            controller = make(arm, dynamics, **options)
    if controller is None or not _takes(controller, 6):
        raise FileAccessError(path, "no function of six arguments for a controller", NEEDED)
    if inspect.isfunction(controller) and not hasattr(controller, "name"):
        controller.name = Path(path).name  # type: ignore[attr-defined]
    return cast(Controller, controller)


@contextmanager
def faults_in(path: str) -> Iterator[None]:
    """Turns an error that the code of a file raises into a `FileAccessError` that says in which line."""
    try:
        yield
    except LwrDynError:
        raise
    except (Exception, SystemExit) as fault:
        lines = [frame.lineno for frame in extract_tb(fault.__traceback__) if frame.filename == path]
        if isinstance(fault, SyntaxError) and fault.filename == path:
            lines = [fault.lineno]
        if not lines:
            raise
        text = f"line {lines[-1]}: {type(fault).__name__}: {getattr(fault, 'msg', fault)}"
        raise FileAccessError(path, text, "a controller that runs") from fault


def _run(path: str) -> ModuleType:
    text = read_text(path, NEEDED)
    module = ModuleType(f"lwr_dyn_controller_{Path(path).stem}")
    module.__file__ = path
    sys.modules[module.__name__] = module  # dataclasses look their module up there
    with faults_in(path):
        exec(compile(text, path, "exec"), module.__dict__)
    return module


def _takes(function: Any, arguments: int) -> bool:
    try:
        inspect.signature(function).bind(*range(arguments))
    except (TypeError, ValueError):
        return False
    return True
