"""The colours of figures and pages.

Okabe & Ito's palette (2008) for what must be told apart: by any colour vision, and in grey print.
"""

from __future__ import annotations

STANCE = "#D55E00"
SWING = "#0072B2"
TRUNK = "#333333"
SECOND = "#009E73"
MEAN = "#CC79A7"
LIMIT = "#B00020"
GREY = "#8A8A8A"
GROUND = "#B5B5B5"
INSIDE = "#F1F4F7"
