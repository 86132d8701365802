"""The tables that compare solvers, from the results of their benchmarks."""

from __future__ import annotations

from tables import Record, median, number, table


def solvers(data: Record) -> str:
    """All methods, sigma by sigma."""
    runs = data["runs"]
    names = list(dict.fromkeys(r["method"] for r in runs))
    rows = [
        solver_row(name, sigma, [r for r in runs if r["method"] == name and r["sigma"] == sigma])
        for sigma in sorted({r["sigma"] for r in runs})
        for name in names
        if any(r["method"] == name and r["sigma"] == sigma for r in runs)
    ]
    head = (
        "sigma", "method", "success", "at best optimum", "iterations", "evaluations", "Hessians",
        "CPU s", "in evaluations", "in solver", "J spread",
    )  # fmt: skip
    optima = ", ".join(f"{cost:.3f}" for cost in data["optima"])
    return (
        "The same `WalkProblem` with the same derivatives for all, that of the preset `standard` "
        "at 1.0 m/s without torsional friction; medians over starts, of which methods that are "
        "slow have fewer. Success: violation at most 1e-6 and cost within "
        f"0.01 % of a point that satisfies the KKT conditions ({optima}). A run is stopped after "
        f"{data['cap']:.0f} s of CPU. Each evaluation of cost and rows at a new point counts, with "
        "derivatives or without. Time in the solver includes the adapter: for SNOPT Drake's "
        "automatic differentiation types, for the SciPy methods and IPOPT the judgement of every "
        "iterate. J spread is largest less smallest cost of the successful runs.\n\n"
        + table(head, rows)
        + "\n\n"
        + against_snopt(runs)
    )


def solver_row(name: str, sigma: float, runs: list[Record]) -> tuple[object, ...]:
    """One line of the solvers' table."""
    good = [r for r in runs if r["optimum"] is not None]
    known = [r["iterations"] for r in runs if "iterations" in r]
    middle = {
        key: median(r[key] for r in runs)
        for key in ("evaluations", "hessians", "evaluation cpu seconds", "cpu seconds")
    }
    costs = [r["cost"] for r in good]
    return (
        sigma, name, f"{len(good)}/{len(runs)}", sum(r["optimum"] == 0 for r in good),
        f"{median(known):.0f}" if known else "", f"{middle['evaluations']:.0f}",
        f"{middle['hessians']:.0f}", number(middle["cpu seconds"]),
        number(middle["evaluation cpu seconds"]),
        number(median(r["cpu seconds"] - r["evaluation cpu seconds"] for r in runs)),
        f"{max(costs) - min(costs):.2g}" if costs else "",
    )  # fmt: skip


def pairs(runs: list[Record], theirs: str, ours: str) -> list[tuple[Record, Record]]:
    """Runs of two methods from the same start."""
    mine = {(r["sigma"], r["seed"]): r for r in runs if r["method"] == ours}
    return [(r, mine[r["sigma"], r["seed"]]) for r in runs if r["method"] == theirs]


def snopt_ratios(runs: list[Record]) -> Record | None:
    """Ours against SNOPT, start by start."""
    paired = pairs(runs, "SNOPT", "gaitopt SQP, exact Hessian")
    both = [(s, g) for s, g in paired if s["optimum"] is not None and g["optimum"] is not None]
    if not both:
        return None
    bare = [(s["cpu seconds"] - s["marshalling"]) / g["cpu seconds"] for s, g in both]
    return {
        "starts": len(paired),
        "same": sum(abs(s["cost"] - g["cost"]) <= 1e-4 * g["cost"] for s, g in both),
        "both": len(both),
        "evaluations": median(s["evaluations"] / g["evaluations"] for s, g in both),
        "cpu": median(s["cpu seconds"] / g["cpu seconds"] for s, g in both),
        "without types": median(bare),
        "apart": min(abs(s["cost"] / g["cost"] - 1.0) for s, g in both),
    }


def against_snopt(runs: list[Record]) -> str:
    r = snopt_ratios(runs)
    if r is None:
        return "There is no run of SNOPT to compare with."
    return (
        f"Against SNOPT, start by start (median of the {r['both']} of {r['starts']} from "
        f"which both succeed): {r['evaluations']:.1f} times "
        f"fewer evaluations, {r['cpu']:.0f} times less CPU time "
        f"({r['without types']:.0f} times without the making of Drake's types). "
        f"From {r['same']} of them both end at the same optimum "
        "within 1e-4; the others end at another of the optima above."
    )


def paper_method(data: Record) -> str:
    """The paper's method in both modes."""
    ours = data["ours"]
    rows = [paper_row("gaitopt", ours, ours)]
    names = {"all": "SLSQP, differences", "constraints": "SLSQP, exact cost gradient"}
    rows += [paper_row(names[k], run, ours) for k, run in data["paper"].items()]
    near = ("0.01", "0.001", "0.0001")
    head = (
        "method", "ended as", "J", "KKT", "evaluations", "s", *(f"s to J + {100 * float(n):g} %"
        for n in near), "ratio to J + 1 %", "ratio to J + 0.01 %", "ratio to the end",
    )  # fmt: skip
    return (
        "SLSQP with forward differences from the same guess, on gaitopt's own evaluation, whose "
        "values are cheap; the time of the paper's own evaluation is not in these ratios. Time "
        "to J is when a feasible iterate first costs no more than that above gaitopt's "
        f"optimum. Times are of the CPU. Runs are stopped after {data['cap']:.0f} s; ours is the "
        f"median of {len(data['runs'])}.\n\n" + table(head, rows)
    )


def paper_row(name: str, run: Record, ours: Record) -> tuple[object, ...]:
    times, own = run["first time"], ours["first time"]
    return (
        name, run["status"].lower(), f"{run['cost']:.3f}", f"{run['kkt']:.1e}",
        run["evaluations"], number(run["cpu seconds"]),
        *(number(t) if t is not None else "never" for t in times.values()),
        *(f"{times[n] / own[n]:.0f}" if times[n] else "" for n in ("0.01", "0.0001")),
        f"{run['cpu seconds'] / ours['cpu seconds']:.0f}",
    )  # fmt: skip
