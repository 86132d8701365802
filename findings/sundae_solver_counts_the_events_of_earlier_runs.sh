#!/usr/bin/env bash
# Version:  scikit-sundae 1.2.0 (its own SUNDIALS), CVODE and IDA
# Does:     solve() of one solver object keeps the events of the runs before: t_events, i_events and y_events begin with theirs, from another
#           start, and a terminal of n events counts them, so that the second run stops n-1 events too early.
# Guess:    solve() answers for its own run, as the solution's t and y do, which are right.
# Means:    a step ends by an event, and one solver is made for many steps: t_events[0] and y_events[0] are those of the very first
#           step for ever. A return map differenced like this has slope 0, that is the most stable walk there is. Make a
#           solver for each run, or take the last state of y and not the event. No report was found.
# Seen:     rimless wheel, eight spokes, slope of 0.1: d(speed squared after the next touchdown) is cos(45 deg)^2 = 0.5 by theory and with a new
#           solver for each step, 0 with one solver; t_events of the third step has 3 entries; a run that stops at the second zero of an oscillation,
#           4.712 s, stops at the first, 1.571 s, when it is done again
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check scikit-sundae==1.2.0 numpy==2.4.6 scipy==1.17.1
cd "$work"
"$work/env/bin/python" - > out 2>&1 <<'PY' || { tail -20 out; exit 1; }
import numpy as np
from sksundae.cvode import CVODE
from sksundae.ida import IDA

GRAVITY, SPOKE, SLOPE = 9.81, np.pi / 8, 0.1  # legs of 1 m


def fall(t, y, rates):
    rates[0], rates[1] = y[1], GRAVITY * np.sin(y[0])


def touchdown(t, y, events):
    events[0] = y[0] - (SLOPE + SPOKE)


touchdown.terminal, touchdown.direction = [True], [1]


def solver():
    return CVODE(fall, rtol=1e-10, atol=1e-12, eventsfn=touchdown, num_events=1)


def next_square(wheel, square, by_event):
    """Square of the speed after the next touchdown, by the first event or by the last state of the run."""
    run = wheel.solve(np.linspace(0, 5, 11), np.array([SLOPE - SPOKE, np.sqrt(square)]))
    speed = run.y_events[0][1] if by_event else run.y[-1][1]
    return (np.cos(2 * SPOKE) * speed) ** 2, len(run.t_events)


theory, start, step = np.cos(2 * SPOKE) ** 2, 8.0, 0.1
shared = solver()
for words, make, by_event in (
    ("a new solver for each step, event", solver, True),
    ("one solver, last state", lambda: shared, False),
    ("one solver, event", lambda: shared, True),
):
    low, high = (next_square(make(), start + sign * step, by_event) for sign in (-1, 1))
    slope = (high[0] - low[0]) / (2 * step)
    print(f"SEEN {words}: slope of the return map {slope:.4f} of {theory:.4f}; events told {low[1]} and {high[1]}")
    assert abs(slope - (0 if words == "one solver, event" else theory)) < 1e-4
    assert abs(low[0] - theory * (start - step + 4 * GRAVITY * np.sin(SPOKE) * np.sin(SLOPE))) < 1e-5 or words == "one solver, event"


def swing(t, y, rates):
    rates[0], rates[1] = y[1], -y[0]


def residual(t, y, rates, rest):
    rest[0], rest[1] = rates[0] - y[1], rates[1] + y[0]


def zero(t, y, events):
    events[0] = y[0]


def zero_of_ida(t, y, rates, events):
    events[0] = y[0]


zero.terminal = zero_of_ida.terminal = [2]
zero.direction = zero_of_ida.direction = [0]
for words, oscillator, more in (
    ("CVODE", CVODE(swing, rtol=1e-9, atol=1e-11, eventsfn=zero, num_events=1), lambda h: ()),
    ("IDA", IDA(residual, rtol=1e-9, atol=1e-11, eventsfn=zero_of_ida, num_events=1), lambda h: (np.array([0.0, -h]),)),
):
    ends = [oscillator.solve(np.linspace(0, 20, 6), np.array([h, 0.0]), *more(h)).t[-1] for h in (1.0, 2.0, 0.5)]
    print(f"SEEN {words}, stop at the second zero, three runs: {np.round(ends, 4)} s of {1.5 * np.pi:.4f} s")
    assert np.allclose(ends, np.pi * np.array([1.5, 0.5, 0.5]), atol=1e-5)
PY
grep SEEN out
