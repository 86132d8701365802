"""Fixtures that all tests share; its presence also puts this directory on the import path."""

import gc
from collections.abc import Callable, Generator

import numpy as np
import pytest
from reference_cases import ReferenceCase, biped, reference_case, reference_task

from gaitopt.design.design import design
from gaitopt.design.options import DesignOptions
from gaitopt.design.pipeline import Design
from gaitopt.gait.task import Task
from gaitopt.model.robot import Robot
from gaitopt.solvers import solver_by_name


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--nothing-skipped",
        action="store_true",
        help="fail on tests that are skipped, but for those that need a browser",
    )


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Generator[None, object, object]:
    """Look for no garbage among the tests themselves, which takes a third of collecting them."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.freeze()
        gc.enable()


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(
    item: pytest.Item, call: "pytest.CallInfo[None]"
) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    del call
    report = yield
    if (
        report.skipped
        and not hasattr(report, "wasxfail")
        and not item.get_closest_marker("browser")
    ):
        _fail(report, item.config)
    return report


@pytest.hookimpl(wrapper=True)
def pytest_make_collect_report(
    collector: pytest.Collector,
) -> Generator[None, pytest.CollectReport, pytest.CollectReport]:
    report = yield
    if report.skipped:
        _fail(report, collector.config)
    return report


def _fail(report: pytest.TestReport | pytest.CollectReport, config: pytest.Config) -> None:
    """Turn a report of a skip into one of a failure, if nothing is to be skipped."""
    if config.getoption("--nothing-skipped"):
        reason = report.longrepr[2] if isinstance(report.longrepr, tuple) else report.longrepr
        report.outcome = "failed"
        report.longrepr = f"--nothing-skipped: {reason}"


@pytest.fixture(scope="module", autouse=True)
def forgotten(request: pytest.FixtureRequest) -> Generator[None]:
    """Keep what functions of a file of tests remember no longer than its tests: walks are large."""
    yield
    for value in vars(request.module).values():
        if getattr(value, "__module__", None) == request.module.__name__:
            getattr(value, "cache_clear", lambda: None)()


@pytest.fixture(scope="session")
def robot() -> Robot:
    """The paper's biped, standing on its right foot."""
    return biped()


@pytest.fixture(scope="session")
def reference() -> Callable[[str], ReferenceCase]:
    """Loader of the independent solution's cases."""
    return reference_case


@pytest.fixture
def rng() -> np.random.Generator:
    """Random numbers, the same for every test."""
    return np.random.default_rng(20)


@pytest.fixture(scope="session")
def standard_task() -> Task:
    """The walk of 1.0 m/s with 43 parameters and every constraint that other solutions have."""
    return reference_task(speed=1.0)


@pytest.fixture(scope="session")
def sampled_design(robot: Robot, standard_task: Task) -> Design:
    """An optimal gait whose constraints hold at the given samples."""
    options = DesignOptions(solver=solver_by_name("sqp"), refine=False)
    return design(robot, standard_task, options)


@pytest.fixture(scope="session")
def refined_design(robot: Robot, standard_task: Task) -> Design:
    """An optimal gait whose constraints hold between the samples too."""
    options = DesignOptions(solver=solver_by_name("sqp"), refine=True)
    return design(robot, standard_task, options)
