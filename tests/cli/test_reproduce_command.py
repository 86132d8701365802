"""`gaitopt reproduce` before it begins."""

from typer.testing import CliRunner

from gaitopt.cli.app import app


def test_a_directory_that_cannot_be_made_is_refused_before_any_work(tmp_path):
    (tmp_path / "file").write_text("")
    done = CliRunner().invoke(app, ["reproduce", "--output", str(tmp_path / "file" / "docs")])
    assert done.exit_code == 2
    assert "is a file" in done.stderr
