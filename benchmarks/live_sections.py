"""The sections on replanning and on the page that follows sliders."""

from __future__ import annotations

from tables import Record, table

ASKED = {"biped13": 100.0, "g1": 250.0}  # ms from a slider's move to the new curves, median


def replanning(data: list[Record]) -> str:
    """The next walk from the last one."""
    rows = [
        (
            one["robot"], one["steps"], one["answered"], one["late"], one["unanswered_in_a_row"],
            *(f"{1e3 * one['seconds'][p]:.0f}" for p in ("p50", "p90", "p99", "p100")),
            f"{1e3 * one['first_s']:.0f}",
            f"{100.0 * one['dearer_than_a_search']['worst']:.2g} of {one['compared']}",
        )
        for one in data
    ]  # fmt: skip
    head = (
        "robot", "tasks", "answered", "late", "late in a row, most", "ms, median", "90 %", "99 %",
        "largest", "first walk, ms", "dearer than a search, %, most",
    )  # fmt: skip
    deadline = 1e3 * data[0]["deadline_s"]
    return (
        "Random walks through speed, duration and distance of the feet sideways, all three "
        "changed each time (standard deviations 0.01 m/s, 5 ms, 5 mm), each plan from the last "
        f"walk within {deadline:.0f} ms by the clock, optimal at its samples. Every 25th answer is "
        f"compared with a search from a first guess.{_priority(data)}\n\n" + table(head, rows)
    )


def live(data: list[Record]) -> str:
    """From a slider's move to the curves on the page."""
    rows, lives = [], []
    for one in data:
        curves, painted, (first, last) = one["curves_ms"], one["painted_ms"], one["memory"]
        rows.append((
            one["robot"], one["moves"], f"{ASKED[one['robot']]:.0f}",
            *(f"{curves[p]:.0f}" for p in ("p50", "p90", "p99")),
            *(f"{painted[p]:.0f}" for p in ("p50", "p90")),
            one["without_walk"], one["certified"], one["stale"], len(one["errors"]),
            f"{1e3 * one['server_processor_s'] / one['moves']:.0f}",
        ))  # fmt: skip
        lives.append((
            one["robot"], *(f"{first[k]:.1f} to {last[k]:.1f}" for k in
                            ("page_heap_mb", "server_mb")),
            *(f"{first[k]:.0f} to {last[k]:.0f}" for k in ("page_nodes", "page_listeners")),
            *(f"{one[k]['seconds']:.1f} s, {one[k]['exit_code']}"
              for k in ("after_closing", "after_interrupt")),
        ))  # fmt: skip
    head = (
        "robot", "moves", "asked, ms", "curves, ms, median", "90 %", "99 %", "painted, ms, median",
        "90 %", "no walk", "certificates", "stale", "errors", "server, CPU ms a move",
    )  # fmt: skip
    tail = (
        "robot", "page's heap, MB", "server, MB", "nodes", "listeners", "end after closing, code",
        "end after Ctrl-C, code",
    )  # fmt: skip
    return (
        "Headless Chromium with a software renderer moves one slider at a time, at random, by up "
        "to three of its steps, as soon as the answer to the move before is there, and rests after "
        "every 25th until the walk is certified. *Curves*: the page has the new ones; *painted*: "
        "its next frame is over. A certificate is stale if speed, duration or period shown with it "
        f"are not those that were sent for it.{_priority(data)}\n\n"
        + table(head, rows)
        + "\n\nMemory after a fifth of the moves and after all of them, and how it ends:\n\n"
        + table(tail, lives)
    )


def _priority(data: list[Record]) -> str:
    if all(one["priority"] == 0 for one in data):
        return ""
    return (
        f" The processes ran at priority {data[0]['priority']} on a machine that others used too."
    )
