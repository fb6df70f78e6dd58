"""Names that need no declaration: the built-in tables hold together, mend what was wrong, and a user extends them."""

import pytest

from lwr_dyn.foundation.errors import FileAccessError, OptionError
from lwr_dyn.krl.names.known_names import CONFIG, SIMPLE, SYSTEM, Function, Type, known_names
from tests.krl.short_programs import told

NAMES = known_names()
FUNCTIONS, STRUCTURES, ENUMS = NAMES.functions, NAMES.structures, NAMES.enums


def test_the_tables_hold_together_and_know_what_a_program_cannot_write():
    used = {p.type for f in FUNCTIONS.values() for p in f.parameters} | set(SYSTEM.values()) | set(CONFIG.values())
    used |= {f.returns for f in FUNCTIONS.values() if f.returns} | {t for s in STRUCTURES.values() for t in s.values()}
    assert {kind.name for kind in used} <= SIMPLE | {"?"} | set(STRUCTURES) | set(ENUMS)
    assert not set(STRUCTURES) & set(ENUMS)
    assert (len(FUNCTIONS) > 200, len(SYSTEM) > 990, len(STRUCTURES) > 70, len(ENUMS) > 80) == (True,) * 4
    assert [name for name in SYSTEM if not NAMES.origins[name].title] == []
    assert NAMES.read_only <= set(SYSTEM)
    names = ["$IN", "$POS_ACT", "$ROBRUNTIME", "$OUT", "$BASE", "$TIMER", "$OV_PRO"]
    assert [x in NAMES.read_only for x in names] == [True] * 3 + [False] * 4
    assert NAMES.text("$POS_ACT").startswith("E6POS $POS_ACT, read-only")
    assert "Mada" in NAMES.text("$SOFTN_END")


def test_what_was_wrong_against_the_controller_is_mended():
    assert [p.type.name for p in FUNCTIONS["FRAND"].parameters] == ["REAL", "REAL"]
    assert "APO_T" not in STRUCTURES
    assert STRUCTURES["CONT"]["CPTP"].name == "INT"
    returned = {name: FUNCTIONS[name].returns.name for name in ("SAPO", "SAPO_PTP", "SVEL_CP", "SVEL_JOINT")}
    assert returned == {"SAPO": "CONT", "SAPO_PTP": "CONT", "SVEL_CP": "CP", "SVEL_JOINT": "REAL"}
    assert (SYSTEM["$VEL_AXIS"], SYSTEM["$VEL_AXIS"].sizes) == (Type("REAL", 1), (6,))
    types = {"$APO": "CONT", "$INTERRUPT": "BOOL", "$PATHTIME": "PATHTIME_STRUC", "$RED_VEL": "INT",
             "$SOFTN_END": "REAL[]"}  # fmt: skip
    assert {x: str(SYSTEM[x]) for x in types} == types
    assert SYSTEM["$TORQMON"].sizes == (12,)


def test_functions_know_their_arguments_and_modes():
    copy = FUNCTIONS["STRCOPY"]
    assert [(p.type.name, p.mode) for p in copy.parameters] == [("CHAR", "OUT"), ("CHAR", "IN")]
    taken = {x: (FUNCTIONS[x].least, FUNCTIONS[x].most, FUNCTIONS[x].open) for x in ("BAS", "CREAD")}
    assert taken == {"BAS": (1, 2, False), "CREAD": (3, FUNCTIONS["CREAD"].most, True)}
    assert FUNCTIONS["CREAD"].most > 3


def test_kernel_names_need_no_declaration():
    lines = ["DECL KRLMSG_T m", "DECL KRLMSGPAR_T p[3]", "DECL KRLMSGOPT_T o", "INT h", "DECL EKI_STATUS r", "REAL x"]
    lines += ["DECL LDAT L", 'm.MSG_TXT[] = "hi"', "h = SET_KRLMSG(#NOTIFY, m, p[], o)", 'r = EKI_INIT("a")']
    lines += ["SPTP {A1 0} WITH $APO = SAPO_PTP(PDEFAULT), $JERK = SJERK(LDEFAULT)", "ERR_RAISE($ERR)", "x = r.Buff"]
    lines += ["SCIRC {X 1}, {X 2} WITH $CIRC_TYPE = SCIRC_TYP(L), $CIRC_MODE = SCIRC_M(L)", "GRPg_Check(1)"]
    assert told(*lines) == []


@pytest.mark.parametrize(
    ("lines", "expected"),
    [
        (["DECL CONT c", "c.SPEED = 1"], [(3, "warning", "no-component")]),
        (["DECL DATE d", "d = {SEC 1, WEEK 2}"], [(3, "warning", "no-component")]),
        (["DECL MODE_OP m", "m = #T3"], [(3, "warning", "no-constant")]),
        (["DECL FRAME f", "f.T = 1"], [(3, "error", "no-component")]),
        (["DECL EKI_STATUS r", "r.NEWER = 1"], []),
        (["STRUC CONT INT A", "DECL CONT c", "c.CDIS = 1"], [(4, "error", "no-component")]),
        (['MsgNtoify("x")'], [(2, "error", "unknown-call")]),
        (["REAL x", "x = FRAND()"], [(3, "error", "arguments")]),
    ],
)
def test_members_that_versions_differ_in_are_warnings(lines, expected):
    assert told(*lines) == expected


OWN = """
[[group]]
title = "Our welding"
package = "Weld"
functions = ["BOOL WELD_ON(INT number, OUT WELD_DATA data, REAL time?)", "WELD_LOG(CHAR[] text, ...)"]
variables = ["WELD_DATA LAST_WELD, WELDS[20]", "REAL $WELD_TABLE[8,2]"]
[group.structures]
WELD_DATA = "REAL current, voltage, WELD_MODE mode, CHAR name[24]"
EKI_STATUS = "INT BUFF"
[group.enumerations]
WELD_MODE = "short spray"
"""


def test_a_user_adds_names_and_replaces_others(tmp_path):
    file = tmp_path / "own.toml"
    file.write_text(OWN)
    names = known_names([file])
    assert names.functions["WELD_ON"] == Function(Type("BOOL"), names.functions["WELD_ON"].parameters)
    assert str(names.functions["WELD_ON"].parameters[1]) == "WELD_DATA data:OUT"
    assert names.variables["WELDS"] == Type("WELD_DATA", 1)
    assert names.variables["$WELD_TABLE"].sizes == (8, 2)
    assert (names.enums["WELD_MODE"], "EKI_STATUS" in names.open) == ({"SHORT", "SPRAY"}, False)
    assert names.text("weld_log") == "DEF WELD_LOG(CHAR[] text:IN, ...) (Weld: Our welding)"
    assert names.text("$apo") == "CONT $APO (KSS 8.6: Path, approximation, orientation)"
    assert names.text("nowhere") is None
    assert "WELD_ON" not in known_names().functions
    assert "EKI_STATUS" in known_names().open


BAD = {
    "[[group]": "TOML", "": "no [[group]]", "x = 1\n[[group]]": "x", "group = [{title = 'a'}, 3]": "no [[group]]",
    "[[group]]\nfunction = []": "function",
    "[[group]]\nfunctions = 'A()'": "functions", "[[group]]\nfunctions = ['INT']": "INT",
    "[[group]]\nfunctions = ['INT A(INT)']": "INT", "[[group]]\nfunctions = [3]": "3",
    "[[group]]\ntitle = 'T'\nvariables = ['A B C']": "T: variables", "[[group]]\nvariables = ['A']": "A",
    "[[group]]\n[group.structures]\nS = 'INT'": "structures.S", "[[group]]\n[group.structures]\nS = 2": "structures.S",
    "[[group]]\n[group.enumerations]\n'a b' = 'X'": "a b",
}  # fmt: skip


@pytest.mark.parametrize(("text", "named"), BAD.items())
def test_a_bad_file_is_one_clear_line(tmp_path, text, named):
    file = tmp_path / "bad.toml"
    file.write_text(text)
    with pytest.raises(OptionError) as fault:
        known_names([file])
    assert str(file) in str(fault.value)
    assert named in str(fault.value)
    assert "\n" not in str(fault.value)


def test_a_file_that_cannot_be_read_is_told(tmp_path):
    (tmp_path / "bytes.toml").write_bytes(b"\xff\xfe")
    for name in ("none.toml", "bytes.toml"):
        with pytest.raises(FileAccessError):
            known_names([tmp_path / name])
