"""The tables on starts and on infeasible walks."""

from __future__ import annotations

from tables import Record, median, table

SAME = 1e-4


def starts(data: list[Record]) -> str:
    """Which start leads to the best known optimum."""

    def hit(line: Record, *costs: float | None) -> bool:
        return any(c is not None and c <= line["best"] * (1.0 + SAME) for c in costs)

    rows = [
        (
            f"{line['speed']:.2f}", f"{line['best']:.2f}",
            *("yes" if hit(line, line[k]) else f"{line[k]:.2f}" for k in ("guess", "slower")),
            f"{sum(hit(line, cost) for cost in line['noise'])} of {len(line['noise'])}",
        )
        for line in data
    ]  # fmt: skip
    count = len(data)
    alone, slower, both, noisy = (
        sum(hit(line, *costs(line)) for line in data)
        for costs in (
            lambda d: [d["guess"]], lambda d: [d["slower"]], lambda d: [d["guess"], d["slower"]],
            lambda d: [d["guess"], *d["noise"]],
        )
    )  # fmt: skip
    taken = {k: median(line["cpu seconds"][k] for line in data) for k in ("guess", "slower")}
    head = ("m/s", "best known J", "first guess", "slower walk", "with noise")
    return (
        "Starts at the given samples; J within 0.01 % counts as the same. Best known is the best "
        "of these and of two passes up and two down the speeds, each walk from its neighbour. The "
        f"first guess finds it at {alone} of {count} speeds, the slower walk at {slower}, both "
        f"together (the default of `gaitopt optimise`) at {both}, the guess and "
        f"{len(data[0]['noise'])} starts with noise at {noisy}. The guess takes "
        f"{taken['guess']:.2f} s of CPU, the slower walk {taken['slower']:.2f} s (medians).\n\n"
        + table(head, rows)
    )


def diagnosis(data: list[Record]) -> str:
    """What is said about walks that do not exist."""
    rows = [
        (
            line["task"], ", ".join(line["constraints"]), "; ".join(line["suggestions"]),
            f"{line['cpu seconds']:.1f}",
        )
        for line in data
    ]  # fmt: skip
    head = ("task at 1.0 m/s", "constraints in the way", "each makes it feasible", "CPU s")
    return (
        "Walks of the thirteen-link biped that do not exist. Every suggestion was followed, and "
        "its walk keeps all limits between the samples too. The time is of design and "
        "diagnosis.\n\n" + table(head, rows)
    )


def infeasible(data: Record) -> str:
    """What became of the commands that diagnoses print."""
    return (
        "Random limits that are hard for the biped or for a robot of the catalogue, one to three "
        "at a time. Every command that was printed was run as printed, through a shell. A hundred "
        f"tasks without a gait were meant to be run; {len(data['records'])} were.\n\n"
        + table(("", ""), _followed(data["records"], data["walked"], len(data.get("failed", []))))
    )


def _followed(records: list[Record], walked: int, failed: int) -> list[tuple[object, ...]]:
    codes = [followed["code"] for line in records for followed in line["followed"]]
    advised = sum(bool(line["followed"]) for line in records)
    seconds = [line["diagnosis seconds"] for line in records if line["diagnosis seconds"]]
    return [
        ("random tasks without a gait", len(records)),
        ("random tasks with one, proven or not, left out", walked),
        *([("random tasks that ended in another way", failed)] if failed else []),
        ("diagnoses with a suggestion", advised),
        ("diagnoses without", len(records) - advised),
        ("suggestions printed", len(codes)),
        ("suggestions that exit 0, run as printed", codes.count(0)),
        ("median CPU time of a diagnosis", f"{median(seconds):.1f} s"),
        ("longest", f"{max(seconds):.1f} s"),
    ]


def codesign(data: Record) -> str:
    """Co-design by the exact gradient beside searches without derivatives, to the same value."""
    compared, other = data["compared"], data.get("searched by CMA-ES", {"rows": []})
    seeded = {tuple(row["start"]): row for row in other["rows"]}
    methods = ("exact gradient", "Nelder-Mead", "CMA-ES")
    rows = []
    for row in compared["rows"]:
        found = {**seeded.get(tuple(row["start"]), {}), **row}
        cells = [_taken(found[m]) if m in found else "not run" for m in methods]
        rows.append((", ".join(f"{value:g}" for value in row["start"]), *cells))
    return (
        "Shin (the thigh follows), hip width and foot length of the thirteen-link biped, for the "
        f"sum of the costs of walks at {', '.join(f'{v:g}' for v in compared['speeds'])} m/s, "
        f"until {compared['target']:.2f} N²·m·s, 0.01 % above the least known. All methods solve "
        "the same walks warm, from those of their best design, and begin with those of the "
        "optimum, followed back to the start. Told are designs, walks solved, and evaluations of "
        "their programs: cost and rows at one point, with derivatives or without, failed ones "
        "too.\n\n" + table(("start: shin, hips, foot, m", *methods), rows) + "\n\n"
        f"The whole of `gaitopt codesign`, for {len(data['speeds'])} walks of "
        f"{data['speeds'][0]:g} to {data['speeds'][-1]:g} m/s, searches from several first guesses "
        "and certificates with it, from five starts:\n\n" + _from_starts(data["starts"])
    )


def _from_starts(rows: list[Record]) -> str:
    return table(
        ("start: shin, hips, foot, m", "cost before", "cost after", "shin, hips, foot, m",
         "designs", "evaluations", "CPU, s", "certified"),
        [
            (
                ", ".join(f"{value:g}" for value in row["start"]), f"{row['before']:.1f}",
                f"{row['after']:.2f}",
                ", ".join(f"{row['values'][n]:.4f}" for n in ("shin", "hip_width", "foot_length")),
                row["designs"], row["evaluations"], f"{row['cpu seconds']:.0f}",
                f"{sum(row['certified'])} of {len(row['certified'])}",
            )
            for row in rows
        ],
    )  # fmt: skip


def _taken(record: Record) -> str:
    short = "" if record["reached"] else f", ends at {record['cost']:.0f}"
    counts = f"{record['designs']}, {record['walks']}, {record['evaluations']}"
    return f"{counts} in {record['cpu seconds']:.1f} s{short}"
