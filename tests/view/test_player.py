import urllib.request

import pytest
from sample_gait import sample_gait

from gaitopt.errors import InputError
from gaitopt.view.player import play


def test_the_server_shows_the_walk_and_stops(capfd):
    with play(sample_gait(), steps=2, open_browser=False) as player:
        server = player.viewer.window.server_proc
        with urllib.request.urlopen(player.url, timeout=10) as page:
            assert b"MeshCat" in page.read()
        scene = player.viewer.static_html()
        assert scene.count("handle_command_bytearray") > 50
    assert server.poll() is not None
    player.close()  # twice does no harm
    player.wait()
    assert capfd.readouterr().out == ""


def test_a_scene_that_fails_leaves_no_server(monkeypatch):
    started = []
    from gaitopt.view import player as module

    start = module._start
    monkeypatch.setattr(module, "_start", lambda: started.append(start()) or started[0])
    with pytest.raises(InputError, match="0 steps cannot be shown"):
        play(sample_gait(), steps=0, open_browser=False)
    assert started[0].viewer.window.server_proc.poll() is not None
