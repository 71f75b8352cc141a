"""What others called their bodies, keys and files steers no terminal, starts no line, and is no formula or markup."""

import csv
import io
import json
import re
from html.parser import HTMLParser
from pathlib import Path

import pyarrow.parquet as pq
import pytest
from cli_process import closecall_inside
from diff_logs import SCENE, run_scene, write_scene
from mcap.records import Channel, Message
from places import ROOT
from rewritten_logs import rewrite

from closecall.formats.log.container.checks import TYPES
from closecall.formats.log.tables.escapes import csv_text, html_text, json_text

CLI = ROOT / "cli"

# Clears the screen and sets its title; a C1 control; NUL; turns the writing; lines of their own; markup of rich.
EVIL = "\x1b[2J\x1b]0;owned\x07\x9b31m\x00\u202e\u2066\n\r\u2028\x85\t[red]:bomb:[/] <b>&"
EVIL_SEEN = r"\x1b[2J\x1b]0;owned\x07\x9b31m\x00\u202e\u2066\n\r\u2028\x85\t[red]:bomb:[/] <b>&"


def renamed(name: str):
    """Return a change of a log that calls the body `arm` otherwise, and the words that tell of it."""

    def change(channel: Channel, message: Message) -> list[Message]:
        decoded = TYPES[channel.topic].FromString(message.data)
        _rename(decoded, name)
        message.data = decoded.SerializeToString()
        return [message]

    return change


def _rename(message, name: str) -> None:
    for field, value in message.ListFields():
        if isinstance(value, str):
            setattr(message, field.name, re.sub(r"\barm\b", lambda _: name, value))
        elif field.message_type is not None:
            for one in value if hasattr(value, "extend") else [value]:
                _rename(one, name)


def in_json(name: str):
    return lambda _, values: {key: value.replace('"arm"', json.dumps(name)) for key, value in values.items()}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with two logs whose bodies have names that scenes may not have, and that differ."""
    folder = tmp_path_factory.mktemp("escapes")
    scene = write_scene(folder, SCENE.replace("margins: [", "margins: [{between: [arm, rail], margin: 1}, "))
    plain = run_scene(scene, folder / "plain.mcap", "--log", "full", "--rate", "5")
    (folder / "scene.yaml").write_text(scene.read_text().replace("230, 0, 0", "231, 0, 0"))
    other = run_scene(scene, folder / "other.mcap", "--log", "full", "--rate", "5")
    for log, target in ((plain, "evil.mcap"), (other, f"new{EVIL.replace('/', '')[:60]}.mcap".replace("\x00", ""))):
        rewrite(log, folder / target, renamed(EVIL), metadata=in_json(EVIL), attachments=False)
    rewrite(plain, folder / "sum.mcap", renamed("=1+cmd|' /C calc'!A0"), attachments=False)
    return folder


@pytest.fixture(autouse=True)
def wide(monkeypatch):
    """Keep each row in one line, whatever width another test has left."""
    monkeypatch.setenv("COLUMNS", "1000")


def said(folder: Path, *arguments: object, code: int = 0) -> str:
    """Run a command; return all that it says, of which every line prints."""
    done = closecall_inside(*arguments, cwd=folder)
    assert done.returncode == code, done.stderr
    for line in (done.stdout + done.stderr).split("\n"):
        assert line.isprintable(), line
    return done.stdout + done.stderr


def new_log(folder: Path) -> str:
    (name,) = (path.name for path in folder.glob("new*.mcap"))
    return name


def test_names_steer_no_terminal(folder):
    new = new_log(folder)
    assert EVIL_SEEN in said(folder, "summary", "evil.mcap")
    assert EVIL_SEEN in said(folder, "diff", "evil.mcap", new, code=1)
    assert EVIL_SEEN in said(folder, "diff", "evil.mcap", new, "--all", "--limit", "30", code=1)
    assert "matches no pairs" in said(
        folder, "diff", new, new, "--ignore", EVIL.replace("\x00", "") + "|nobody", code=2
    )
    assert "MB" in said(folder, "report", new, "-o", f"{new}.html")
    assert "rows" in said(folder, "export", new, "-o", new + "tables")
    assert "messages" in said(folder, "extract", new, "--to", "1", "-o", "part" + new)
    assert "unfinished" in said(folder, "summary", cut(folder, new), code=3)


def cut(folder: Path, name: str) -> str:
    (folder / f"cut{name}").write_bytes((folder / name).read_bytes()[:-20])
    return f"cut{name}"


def test_names_in_json_come_back_as_they_are_and_print(folder):
    new = new_log(folder)
    summary = json.loads(said(folder, "summary", "evil.mcap", "--json"))
    assert EVIL in {pair["body_a"] for pair in summary["pairs"]}
    difference = json.loads(said(folder, "diff", "evil.mcap", new, "--json", code=1))
    assert difference["new"] == new
    assert f"{EVIL}|wall" in {one["subject"] for one in difference["differences"]}
    lines = said(folder, "export", "evil.mcap", "--topic", "/spans", "--format", "ndjson").splitlines()
    assert EVIL in {json.loads(line)["body_a"] for line in lines}


def test_names_in_words_of_a_command_line_and_in_errors_print(folder):
    evil = EVIL.replace("\x00", "").replace("/", "")[:40]
    for arguments in (
        ["summary", evil],
        ["summary", "evil.mcap", "--verdict", evil],
        ["summary", "evil.mcap", f"--{evil}"],
        ["check", evil],
        ["run", evil, "-o", "x.mcap"],
        ["run", "scene.yaml", "-o", f"{evil}/x.mcap"],
        ["extract", "evil.mcap", evil],
        ["export", "evil.mcap", "--topic", evil],
    ):
        done = closecall_inside(*arguments, cwd=folder)
        assert done.returncode == 2
        shown = done.stderr.split("\n")
        assert all(line.isprintable() for line in shown), arguments
        assert len([line for line in shown if line and not line.startswith(("Usage:", "Try "))]) <= 2


def test_a_name_that_the_terminal_cannot_write_is_told_by_number(folder):
    undecodable = "\udcff\udcfe.mcap"
    assert r"\udcff\udcfe.mcap: does not exist" in said(folder, "summary", undecodable, code=2)
    assert json_text({"name": undecodable}) == r'{"name": "\udcff\udcfe.mcap"}'
    assert json.loads(json_text("\U000e0041 😀 é")) == "\U000e0041 😀 é"


def test_no_cell_of_text_is_a_formula_and_numbers_are_untouched(folder):
    text = said(folder, "export", "sum.mcap", "--topic", "/distances")
    rows = list(csv.DictReader(io.StringIO(text)))
    assert rows[0]["body_a"] == "'=1+cmd|' /C calc'!A0"
    assert any(row["witness_a_x"].startswith("-") for row in rows)
    lines = said(folder, "export", "evil.mcap", "--topic", "/spans").splitlines()
    assert len(lines) == 1 + sum(1 for _ in csv.DictReader(lines))
    assert closecall_inside("export", "sum.mcap", "--format", "parquet", "-o", "t", cwd=folder).returncode == 0
    names = pq.read_table(folder / "t" / "distances.parquet")["body_a"].to_pylist()
    assert [f"'{name}" if name.startswith("=") else name for name in names] == [row["body_a"] for row in rows]


@pytest.mark.parametrize("text", ["=1", "+1", "-1", "@A1", "'=1", "  =1", "＝1", "＠x", "'", "-"])
def test_one_apostrophe_in_front_of_what_is_like_a_formula_comes_off_again(text):
    assert csv_text(text) == f"'{text}"


@pytest.mark.parametrize("text", ["", "a=1", "1+1", "arm|wall", "größe", "(=1)"])
def test_other_texts_stay(text):
    assert csv_text(text) == text


def test_tabs_and_returns_in_front_of_a_formula_are_escaped():
    assert csv_text("\t=1") == r"\t=1"
    assert csv_text("\r=1") == r"\r=1"


class _Page(HTMLParser):
    def __init__(self) -> None:
        super().__init__()
        self.tags: set[str] = set()
        self.text = ""

    def handle_starttag(self, tag, attrs):
        self.tags.add(tag)

    def handle_data(self, data):
        self.text += data


def test_a_page_has_no_name_that_is_markup_or_turns_the_writing(folder):
    assert closecall_inside("report", "evil.mcap", "-o", "page.html", cwd=folder).returncode == 0
    text = (folder / "page.html").read_text()
    page = _Page()
    page.feed(text)
    assert "b" not in page.tags
    assert EVIL_SEEN in page.text
    assert not [c for c in text if not c.isprintable() and c not in "\n\t" and c in EVIL]
    assert html_text("<\u202e>") == r"&lt;\u202e&gt;"


def test_text_leaves_for_the_terminal_by_one_door():
    doors = re.compile(r"click\.s?echo|[^\w.]print\(|[^\w.]Text\(|std(out|err)\.write|\.show\(\)")
    for path in CLI.glob("*.py"):
        if path.name not in ("terminal.py", "schema.py", "completion.py"):  # the latter two print closecall's own texts
            assert not doors.search(path.read_text()), path
