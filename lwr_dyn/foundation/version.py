"""The versions of this package and of others, in a module without imports so that every other module can use it."""

VERSION = "0.3.0"

_known: dict[str, str] = {}


def package_version(name: str) -> str:
    """The version of an installed package, whose files are read once; raises `PackageNotFoundError`.

    >>> package_version("numpy").count(".") > 0
    True
    """
    if name not in _known:
        from importlib.metadata import version

        _known[name] = version(name)
    return _known[name]
