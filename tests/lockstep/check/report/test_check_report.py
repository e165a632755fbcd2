"""The report as JSON, JUnit XML and HTML, and the exit codes of the command."""

import json
import math
import os
import pty
import re
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path
from xml.etree import ElementTree

import pytest

from lockstep import InputError
from lockstep.__main__ import main
from lockstep.check.report.check_report import CheckReport, as_json, as_junit, fails, from_json, write_text
from lockstep.check.report.finding import Finding
from lockstep.check.report.report_html import as_html
from lockstep.check.report.report_text import plain_lines

from ..conftest import BINARY, XML, Make

STATIC = ("--static",)


def finding(check: str, status: str, **more: object) -> Finding:
    return Finding(check=check, group=check.partition(".")[0], title=f"title of {check}", status=status, **more)  # type: ignore[arg-type]


FINDINGS = (
    finding("static.a", "pass", message="fine"),
    finding("static.b", "info", numbers={"size_bytes": 12.0, "odd": math.nan}),
    finding("dynamic.c", "warning", message="<b>&\x00\x1b[31m", details=("one", "zwei ä")),
    finding("dynamic.d", "error", message="does not repeat"),
    finding("contract.e", "skipped", message="no contract"),
)
REPORT = CheckReport(
    file='a&b"<.fmu',
    sha256="00ff",
    model="Model",
    guid="{1}",
    tool="by hand",
    checked="2026-01-02T03:04:05+00:00",
    host="linux64",
    seconds=1.5,
    findings=FINDINGS,
)
GOOD = replace(REPORT, file="good.fmu", findings=FINDINGS[:2])


def test_json_reads_back() -> None:
    text = as_json([REPORT, GOOD])
    again = from_json(text)

    assert again[1].findings[0] == FINDINGS[0]
    assert math.isnan(again[0].findings[1].numbers["odd"])
    assert as_json(again) == text
    assert json.loads(text)["fmus"][0]["worst"] == "error"
    assert json.loads(text)["fmus"][0]["counts"] == {"pass": 1, "info": 1, "warning": 1, "error": 1, "skipped": 1}


def test_json_of_another_format_is_refused() -> None:
    with pytest.raises(ValueError, match="format 99"):
        from_json('{"format": 99}')


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[]", r"report: \[\] must be a table"),
        ("[" * 100_000, "report: is nested too deeply"),
        ('{"format": 1}', "report: fmus is missing"),
        ('{"format": 1, "fmus": [{}]}', r"report: fmus\[1\]\.file is missing"),
        ("{", "report: is no JSON file"),
    ],
)
def test_json_of_another_shape_is_refused(text: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        from_json(text)


@pytest.mark.parametrize(("strict", "failed"), [(False, ["dynamic.d"]), (True, ["dynamic.c", "dynamic.d"])])
def test_junit_parses_and_counts(strict: bool, failed: list[str]) -> None:
    root = ElementTree.fromstring(as_junit([REPORT, GOOD], strict))
    suite = root[0]

    assert [s.get("name") for s in root] == ['a&b"<.fmu', "good.fmu"]
    assert suite.get("tests") == str(len(suite)) == "5"
    assert [case.get("classname") for case in suite if case.find("failure") is not None] == failed
    assert suite.get("failures") == str(len(failed))
    assert [case.get("classname") for case in suite if case.find("skipped") is not None] == ["contract.e"]
    assert suite.get("skipped") == "1"
    assert "zwei ä" in str(ElementTree.tostring(suite[2], encoding="unicode"))


class Page(HTMLParser):
    """Note what a page loads or links to, and its text."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.links: list[str] = []
        self.tags: list[str] = []
        self.text = ""
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        self.links += [value or "" for name, value in attrs if name in ("src", "href", "srcset", "action", "data")]

    def handle_data(self, data: str) -> None:
        self.text += data


def test_html_loads_nothing_and_shows_all_findings() -> None:
    text = as_html([REPORT, GOOD])
    page = Page(text)

    assert all(link.startswith("#") for link in page.links)
    assert not {"script", "link", "iframe", "img", "object"} & set(page.tags)
    assert not re.search(r"https?:|@import|url\(", text)
    assert "b" not in page.tags  # a message is text, not markup
    for found in FINDINGS:
        assert found.check in page.text
        assert found.title in page.text
    assert "does not repeat" in page.text
    assert "size_bytes = 12" in page.text
    assert "zwei ä" in page.text


def test_long_lists_are_cut_except_those_of_the_contract() -> None:
    lines = tuple(f"line {i}" for i in range(40))
    long = replace(REPORT, findings=(finding("dynamic.a", "info", details=lines),))
    contract = replace(REPORT, findings=(finding("contract.a", "info", details=lines),))

    assert len(plain_lines(long)) == 13
    assert "and 29 lines more" in plain_lines(long)[-1]
    assert "line 39" in as_html([long])
    assert len(plain_lines(contract)) == 41


def test_only_an_error_fails_unless_strict() -> None:
    warned = replace(REPORT, findings=FINDINGS[:3])

    assert [fails([GOOD, report], strict) for report in (GOOD, warned, REPORT) for strict in (False, True)] == [
        False, False, False, True, True, True,
    ]  # fmt: skip


def test_file_is_written_completely_or_not_at_all(tmp_path: Path) -> None:
    write_text(tmp_path / "new" / "report.json", "first")
    (tmp_path / "taken" / "report.json").mkdir(parents=True)
    with pytest.raises(OSError, match="directory"):
        write_text(tmp_path / "taken" / "report.json", "second")

    assert (tmp_path / "new" / "report.json").read_text() == "first"
    assert [path.name for path in tmp_path.rglob("*.part")] == []


Check = Callable[..., tuple[int, str, str]]


@pytest.fixture
def check(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> Check:
    """Return a function that runs the command `check` in a folder; it returns exit code, output and error output."""

    def run(*arguments: object, folder: Path | None = None) -> tuple[int, str, str]:
        if folder is not None:
            monkeypatch.chdir(folder)
        code = main(["check", *map(str, arguments)])
        printed = capsys.readouterr()
        return code, printed.out, printed.err

    return run


def test_good_fmu_gets_0_and_every_file(make: Make, tmp_path: Path) -> None:
    files = {option: tmp_path / "out" / f"report.{option}" for option in ("html", "json", "junit")}
    options = [word for option, path in files.items() for word in (f"--{option}", path)]
    command = [sys.executable, "-W", "error", "-m", "lockstep", "check", make(), make(name="again.fmu"), *STATIC]
    done = subprocess.run([*command, "--strict", *options], capture_output=True, text=True, check=False, timeout=60)

    assert (done.returncode, done.stderr) == (0, "")
    assert "good.fmu: 18 passed\n" in done.stdout
    assert "  pass     static.schema" in done.stdout
    assert [Path(r.file).name for r in from_json(files["json"].read_text())] == ["good.fmu", "again.fmu"]
    assert len(ElementTree.parse(files["junit"]).getroot()) == 2
    assert "again.fmu" in files["html"].read_text()
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == sorted(p.name for p in files.values())


@pytest.mark.parametrize(
    ("changes", "strict", "code"),
    [
        ({"documentation/index.html": None}, (), 0),
        ({"documentation/index.html": None}, ("--strict",), 1),
        ({BINARY: None}, (), 1),
    ],
)
def test_exit_code_shows_the_severity(
    check: Check, make: Make, changes: dict[str, None], strict: tuple[str, ...], code: int
) -> None:
    assert check(make(changes), *STATIC, *strict)[0] == code


def test_file_that_is_not_an_fmu_is_a_finding(check: Check, tmp_path: Path) -> None:
    (tmp_path / "vendor.fmu").write_bytes(b"no zip")
    code, printed, errors = check(tmp_path / "vendor.fmu")  # dynamic checks too: there is nothing to run

    assert (code, errors) == (1, "")
    assert "error    static.archive" in printed
    assert "skipped  dynamic.run" in printed


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["nowhere.fmu"], "nowhere.fmu: no such file"),
        (["."], "is a folder; pack it"),
        (["good.fmu", "--html", "."], "--html .: is a folder"),
        (["good.fmu", "--html", "good.fmu/report.html"], "cannot be written"),
        (["good.fmu", "--json", "good.fmu"], "is one of the FMUs"),
        (["good.fmu", "--json", "x", "--junit", "x"], "the same file"),
        (["good.fmu", "nowhere.fmu", "--json", "x"], "nowhere.fmu: no such file"),
    ],
)
def test_bad_input_is_refused_before_any_check(check: Check, make: Make, arguments: list[str], says: str) -> None:
    folder = make().parent
    code, printed, errors = check(*arguments, *STATIC, folder=folder)

    assert (code, printed) == (2, "")
    assert says in errors
    assert errors.count("\n") == 1
    assert not (folder / "x").exists()


def test_terminal_gets_a_table_without_control_characters(make: Make) -> None:
    path = make(xml=XML.replace('name="attitude[2]"', 'name="a&#x9b;31m[2]"'))
    master, terminal = pty.openpty()
    command = [sys.executable, "-m", "lockstep", "check", str(path), *STATIC]
    environment = os.environ | {"TERM": "xterm", "COLUMNS": "120"}
    with subprocess.Popen(command, stdout=terminal, stderr=terminal, env=environment) as process:
        os.close(terminal)
        shown = b""
        while True:
            try:
                part = os.read(master, 65536)
            except OSError:  # the other end is closed
                break
            if not part:
                break
            shown += part
    os.close(master)
    text = shown.decode()

    assert process.returncode == 1
    assert "static.schema" in text
    assert "\x1b[" in text  # colours
    assert "\x9b" not in text
