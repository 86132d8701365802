"""The tables on whole processes, sweeps and the paper's own evaluation."""

from __future__ import annotations

from tables import Record, median, number, table


def process(data: Record) -> str:
    """Whole processes."""
    rows = [
        (
            f"`gaitopt {name}`" if name != "import" else "`import gaitopt`",
            f"{median(r['wall'] for r in runs):.2f}", f"{median(r['cpu'] for r in runs):.2f}",
        )
        for name, runs in data.items()
    ]  # fmt: skip
    return (
        "A process from start to exit, medians. `optimise` is the walk of the thirteen-link biped "
        "at 1.0 m/s, refined and certified, with its gait and summary written.\n\n"
        + table(("what", "s", "CPU s"), rows)
    )


def sweep(data: Record) -> str:
    """Nineteen gaits by continuation against as many cold designs."""
    gaits, one, two = data["sweep"]["gaits"], data["cold, 1"], data["cold, 2"]
    rows = [
        (
            f"{many['speed']:.2f}", f"{many['cost']:.2f}", f"{first['cost']:.2f}",
            _percent(many, first), f"{second['cost']:.2f}", _percent(many, second),
            "yes" if many["certified"] else "no",
        )
        for many, first, second in zip(gaits, one, two, strict=True)
    ]  # fmt: skip
    taken = {name: sum(g["cpu seconds"] for g in data[name]) for name in ("cold, 1", "cold, 2")}
    spent, all_three = data["sweep"]["cpu seconds"], data["sweeps, cpu seconds"]
    clock = data["commands"]
    stages = [
        (stage, str(s["jobs"]), f"{s['cpu seconds']:.2f}", f"{s['cpu seconds'] / s['jobs']:.3f}")
        for stage, s in data["sweep"]["stages"].items()
    ]
    head = ("m/s", "J, sweep", "one start", "sweep, %", "two starts", "sweep, %", "certified")
    return (
        f"`gaitopt sweep` takes {clock['sweep']:.1f} s by the clock, {len(gaits)} times "
        f"`gaitopt optimise` without page and figures {clock['optimise']:.1f} s, "
        f"{clock['optimise'] / clock['sweep']:.1f} times as long: each starts a process and "
        f"prepares the robot anew. In one process the sweep took {spent:.1f} s of CPU (median of "
        f"{', '.join(f'{s:.1f}' for s in all_three)}). As many designs by the two starts that "
        f"`optimise` makes take {taken['cold, 2']:.1f} s, {taken['cold, 2'] / spent:.1f} times as "
        f"long; from the first guess alone {taken['cold, 1']:.1f} s, "
        f"{taken['cold, 1'] / spent:.1f} times, and they end at higher optima. All are refined and "
        "certified.\n\n"
        + table(head, rows)
        + "\n\nWhere the sweep's time goes:\n\n"
        + table(("stage", "jobs", "CPU s", "each"), stages)
    )


def workers(data: Record) -> str:
    """The same sweep by workers that share it."""
    rows = [
        (name.replace(", 1", ", one worker").replace(", 2", ", two workers"), f"{wall:.1f}",
         f"{median(r['cpu'] for r in runs):.1f}", f"{60.0 * 91 / wall:.0f}")
        for name, runs in data["commands"].items()
        for wall in [median(r["wall"] for r in runs)]
    ]  # fmt: skip
    shares = [
        (" x ".join(f"{name} {text}" for name, text in one["quantities"].items()),
         *(f"{seconds:.1f} ({one['seconds']['1'] / seconds:.1f})"
           for seconds in one["seconds"].values()))
        for one in data["simulated"]
    ]  # fmt: skip
    counts = data["simulated"][0]["seconds"]
    return (
        "91 speeds, 0.4 to 1.3 m/s, without torsional friction, which version 0.1 does not know; "
        "whole commands, medians in turns, on a machine that others used too.\n\n"
        + table(("command", "s", "CPU s", "gaits a minute"), rows)
        + "\n\nBy workers in simulated time: a job takes the CPU time that it took alone, the "
        "sweep itself its own, messages none. Seconds, and how many times sooner than by one.\n\n"
        + table(("sweep", *(f"{n} workers" for n in counts)), shares)
    )


def grids(data: Record) -> str:
    """Grids of two quantities against single designs."""
    rows = []
    for one in data:
        gaits, seconds = one["gaits"], one["cpu seconds"]
        apart = [100.0 * (g["cost"] / g["single"] - 1.0) for g in gaits]
        rows.append((
            " x ".join(f"{name} {text}" for name, text in one["quantities"].items()),
            str(len(gaits)), str(sum(g["certified"] for g in gaits)),
            str(sum(a > 0.01 for a in apart)), str(sum(a < -0.01 for a in apart)),
            f"{max(apart):+.2f}", f"{min(apart):+.2f}",
            f"{seconds['sweep']:.1f}", f"{seconds['single']:.1f}",
        ))  # fmt: skip
    head = (
        "grid", "gaits", "certified", "dearer", "cheaper", "most, %", "least, %",
        "CPU s, sweep", "single",
    )  # fmt: skip
    return (
        "Each gait of a sweep against a design of its own from the two starts that `optimise` "
        "makes; dearer or cheaper by more than 0.01 %.\n\n" + table(head, rows)
    )


def _percent(many: Record, other: Record) -> str:
    return f"{100.0 * (many['cost'] / other['cost'] - 1.0):+.1f}"


def paper_own(data: Record) -> str:
    """The paper's method on the paper's evaluation."""
    ours = median(run["arrived"] for run in data["ours"])
    cost = data["evaluation"]
    slower = cost["paper"] / cost["gaitopt"]
    rows = [
        ("gaitopt, exact derivatives", f"{ours:.3f}", "1", "arrived"),
        _line("SLSQP, differences, gaitopt's evaluation", data["fast"], ours),
    ]
    fast = data["fast"]["progress"][-1]
    rows.append((
        "the same evaluations on the paper's evaluation, computed",
        number(own_seconds(data)), number(own_seconds(data) / ours), "computed",
    ))  # fmt: skip
    if "paper" in data and data["paper"]["progress"]:
        rows.append(_line("SLSQP, differences, the paper's evaluation", data["paper"], ours))
    return (
        "SLSQP with forward differences of cost and rows, from the same guess, until a feasible "
        "iterate costs no more than gaitopt's optimum + 0.01 %. The paper's evaluation goes "
        "through the chain of Table 1 instant by instant with the recursive Newton-Euler "
        f"algorithm, in Python; it is the same program (apart by {cost['apart']:.0e}) and takes "
        f"{1e3 * cost['paper']:.0f} ms where gaitopt's batched one takes "
        f"{1e3 * cost['gaitopt']:.2f} ms, {slower:.0f} times as long. The computed line takes "
        f"the {fast[3]:.0f} evaluations of the run above it, each as long as measured there, and "
        "its own time in SLSQP. CPU seconds.\n\n"
        + table(("method", "s to J + 0.01 %", "ratio", ""), rows)
    )


def own_seconds(data: Record) -> float:
    """Time of the fast run's evaluations, were they the paper's, with its time in the solver."""
    seconds, _, _, evaluations, evaluating = data["fast"]["progress"][-1]
    return float(evaluations * data["evaluation"]["paper"] + seconds - evaluating)


def _line(name: str, run: Record, ours: float) -> tuple[str, str, str, str]:
    seconds, cost, violation = run["progress"][-1][:3]
    state = "arrived" if run["arrived"] else f"stopped at J = {cost:.1f}, violation {violation:.0e}"
    return name, number(seconds), number(seconds / ours), state


def proof(data: Record) -> str:
    """Certified walks at thousands of instants."""
    certified = [r for r in data["records"] if r["outcome"] == "certified"]
    samples = sorted({r["samples"] for r in certified})
    robots = sorted({r["robot"] for r in certified})
    above = sum(r["violation"] > 1e-6 for r in certified)
    hidden = max(r["violation"] - r["told"] for r in certified)
    others = [r for r in data["records"] if r["outcome"] != "certified"]
    return (
        f"{len(certified)} random certified walks ({', '.join(robots)}; samples "
        f"{', '.join(map(str, samples))}) evaluated at {data['instants']} equally spaced instants: "
        f"the worst scaled violation is {data['worst']:.1e}, the median {data['median']:.1e}; "
        f"{above} exceed 1e-6. (Before extremes were located, 132 of 132 did: median 5e-5, worst "
        f"8e-4.) The certificate itself told at most {data['told']:.1e}; no walk exceeds its own "
        f"certificate by more than {max(hidden, 0.0):.1e}. {len(others)} further draws had no gait "
        "or were not certified, and say so."
    )


def designs(data: Record) -> str:
    """Designs and next walks over version 0.1."""
    rows = []
    for what in ("design", "next walk"):
        for column, speed in enumerate(data["speeds"]):
            old, plain, own = (
                median(turn[column] for turn in data[name][what])
                for name in ("0.1", "plain path", "gaitopt")
            )
            rows.append((
                what, f"{speed:g}", *(f"{1e3 * time:.1f}" for time in (old, plain, own)),
                f"{plain / old:.2f}", f"{own / old:.2f}",
            ))  # fmt: skip
    head = (
        "what", "m/s", "version 0.1, ms", "plain path, ms", "ms", "plain path over 0.1", "over 0.1",
    )  # fmt: skip
    turns = len(data["0.1"]["design"])
    return (
        "Biped, preset `standard`: certified designs from one start; next walks at the samples "
        "from the walk 0.01 m/s slower (`Replanner`; in version 0.1 its SQP from that walk and its "
        f"multipliers), program included. CPU time, medians of {turns} turns; of the next walk "
        "each turn is the least of three.\n\n" + table(head, rows)
    )


def ratios_to_old(data: Record, what: str) -> list[float]:
    """Return the ratios of median times to those of version 0.1, at each speed."""
    times = (
        [median(turn[k] for turn in data[name][what]) for k in range(len(data["speeds"]))]
        for name in ("gaitopt", "0.1")
    )
    return [own / old for own, old in zip(*times, strict=True)]
