"""The tables on gaitopt alone, from the results of its benchmarks."""

from __future__ import annotations

from tables import Record, median, number, table


def evaluation(data: list[Record]) -> str:
    """Ratios to the bare sweep, by samples."""
    rows = []
    for line in data:
        taken = line["seconds"]
        bare = taken["bare"]["min"]
        rows.append(
            (
                line["samples"],
                line["rows"],
                f"{1e3 * bare:.2f}",
                *(
                    f"{taken[kind + k]['min'] / bare:.1f}"
                    for kind in ("", "plain ")
                    for k in ("values", "point", "hessian")
                ),
                f"{1e6 * taken['point']['min'] / line['samples']:.0f}",
            )
        )
    head = (
        "samples", "rows", "bare sweep, ms", "values", "all derivatives", "exact Hessian",
        "plain path: values", "derivatives", "Hessian", "derivatives, µs per sample",
    )  # fmt: skip
    return (
        "Compiled, and by the plain path (`GAITOPT_COMPILED=0`). Least CPU time over interleaved "
        "rounds, in units of the bare sweep: one `computeRNEADerivatives` call per sample. The "
        "Hessian is that of the Lagrangian at the optimum's multipliers, after the derivatives. "
        "Growth is linear where the last column is constant.\n\n" + table(head, rows)
    )


def cold(data: list[Record]) -> str:
    """Our own solves."""
    rows = []
    for sigma in sorted({r["sigma"] for r in data}):
        runs = [r for r in data if r["sigma"] == sigma]
        sweeps = [r["cpu seconds"] / r["bare"] for r in runs]
        rows.append((
            sigma, f"{sum(solved(r) for r in runs)}/{len(runs)}",
            f"{median(r['iterations'] for r in runs):.0f}",
            f"{median(r['evaluations'] for r in runs):.0f}",
            f"{median(r['seconds'] for r in runs):.3f}", f"{max(r['seconds'] for r in runs):.3f}",
            f"{median(r['cpu seconds'] for r in runs):.3f}", f"{median(sweeps):.0f}",
            ", ".join(str(c) for c in sorted({round(r["cost"], 1) for r in runs})),
        ))  # fmt: skip
    head = (
        "sigma", "KKT ≤ 1e-6", "iterations", "evaluations", "s, median", "s, largest",
        "CPU s, median", "bare sweeps, median", "costs found",
    )  # fmt: skip
    return (
        "SQP with the exact Hessian at 1.0 m/s, one thread, from the first guess with normal "
        "noise of standard deviation sigma on every joint parameter. A bare sweep was timed "
        "before and after every solve; the ratio is of CPU times.\n\n" + table(head, rows)
    )


def solved(run: Record) -> bool:
    return bool(run["kkt"] <= 1e-6 and run["violation"] <= 1e-6)


def scaling(data: Record) -> str:
    """Postures and samples."""
    keys = ("postures", "samples", "parameters", "rows")
    rows = [
        (*(r[k] for k in keys), r["status"].lower(), f"{r['cost']:.3f}", r["iterations"],
         r["evaluations"], number(r["seconds"]), f"{r['cpu seconds'] / r['bare']:.0f}")
        for r in (*data["postures"], *data["samples"])
    ]  # fmt: skip
    head = (*keys, "ended as", "J", "iterations", "evaluations", "s", "bare sweeps")
    return (
        "One cold solve each from the first guess, stopped after "
        f"{data['cap']:.0f} s of CPU. J falls with the postures; with the samples it changes, "
        "since constraints hold at more instants, and where another optimum is found.\n\n"
        + table(head, rows)
    )


def memory(data: Record) -> str:
    """Memory of one design."""
    faults = data["page faults of an evaluation"]
    named = ("peak of one design", "held after one design", "one Jacobian")
    rows = [(f"{name}, MB", f"{data[name]:.2f}") for name in named]
    rows += [
        ("process before the first design, MB", f"{data['resident before']:.0f}"),
        ("process after it, MB", f"{data['resident after']:.0f}"),
        ("page faults per evaluation of a solve, plain", f"{faults['plain']:.1f}"),
        ("page faults per evaluation, memory kept", f"{faults['kept']:.1f}"),
    ]
    return (
        "A refined and certified design at 1.0 m/s; peak and what is held are Python's "
        "allocations, the process includes all libraries.\n\n" + table(("what", "value"), rows)
    )


def random_bipeds(data: list[Record]) -> str:
    """Counts and times of the random bipeds."""
    counts = {
        "certified": [r for r in data if r["outcome"] == "certified"],
        "not certified": [r for r in data if r["outcome"] == "not certified"],
        "no gait, diagnosed": [r for r in data if r["outcome"] == "no gait" and r["diagnosed"]],
        "no gait, not diagnosed": [
            r for r in data if r["outcome"] == "no gait" and not r["diagnosed"]
        ],
        "error": [r for r in data if r["outcome"] == "error"],
    }
    rows = [
        (name, len(runs), number(median(r["seconds"] for r in runs)) if runs else "",
         number(max(r["seconds"] for r in runs)) if runs else "")
        for name, runs in counts.items()
    ]  # fmt: skip
    others = [
        f"- seed {r['seed']}, {r['speed']:.2f} m/s: {r['outcome']}: "
        f"{r.get('diagnosis', r['reason'])}"
        for r in data
        if r["outcome"] != "certified"
    ]
    return (
        "Lengths changed by up to 20 %, masses by up to 30 %, each on its own; speeds from 0.5 to "
        "1.2 m/s; cold, with refinement and confirmation.\n\n"
        + table(("outcome", "bipeds", "s, median", "s, largest"), rows)
        + "".join(f"\n{line}" for line in (["", *others] if others else []))
    )
