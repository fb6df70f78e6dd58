from tests.checks.urdf.broken_files import broken, judged


def test_broken_files_are_judged_without_an_exception():
    """A share of `scripts/soak.py linter_broken`."""
    counts = [judged(seed) for seed in range(120)]
    assert sum(count > 0 for count in counts) > 80
    assert len({broken(seed) for seed in range(120)}) > 110
