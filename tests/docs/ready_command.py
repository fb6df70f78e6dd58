"""`lwr-dyn` for pages without waiting for its imports: a process that has loaded everything forks for each command.

A worker of the tests starts one such process, which ends with it. `lwr-dyn` on the path of a page is then this file run
as `ready_command.py SOCKET ARGUMENTS...`: it hands over arguments, folder, environment and its three streams, passes
signals on, and ends as the command does. The command runs as `python -m lwr_dyn` runs it.
"""

from __future__ import annotations

import contextlib
import json
import os
import signal
import socket
import sys

SERVE = "serve"
"""In the place of the arguments' socket: be the process that is asked."""
PASSED_ON = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


def ask(path: str, arguments: list[str]) -> int:
    """The exit code of a command that the process at this socket runs for us, negative for a signal."""
    ignored = signal.getsignal(signal.SIGINT) is signal.SIG_IGN
    said = {"arguments": arguments, "folder": os.getcwd(), "environment": dict(os.environ), "ignored": ignored}
    with socket.socket(socket.AF_UNIX) as door:
        door.connect(path)
        socket.send_fds(door, [b"."], [0, 1, 2])
        door.sendall(json.dumps(said).encode())
        door.shutdown(socket.SHUT_WR)
        with door.makefile("r") as answers:
            process = int(answers.readline())
            for number in PASSED_ON:
                if signal.getsignal(number) is not signal.SIG_IGN:
                    signal.signal(number, lambda received, _: os.kill(process, received))
            return int(answers.readline())


def end(code: int) -> None:
    """End as the command has ended, by the same signal too."""
    if code < 0:
        if -code != signal.SIGKILL:
            signal.signal(-code, signal.SIG_DFL)
        os.kill(os.getpid(), -code)
    sys.exit(code)


def serve(path: str) -> None:
    """Fork for each request until stdin is closed; comes back in the fork that is to run a command, ready for it."""
    import select

    with socket.socket(socket.AF_UNIX) as listener:
        listener.bind(path)
        listener.listen()
        print("ready", flush=True)
        while listener in select.select([0, listener], [], [])[0]:
            reap()
            door, _ = listener.accept()
            if os.fork() == 0:
                break
            door.close()
        else:
            reap()
            os._exit(0)
    with door, door.makefile("rw") as words:
        streams = socket.recv_fds(door, 1, 3)[1]
        request = json.loads(words.read())
        if process := os.fork():
            print(process, file=words, flush=True)
            print(os.waitstatus_to_exitcode(os.waitpid(process, 0)[1]), file=words, flush=True)
            os._exit(0)
    become(request, streams)


def reap() -> None:
    """Take leave of the forks that have ended: their time counts as that of this process."""
    with contextlib.suppress(ChildProcessError):
        while os.waitpid(-1, os.WNOHANG)[0]:
            pass


def become(request: dict, streams: list[int]) -> None:
    """Take the place of who asked: streams, folder, environment, arguments."""
    for place, stream in enumerate(streams):
        os.dup2(stream, place)
        os.close(stream)
    sys.stdin, sys.stdout = os.fdopen(0, closefd=False), os.fdopen(1, "w", closefd=False)
    sys.stderr = os.fdopen(2, "w", buffering=1, errors="backslashreplace", closefd=False)
    sys.__stdin__, sys.__stdout__, sys.__stderr__ = sys.stdin, sys.stdout, sys.stderr
    os.chdir(request["folder"])
    os.environ.clear()
    os.environ.update(request["environment"])
    signal.signal(signal.SIGINT, signal.SIG_IGN if request["ignored"] else signal.default_int_handler)
    sys.argv[1:] = request["arguments"]
    sys.path[0] = request["folder"]


def load_all() -> None:
    """Import what commands import, but for what needs a package that is not installed."""
    import gc
    import importlib
    import pkgutil

    import lwr_dyn

    gc.disable()
    for module in pkgutil.walk_packages(lwr_dyn.__path__, "lwr_dyn."):
        if not module.name.endswith("__main__"):
            with contextlib.suppress(ImportError):
                importlib.import_module(module.name)
    gc.freeze()  # no page of memory is copied for the collector's marks
    gc.enable()


def search() -> None:
    """Find the largest inertias of the LWR 4+, by which gains are chosen in most examples: forks have them then."""
    import lwr_dyn
    from lwr_dyn.control.inertia.worst_case import worst_case_inertias

    worst_case_inertias(lwr_dyn.load("lwr4plus"))


if __name__ == "__main__":
    if sys.argv[1] != SERVE:
        end(ask(sys.argv[1], sys.argv[2:]))
    import runpy

    load_all()
    search()
    serve(sys.argv.pop(2))
    runpy.run_module("lwr_dyn", run_name="__main__", alter_sys=True)
