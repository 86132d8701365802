"""Every error gaitopt raises on purpose.

A message says what was wrong, the value with its unit, what is allowed, and what to do next.
"""

import re
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from traceback import walk_tb

PLUGIN = "gaitopt_plugin_"
"""How the name of the module of a plugin begins."""

_OTHER_SIDE = {"left": "right", "right": "left", "l": "r", "r": "l"}


def did_you_mean(name: object, known: Iterable[str]) -> str:
    """Return the question whether the nearest of known names was meant; empty where none is near.

    The same name of the other side is near, but nobody means the right foot who says the left.

    Args:
        name: that is not known.
        known: names that are; that one may be among them, where it is known but means nothing.
    """
    from difflib import get_close_matches  # which no command needs that is given rightly

    text = str(name).lower()
    sides = r"left|right|(?<![a-z])[lr](?![a-z])"
    mirrored = re.sub(sides, lambda side: _OTHER_SIDE[side[0]], text)
    other = mirrored if mirrored != text else None
    names = [one for one in known if one != name and one.lower() != other]
    close = get_close_matches(str(name), names, n=1)
    return f"did you mean '{close[0]}'? " if close else ""


def there_are(known: Iterable[str], name: object) -> str:
    """Return which names there are, after the question whether the nearest of them was meant."""
    names = list(known)
    return f"{did_you_mean(name, names)}there are {', '.join(names)}"


def reason_of(error: Exception) -> str:
    """Return why a file cannot be read or written, as the system says it: "permission denied"."""
    return (getattr(error, "strerror", None) or str(error) or "unknown reason").lower()


class GaitoptError(Exception):
    """Base of all gaitopt errors.

    Attributes:
        exit_code: what the command line returns when this error reaches it.
    """

    exit_code = 2


class InputError(GaitoptError):
    """A value, option or file given by the user cannot be used."""


class IdleOptionError(InputError):
    """An option has no effect where it is given."""

    def __init__(self, given: str, when: str) -> None:
        """Say so.

        Args:
            given: the option, its value and unit.
            when: it acts, as "with --output DIR".
        """
        super().__init__(
            f"{given} has no effect here: it acts only {when}; ask for that, or leave "
            f"{given.split()[0]} out"
        )


class OptionError(InputError, TypeError):
    """A dataclass of options was given a name it does not have, or a value of another kind."""


class SpecError(InputError):
    """A biped parameter table is not physical or not complete."""


class RobotError(InputError):
    """A URDF cannot be read, or is not a biped with two mirrored legs."""


class RobotFaultsError(RobotError):
    """Several faults keep a robot from being used.

    Attributes:
        faults: a sentence for each.
    """

    def __init__(self, message: str, faults: tuple[str, ...]) -> None:
        super().__init__(message)
        self.faults = faults


class GaitFileError(InputError):
    """A gait file is missing, truncated, or was not written by gaitopt."""


class MissingExtraError(InputError):
    """A feature needs an optional package that is not installed."""

    def __init__(self, feature: str, extra: str) -> None:
        super().__init__(
            f"{feature} needs an optional package; run: pip install 'gaitopt[{extra}]' (in a "
            f"clone of gaitopt: pip install '.[{extra}]')"
        )


def missing_package(error: Exception) -> str:
    """Return what to do about a package that is not installed though gaitopt needs it.

    Empty where an error is of another kind. That of an optional one is a `MissingExtraError`.
    """
    name = (error.name or "").partition(".")[0] if isinstance(error, ModuleNotFoundError) else ""
    if name in ("", "gaitopt"):
        return ""
    return (
        f"the package {name} is not installed, which gaitopt needs; run: pip install gaitopt (in a "
        "clone of gaitopt: pip install .), which installs what is missing"
    )


class EvaluationError(GaitoptError):
    """The problem has no value at a trial point (the solvers then try a shorter step)."""


class UnreachableError(EvaluationError):
    """A leg cannot reach the posture asked of it.

    Attributes:
        diagnosis: a `Diagnosis` of the walk asked for, if one was made, else None.
    """

    exit_code = 3

    def __init__(self, message: str, diagnosis: object = None) -> None:
        super().__init__(message)
        self.diagnosis = diagnosis


class NoGaitFoundError(GaitoptError):
    """No feasible gait was found for the task.

    Attributes:
        solution: the `Solution` the solver gave up with, if any, else None.
        diagnosis: a `Diagnosis` of why, if one was made, else None.
    """

    exit_code = 3

    def __init__(self, message: str, solution: object = None, diagnosis: object = None) -> None:
        super().__init__(message)
        self.solution, self.diagnosis = solution, diagnosis


class StoppedError(NoGaitFoundError):
    """A search was stopped, as its `stop` asked for, before there was a walk."""

    exit_code = 130

    def __init__(self, solution: object = None) -> None:
        super().__init__("interrupted before there was a result", solution)


def failure(error: BaseException, module: str = "") -> str:
    """Return an exception in words, with the line of `own_line`, if any."""
    told = f"{type(error).__name__}: {error}".removesuffix(": ")
    line = own_line(error, module)
    return f"{told} ({line})" if line else told


def own_line(error: BaseException, module: str = "") -> str:
    """Return the last line of a plugin that an exception passed, "line 3 of mine.py", or nothing.

    Args:
        module: not of gaitopt, whose lines are told too.
    """
    for frame, line in reversed([*walk_tb(error.__traceback__)]):
        name = str(frame.f_globals.get("__name__"))
        if name.startswith(PLUGIN) or (name == module and not name.startswith("gaitopt.")):
            return f"line {line} of {Path(frame.f_code.co_filename).name}"
    return ""


@contextmanager
def own_code(of: object, what: str) -> Iterator[None]:
    """Tell what the code of a constraint, a cost or a terrain of one's own raises in our words.

    Args:
        of: the constraint, the cost, the terrain, or a function of one.
        what: it is and cannot do, as "the cost 'calm' cannot make its integrand".

    Raises:
        InputError: the code raises an exception; ours are left as they are.
    """
    try:
        yield
    except GaitoptError:
        raise
    except (Exception, SystemExit) as error:
        raise InputError(f"{what}: {failure(error, type(of).__module__)}") from error


@contextmanager
def plugins_told() -> Iterator[None]:
    """Tell what a plugin raises with its line, which does not reach another process.

    Raises:
        InputError: a plugin raises an exception, or exits.
    """
    try:
        yield
    except GaitoptError:
        raise
    except (Exception, SystemExit) as error:
        if not own_line(error):
            raise
        raise InputError(f"{failure(error)}; correct it") from error
