"""`lwr-dyn conventions`: output, exit codes, one clear line for bad input."""

import pytest

from lwr_dyn.arms.papers.catalog import template

NUMBER = """
[[number]]
quantity = "{quantity}"
joint = "{joint}"
value = {value}
unit = "{unit}"
where = "somewhere"
{rest}
"""


@pytest.fixture
def evidence(tmp_path):
    def write(text):
        path = tmp_path / "evidence.toml"
        path.write_text(text, encoding="utf-8")
        return str(path)

    return write


def number(quantity="inertia", joint="joint_2", value='"2.9"', unit="kg m^2", rest="q = [0, 0, 0, 0, 0, 0, 0]"):
    return NUMBER.format(quantity=quantity, joint=joint, value=value, unit=unit, rest=rest)


def test_wam_as_text_and_json(printed, recorded):
    out = printed("conventions", "wam7")
    assert "link 1, 3, 6: products of inertia +integral (decided by second tensors)" in out
    record = recorded("conventions", "wam7")
    assert record["best"]["about"] == "com"
    assert record["best"]["products"] == ["integral"] * 7
    made = {(d["question"], d["link"]): d for d in record["decisions"]["arm"]}
    assert made["products", 1]["decided"]
    assert made["products", 2]["others"] == ["tensor"]


@pytest.mark.slow
def test_kr30_gives_zero_and_signs(printed):
    out = printed("conventions", "kr30ha")
    assert "signs (-1, -1, -1, -1, -1, -1), offsets (0, 0, 90, 0, 0, 180) deg: 11 of 11 checks hold" in out
    assert "its inertias are estimated" in out


def test_a_file_of_ones_own_with_evidence(printed, tmp_path, evidence):
    robot = tmp_path / "mine.toml"
    text = template("mine.toml", "mine", "RRR", "modified")
    robot.write_text(text.replace('kind = "assumed"', 'kind = "printed"'), encoding="utf-8")
    given = evidence(number("gravity", unit="N m", rest="q = [0, 90, 0]"))
    assert "published numbers" in printed("conventions", str(robot), "--evidence", given)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (number(joint="joint_9"), "no joint of lwr4plus named 'joint_9'"),
        (number(value="2.9"), "a number without its digits"),
        (number(value='"two"'), "no digits"),
        (number(value='"nan"'), "no digits"),
        (number(value='"1e999"'), "no digits"),
        (number(unit="N m"), "allowed: one of kg m^2"),
        (number(quantity="mass"), "number[0].quantity"),
        (number(rest="q = [0, 0]"), "allowed: 7 numbers, one per joint"),
        (number(rest=""), "number[0].q: missing"),
        (number(rest="q = [0, 0, 0, 0, 0, 0, 0]\ncolour = 1"), "number[0].colour: unknown field"),
        ("[[nunber]]\n", "nunber: unknown field"),
        ("[arm]\nconvention = 'classic'\n", "one of standard, modified"),
        ("[arm]\nalike = [['link_1']]\n", "lists of two or more different links"),
        ("[arm]\nalike = [['link_1', 'link_1']]\n", "lists of two or more different links"),
        ("[arm]\nalike = ['link_1']\n", "lists of two or more different links"),
        ("[arm]\nalike = [['link_1', 'link_8']]\n", "no link named 'link_8'"),
        ("[tensors]\nabout = 'origin'\nproducts = 'tensor'\nunit = 'kg m^2'\nwhere = ''\nvalues = [['1','1','1']]\n",
         "tensors.values[0]: 3 entries"),
        ("[tensors]\nabout = 'origin'\nproducts = 'tensor'\nunit = 'kg m^2'\nwhere = ''\n"
         "values = [['1','1','1','-','-','-']]\n", "tensors.values: 1 rows"),
        ("number = [", "TOML"),
    ],
)  # fmt: skip
def test_bad_evidence_is_one_line(refused, evidence, text, says):
    assert says in refused("conventions", "lwr4plus", "--evidence", evidence(text))


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (("nobody",), "no robot named 'nobody'"),
        (("lwr4",), "masses and inertias not given"),
        (("arm.urdf",), "a URDF states its conventions"),
        (("lwr4plus", "--evidence", "nowhere.toml"), "no such file"),
        (("kr30ha", "--evidence", "nowhere.toml"), "has none to read"),
    ],
)
def test_bad_arguments_are_one_line(refused, arguments, says):
    assert says in refused("conventions", *arguments)
