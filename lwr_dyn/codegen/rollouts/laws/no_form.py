"""The error of a controller that kernels cannot take."""

from lwr_dyn.foundation.errors import OptionError


class NoKernelFormError(OptionError):
    """A controller without a form that kernels take, or one that does not act as its form."""
