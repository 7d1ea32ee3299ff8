"""What is read is never overwritten, and no log counts twice."""

from pathlib import Path

import pytest
from typer import Context
from typer.main import get_command

from rcc_sim.cli.app import app
from rcc_sim.cli.keep import WRITES, keep
from rcc_sim.cli.logs import once
from rcc_sim.cli.output import emit, not_foreign
from rcc_sim.errors import InputError


def test_a_file_that_is_read_is_not_written(tmp_path):
    log, link = tmp_path / "log.csv", tmp_path / "link.csv"
    log.write_text("time_s\n0\n")
    link.symlink_to(log)
    for path in (log, link, tmp_path / "." / "log.csv"):
        with pytest.raises(InputError, match=r"--output: .*: is read here"):
            keep([str(log)], {"--html": None, "--output": path})
    keep([str(log), "rcc", "-"], {"--output": tmp_path / "new.csv"})


def given(command, name=""):
    """Yield each command, one option that it writes to and one value that it reads."""
    for under in getattr(command, "commands", {}).values():
        yield from given(under, f"{name} {under.name}")
    options = {o: p.name for p in command.params for o in p.opts if o in WRITES}
    for option, written in options.items():
        for param in command.params:
            if param.name not in options.values() and not getattr(
                param, "is_flag", False
            ):
                yield pytest.param(
                    command, written, param.name, id=f"{name} {param.name} {option}"
                )


def every_command():
    root = get_command(app)
    for name in root.list_commands(Context(root)):
        yield from given(root.get_command(Context(root), name), name)


@pytest.mark.parametrize(("command", "written", "read"), list(every_command()))
def test_no_command_writes_over_what_it_reads(tmp_path, command, written, read):
    file = tmp_path / "given.csv"
    file.write_text("time_s\n0\n")
    values = {param.name: None for param in command.params}
    for value in (str(file), [str(file)], f"effect.column={file}"):
        with pytest.raises(InputError, match="is read here, and would be lost"):
            command.callback(**(values | {read: value, written: file}))
    assert file.read_text() == "time_s\n0\n"


def test_a_log_that_is_given_twice_is_refused(tmp_path):
    one, two = str(tmp_path / "a.csv"), str(tmp_path / "b.csv")
    once([one, two, "-", "-"])
    with pytest.raises(InputError, match="given twice"):
        once([one, two, str(tmp_path / "x" / ".." / "a.csv")])


def test_two_results_in_one_file_are_refused(tmp_path):
    twice = {"--profiles": tmp_path / "a.csv", "--output": tmp_path / "." / "a.csv"}
    with pytest.raises(
        InputError, match=r"--output: .*a\.csv: --profiles writes there"
    ):
        keep([], twice)
    keep([], {"--profiles": tmp_path / "a.csv", "--output": tmp_path / "b.csv"})
    keep([], {"--plot": Path("/dev/null"), "--output": Path("/dev/null")})


def test_what_cannot_be_written_is_refused_before_the_work(tmp_path):
    with pytest.raises(InputError, match=r"--html: .*: is a folder"):
        keep([], {"--html": tmp_path})
    with pytest.raises(InputError, match=r"--output: .*: there is no folder .*none"):
        keep([], {"--output": tmp_path / "none" / "a.csv"})
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match=r"--html: .*: .*file is a file, not a folder"):
        keep([], {"--html": tmp_path / "file" / "a.html"})
    keep([], {"--output": tmp_path / "a.csv"})
    assert [p.name for p in tmp_path.iterdir()] == ["file"]


@pytest.mark.skipif(not Path("/proc/self").is_dir(), reason="no /proc here")
def test_a_folder_in_which_even_root_makes_no_file_is_refused():
    with pytest.raises(InputError, match=r"--html: .*: the folder /proc cannot"):
        keep([], {"--html": Path("/proc/a.html")})


@pytest.mark.parametrize(
    ("option", "bad", "good"),
    [
        ("--html", "-", "a.html"),
        ("--html", "a.pdf", "a.htm"),
        ("--write-vehicle", "m.txt", "m.toml"),
        ("--next-run", "n.txt", "n.mcap"),
        ("--profiles", "p", "p.csv"),
    ],
)
def test_what_is_written_ends_as_it_should(tmp_path, option, bad, good):
    with pytest.raises(InputError, match=rf"{option}: .*{bad}: should end in \."):
        keep([], {option: tmp_path / bad})
    keep([], {option: tmp_path / good})


def test_a_name_that_promises_another_format_is_refused(tmp_path):
    with pytest.raises(InputError, match=r"found\.xlsx: \.xlsx is not written") as told:
        not_foreign(tmp_path / "found.xlsx")
    assert str(tmp_path / "found.csv") in told.value.hint
    for name in ("found.csv", "found", "found.v2", "run.mcap", "found.parquet"):
        assert not_foreign(tmp_path / name) == tmp_path / name


def test_two_formats_at_once_are_refused():
    with pytest.raises(InputError, match="--json and --csv: one of them"):
        emit({"a": 1}, [{"a": 1}], json=True, csv=True)


def test_a_name_that_ends_in_json_is_json(tmp_path):
    emit({"a": 1}, [{"a": 1}], output=tmp_path / "found.json")
    assert (tmp_path / "found.json").read_text() == '{\n "a": 1\n}\n'
    emit({"a": 1}, [{"a": 1}], output=tmp_path / "found.txt")
    assert (tmp_path / "found.txt").read_text() == "a\n1\n"
    emit({"a": 1}, [{"a": 1}], csv=True, output=tmp_path / "found.json")
    assert (tmp_path / "found.json").read_text() == "a\n1\n"
