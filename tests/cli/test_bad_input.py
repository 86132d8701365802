"""What a user can get wrong: one clear message, exit code 2, nothing written, no traceback."""

import re

import numpy as np
import pytest

FILES = {
    "broken.toml": "x = [",
    "binary.toml": b"\xff\xfe\x00",
    "typo.toml": "[task]\nsped = 1.0\n",
    "section.toml": "[tsk]\nspeed = 1.0\n",
    "kind.toml": '[task]\nspeed = "fast"\n',
    "flag.toml": "[task]\nsamples = true\n",
    "plugless.toml": "[plugin]\nfile = 'a.py'\n",
    "bare.toml": "speed = 1.0\n",
    "quantity.toml": '[geometry]\nfree = ["durtion"]\n',
    "negative.toml": "[links.shin]\nmass = -1\n",
    "inertia.toml": "[links.shin]\ninertia = [[1, 0, 0], [0, 1, 0], [0, 0, 5]]\n",
    "range.toml": "[joints.knee]\nlower = 1.0\nupper = 0.5\n",
    "broken.urdf": "<robot",
    "unknown.toml": 'feets = ["a", "b"]',
    "legless.urdf": '<robot name="a"><link name="b"/></robot>',
    "file": "a regular file",
}

CASES = [
    (["--bogus"], "No such option"),
    (["legs.URDF"], r"extra .*\(legs.URDF\); did you mean --urdf legs.URDF\?"),
    (["legs.xml"], r"did you mean --urdf legs.xml\?"),
    (["task.toml"], r"did you mean --config task.toml\?"),
    (["gait.npz"], r"did you mean --start gait.npz\?"),
    (["g1"], r"did you mean --robot g1\?"),
    (["1.0"], r"extra .*\(1.0\)[^;]*$"),
    (["--boundary", "none"], "boundary 'none' is unknown"),
    (["--speed", "nan"], "speed is nan m/s"),
    (["--phase-times", "best"], "it acts only with --heel-strike or --double-support"),
    (["--speed", "inf"], "speed is inf m/s"),
    (["--speed", "quick"], "--speed"),
    (["--duration", "0"], "duration is 0.0 s"),
    (["--samples", "30"], "odd number of samples, not 30"),
    (["--samples", "1"], "1 samples are too few"),
    (["--postures", "0"], "postures is 0"),
    (["--friction", "0"], "friction is 0.0; it must be between 0.001 and 100"),
    (["--friction", "1e-9"], "friction is 1e-09; it must be between 0.001"),
    (["--friction", "1e18"], "friction is 1e.18; it must be between 0.001 and 100"),
    (["--speed-as", "penalty", "--penalty-weight", "1e18"], "1e.18 cost/m²; it must be at most"),
    (
        ["--preset", "standart"],
        "'standart' is unknown; did you mean 'standard'. choose one of standard, paper",
    ),
    (["--solver", "sqpp"], "no solver 'sqpp'; .*choose one of .*sqp"),
    (["--qp-solver", "cvx"], "qp_solver is 'cvx'; choose one of"),
    (["--differences", "some"], "'some' is unknown; choose none, constraints, all"),
    (["--tolerance", "-1"], "tolerance is -1.0"),
    (["--max-iterations", "0"], "max_iterations is 0"),
    (["--seed", "-1"], "seed is -1; it must not be negative"),
    (["--sigma", "-1"], "sigma is -1.0 rad; it must be from 0 to 3.1416 rad"),
    (["--sigma", "1e9"], "sigma is 1000000000.0 rad; it must be from 0 to 3.1416 rad"),
    (
        ["--trunk-pitch", "5"],
        "trunk_pitch is 5.0 rad; .* at most 1.5708 rad; for degrees .*6deg",
    ),
    (["--trunk-roll", "200deg"], "trunk_roll is 3.49.* rad; it must be at most 1.5708"),
    (["--trunk-yaw", "3"], "trunk_yaw is 3.0 rad; it must be at most 1.5708"),
    (["--swing-tilt", "5"], "swing_tilt is 5.0 rad; it must be at most 1; for degrees .*6deg"),
    (["--gravity", "1e9"], "gravity is 1e.09 m/s²; .* more than 1000 m/s² is nowhere"),
    (["--armature", "*=1e9"], "armature is 1e.09 kg·m²; it must be from 0 to 1000 kg·m²"),
    (["--gravity", "0"], "gravity is 0 m/s²; a walk needs at least 0.01 m/s²"),
    (["--free", "bogus"], "no geometric quantity 'bogus'"),
    (["--fix", "pelvis_roll"], "--fix pelvis_roll: give a name and a number"),
    (["--fix", "pelvis_rol=3deg"], "no geometric quantity 'pelvis_rol'; .*there are pelvis_height"),
    (["--set", "shinn=24cm"], "unknown entry shinn; did you mean 'shin'?"),
    (["--set", "shin=24kg"], "--set shin=24kg: give a number in m, if you like with its unit: m"),
    (["--fix", "pelvis_roll=nan"], "cannot be fixed at nan"),
    (["--fix", "duration=1"], "by --duration"),
    (["--fix", "step_length=0.4"], "step_length is fixed"),
    (["--config", "absent.toml"], "cannot read the configuration .*no such file"),
    (["--config", "broken.toml"], "not TOML"),
    (["--config", "binary.toml"], "not UTF-8 text"),
    (["--config", "typo.toml"], "unknown entry in .task. 'sped'; did you mean 'speed'"),
    (["--config", "section.toml"], "unknown section 'tsk'; did you mean 'task'"),
    (["--config", "kind.toml"], "task.speed = 'fast' is wrong; give a number"),
    (["--config", "flag.toml"], "task.samples = 'True' is wrong; give a whole number"),
    (["--config", "plugless.toml"], "unknown entry in .plugin. 'file'; there are plugin"),
    (["--config", "bare.toml"], "unknown section 'speed'"),
    (["--config", "quantity.toml"], "no geometric quantity 'durtion'"),
    (["--spec", "absent.toml"], "cannot read .*absent.toml"),
    (["--spec", "broken.toml"], "not TOML"),
    (["--spec", "negative.toml"], "links.shin.mass = -1 kg"),
    (["--spec", "inertia.toml"], "links.shin.inertia cannot belong to a body"),
    (["--spec", "range.toml"], "joints.knee.lower = 1 rad is not below"),
    (["--urdf", "absent.urdf"], "cannot read the URDF .*no such file"),
    (["--urdf", "broken.urdf"], "the file is not well-formed XML: line 1"),
    (["--urdf", "legless.urdf"], "no two legs were found"),
    (["--urdf", "legless.urdf", "--spec", "negative.toml"], "exclude each other"),
    (["--robot", "tallos"], "no robot 'tallos'; did you mean 'talos'"),
    (["--robot", "biped13", "--urdf", "legless.urdf"], "--robot and --urdf exclude each other"),
    (["--choices", "absent.toml"], "absent.toml"),
    (["--choices", "unknown.toml"], "unknown entry feets; did you mean 'feet'"),
    (["--sole", "0.1,0.1"], "not four numbers; give its edges in metres"),
    (["--forward", "north"], "forward is 'north'; it must be one of"),
    (["--posture", "sitting"], "no SRDF is given"),
    (["--stance-sole", "toes"], "no frame named 'toes'"),
    (["--start", "absent.npz"], "cannot read the gait file"),
    (["--output", "file/walk"], "cannot write to .*is a file"),
    (["--output", ""], "the name is empty; give a directory, as '.' for this one"),
    (["--duration", "1e-9"], "duration is 1e-09 s; it must be 0.05 s or more"),
    (["--package-dir", "absent"], "--package-dir absent: there is no such directory"),
    (["--cost", "torqe"], "no cost 'torqe'; did you mean 'torque'?"),
    (["--cost", "torque + 2 wrk"], "no cost 'wrk'; did you mean 'work'?"),
    (["--weights", "left_kne_=2"], "'left_kne_', .* did you mean 'left_knee'?"),
    (["--limit", "lft_knee.torque=9"], "matches 'lft_knee'; did you mean 'left_knee'?"),
    (["--armature", "lft_knee=0.1"], "matches 'lft_knee'; did you mean 'left_knee'?"),
    (["--without", "fricton"], "'fricton'; did you mean 'friction'?"),
    (["--move", "wiast"], "'wiast'; did you mean 'waist'?"),
    (["--solver", "sqp+newto"], "did you mean 'sqp.newton'?"),
    (["--free", "pelvis_rol"], "did you mean 'pelvis_roll'?"),
    (["--preset", "humnoid"], "did you mean 'humanoid'?"),
]


@pytest.fixture
def workplace(tmp_path, monkeypatch):
    for name, content in FILES.items():
        (tmp_path / name).write_bytes(content if isinstance(content, bytes) else content.encode())
    monkeypatch.chdir(tmp_path)
    return tmp_path


def refused(result, pattern):
    """One message that matches, exit code 2, nothing on stdout."""
    message = " ".join(result.stderr.replace("│", " ").split())
    assert result.exit_code == 2, message
    assert result.stdout == ""
    assert re.search(pattern, message), message


@pytest.mark.parametrize(("words", "pattern"), CASES, ids=[" ".join(c[0]) for c in CASES])
def test_optimise_refuses(quick, workplace, words, pattern):
    refused(quick("--output", "out", *words), pattern)
    assert {path.name for path in workplace.iterdir()} == set(FILES)


@pytest.mark.parametrize(
    ("words", "pattern"),
    [
        (["urdf", "--spec", "negative.toml", "-o", "out.urdf"], "links.shin.mass = -1 kg"),
        (["urdf", "-o", "file/out.urdf"], "cannot write"),
        (["urdf", "--write-spec", "file/out.toml"], "cannot write"),
        (["urdf", "--write-spec", "mine.toml", "-o", "no/a.urdf"], "there is no directory '.*no'"),
        (["inspect", "--html", "file/out.html"], "--html file/out.html: cannot write it"),
        (["inspect", "--write-choices", "no/c.toml"], "there is no directory '.*no'"),
        (
            ["requirements", "gait.npz", "--output", "a.csv", "--figure", "./a.csv"],
            "--figure a.csv: --output is to write the same file; give two file names",
        ),
        (["inspect", "--html", "typo.toml"], "'typo.toml' is wrong; .* ends in .html or .htm"),
        (["inspect", "--write-choices", "legless.urdf"], "is wrong; .* ends in .toml"),
        (["urdf", "--output", "typo.toml"], "is wrong; .* ends in .urdf or .xml"),
        (["reproduce", "--output", ""], "the name is empty; give a directory"),
        (["sweep", "--output", ""], "the name is empty; give a directory"),
        (["check", "absent.npz"], "there is no such file"),
        (["check", "file"], "truncated, or not a gait file"),
        (["walk"], "No such command 'walk'"),
        (["sweep", "--grid", "trunk_pich=0:1:1", "-o", "out"], "did you mean 'trunk_pitch'?"),
        (["sweep", "--grid", "shinn=1,2", "-o", "out"], "did you mean 'shin'?"),
        (
            ["codesign", "--vary", "shinn=1:2", "--speeds", "1", "-o", "out"],
            "--vary shinn=1:2: did you mean 'shin'?",
        ),
    ],
)
def test_other_commands_refuse(cli, workplace, words, pattern):
    refused(cli(*words), pattern)
    assert {path.name for path in workplace.iterdir()} == set(FILES)


@pytest.mark.parametrize(
    ("words", "pattern"),
    [
        (["play", "--html", "file/out.html"], "cannot write"),
        (["play", "--html", "out.html", "--steps", "0"], "0 steps cannot be shown"),
        (["plot", "--format", "bmp"], "choose png, svg, pdf"),
        (["plot", "--output", "file"], "cannot make the directory"),
        (["export", "--output", "out.doc"], "suffix must be one of"),
        (["export"], "Missing option '--output'"),
    ],
)
def test_commands_that_take_a_gait_refuse(cli, workplace, designed, words, pattern):
    refused(cli(words[0], designed / "gait.npz", *words[1:]), pattern)
    assert {path.name for path in workplace.iterdir()} == set(FILES)


@pytest.mark.parametrize("command", ["check", "library", "requirements"])
def test_the_gait_of_a_directory_is_pointed_to(cli, designed, command):
    refused(cli(command, designed), r"; there is the gait '.*gait\.npz'; give")


@pytest.mark.parametrize("command", ["check", "play", "plot"])
def test_truncated_and_foreign_gaits_are_refused(cli, gait_file, command):
    gait_file.write_bytes(gait_file.read_bytes()[:3000])
    refused(cli(command, gait_file), "truncated")
    with gait_file.open("wb") as stream:
        np.savez(stream, a=np.arange(3))
    refused(cli(command, gait_file), "'meta' is missing")
