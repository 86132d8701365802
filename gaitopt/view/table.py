"""A gait as a table: one row per sample, for spreadsheets and plots."""

from __future__ import annotations

import csv
import io

import numpy as np

from gaitopt.gait.result import Gait
from gaitopt.nlp import Array
from gaitopt.view.stride import Stride

_WRENCH = ("force_x [N]", "force_y [N]", "force_z [N]",
           "moment_x [N.m]", "moment_y [N.m]", "moment_z [N.m]")  # fmt: skip


def csv_text(gait: Gait, stride: Stride) -> str:
    """Return the samples of a stride as comma-separated values with a header of names and units.

    Columns: time, step, then angle, rate, acceleration and torque of each joint, the ground wrench
    and the centre of pressure in the standing foot's sole frame.
    """
    blocks = [stride.time[:, None], stride.step[:, None].astype(np.float64)]
    header = ["time [s]", "step"]
    for values, name, unit in (
        (stride.q, "q", "rad"),
        (stride.dq, "dq", "rad/s"),
        (stride.ddq, "ddq", "rad/s2"),
        (stride.torque, "torque", "N.m"),
    ):
        header += [f"{joint} {name} [{unit}]" for joint in gait.joint_names]
        blocks.append(values)
    header += [*_WRENCH, "cop_x [m]", "cop_y [m]"]
    blocks += [stride.ground_wrench, stride.cop]
    return _written(header, np.hstack(blocks))


def _written(header: list[str], rows: Array) -> str:
    buffer = io.StringIO()
    writer = csv.writer(buffer, lineterminator="\n")
    writer.writerow(header)
    # 17 significant digits: reading the text gives the same number
    writer.writerows([[f"{value:.17g}" for value in row] for row in rows])
    return buffer.getvalue()
