"""What was asked of the optimiser, beside what was measured."""

from __future__ import annotations

from typing import Any

from comparisons import snopt_ratios
from live_sections import ASKED
from process_sections import own_seconds, ratios_to_old
from robots_section import OPTIMAL
from robots_section import solved as solved_of
from sections import solved
from tables import Record, median, table


def must_show(data: dict[str, Any]) -> str:
    """Return the table; a demand that is not met says so."""
    rows = [
        *_evaluation(data["evaluation"]),
        *_cold(data["cold"]),
        *_snopt(data["solvers"]),
        _paper(data["paper_method"]),
        _paper_own(data["paper_own"]),
        _bipeds(data["random_bipeds"]),
        *_process(data["process"]),
        *_designs(data["designs"]),
        *_robots(data["real_robots"]),
        _sweep(data["sweep"]),
        *_workers(data["workers"]["commands"]),
        *_codesign(data["codesign"]),
        *_live(data["live"]),
    ]
    return table(
        ("what", "asked", "measured", "met"),
        [
            (what, asked, measured, "yes" if met else "**no**")
            for what, asked, measured, met in rows
        ],
    )


def _evaluation(data: list[Record]) -> list[tuple[str, str, str, bool]]:
    rows = []
    for part, most, name in (
        ("point", 2.5, "cost, rows and all Jacobians"),
        ("hessian", 4.0, "exact Hessian"),
    ):
        ratios = [r["seconds"][part]["min"] / r["seconds"]["bare"]["min"] for r in data]
        usual = next(q for q, r in zip(ratios, data, strict=True) if r["samples"] == 31)
        rows.append((
            name, f"≤ {most:g} bare sweeps at 31 samples",
            f"{usual:.1f}, {min(ratios):.1f} to {max(ratios):.1f} over all; "
            "[why](decisions/compiled.md)",
            usual <= most,
        ))  # fmt: skip
    return rows


def _cold(data: list[Record]) -> list[tuple[str, str, str, bool]]:
    rows = []
    for sigma, least in ((0.05, 20), (0.1, 19)):
        runs = [r for r in data if r["sigma"] == sigma]
        good = sum(solved(r) for r in runs)
        rows.append((
            f"cold solves, sigma {sigma:g}, KKT ≤ 1e-6", f"{least}/20", f"{good}/{len(runs)}",
            good >= least,
        ))  # fmt: skip
    runs = [r for r in data if r["sigma"] == 0.05]
    seconds = median(r["cpu seconds"] for r in runs)
    sweeps = median(r["cpu seconds"] / r["bare"] for r in runs)
    rows.append(("their time, median", "≤ 0.25 s", f"{seconds:.3f} s of CPU", seconds <= 0.25))
    rows.append(("", "≤ 800 bare sweeps", f"{sweeps:.0f}", sweeps <= 800.0))
    return rows


def _snopt(data: Record) -> list[tuple[str, str, str, bool]]:
    r = snopt_ratios(data["runs"])
    if r is None:
        return [("against SNOPT", "same optimum", "not run", False)]
    return [
        ("SNOPT's optimum", "the same within 1e-4", f"closest pair {r['apart']:.0e}; same "
         f"one from {r['same']} of {r['both']} starts", r["apart"] <= 1e-4),
        ("evaluations against SNOPT", "10 times fewer", f"{r['evaluations']:.1f} times",
         r["evaluations"] >= 10.0),
        ("CPU time against SNOPT", "10 times less", f"{r['cpu']:.0f} times "
         f"({r['without types']:.0f} without Drake's types)", r["without types"] >= 10.0),
    ]  # fmt: skip


def _paper(data: Record) -> tuple[str, str, str, bool]:
    ours = data["ours"]["first time"]["0.0001"]
    ratios = [run["first time"]["0.0001"] for run in data["paper"].values()]
    known = [seconds / ours for seconds in ratios if seconds is not None]
    measured = " and ".join(f"{ratio:.0f}" for ratio in known) if known else "never reached J"
    return (
        "paper's method, time to J + 0.01 %", "1000 times longer",
        f"{measured} times, on gaitopt's fast evaluation", bool(known) and min(known) >= 1000.0,
    )  # fmt: skip


def _paper_own(data: Record) -> tuple[str, str, str, bool]:
    ours = median(run["arrived"] for run in data["ours"])
    arrived = data.get("paper", {}).get("arrived", False)
    seconds = data["paper"]["progress"][-1][0] if arrived else own_seconds(data)
    ratio = seconds / ours
    return (
        "the same on the paper's own evaluation", "1000 times longer",
        f"{ratio:.0f} times" + ("" if arrived else ", computed"), ratio >= 1000.0,
    )  # fmt: skip


def _process(data: Record) -> list[tuple[str, str, str, bool]]:
    rows = []
    for name, what, most in (
        ("help", "import and help", 0.5),
        ("optimise", "optimise, whole process", 3.0),
    ):
        wall = median(run["wall"] for run in data[name])
        rows.append((what, f"< {most:g} s", f"{wall:.2f} s", wall < most))
    return rows


def _designs(data: Record) -> list[tuple[str, str, str, bool]]:
    rows = []
    for what, name, most in (
        ("design", "certified design from one start", 0.5),
        ("next walk", "the next walk, 0.01 m/s away", 0.35),
    ):
        ratios = ratios_to_old(data, what)
        rows.append((
            name, f"≤ {most:g} times version 0.1",
            f"{median(ratios):.2f} times; {min(ratios):.2f} to {max(ratios):.2f} at four speeds",
            median(ratios) <= most,
        ))  # fmt: skip
    return rows


def _robots(data: Record) -> list[tuple[str, str, str, bool]]:
    starts = [run for robot in data["catalogue"] for run in robot["starts"]]
    slowest = max(median(r["cpu seconds"] for r in x["starts"]) for x in data["catalogue"])
    known = [
        min(r["cost"] for r in x["starts"] if r["status"] == OPTIMAL) / x["known"] - 1.0
        for x in data["known"]
    ]
    peer = [run for task in data["head to head"] for run in task["starts"]]
    return [
        ("real robots, cold starts", "all optimal", f"{solved_of(starts)} of "
         f"{len(data['catalogue'])} robots", all(r["status"] == OPTIMAL for r in starts)),
        ("their time, median of the slowest", "≤ 1 s", f"{slowest:.2f} s of CPU", slowest <= 1.0),
        ("known optima of real robots, best of 9", "within 0.1 %", f"{100.0 * max(known):+.4f} %",
         max(known) <= 1e-3),
        ("the peer's task for G1", "9/9 optimal", f"{solved_of(peer)} on two soles",
         all(r["status"] == OPTIMAL for r in peer)),
    ]  # fmt: skip


def _codesign(data: Record) -> list[tuple[str, str, str, bool]]:
    found = []
    for name, part in (("Nelder-Mead", "compared"), ("CMA-ES", "searched by CMA-ES")):
        rows = [row for row in data.get(part, {"rows": []})["rows"] if name in row]
        if not rows:
            continue
        each = [row[name]["evaluations"] / row["exact gradient"]["evaluations"] for row in rows]
        reached = [q for q, row in zip(each, rows, strict=True) if row[name]["reached"]]
        never = f"; never from {len(rows) - len(reached)}" if len(reached) < len(rows) else ""
        ratios = ", ".join(f"{q:.1f}" for q in sorted(reached))
        starts = f"{len(rows)} start" + ("s" if len(rows) > 1 else "")
        found.append((
            f"co-design beside {name}, evaluations of walks", "20 times fewer",
            f"of {starts}: {ratios or 'none'} times{never}", all(q >= 20.0 for q in reached),
        ))  # fmt: skip
    ends = [row["after"] for row in data["starts"]]
    apart = max(ends) / min(ends) - 1.0
    improved = 1.0 - ends[0] / data["starts"][0]["before"]
    found.append((
        "co-design for eight speeds, from five starts", "the same optimum",
        f"costs within {apart:.0e}; {100.0 * improved:.1f} % less than as it is",
        len(ends) == 5 and apart <= 1e-5,
    ))  # fmt: skip
    return found


def _sweep(data: Record) -> tuple[str, str, str, bool]:
    spent = data["sweep"]["cpu seconds"]
    one, two = (sum(g["cpu seconds"] for g in data[f"cold, {n}"]) / spent for n in (1, 2))
    dearest = max(
        many["cost"] / cold["cost"] - 1.0
        for many, cold in zip(data["sweep"]["gaits"], data["cold, 2"], strict=True)
    )
    clock = data["commands"]["optimise"] / data["commands"]["sweep"]
    return (
        "19 gaits against 19 cold commands, by the clock", "3 times faster, no cost higher",
        f"{clock:.1f} times; in one process {two:.1f}, against one start each {one:.1f}; "
        f"none more than {max(dearest, 0.0):.0e} higher",
        dearest <= 1e-6 and clock >= 3.0,
    )  # fmt: skip


def _workers(data: dict[str, list[Record]]) -> list[tuple[str, str, str, bool]]:
    seconds = {name: median(run["wall"] for run in runs) for name, runs in data.items()}
    two, shared = seconds["gaitopt, 2"], seconds["gaitopt, 1"] / seconds["gaitopt, 2"]
    faster = seconds["0.1, 2"] / two
    return [
        ("91 speeds on two cores", "4 times the gaits a minute of version 0.1",
         f"{faster:.1f} times, {60.0 * 91 / two:.0f} a minute", faster >= 4.0),
        ("two workers on them", "1.7 times one", f"{shared:.2f} times", shared >= 1.7),
    ]  # fmt: skip


def _live(data: list[Record]) -> list[tuple[str, str, str, bool]]:
    rows = []
    for one in data:
        name, half = one["robot"], one["curves_ms"]["p50"]
        rows.append((
            f"live page, slider to curves, {name}", f"≤ {ASKED[name]:.0f} ms",
            f"{half:.0f} ms", half <= ASKED[name],
        ))  # fmt: skip
        rows.append((
            f"its moves, {name}", "500 without an error or a stale certificate",
            f"{one['moves']}, {len(one['errors'])} errors, {one['stale']} stale",
            one["moves"] >= 500 and not one["errors"] and one["stale"] == 0,
        ))  # fmt: skip
    return rows


def _bipeds(data: list[Record]) -> tuple[str, str, str, bool]:
    certified = sum(r["outcome"] == "certified" for r in data)
    diagnosed = sum(r["outcome"] == "no gait" and r["diagnosed"] for r in data)
    return (
        "random bipeds, certified or diagnosed", f"{len(data)}/{len(data)}",
        f"{certified} certified, {diagnosed} diagnosed", certified + diagnosed == len(data),
    )  # fmt: skip
