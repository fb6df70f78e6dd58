"""`lwr-dyn lint`: exit codes, one line for bad input, JSON."""

import json

import pytest

GAINS = "Joint,K_P,K_D\n1,7310,292.4\n2,7270,290.8\n3,1225.7,49.03\n4,13.5,4.4\n5,0.5392,0.1756\n"


def test_a_finding_is_printed_with_its_place(tmp_path, lwr_dyn_command):
    (tmp_path / "gains.csv").write_text(GAINS)
    code, out, _ = lwr_dyn_command("lint", str(tmp_path / "gains.csv"))
    assert code == 1
    assert "gains.csv:gains, row 4, K_D: error swapped: " in out
    assert out.endswith("1 found\n")
    record = json.loads(lwr_dyn_command("lint", str(tmp_path / "gains.csv"), "--json")[1])
    assert record["holds"] is False
    assert record["findings"][0]["rule"] == "swapped"


def test_a_clean_robot(printed):
    assert printed("lint", "wam7").endswith(" numbers looked at: 0 found\n")


def test_all_that_is_printed_of_a_robot(lwr_dyn_command):
    code, out, _ = lwr_dyn_command("lint", "lwr4plus")
    assert code == 1
    for rule in ("power-of-ten", "rows-shifted", "copied", "column-order", "swapped", "unit"):
        assert f" {rule}: " in out, rule


@pytest.mark.parametrize("name", ["nobody", "nofile.csv", "nofile.toml", "/etc"])
def test_bad_names(name, refused):
    refused("lint", name)


def test_mjcf_is_sent_to_the_command_that_reads_it(refused):
    words = "arms/wam7.xml: MJCF, which has no rules here; allowed: `lwr-dyn check arms/wam7.xml`, or lint of its .urdf"
    assert words in refused("lint", "arms/wam7.xml")


def test_bytes_that_are_no_text(tmp_path, refused):
    (tmp_path / "x.csv").write_bytes(b"\xff\xfe\x00")
    assert "not UTF-8" in refused("lint", str(tmp_path / "x.csv"))
