"""Pages that show themselves in a notebook, each in a frame of its own."""

from __future__ import annotations

import html

from gaitopt.errors import GaitoptError
from gaitopt.gait.result import Gait

HEIGHT = 640  # pixels of a frame


class Page(str):
    """The text of a page; a notebook shows the page."""

    __slots__ = ()

    def __repr__(self) -> str:
        """Return its size: the whole of it is megabytes long."""
        return f"<Page of {len(self.encode()) / 1e6:.1f} MB>"

    def _repr_html_(self) -> str:
        """Return it in a frame, so that page and notebook have their own styles and names."""
        return (
            f'<iframe srcdoc="{html.escape(self)}" style="width: 100%; height: {HEIGHT}px; '
            'border: 0" allowfullscreen></iframe>'
        )


def gait_html(gait: Gait) -> str | None:
    """Return the page of a gait in a frame; None where the robot cannot be drawn."""
    from gaitopt.view.page import page_text

    try:
        return page_text(gait)._repr_html_()
    except GaitoptError:
        return None
