"""The table on damaged inputs, from the results of `fuzz.py`."""

from __future__ import annotations

from tables import Record, table


def fuzz(data: Record) -> str:
    """What became of inputs changed at random, by kind."""
    rows = []
    for name, kind in data["kinds"].items():
        results = kind["results"]
        refused = _count(results, "refused") + results.get("exit code 2", 0)
        both = _count(results, "read, as MuJoCo")
        rows.append((
            name, kind["mutations"], refused, kind["mutations"] - refused,
            both if name in ("URDF", "MJCF") else "", _count(results, "", "a short design"),
            kind["findings"], f"{kind['seconds']:.1f}", f"{max(kind['memory'], 0.0):.0f}",
        ))  # fmt: skip
    head = (
        "input", "mutations", "refused in words", "read or done", "equal to MuJoCo's",
        "short designs", "faults", "s of CPU, most", "MB, most",
    )  # fmt: skip
    notes = [f"- {count}: {note}" for note, count in data["notes"].items()]
    faults = [f"- {f['number']} ({f['kind']}): {f['finding']}" for f in data["findings"]]
    return "\n".join([
        f"{data['mutations']} mutations of seed {data['seed']}, of 20,000 that are to be tried (a "
        "run goes on where it was ended), each in a process that may die of it; 1 % as commands of "
        "their own. A fault is an exception that is not of `gaitopt.errors`, an exit code that is "
        "not documented, a word of a library on the screen, a file not whole, more than 20 s or "
        "1 GB, the end of the process, or a robot unlike the text: every MJCF that is read is "
        "compared with MuJoCo's reading, every URDF with a strict reader of the standard and with "
        "MuJoCo's.\n",
        table(head, rows),
        *(["\nWhat MuJoCo refuses of URDFs that agree with the strict reader, or reads otherwise "
           "than it:\n", *notes] if notes else []),
        *(["\nFaults:\n", *faults] if faults else ["\nNo faults."]),
    ])  # fmt: skip


def _count(results: Record, start: str, end: str = "") -> int:
    return sum(n for name, n in results.items() if name.startswith(start) and name.endswith(end))
