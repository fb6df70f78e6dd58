"""A user's own paper: verdicts by hand, errata and their proofs, pages, and one line for each bad input."""

import json

import pytest

from lwr_dyn.foundation.errors import LwrDynError
from lwr_dyn.reproduction.compare import compare_numbers
from lwr_dyn.reproduction.own_paper import own_study
from lwr_dyn.reproduction.reproduce import reproduce
from tests.reproduction.pages import lost
from tests.reproduction.two_links import RESULTS, TEXT, writer

LOST_POINT = """
[[erratum]]
id = "mass-2"
where = "Table II, row 2"
printed = "15"
read_as = "1.5"
why = "Table IV follows with 1.5"
effect = "all torques"
severity = "model"
status = "proven"
patch = [{ at = "inertial.mass.values[1]", printed = 15, read = 1.5 }]
[reading.printed]
about = "as printed"
[reading.corrected]
about = "with the mass of Table IV"
errata = ["mass-2"]
"""


@pytest.fixture
def written(tmp_path):
    return writer(tmp_path, TEXT + RESULTS)


def verdicts(path):
    return {
        n.cell.path.removeprefix("results."): n.verdict for n in compare_numbers(own_study(path), slow=True).numbers
    }


NAMES = ("b11.printed[0]", "holding.printed[0]", "holding.printed[1]", "share.printed[0]", "reach.printed[0]")


def test_numbers_by_hand_are_reproduced(written):
    assert verdicts(written()) == dict.fromkeys(NAMES, "reproduced")


def test_a_last_digit_counts(written):
    """0.93 kg m^2 is printed as 0.930; 0.931 and 0.9304 are other numbers, 0.9 is not."""
    for text, verdict in {"0.931": "differs", "0.9304": "differs", "0.9": "reproduced", "0.9300": "reproduced"}.items():
        assert verdicts(written(("0.930", text)))["b11.printed[0]"] == verdict, text


def test_q_in_degrees_and_in_radians_is_one_pose(written):
    turned = written(("q_deg = [0, 0]", "q_deg = [7, 90]"), ("0.930", "0.630"))
    assert verdicts(turned)["b11.printed[0]"] == "reproduced"
    same = written(("q_deg = [0, 0]", "q = [0.1, 1.5707963267948966]"), ("0.930", "0.630"))
    assert verdicts(same)["b11.printed[0]"] == "reproduced"


def test_an_erratum_explains_and_is_proven_by_what_follows_with_it(written, tmp_path):
    path = written(("values = [2.0, 1.5]", "values = [2.0, 15]"), ("title", 'default_reading = "corrected"\ntitle'),
                   more=LOST_POINT)  # fmt: skip
    found = verdicts(path)
    assert found.pop("reach.printed[0]") == "reproduced"
    assert set(found.values()) == {"after erratum"}
    done = reproduce(path, tmp_path / "out")
    assert done.holds
    (erratum,) = done.document.record()["errata"]
    assert erratum["proof"]["holds"] is True
    assert "printed 0.930, with the erratum 0.93" in erratum["proof"]["numbers"]["b11.printed[0]"]
    assert lost(tmp_path / "out") == []


def test_a_proof_is_of_its_own_erratum_alone(written):
    """The torque of a motor shows the one, the inertia the other."""
    other = (
        LOST_POINT.partition("[reading")[0]
        .replace("mass-2", "effort-1")
        .replace("printed = 15, read = 1.5", "printed = 4, read = 40")
    )
    more = other.replace("inertial.mass.values[1]", "limits.effort.values[0]") + LOST_POINT
    study = own_study(written(("values = [2.0, 1.5]", "values = [2.0, 15]"), ("[40, 10]", "[4, 10]"), more=more))
    shown = {name: list(study.proofs[name](study.data).numbers) for name in ("mass-2", "effort-1")}
    share = "share.printed[0]"
    assert shown == {
        "mass-2": ["b11.printed[0]", "holding.printed[0]", "holding.printed[1]", share],
        "effort-1": [share],
    }


def test_many_errata_are_not_tried_in_all_combinations(written):
    """Of nine errata a result tries those of the reading and those that it names."""
    start = LOST_POINT.partition("[reading")[0]
    more = start + "".join(
        start.replace('"mass-2"', f'"other-{k}"').replace("inertial.mass.values[1]", f"results.reach.x{k}")
        for k in range(8)
    )
    heavy = ("values = [2.0, 1.5]", "values = [2.0, 15]")
    assert verdicts(written(heavy, more=more))["b11.printed[0]"] == "differs"
    named = ('unit = "kg m^2"\ncompute', 'unit = "kg m^2"\nerrata = ["mass-2"]\ncompute')
    assert verdicts(written(heavy, named, more=more))["b11.printed[0]"] == "after erratum"


def test_the_result_that_a_value_was_read_from_is_no_evidence(written):
    """With every number as the source of the mass nothing shows the erratum; with one, the others do."""
    texts = [f"results.{name}" for name in NAMES]
    for fitted, holds in ((texts[:1], True), (texts, False)):
        more = LOST_POINT.replace("read = 1.5 }", f"read = 1.5, fitted_to = {json.dumps(fitted)} }}")
        study = own_study(written(("values = [2.0, 1.5]", "values = [2.0, 15]"), more=more))
        proof = study.proofs["mass-2"](study.data)
        assert proof.holds is holds
        assert set(proof.numbers) == (set(NAMES) - {"b11.printed[0]", "reach.printed[0]"} if holds else set())


def test_a_proven_erratum_that_nothing_shows_does_not_hold(written, tmp_path):
    idle = LOST_POINT.replace("inertial.mass.values[1]", "limits.effort.values[1]").replace(
        "printed = 15", "printed = 10"
    )
    done = reproduce(written(more=idle), tmp_path / "out")
    assert not done.holds
    assert "erratum mass-2: no printed result of the file shows it" in done.document.text()


def test_an_erratum_of_a_printed_result(written):
    misprint = LOST_POINT.partition("[reading")[0].replace(
        '"inertial.mass.values[1]", printed = 15, read = 1.5',
        '"results.b11.printed[0]", printed = "0.390", read = "0.930"',
    )
    (number, *_) = compare_numbers(own_study(written(("0.930", "0.390"), more=misprint))).numbers
    assert (number.verdict, number.errata) == ("after erratum", ("mass-2",))


def test_what_differs_what_is_assumed_and_what_is_read_off_a_figure(written, tmp_path):
    path = written(
        ('printed = "0.930"', 'printed = "0.950"'),
        ('printed = "38"', 'assumed = ["the payload"]\nprinted = "41"'),
        ('printed = "900"', 'range = ["880", "910"]\nprinted = "890"'),
    )
    assert list(verdicts(path).values()) == [
        "differs", "reproduced", "reproduced", "under assumed conditions", "reproduced"
    ]  # fmt: skip
    done = reproduce(path, tmp_path / "out")
    assert not done.holds
    text = done.document.text()
    assert "differs by -0.02, -20 last digits" in text
    assert "not near, assumed: the payload" in text
    assert "near, assumed: the payload" in reproduce(
        written(('printed = "38"', 'assumed = ["the payload"]\nprinted = "38"')), tmp_path / "near"
    ).document.text().replace("not near", "far")


def test_a_number_that_is_a_cell_of_the_tables_is_not_computed(written):
    record_of = written(("gravity[1] / limits.effort[1]\"\nq_deg = [0, 0]", "limits.effort[1]\""),
                        ('printed = "38"\nunit = "%"', 'printed = "40"\nunit = "N m"'))  # fmt: skip
    from lwr_dyn.reproduction.basis import with_bases

    study = own_study(record_of)
    outcomes = {n.block.name: n.outcome for n in with_bases(study, compare_numbers(study)).numbers}
    assert outcomes["share"] == "repeated in print"
    assert outcomes["b11"] == "reproduced"


def test_the_folder_is_that_of_a_paper(written, tmp_path):
    done = reproduce(written(), tmp_path / "out")
    assert done.holds
    assert {p.name for p in (tmp_path / "out").iterdir()} == {
        "models", "checks.txt", "tables.txt", "results.json", "report.html"
    }  # fmt: skip
    record = json.loads((tmp_path / "out" / "results.json").read_text(encoding="utf-8"))
    assert [n["computed_by"] for n in record["numbers"]][:2] == [
        "mass_matrix[1,1] at q = (0, 0) deg", "gravity at q = (0, 0) deg"
    ]  # fmt: skip
    assert [n["value"] for n in record["numbers"]] == pytest.approx([0.93, 15.2055, 2.943, 38.01375, 900.0], rel=1e-12)
    assert lost(tmp_path / "out") == []


B11, G, SHARE = "mass_matrix[1,1]", 'compute = "gravity"\n', "gravity[1] / limits.effort[1]"
Q, REACH = "q_deg = [0, 0]", 'id = "reach"'
BAD = {
    "unknown quantity": (B11, "mass_matrx[1,1]", "b11.compute: no quantity or column 'mass_matrx'"),
    "joint out of range": (B11, "mass_matrix[1,3]", "allowed: mass_matrix[1 to 2,1 to 2], counted from 1"),
    "missing q": (G + Q, G, "holding.q_deg: missing; allowed: a list of 2 finite numbers, one a joint [deg]: gravity"),
    "short q": (Q, "q_deg = [0]", "b11.q_deg: [0]; allowed: a list of 2 finite numbers"),
    "endless q": (Q, "q_deg = [0, inf]", "b11.q_deg: [0, inf]; allowed: a list of 2 finite"),
    "q twice": (Q, f"{Q}\nq = [0, 0]", "b11.q: given with q_deg; allowed: one of them"),
    "dq that it does not take": (Q, f"{Q}\ndq = [0, 0]", "mass_matrix[1,1] does not take it"),
    "printed is no number": ('"0.930"', '"0,930"', "b11.printed: '0,930'; allowed: a number as printed"),
    "printed without digits": ('"0.930"', "0.930", "b11.printed: 0.93, a number without its digits"),
    "a number too large": ('"0.930"', '"1e31"', "b11.printed: '1e31'; allowed: a number up to 1e+30"),
    "a digit too small": (
        '"0.930"',
        '"1e-300"',
        "b11.printed: '1e-300'; allowed: a number up to 1e+30, its last digit",
    ),
    "a list for one number": ('"0.930"', '["0.930"]', "b11.printed: ['0.930']; allowed: a number as printed"),
    "one number for a list": ('["15.21", "2.94"]', '"15.21"', "a list of 2 for gravity; one number is gravity[1]"),
    "unknown column": (SHARE, "limits.efort[1]", "no quantity or column 'limits.efort' (did you mean limits.effort?)"),
    "division by zero": (SHARE, "gravity[1] / dh.d[1]", "no value for gravity[1] = 15.2055, dh.d[1] = 0; allowed: no "),
    "no expression": (SHARE, "__import__('os')", "share.compute: \"__import__('os')\"; allowed: a quantity"),
    "unknown unit": ('unit = "%"', 'unit = "percent"', "share.unit: 'percent'; allowed: units such as"),
    "another unit": ('"kg m^2"\ncompute', '"N m"\ncompute', "a unit of m^2 kg, which mass_matrix[1,1] has"),
    "id twice": (REACH, 'id = "b11"', "b11.id: 'b11' twice; allowed: each id once"),
    "an odd id": (REACH, 'id = "../x"', "[3].id: '../x'; allowed: a letter, then letters, digits and _"),
    "a reserved id": (REACH, 'id = "paper"', "[3].id: 'paper'; allowed: a letter"),
    "unknown field": (REACH, f'{REACH}\nprinte = "1"', "reach.printe: unknown field (did you mean printed?)"),
    "unknown erratum": (REACH, f'{REACH}\nerrata = ["x"]', "reach.errata: 'x'; allowed: one of none"),
    "outside its range": (REACH, f'{REACH}\nrange = ["1", "2"]', "reach.range[0]: the value read, 900, lies outside"),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_input_is_one_line(case, written):
    old, new, words = BAD[case]
    with pytest.raises(LwrDynError) as fault:
        own_study(written((old, new)))
    assert words in str(fault.value)
    assert str(fault.value).startswith("two.toml: result")
    assert "\n" not in str(fault.value)


def test_results_of_an_arm_without_masses(written):
    start = TEXT.index("[inertial]")
    with pytest.raises(LwrDynError, match=r"result.b11.compute: mass_matrix\[1,1\] has no value: .* not given"):
        own_study(written((TEXT[start:], "")))


def test_units_of_a_vector_over_different_joints(written):
    sliding = ('"revolute"]', '"prismatic"]'), ('[40, 10], unit = "N m"', '[40, 10], unit = ["N m", "N"]')
    with pytest.raises(LwrDynError, match="allowed: gravity entry by entry: turning and sliding joints differ"):
        own_study(written(*sliding))


def test_a_file_without_results(tmp_path):
    (tmp_path / "arm.toml").write_text(TEXT, encoding="utf-8")
    with pytest.raises(LwrDynError, match=r"arm.toml: result: missing; allowed: tables \[\[result\]\]"):
        own_study(tmp_path / "arm.toml")


def test_names_of_the_file_name_no_other_folder(written, tmp_path):
    away = written(('name = "two_links"', 'name = "../../two links"'))
    reproduce(away, tmp_path / "a" / "out")
    assert sorted(p.name for p in (tmp_path / "a" / "out" / "models").iterdir()) == [
        ".._.._two_links_printed.provenance.json", ".._.._two_links_printed.urdf", ".._.._two_links_printed.xml"
    ]  # fmt: skip
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a", "two.toml"]
