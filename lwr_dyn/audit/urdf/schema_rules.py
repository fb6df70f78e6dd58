"""Rules of the format: the outermost element, names, tags, attributes, numbers."""

from collections.abc import Iterator

from lwr_dyn.audit.urdf.document import UrdfDocument
from lwr_dyn.audit.urdf.finding import UrdfFinding


def root_tag(document: UrdfDocument) -> Iterator[UrdfFinding]:
    """The outermost element of a URDF is `<robot name="...">`; in a file with another one nothing can be judged."""
    root = document.root
    if root is not None and root.tag != "robot":
        yield UrdfFinding(f"the outermost element is <{root.tag}>", "a URDF is one <robot>", root.place, "", "<robot>")
