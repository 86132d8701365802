"""What pyproject.toml cannot say: the compiled kernels, which gaitopt can do without.

Where there is no compiler they are left out, and the plain path of NumPy and Pinocchio computes the
same (docs/decisions/compiled.md).
"""

import zlib
from pathlib import Path

from pybind11.setup_helpers import ParallelCompile, Pybind11Extension
from setuptools import setup

PACKAGE = Path("gaitopt")
# by which gaitopt/mechanics/compiled.py knows kernels of other sources
SOURCES = zlib.crc32(b"".join(file.read_bytes() for file in sorted(PACKAGE.glob("*/*.[ch]pp"))))
ParallelCompile(default=0).install()  # by all cores

setup(
    ext_modules=[
        Pybind11Extension(
            "gaitopt.mechanics.kernels",
            sorted(map(str, PACKAGE.glob("*/*.cpp"))),
            depends=sorted(map(str, PACKAGE.glob("*/*.hpp"))),
            define_macros=[("GAITOPT_SOURCES", f"{SOURCES}u")],
            cxx_std=17,
            # no product is fused with a sum, so that both versions (lanes.hpp) give the same
            extra_compile_args=["-O3", "-fno-math-errno", "-ffp-contract=off", "-Wno-psabi"],
            optional=True,
        )
    ]
)
