"""The one reader of TOML."""

from pathlib import Path

import pytest

import gaitopt
from gaitopt.errors import InputError, RobotError, SpecError
from gaitopt.importers.text_files import parse_toml
from gaitopt.model.import_options import choices_from_toml

PACKAGE = Path(gaitopt.__file__).parent


@pytest.mark.parametrize("text", ["a.b = 2.5", b"a.b = 2.5", b"\xef\xbb\xbf[a]\r\nb = 2.5\r\n"])
def test_texts_and_bytes_are_read_alike(text):
    assert parse_toml(text, "here") == {"a": {"b": 2.5}}


@pytest.mark.parametrize("text", ["a = [", "a = 1\na = 2", b"a = '\xe9'", "a = " + "[" * 5000])
@pytest.mark.parametrize("kind", [InputError, RobotError, SpecError])
def test_damage_is_told_in_one_line_by_the_error_asked_for(text, kind):
    with pytest.raises(kind, match=r"^walk\.toml: not TOML: .+; begin again$") as caught:
        parse_toml(text, "walk.toml", "begin again", kind)
    assert type(caught.value) is kind
    assert len(str(caught.value)) < 300
    assert "codec" not in str(caught.value)


def test_only_the_word_is_infinite():
    assert parse_toml("a = inf\nb = -inf\nc = 1e300", "here")["b"] == float("-inf")
    with pytest.raises(RobotError, match="the number 1e400 is too large"):
        choices_from_toml('[[limits]]\njoints = "*knee*"\ntorque = 1e400\n')


def test_nothing_else_reads_toml():
    files = [p for p in PACKAGE.rglob("*.py") if "tomllib" in p.read_text("utf-8")]
    assert files == [PACKAGE / "importers" / "text_files.py"]
