"""`lwr-dyn fk --symbolic` prints the DH matrices and the position by two routes."""


def test_symbols_print(lwr_dyn_command):
    assert "vector route: 12 products, 5 sums" in lwr_dyn_command("fk", "lwr4", "--symbolic")[1]
