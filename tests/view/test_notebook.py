"""What a notebook shows: asked as IPython asks, and looked at in a browser."""

import asyncio
import html
import re
from dataclasses import replace

import pytest
from browser import BROWSER, opened
from IPython.core.formatters import DisplayFormatter
from sample_gait import bare_gait, sample_gait
from transitions import from_rest

from gaitopt import page_text
from gaitopt.view.page_parts import Page


def shown(thing):
    """What IPython sends to a notebook."""
    formatter = DisplayFormatter()
    formatter.active_types = formatter.format_types
    data, _ = formatter.format(thing)
    return data


def framed(data):
    return html.unescape(re.search(r'srcdoc="([^"]*)"', data["text/html"])[1])


def without_scene(page):
    """A page without its drawing commands, in which MeshCat gives everything a random name."""
    return re.sub(r'PACKED_SCENE = "[^"]+"', "", page)


def test_a_gait_shows_its_page():
    gait = sample_gait()
    data = shown(gait)
    assert without_scene(framed(data)) == without_scene(page_text(gait))
    assert data["text/plain"] == repr(gait)


def test_a_transition_shows_its_page():
    transition = from_rest().transition
    data = shown(transition)
    assert without_scene(framed(data)) == without_scene(page_text(transition))
    assert data["text/plain"] == repr(transition)


def test_a_page_shows_itself_and_is_short_as_text():
    page = page_text(bare_gait(), steps=1)
    assert isinstance(page, str)
    data = shown(page)
    assert framed(data) == page
    assert re.fullmatch(r"<Page of 0\.\d MB>", data["text/plain"])
    odd = Page('<p title="a & b">\'</p>\n')
    assert framed(shown(odd)) == odd


def test_a_gait_that_cannot_be_drawn_is_shown_as_text():
    lost = replace(sample_gait(), urdf="<robot/>")
    assert set(shown(lost)) == {"text/plain"}


async def _seen(url, folder):
    async with opened(url, folder) as page:
        inside = "document.querySelector('iframe')?.contentDocument"
        await page.wait_for(f"{inside} && {inside}.querySelectorAll('.foot span').length")
        found = await page.value(
            f"[{inside}.getElementById('title').textContent, "
            f"{inside}.querySelectorAll('.panel path').length, "
            "document.querySelector('iframe').getBoundingClientRect().height]"
        )
        times = (
            "[...document.querySelectorAll('iframe')].map(one => one.contentDocument"
            ".querySelectorAll('.foot span').length && "
            "Number(one.contentDocument.getElementById('scrub').value))"
        )
        await page.wait_for(f"{FRAMES}[1].contentDocument.querySelectorAll('.foot span').length")
        await page.wait_for(f"{times}[0] > 0")
        clocks = await page.value(times)
        await page.value(f"{FRAMES}[1].scrollIntoView()")
        await page.wait_for(f"{times}[1] > 0")
        return [*found, clocks]


FRAMES = "document.querySelectorAll('iframe')"


@pytest.mark.browser
@pytest.mark.skipif(BROWSER is None, reason="no Chromium browser found")
def test_a_browser_draws_the_page_in_its_frame(tmp_path):
    notebook = tmp_path / "notebook.html"
    cell = f"<h1>cell</h1>{shown(sample_gait())['text/html']}"
    notebook.write_text(f"{cell}<div style='height: 3000px'></div>{cell}")
    title, curves, height, clocks = asyncio.run(_seen(notebook.as_uri(), tmp_path))
    assert title.endswith("at 1 m/s")
    assert curves == 12
    assert height >= 600
    assert clocks[0] > 0.0
    assert clocks[1] == 0.0  # nobody sees it yet
