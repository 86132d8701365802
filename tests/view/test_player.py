import re
import socket
import urllib.request
from contextlib import closing
from pathlib import Path

import pytest
from page_scene import commands_of, unpacked
from sample_gait import sample_gait

from gaitopt.errors import InputError
from gaitopt.view import scene_server as module
from gaitopt.view.scene_server import SceneServer, is_local, play


def test_the_server_shows_the_walk_and_stops(capfd):
    with play(sample_gait(), steps=2, open_browser=False) as player:
        with urllib.request.urlopen(player.url, timeout=300) as page:
            assert b"MeshCat" in page.read()
        with urllib.request.urlopen(f"{player.url}main.min.js", timeout=300) as script:
            assert len(script.read()) > 100_000
        scene = player.viewer.static_html()
        assert len(player.server.scene()) > 50
        packed = re.findall(r'"([^"]*)"\);</script>', scene)[-1]
        assert len(commands_of(unpacked(packed))) == len(player.server.scene())
    assert player.server.closed
    with pytest.raises(OSError, match="refused"):
        socket.create_connection(("127.0.0.1", player.server.port), timeout=300)
    player.close()  # twice does no harm
    player.wait()
    assert capfd.readouterr() == ("", "")


def test_a_browser_gets_the_scene_and_what_comes_after():
    from tornado.ioloop import IOLoop
    from tornado.websocket import websocket_connect

    server = SceneServer(port=0)
    server.send(Command({"type": "set_transform", "path": "/a", "matrix": [1.0]}))
    server.send(Command({"type": "set_transform", "path": "/a", "matrix": [2.0]}))
    server.send(Command({"type": "set_object", "path": "/a/b", "object": {}}))
    server.send(Command({"type": "set_object", "path": "/c", "object": {}}))
    server.send(Command({"type": "delete", "path": "/a"}))

    async def browse():
        connection = await websocket_connect(f"ws://127.0.0.1:{server.port}/")
        first = await connection.read_message()
        server.send(Command({"type": "set_object", "path": "/later", "object": {}}))
        second = await connection.read_message()
        connection.close()
        return first, second

    loop = IOLoop(make_current=False)
    try:
        first, second = loop.run_sync(browse, timeout=300)
    finally:
        loop.close(all_fds=True)
        server.close()
    assert b"/c" in first
    assert b"/later" in second
    assert len(server.scene()) == 2


class Command:
    def __init__(self, record):
        self.record = record

    def lower(self):
        return self.record


def listening_addresses(port):
    """Addresses at which something listens, as the kernel has them."""
    found = set()
    for name in ("tcp", "tcp6"):
        table = Path(f"/proc/net/{name}")
        for row in table.read_text().splitlines()[1:] if table.exists() else ():
            _, local, _, state, *_ = row.split()
            address, _, number = local.partition(":")
            if state == "0A" and int(number, 16) == port:
                found.add(address)
    return found


@pytest.mark.skipif(not Path("/proc/net/tcp").exists(), reason="there is no /proc/net/tcp")
def test_only_this_machine_is_listened_to():
    with play(sample_gait(), steps=1, open_browser=False) as player:
        assert player.url.startswith("http://127.0.0.1:")
        assert listening_addresses(player.server.port) == {"0100007F"}
    assert listening_addresses(player.server.port) == set()
    with play(sample_gait(), steps=1, open_browser=False, host="0.0.0.0", port=0) as player:
        assert listening_addresses(player.server.port) == {"00000000"}
    assert not is_local("0.0.0.0")
    assert is_local("127.0.0.1")


def test_ports_and_hosts_that_cannot_be_are_told():
    with closing(SceneServer()) as first, closing(SceneServer()) as second:
        assert 7000 <= first.port < second.port
        with pytest.raises(InputError, match=rf"port {first.port}: address already in use; give"):
            SceneServer(port=first.port)
    for port in (-1, 65536):
        with pytest.raises(InputError, match=f"port {port} does not exist"):
            SceneServer(port=port)
    with pytest.raises(InputError, match="the host is empty"):
        SceneServer(" ")
    for host in ("no.such.host.invalid", "203.0.113.7", "a" * 80):
        with pytest.raises(InputError, match="cannot listen at"):
            SceneServer(host)


def test_a_scene_that_fails_leaves_no_server(monkeypatch):
    started = []
    monkeypatch.setattr(
        module, "SceneServer", lambda *where: started.append(SceneServer(*where)) or started[0]
    )
    with pytest.raises(InputError, match="0 steps cannot be shown"):
        play(sample_gait(), steps=0, open_browser=False)
    assert started[0].closed


def test_the_command_refuses_what_does_not_go_together(cli_play):
    assert "neither --host nor --port" in cli_play("--html", "a.html", "--port", "7000")
    assert "port 70000 does not exist" in cli_play("--port", "70000")


@pytest.fixture
def cli_play(tmp_path):
    from typer.testing import CliRunner

    from gaitopt import save_gait
    from gaitopt.cli.app import app

    path = save_gait(sample_gait(), tmp_path / "gait.npz")

    def run(*words):
        result = CliRunner().invoke(app, ["play", str(path), *words])
        assert result.exit_code == 2
        return result.stderr

    return run
