"""What is said of an origin."""

from lwr_dyn.checks.origin.link_numbers import known_set
from lwr_dyn.checks.origin.origin_document import origin_document
from lwr_dyn.checks.origin.tracing import trace_origin


def test_a_copy_and_none():
    links = known_set("ur10e", "maker").links
    document = origin_document("a.urdf", links, trace_origin(links))
    assert document.verdict.startswith("a.urdf: numbers of ur10e:maker")
    assert "ur10:maker" in document.text()
    assert document.record()["origin"] == "ur10e:maker"
    assert len(document.record()["links"]) == 6
    none = origin_document("a.urdf", links, None)
    assert none.verdict == "a.urdf: the numbers of no published set here"
    assert none.record()["origin"] is None
