"""`lwr-dyn`, also as `python -m lwr_dyn`: Ctrl-C ends it with one line, even before the first import is done.

Where the shell has it ignored (`nohup`, `&` in a script), it stays ignored.
"""

import os
import signal
from typing import Any


def _stop(*_: Any) -> None:
    os.write(2, b"lwr-dyn: stopped\n")
    os._exit(130)


def main() -> None:
    """Run the command; while modules are loaded nothing is half written, so that the process may end at once.

    BLAS gets one thread, unless OMP_NUM_THREADS says otherwise: on matrices this small, threads wait for each other.
    """
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    heard = signal.getsignal(signal.SIGINT) is not signal.SIG_IGN
    if heard:
        signal.signal(signal.SIGINT, _stop)
    from lwr_dyn.cli import main as command

    try:
        command.main()
    finally:
        if heard:
            signal.signal(signal.SIGINT, _stop)


if __name__ == "__main__":
    main()
