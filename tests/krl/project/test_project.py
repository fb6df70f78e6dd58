"""A project: which names a module sees, its data in a run; random projects against a second way to say it."""

import random

import pytest

from lwr_dyn.foundation.errors import FileAccessError
from lwr_dyn.krl.checks.static_checks import check_project
from lwr_dyn.krl.language.source import parse_bytes
from lwr_dyn.krl.project.program import load_program, load_project, program_in
from lwr_dyn.krl.project.project import module_file, project_of
from lwr_dyn.krl.running.program_run import ProgramError, check_program, run_program
from tests.krl.mutations import SOURCES, mutated
from tests.krl.random_projects import disagreement

HOME = "$VEL_AXIS[1]=100\nPTP {A1 0, A2 -90, A3 90, A4 0, A5 30, A6 0}\n"


@pytest.fixture
def folder(tmp_path):
    def write(files):
        for name, text in files.items():
            (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
            (tmp_path / name).write_text(text)
        return tmp_path

    return write


def program(folder, name):
    project = load_project(folder)
    return program_in(project, project.homes[name])


def told(folder, name):
    return [(d.position.file, d.position.line, d.code) for d in check_program(program(folder, name))]


B = {"b.src": "DEF b( )\nEND\nDEF inner( )\nEND\n", "b.dat": "DEFDAT b PUBLIC\nINT local\nENDDAT\n"}
SEEN = {
    "what is global in a public data list": (
        {"a.src": "DEF a( )\nseen = 1\nhidden = 2\nlocal = 3\nOWN = 4\nEND\n",
         "a.dat": "DEFDAT a\nINT own\nEXT far( )\nENDDAT\n",
         "b.dat": "DEFDAT b PUBLIC\nDECL GLOBAL INT seen\nINT local\nENDDAT\n",
         "c.dat": "DEFDAT c\nGLOBAL INT hidden\nENDDAT\n"},
        {"a.src": ["a.src:3 undeclared", "a.src:4 undeclared"], "c.dat": ["c.dat:1 hidden-global"]}),
    "types by the same rule, and all of the configuration": (
        {"a.src": "DEF a( )\nDECL T1 x\nDECL T2 y\nDECL T3 z\nx.n = 1\nEND\n",
         "b.dat": "DEFDAT b PUBLIC\nGLOBAL STRUC T1 INT n\nENUM T2 ON_1, OFF_1\nENDDAT\n",
         "System/$config.dat": "DEFDAT $config\nENUM T3 A_1, B_1\nENDDAT\n"},
        {"a.src": ["a.src:3 unknown-type"]}),
    "of routines the first and the global ones": (
        {"a.src": "DEF a( )\nb( )\nshared( )\ninner( )\nmine( )\nEND\nDEF mine( )\nEND\n",
         "b.src": "DEF b( )\nEND\nGLOBAL DEF shared( )\nEND\nDEF inner( )\nEND\n"},
        {"a.src": ["a.src:4 unknown-call"]}),
    "the controller apart from the robot": (
        {"KRC/R1/Program/a.src": "DEF a( )\nof_robot = 1\nof_controller = 1\nEND\n",
         "KRC/R1/System/$config.dat": "DEFDAT $CONFIG\nINT of_robot\nENDDAT\n",
         "KRC/STEU/$config.dat": "DEFDAT $CONFIG\nINT of_controller\nENDDAT\n"},
        {"KRC/R1/Program/a.src": ["KRC/R1/Program/a.src:3 undeclared"]}),
    "a data list of another name": (
        {"a.src": "DEF a( )\nn = 1\nEND\n", "a.dat": "DEFDAT other\nINT n\nENDDAT\n"},
        {"a.src": ["a.dat:1 module-name"]}),
}  # fmt: skip


@pytest.mark.parametrize(("files", "expected"), SEEN.values(), ids=SEEN)
def test_a_module_sees(folder, files, expected):
    where = folder(files)
    assert {name: [f"{file}:{line} {code}" for file, line, code in told(where, name)] for name in expected} == expected


def test_the_hint_names_the_file_that_hides_a_name(folder):
    where = folder({"a.src": "DEF a( )\nlocal = 1\ninner( )\nEND\n", **B})
    hints = [d.hint for d in check_program(program(where, "a.src"))]
    assert [hint.split(" declares")[0] for hint in hints] == ["b.dat", "b.src"]


def test_of_two_modules_of_one_name_the_nearest_is_taken_and_both_are_told(folder):
    where = folder({
        "new/a.src": "DEF a( )\nb(1)\nEND\n", "old/a.src": "DEF a( )\nb(1)\nEND\n",
        "new/b.src": "DEF b(n:IN)\nINT n\nEND\n", "old/b.src": "DEF b( )\nEND\n",
    })  # fmt: skip
    assert (told(where, "new/a.src"), told(where, "old/a.src")) == ([], [("old/a.src", 2, "arguments")])
    assert [d.code for d in check_program(load_program(where / "new/a.src", [where]))] == ["module-twice"]
    twins = [(d.position.file, d.code) for d in load_project(where).twins()]
    assert twins == [(f"{x}/{y}.src", "module-twice") for y in "ab" for x in ("new", "old")]


def test_a_lent_file_that_cannot_be_read_is_told(folder):
    where = folder({"a.src": "DEF a( )\nHALT\nEND\n", "b.dat": "DEFDAT b\nINT 1n\nINT m[\nENDDAT\n"})
    (diagnostic,) = check_program(load_program(where / "a.src", [where / "b.dat"]))
    assert (diagnostic.position.file, diagnostic.position.line, diagnostic.code) == ("b.dat", 2, "lent-file")
    assert (diagnostic.severity, "2 faults" in diagnostic.message) == ("warning", True)


def test_a_submit_module_is_read_and_a_whole_folder_can_be_lent(folder):
    where = folder({
        "run/sps.sub": "DEF sps( )\nLOOP\ntold = TRUE\nhelper( )\nENDLOOP\nEND\n",
        "lent/$config.dat": "DEFDAT $config\nBOOL told\nENDDAT\n",
        "lent/helper.src": "DEF helper( )\nEND\n",
    })  # fmt: skip
    assert check_program(load_program(where / "run/sps.sub", [where / "lent"])) == ()
    assert len(check_program(load_program(where / "run/sps.sub"))) == 2
    with pytest.raises(FileAccessError, match="without KRL files"):
        load_project(folder({"none/x.txt": ""}) / "none")


def test_each_module_has_its_own_data_while_a_program_runs(folder, arm):
    where = folder({
        "a.src": f"DEF a( )\n{HOME}b( )\np[3] = 5\nPTP_REL {{A1 p[3]}}\nPTP_REL {{A1 shared}}\nEND\n",
        "a.dat": "DEFDAT a\nDECL INT p[3]\nENDDAT\n",
        "b.src": "DEF b( )\np[5] = 7\nshared = p[5]\nEND\n",
        "b.dat": "DEFDAT b PUBLIC\nDECL INT p[5]\nGLOBAL INT shared = 1\nENDDAT\n",
    })  # fmt: skip
    run = run_program(program(where, "a.src"), arm)
    assert [round(float(x.q[0]) * 57.29577951) for x in run.executed] == [0, 5, 12]
    assert run_program(load_program(where / "a.src", [where / "b.src"]), arm).cycle_time == run.cycle_time


def test_names_that_differ_in_case_only_are_all_read_and_told(folder):
    where = folder({
        "a.src": "DEF a( )\nn = 1\nEND\n",
        "A.src": "DEF A( )\nn = 1\nEND\n",
        "b.src": "DEF b( )\nm = 1\nEND\n",
        "B.DAT": "DEFDAT b\nINT m\nENDDAT\n",
    })  # fmt: skip
    project = load_project(where)
    assert sorted(project.homes) == ["A.src", "B.DAT", "a.src", "b.src"]
    assert [str(m.path) for m in project.modules] == ["A.src", "a.src", "b.src"]
    assert [d.position.file for d in project.twins()] == ["A.src", "a.src"]
    assert told(where, "b.src") == []


def test_a_fault_after_a_function_of_another_module_stands_in_the_calling_line(folder, arm):
    where = folder({
        "a.src": f"DEF a( )\n{HOME}PTP_REL {{A1 far( )}}\nEND\n",
        "b.src": "DEF b( )\nEND\nGLOBAL DEFFCT INT far( )\nRETURN 300\nENDFCT\n",
    })  # fmt: skip
    with pytest.raises(ProgramError, match=r"^a\.src:4:1: A1 = 300 deg"):
        run_program(program(where, "a.src"), arm)


def test_a_lent_routine_whose_blocks_are_faulty_is_run_as_far_as_they_go(folder, arm):
    nested = "FOR I = 1 TO 1\n" * 200 + "FOR I = 2 TO 1\n" + "ENDFOR\n" * 201
    where = folder({
        "a.src": f"DEF a( )\n{HOME}b( )\nEND\n",
        "b.src": f"DEF b( )\nINT I\nUNTIL FALSE\nELSE\nEXIT\n{nested}PTP_REL {{A1 10 * I}}\nEND\n",
    })  # fmt: skip
    run = run_program(load_program(where / "a.src", [where / "b.src"]), arm)
    assert [round(float(x.q[0]) * 57.29577951) for x in run.executed] == [0, 10]


COUNT, SEED = 120, 17
"""scripts/soak.py krl_projects tries more."""


def test_names_are_those_of_the_file_that_the_rule_says():
    rng = random.Random(SEED)
    assert [x for x in (disagreement(rng) for _ in range(COUNT)) if x is not None] == []


def test_broken_files_in_a_project_are_diagnosed():
    rng = random.Random(SEED)
    for _ in range(COUNT // 8):
        texts = {path.name: mutated(path.read_bytes(), rng) for source in SOURCES for path in with_data(source)}
        checked = check_project(project_of(module_file(*parse_bytes(text, name)) for name, text in texts.items()))
        assert sorted(x.name for x in checked) == sorted(texts)
        assert any(x.diagnostics for x in checked)


def with_data(source):
    """A `.src`, and its `.dat` if it has one."""
    return [x for x in (source, source.with_suffix(".dat")) if x.exists()]
