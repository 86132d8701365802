"""What holds for the whole house: layers, public names, the README, generated files."""

import ast
import functools
import importlib
import json
import re
import subprocess
import sys
from pathlib import Path

import pytest

import gaitopt
from gaitopt import errors
from gaitopt.cli import command_options
from gaitopt.cli.config import COMPARISON, SCHEMA, SWEEP
from gaitopt.design.options import DesignOptions
from gaitopt.design.starts import many_starts
from gaitopt.gait.presets import preset_task
from gaitopt.settings import declared
from gaitopt.solvers import SQP

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

ROOT = Path(__file__).parents[1]
PACKAGES = sorted(
    ".".join(path.parent.relative_to(ROOT).parts) for path in ROOT.glob("gaitopt/**/__init__.py")
)


def run(*command: str) -> "subprocess.CompletedProcess[str]":
    return subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)


def test_imports_point_down_without_cycles():
    found = run(str(Path(sys.executable).with_name("lint-imports")), "--no-cache")
    assert found.returncode == 0, found.stdout
    assert "2 kept, 0 broken" in found.stdout


PACKAGED_AS = {
    "pinocchio": "pin", "mujoco_menagerie": "mujoco-menagerie", "cyipopt": "cyipopt-wheels"
}  # fmt: skip


def test_what_is_imported_is_declared():
    """What a dependency of ours needs today it may do without tomorrow."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    extras = project["optional-dependencies"].values()
    needed = [*project["dependencies"], *(one for extra in extras for one in extra)]
    declared = {re.match(r"[\w-]+", one)[0].replace("-", "_") for one in needed}
    imported = set()
    for path in ROOT.glob("gaitopt/**/*.py"):
        for node in ast.walk(ast.parse(path.read_text("utf-8"))):
            if isinstance(node, ast.Import):
                imported |= {alias.name.partition(".")[0] for alias in node.names}
            elif isinstance(node, ast.ImportFrom) and node.level == 0:
                imported.add(node.module.partition(".")[0])
    foreign = imported - set(sys.stdlib_module_names) - {"gaitopt"}
    packages = {PACKAGED_AS.get(name, name).replace("-", "_") for name in foreign}
    assert packages - declared == set()


@pytest.mark.parametrize("name", PACKAGES)
def test_public_names_exist(name):
    package = importlib.import_module(name)
    names = getattr(package, "__all__", [])
    assert [n for n in names if not hasattr(package, n)] == []


def test_public_names_are_the_ones_with_a_home():
    lazy = set(gaitopt.__all__) - {"__version__"}
    assert lazy == set(gaitopt._HOMES)
    assert set(dir(gaitopt)) == set(gaitopt.__all__)
    typed = re.search(r"if TYPE_CHECKING:(.*?)\n\n_HOMES", Path(gaitopt.__file__).read_text(), re.S)
    assert typed is not None
    assert {n for n in lazy if not re.search(rf"\b{n}\b", typed[1])} == set()


def test_unknown_name_is_an_attribute_error():
    with pytest.raises(AttributeError, match="no attribute 'desing'"):
        gaitopt.desing  # noqa: B018


def test_import_is_light():
    code = "import sys, gaitopt; print([m for m in ('numpy', 'pinocchio') if m in sys.modules])"
    assert run(sys.executable, "-c", code).stdout == "[]\n"


def test_version_has_one_place():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())
    assert project["project"]["dynamic"] == ["version"]
    assert project["tool"]["setuptools"]["dynamic"]["version"]["attr"] == (
        "gaitopt.version.__version__"
    )
    assert f"## [{gaitopt.__version__}]" in (ROOT / "CHANGELOG.md").read_text()


def test_lines_of_the_changelog_are_short():
    lines = (ROOT / "CHANGELOG.md").read_text().splitlines()
    assert not [line for line in lines if len(line) > 120]


def test_urdf_is_current():
    found = run(sys.executable, "scripts/generate_urdf", "--check")
    assert found.returncode == 0, found.stderr


def test_readme_example_runs(capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    blocks = re.findall(r"```python\n(.*?)```", (ROOT / "README.md").read_text(), re.S)
    assert len(blocks) == 1
    exec(compile(blocks[0], "README.md", "exec"), {})
    assert "certified" in capsys.readouterr().out
    assert (tmp_path / "walk.npz").exists()


def test_readme_links_exist():
    text = (ROOT / "README.md").read_text()
    targets = [t for t in re.findall(r"\]\(([^)#]+)\)", text) if "://" not in t]
    assert targets
    assert [t for t in targets if not (ROOT / t).exists()] == []


def test_docs_name_files_that_there_are():
    known = [f"/{path.relative_to(ROOT).as_posix()}" for path in ROOT.rglob("*.py")]
    of_readers = {"NAME.py", "ball_line.py", "calm.py", "hurdles.py", "mine.py", "steady_ankle.py"}
    named = {
        (page.name, path)
        for page in (ROOT / "docs").rglob("*.md")
        for path in re.findall(r"(?:\w+/)*\w+\.py\b", page.read_text("utf-8"))
        if path.split("/")[-1] not in of_readers
    }
    assert len(named) > 50
    assert [each for each in named if not any(path.endswith(f"/{each[1]}") for path in known)] == []


def test_how_it_works_names_what_there_is():
    text = (ROOT / "docs" / "how-it-works.md").read_text("utf-8")
    paths = set(re.findall(r"`([a-z_]+/[a-z_]+\.py|[a-z_]+\.py)`", text))
    assert len(paths) > 20
    assert [path for path in paths if not (ROOT / "gaitopt" / path).exists()] == []
    source = "".join(path.read_text("utf-8") for path in (ROOT / "gaitopt").rglob("*.py"))
    records = re.search(r"From the option to the row: (.*?)Eleven records", text, re.S)
    assert records is not None
    for name in set(re.findall(r"`(\w+)`", records[1])):
        assert re.search(rf"(class {name}\b|^{name} = )", source, re.M), name


def test_results_hold_no_place_of_a_machine():
    results = [*(ROOT / "benchmarks" / "results").glob("*.json"), *(ROOT / "docs").rglob("*.json")]
    assert results
    place = re.compile(r"(?<![\w.])/(?:tmp|home|root|work|Users|usr|opt)/")
    assert [p.name for p in results if place.search(p.read_text("utf-8"))] == []


def test_what_is_cited_is_this_version():
    lines = (ROOT / "CITATION.cff").read_text().splitlines()
    assert f"version: {gaitopt.__version__}" in lines
    assert "license: BSD-2-Clause" in lines


def test_picture_is_of_the_gait_that_the_command_finds(robot):
    record = json.loads((ROOT / "docs" / "images" / "walk.json").read_text())
    assert record["speed_m_per_s"] == pytest.approx(1.0)
    found = many_starts(robot, preset_task(speed=1.0), DesignOptions(solver=SQP()))
    assert record["cost_N2ms"] == pytest.approx(found.design.gait.cost, rel=1e-5)
    assert record["gaitopt"] == gaitopt.__version__
    assert (ROOT / "docs" / "images" / "walk.png").stat().st_size < 300_000


@pytest.mark.parametrize("name", ["scripts/walk", "scripts/test", ".ci/run"])
def test_scripts_are_sound(name):
    script = ROOT / name
    assert script.stat().st_mode & 0o111 == 0o111
    assert "set -euo pipefail" in script.read_text()
    assert run("bash", "-n", str(script)).returncode == 0


def test_the_help_of_every_option_is_a_sentence():
    settings = [one for section in SCHEMA.values() for one in section.values()]
    settings += [*SWEEP, *COMPARISON]
    own = [value for name, value in vars(command_options).items() if name.endswith("Options")]
    settings += [one for options in own for one in declared(options)]
    assert len(own) > 10
    for one in settings:
        assert len(one.help.split()) >= 4, (one.name, one.help)
        assert one.help.endswith("."), (one.name, one.help)
        # the help says a default by itself
        assert one.default in (None, ()) or "by default" not in one.help.lower(), one.name


def raised(node):
    """The errors of gaitopt that a function itself raises, not those of functions inside it."""
    found, left = set(), list(ast.iter_child_nodes(node))
    while left:
        one = left.pop()
        if isinstance(one, ast.FunctionDef | ast.Lambda):
            continue
        if isinstance(one, ast.Raise) and isinstance(one.exc, ast.Call):
            found.add(ast.unparse(one.exc.func))
        left += ast.iter_child_nodes(one)
    return {name for name in found if hasattr(errors, name)}


@functools.cache
def modules():
    """Every file of the package, parsed."""
    paths = sorted((ROOT / "gaitopt").rglob("*.py"))
    return {path: ast.parse(path.read_text("utf-8")) for path in paths}


def defined():
    """Public classes and functions of the package: file, class or None, node."""
    for path, module in modules().items():
        for node in module.body:
            if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
                yield path, None, node
                for inner in node.body:
                    if isinstance(inner, ast.FunctionDef):
                        yield path, node, inner
            elif isinstance(node, ast.FunctionDef):
                yield path, None, node


def test_every_error_is_in_a_docstring():
    missing = []
    for path, owner, node in defined():
        if not isinstance(node, ast.FunctionDef):
            continue
        made = node.name in ("__init__", "__post_init__")
        if node.name.startswith("_") and not made:
            continue
        text = (ast.get_docstring(node) or "") + (ast.get_docstring(owner) or "" if made else "")
        told = text.partition("Raises:")[2]
        missing += [f"{path.name}: {node.name}: {e}" for e in raised(node) if e not in told]
    assert missing == []


def test_every_field_is_in_a_docstring():
    """Of public dataclasses; a field that declares itself with its help is an option."""
    missing = []
    for path, _, node in defined():
        marks = [ast.unparse(mark) for mark in getattr(node, "decorator_list", ())]
        if not isinstance(node, ast.ClassDef) or not any("dataclass" in mark for mark in marks):
            continue
        # what a base class or a class beside it tells is not told again
        same = [n for n in modules()[path].body if isinstance(n, ast.ClassDef)]
        known = {node.name, *(ast.unparse(base) for base in node.bases)}
        text = "".join(ast.get_docstring(n) or "" for n in same if n.name in known)
        for one in node.body:
            if not isinstance(one, ast.AnnAssign) or "ClassVar" in ast.unparse(one.annotation):
                continue
            name = ast.unparse(one.target)
            declares = one.value is not None and re.match(
                r"(entry|margin|joint_weights_field)\(", ast.unparse(one.value)
            )
            if not (name.startswith("_") or declares or re.search(rf"\b{name}\b", text)):
                missing.append(f"{path.name}: {node.name}.{name}")
    assert missing == []


_SIZE = r"(?:\.\.\.|\w+(?: [-+*/·] \w+| \w)*)"
_SHAPE = rf"\({_SIZE},(?: {_SIZE}(?:, {_SIZE})*)?\)"


def array(node):
    return node is not None and re.search(r"\bArray\b", ast.unparse(node)) is not None


def bases(owner, classes):
    for base in owner.bases if owner is not None else ():
        known = classes.get(ast.unparse(base).split("[")[0])
        if known is not None:
            yield known
            yield from bases(known, classes)


def test_every_method_has_a_docstring():
    """Its own, or that of the method of a base class which it overrides."""
    every = (node for module in modules().values() for node in module.body)
    classes = {node.name: node for node in every if isinstance(node, ast.ClassDef)}
    missing, seen = [], 0
    for path, owner, node in defined():
        if owner is None or node.name.startswith("_"):
            continue
        every = [m for one in (owner, *bases(owner, classes)) for m in one.body]
        own = [m for m in every if getattr(m, "name", "") == node.name]
        seen += 1
        if not any(ast.get_docstring(one) for one in own):
            missing.append(f"{path.name}: {owner.name}.{node.name}")
    assert missing == []
    assert seen > 1000


def test_every_array_has_a_shape_in_a_docstring():
    """Or the name of what tells it: of a method also where it overrides, of its letters the class.

    A function that takes or returns arrays says at least one shape, as (N, 3) or (n,).
    """
    classes = {node.name: node for _, _, node in defined() if isinstance(node, ast.ClassDef)}
    missing, seen = [], 0
    for path, owner, node in defined():
        if not isinstance(node, ast.FunctionDef) or node.name.startswith("_"):
            continue
        given = [
            one.arg for one in (*node.args.args, *node.args.kwonlyargs) if array(one.annotation)
        ]
        if not given and not array(node.returns):
            continue
        seen += 1
        above = [*bases(owner, classes)]
        told = [
            node,
            *(m for one in above for m in one.body if getattr(m, "name", "") == node.name),
        ]
        text = " ".join(ast.get_docstring(one) or "" for one in told)
        letters = " ".join(
            ast.get_docstring(one) or "" for one in (owner, *above) if one is not None
        )
        named = all(re.search(rf"\b{name}\b[^.]*{_SHAPE}", letters) for name in given)
        if not (
            re.search(rf"{_SHAPE}|\bshape\b|`", text)
            or (given and named and not array(node.returns))
        ):
            missing.append(f"{path.name}: {node.name}")
    assert missing == []
    assert seen > 500


_PHYSICAL = re.compile(
    r"(^|_)(torque|speed|velocity|rates?|acceleration|forces?|wrench|mass|inertia|durations?|times?"
    r"|power|energy|stiffness|damping|friction|angles?|d?d?q|impulse|armature|moment|height|width"
    r"|gravity|momentum|twist|distance|clearance)$"
)
_UNIT = re.compile(
    r"\[(-|[^\]]*[^\]\d,. -][^\]]*)\]"  # as [N·m], or [-] of none
    r"|\b(dimensionless|relative|shares?|coefficient|scaled)\b"
    r"|\b([Ww]eights?|[Dd]erivatives?) (of|in|with)\b"  # follow from those of both
    r"|\b(as (of|in|for)|see|likewise)\b"  # told there
)


def physical(node):
    """Physical quantities of a class's fields or of a function's arguments."""
    if isinstance(node, ast.ClassDef):
        pairs = [
            (ast.unparse(one.target), one.annotation)
            for one in node.body
            if isinstance(one, ast.AnnAssign)
            and not re.match(r"(entry|margin)\(", ast.unparse(one.value) if one.value else "")
        ]
    else:
        pairs = [(one.arg, one.annotation) for one in (*node.args.args, *node.args.kwonlyargs)]
    for name, kind in pairs:
        numbers = kind is not None and re.search(r"\b(float|Array|ArrayLike)\b", ast.unparse(kind))
        if numbers and _PHYSICAL.search(name) and not name.startswith("_"):
            yield name


def told_of(name, text):
    """What a docstring says of one of its entries; all that it says where there are none."""
    entries = text.partition("Attributes:" if "Attributes:" in text else "Args:")[2]
    found = re.search(
        rf"^\s+(\w+, )*{name}(, \w+)*:.*?(?=^\s+\w+(, \w+)*:|\Z)", entries, re.S | re.M
    )
    return found[0] if found else text.partition("Args:")[0]


def test_every_physical_quantity_has_a_unit_in_a_docstring():
    """A field or an argument that is a number or an array, by its name; in the solvers none is."""
    missing, seen = [], 0
    for path, _, node in defined():
        named = any("dataclass" in ast.unparse(mark) for mark in node.decorator_list)
        named = named or isinstance(node, ast.FunctionDef)
        if node.name.startswith("_") or "solvers" in path.parts or not named:
            continue
        text = ast.get_docstring(node) or ""
        for name in physical(node):
            seen += 1
            of_all = text.partition("\n")[0].startswith("Derivatives")
            if not (of_all or _UNIT.search(told_of(name, text))):
                missing.append(f"{path.name}: {node.name}.{name}")
    assert missing == []
    assert seen > 300


def test_paths_are_asked_by_what_raises_nothing():
    """`Path.exists` and its like raise for names too long, loops of links, and closed folders."""
    asked = re.compile(r"\.(exists|is_file|is_dir|resolve)\(\)")
    files = (ROOT / "gaitopt").rglob("*.py")
    assert [path.name for path in files if asked.search(path.read_text("utf-8"))] == []


def test_no_two_test_files_share_a_name():
    names = [path.name for path in (ROOT / "tests").rglob("test_*.py")]
    assert [name for name in names if names.count(name) > 1] == []
