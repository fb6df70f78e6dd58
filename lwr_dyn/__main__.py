"""`python -m lwr_dyn` is `lwr-dyn`."""

from lwr_dyn.cli.main import main

main()
