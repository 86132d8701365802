"""The table on real robots, from the results of its benchmark."""

from __future__ import annotations

from collections import Counter

from tables import Record, median, table

OPTIMAL = "OPTIMAL"


def real_robots(data: Record) -> str:
    """Starts, speeds, known results and the head-to-head."""
    return "\n\n".join(
        (
            "Robots of example-robot-data as they come, with the default task of a humanoid: "
            "lifted double support, relaxed approach, bounds on trunk, width, torsion and gaps; "
            "rigid bodies alone, without rotors and the damping of their files, which "
            "[physics.md](physics.md) adds. "
            "Nine starts: the first guess, and eight with normal noise of 0.05 on every joint "
            "parameter. Times are of the CPU, one thread, without refinement and certificate.",
            _starts(data["catalogue"]),
            "Three speeds each, the last the fastest found by `gaitopt optimise --fastest`; "
            "refined between the samples and certified.",
            _speeds(data["catalogue"]),
            "Walks whose optimum another program has found, with its settings (no bounds on "
            "trunk, width or gaps).",
            _known(data["known"]),
            "The G1 example of RAPTOR, like for like: steps of 0.15 m in 0.4 s, feet level and "
            "0.237 m apart, trunk within one degree, clearance 0.05 m. RAPTOR's own runs on such "
            "a machine: feasible 12 of 12 in about 10.5 s, optimal 0 of 12; its cost is another.",
            _head_to_head(data["head to head"]),
        )
    )


def solved(runs: list[Record]) -> str:
    """How many of the runs are optimal."""
    return f"{sum(r['status'] == OPTIMAL for r in runs)}/{len(runs)}"


def costs(runs: list[Record]) -> str:
    """The different costs of the optimal runs, and how often each was found."""
    found = Counter(f"{r['cost']:.2f}" for r in runs if r["status"] == OPTIMAL)
    return ", ".join(f"{cost} ({n})" for cost, n in sorted(found.items(), key=lambda e: e[0]))


def seconds(runs: list[Record]) -> str:
    """Median and largest time."""
    taken = [r["cpu seconds"] for r in runs]
    return f"{median(taken):.2f}, {max(taken):.2f}"


def _iterations(runs: list[Record]) -> str:
    return f"{median(r['iterations'] for r in runs if 'iterations' in r):.0f}"


def _starts(data: list[Record]) -> str:
    rows = [
        (
            r["robot"], f"{r['mass']:.1f}", f"{r['speed']:g}", solved(r["starts"]),
            costs(r["starts"]), _iterations(r["starts"]), seconds(r["starts"]),
            f"{solved(r['direct'])}: {costs(r['direct'])}",
        )
        for r in data
    ]  # fmt: skip
    head = (
        "robot", "kg", "m/s", "optimal", "J (how often)", "iterations", "s, median, largest",
        "approached directly",
    )  # fmt: skip
    return table(head, rows)


def _speeds(data: list[Record]) -> str:
    rows = []
    for r in data:
        for at in r["speeds"]:
            rows.append((
                r["robot"], f"{at['speed']:.3f}", f"{at.get('duration', 0.0):.2f}",
                f"{at.get('cost', float('nan')):.1f}", at["verdict"],
            ))  # fmt: skip
    return table(("robot", "m/s", "s per step", "J", "verdict"), rows)


def _known(data: list[Record]) -> str:
    rows = []
    for r in data:
        best = min(run["cost"] for run in r["starts"] if run["status"] == OPTIMAL)
        rows.append((
            r["robot"], f"{r['known']:g}", f"{best:.3f}", solved(r["starts"]),
            costs(r["starts"]), _iterations(r["starts"]), seconds(r["starts"]),
        ))  # fmt: skip
    head = (
        "robot", "known J", "best J here", "optimal", "J (how often)", "iterations",
        "s, median, largest",
    )  # fmt: skip
    return table(head, rows)


def _head_to_head(data: list[Record]) -> str:
    rows = [
        (
            r["sole"], solved(r["starts"]), costs(r["starts"]), _iterations(r["starts"]),
            f"{median(run['feasible at'] for run in r['starts']):.0f}", seconds(r["starts"]),
        )
        for r in data
    ]  # fmt: skip
    head = (
        "sole", "optimal", "J (how often)", "iterations", "feasible at iteration",
        "s, median, largest",
    )  # fmt: skip
    return table(head, rows)


def _rigid(record: Record) -> str:
    if "cost" not in record:
        return "-"
    return f"{record['cost']:.1f}" + ("" if record["certified"] else ", not certified")


def public_robots(data: Record) -> str:
    """Files as they come, with the physics in them and without."""
    rows = []
    for r in data["records"]:
        if "cost" not in r:
            rows.append(
                (r["file"], f"{r['speed']:g}", "refused", "", "", "", f"{r['cpu seconds']:.1f}")
            )
            continue
        length, width = (1e3 * v for v in r["sole"])
        rows.append(
            (
                r["file"],
                f"{r['speed']:g}",
                "certified" if r["certified"] else "not certified",
                f"{r['cost']:.1f}",
                _rigid(r["rigid"]),
                f"{length:.0f} x {width:.0f}",
                f"{r['cpu seconds']:.1f}",
            )
        )
    refused = [r for r in data["records"] if "cost" not in r]
    said = "\n".join(f"- {r['file']}: {r['said'][:240]} ..." for r in refused)
    head = ("file", "m/s", "", "J", "J, rigid bodies alone", "sole, mm", "CPU s")
    return "\n\n".join(
        (
            "`gaitopt optimise --urdf FILE --speed V` without any choice, on files of public "
            "packages (docs/robots.md says which). J counts rotors, damping, friction and springs "
            "of the file; the second figure leaves them out (`--without`).",
            table(head, rows),
            f"What the refusals say:\n\n{said}" if refused else "None is refused.",
        )
    )
