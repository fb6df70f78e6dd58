"""Which test files belong to a module."""

from tests.own_tests import TESTS, covered, own_tests


def test_a_file_belongs_to_the_module_with_the_longest_name_and_a_row_adds_others(tmp_path):
    package, tests = tmp_path / "lwr_dyn" / "control", tmp_path / "tests" / "control"
    for folder, names in ((package, ("gain", "gain_map")), (tests, ("test_gain", "test_gain_map_edges", "test_gains"))):
        folder.mkdir(parents=True)
        for name in (*names, f"{names[0]}_bounds"):
            (folder / f"{name}.py").touch()
    (package / "gain_bounds.py").unlink()
    names = [path.name for path in own_tests("control/gain", tests.parent, {})]
    assert names == ["test_gain.py", "test_gain_bounds.py"]
    assert [path.name for path in own_tests("control/gain_map", tests.parent, {})] == ["test_gain_map_edges.py"]
    rows = {"control/gain": ["control/test_gain.py", "laws/test_stable.py"]}
    assert own_tests("control/gain", tests.parent, rows)[2:] == [tests.parent / "laws/test_stable.py"]
    assert own_tests("control/other", tests.parent, rows) == []


def test_the_table_is_read():
    assert own_tests("cli/identify/group") == [
        *(TESTS / "cli/identify" / name for name in ("test_friction.py", "test_table.py")),
        *(TESTS / name for name in ("cli/test_options.py", "cli/test_main_commands.py", "custody/test_help_text.py")),
        TESTS / "custody/test_values.py",
    ]
    of_the_recursion = covered()["dynamics/newton_euler"]
    assert "laws/test_dynamics_laws.py" in of_the_recursion
    assert own_tests("dynamics/newton_euler") == [TESTS / row for row in (*of_the_recursion, "custody/test_values.py")]
