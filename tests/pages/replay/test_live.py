"""The live meshcat: on the loopback only, and real: pages draw what is sent to it."""

import socket
import urllib.error
import urllib.request
from pathlib import Path

import numpy as np
import pytest
import umsgpack
from tornado.ioloop import IOLoop
from tornado.websocket import websocket_connect

import lwr_dyn
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.pages.replay import live, replay_page
from tests.headless import logs, opened, waiting

POSE = 1e-6
"""[m], as in test_replay_page."""
LISTENS = "0A"
LOOPBACK_HEX = "0100007F"
ANYWHERE = urllib.request.build_opener(urllib.request.ProxyHandler({}))


@pytest.fixture(scope="module")
def server(arm, two_runs):
    with live.serve(two_runs, arm, port=0) as running:
        yield running


def listening_sockets() -> dict[int, set[str]]:
    """Port -> addresses this process listens at, according to the kernel."""
    mine = {link.stat().st_ino for link in Path("/proc/self/fd").iterdir() if link.is_socket()}
    found: dict[int, set[str]] = {}
    for table in ("/proc/net/tcp", "/proc/net/tcp6"):
        for row in Path(table).read_text().splitlines()[1:]:
            cells = row.split()
            if cells[3] == LISTENS and int(cells[9]) in mine:
                address, port = cells[1].split(":")
                found.setdefault(int(port, 16), set()).add(address)
    return found


def fetched(url, **headers):
    with ANYWHERE.open(urllib.request.Request(url, headers=headers), timeout=10) as answer:
        return answer.read().decode()


def test_its_only_port_is_on_the_loopback(server):
    sockets = listening_sockets()
    assert sockets == {server.port: {LOOPBACK_HEX}}  # and no other: meshcat's ZeroMQ socket has no port


def test_pages_are_served_to_our_own_names_only(server):
    assert "lwrReplay" in fetched(server.url)
    with ANYWHERE.open(server.url, timeout=10) as answer:
        assert answer.headers["Cache-Control"] == "no-store"
    assert "MeshCat.Viewer" in fetched(server.url + "static/")
    with pytest.raises(urllib.error.HTTPError, match="404"):
        fetched(server.url, Host="rebound.example")


@pytest.mark.slow
def test_a_pose_sent_from_python_moves_the_page(server, browser, arm):
    q = np.array([0.3, -0.4, 0.5, 0.9, -0.2, 0.7, 0.1])
    opened(browser, server.url)
    waiting(browser, 20).until(lambda w: w.execute_script("return lwrReplay.stage.viewer.num_messages_received > 10"))
    server.show(q, run=1)
    asked = lwr_dyn.forward_kinematics(arm, q)

    def there(window):
        return np.abs(np.array(window.execute_script("return lwrReplay.flangePose(1)")) - asked).max() < POSE

    waiting(browser, 20).until(there)
    sent, said = logs(browser)
    allowed = (server.url, server.url.replace("http", "ws"), "data:")
    assert all(address.startswith(allowed) for address in sent)
    assert said == []


def test_a_page_that_is_opened_later_gets_the_pose_that_was_shown_last(server, arm):
    q, found = np.array([0.1, 0.2, -0.3, 0.4, 0.5, -0.6, 0.7]), {}
    server.show(q, run=1)
    expected = {command["path"]: command["matrix"] for command in replay_page.pose_commands(arm, q, 1)}

    async def open_page():
        page = await websocket_connect(server.url.replace("http", "ws"))
        while not expected.keys() <= found.keys():
            command = umsgpack.unpackb(await page.read_message())
            if command["type"] == "set_transform":
                found[command["path"]] = command["matrix"]
        page.close()

    loop = IOLoop(make_current=False)
    loop.run_sync(open_page, timeout=20)
    loop.close(all_fds=True)
    assert {path: found[path] for path in expected} == expected


def test_garbage_on_the_websocket_is_passed_over_in_silence(server, capfd):
    async def send_garbage():
        for message in ("", "no json", "{}", '{"data": 1}', b"\xff\x00", "[" * 10_000):
            page = await websocket_connect(server.url.replace("http", "ws"))
            await page.write_message(message, binary=isinstance(message, bytes))
            assert await page.read_message()  # the scene is sent all the same
            page.close()

    loop = IOLoop(make_current=False)
    loop.run_sync(send_garbage, timeout=20)
    loop.close(all_fds=True)
    with socket.create_connection(("127.0.0.1", server.port)) as raw:
        raw.sendall(b"\xff\xfe\r\n\r\n")
        raw.recv(1)
    assert "lwrReplay" in fetched(server.url)
    assert capfd.readouterr() == ("", "")


def test_a_taken_port_is_one_clear_line(arm, two_runs):
    with socket.socket() as held:
        held.bind(("127.0.0.1", 0))
        held.listen()
        port = held.getsockname()[1]
        with pytest.raises(OptionError, match=f"^port: {port} is taken; allowed: a free port, or 0 for any free one$"):
            live.serve(two_runs, arm, port=port)
    with pytest.raises(OptionError, match="port: 70000"):
        live.serve(two_runs, arm, port=70000)


def test_close_frees_the_port_and_may_be_repeated(arm, two_runs):
    running = live.serve(two_runs, arm, port=0)
    running.close()
    running.close()
    running.wait()
    assert running.port not in listening_sockets()
    live.serve(two_runs, arm, port=running.port).close()
