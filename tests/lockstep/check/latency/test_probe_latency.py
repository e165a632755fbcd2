"""Measured delays against an FMU whose delays stand in its source; claims that are right, wrong and missing."""

import json
import sys
import zipfile
from pathlib import Path

import pytest

from fmus.reference import build as reference
from fmus.vendor.vendor3_fmu import vendor3_fmu
from fmus.vendor.vendor_fmu import vendor_fmu
from lockstep import InputError, RunError
from lockstep.__main__ import main
from lockstep.check.latency.probe_latency import ProbeSettings, probe_latency

sys.path.append(str(Path(__file__).parent))
from delays_fmu import DELAYS, OUTPUTS, TRUE, build_delays

ANY_STEP = 'canHandleVariableCommunicationStepSize="true"'
STATE = 'canGetAndSetFMUstate="true"'
WATCHED = ProbeSettings(steps=12, amplitude=0.1)  # crosses several of the quantiser's 1/64


@pytest.fixture(scope="module")
def good(tmp_path_factory):
    """Return the FMU that takes any step, has a state, and claims what is true."""
    return build_delays(tmp_path_factory.mktemp("good"), "STATE", flags=f"{ANY_STEP} {STATE}")


@pytest.fixture(scope="module")
def wrong(tmp_path_factory):
    """Return one of a fixed step whose claims are wrong: one too few, one too many."""
    feeds = TRUE | {"direct": (), "late[1]": ("v",), "late[2]": ("v",)}
    return build_delays(tmp_path_factory.mktemp("wrong"), "FIXED=0.01", feeds=feeds)


def delays(report):
    """Return least and most steps by output and input, of what answers."""
    return {(p.output, p.input): (p.least, p.most) for p in report.pairs if p.least is not None}


def fed(report):
    """Return the pairs of feedthrough."""
    return {(p.output, p.input) for p in report.pairs if p.feedthrough}


def test_delays_are_those_of_the_source(good):
    report = probe_latency(good, WATCHED)

    assert delays(report) == DELAYS
    assert fed(report) == {(output, name) for output, names in TRUE.items() for name in names}
    assert {pair.agreement for pair in report.pairs} == {"agrees"}
    assert report.unmoved == ("idle",)


def test_fixed_step_without_state_gives_the_same_delays(wrong):
    report = probe_latency(wrong, WATCHED)

    assert delays(report) == DELAYS
    # a shorter step cannot be made: whatever answers within it counts, unless `kind` says otherwise
    assert ("integral", "u") in fed(report)
    assert ("integral", "u") not in fed(probe_latency(wrong, ProbeSettings(steps=12, amplitude=0.1, kind="continuous")))


def test_wrong_claims_are_contradicted_both_ways(wrong):
    report = probe_latency(wrong, WATCHED)

    found = {(p.output, p.input): p.claimed for p in report.of("contradicted")}
    assert found == {("direct", "u"): False, ("integral", "u"): False, ("late[1]", "v"): True, ("late[2]", "v"): True}


def test_a_claim_that_small_changes_confirm_is_not_contradicted(tmp_path):
    """A value far from the usual waits a step, as a filter may treat a measurement far from what it expects."""
    fmu = build_delays(tmp_path, "STATE", "GUARDED", feeds=TRUE | {"late[1]": ("v",)}, flags=f"{ANY_STEP} {STATE}")
    report = probe_latency(fmu, WATCHED)

    (pair,) = [pair for pair in report.pairs if (pair.output, pair.input) == ("late[1]", "v")]
    assert (pair.agreement, pair.feedthrough, pair.least) == ("agrees", True, 0)
    assert pair.most == 1  # of the jump
    assert not report.of("contradicted")
    assert report.smaller == ("v",)


def test_missing_dependencies_are_no_claim(tmp_path):
    report = probe_latency(build_delays(tmp_path, feeds=None, flags=ANY_STEP), WATCHED)

    assert {pair.agreement for pair in report.pairs} == {"no claim"}
    assert delays(report) == DELAYS


def test_answer_without_a_step_is_reported(tmp_path):
    fmu = build_delays(tmp_path, "AT_ONCE", feeds=TRUE | {"direct": ()}, flags=ANY_STEP)

    (pair,) = probe_latency(fmu, WATCHED).of("contradicted")

    assert (pair.output, pair.input, pair.direct) == ("direct", "u", True)


def test_values_and_amplitudes_decide_what_is_excited(good):
    silent = probe_latency(good, ProbeSettings(steps=12, starts={"scale": "0"}, amplitude=0.1))
    assert [(pair.output, pair.input) for pair in silent.of("not excited")] == [("direct", "u")]
    # by default an input changes by a thousandth: not enough for a quantiser of 1/64
    (pair,) = probe_latency(good, ProbeSettings(steps=12)).of("not excited")
    assert (pair.output, pair.input) == ("coarse", "u")


def with_dependencies(fmu, path, dependencies):
    """Copy an FMU with other dependencies of its outputs, as the XML elements to replace."""
    with zipfile.ZipFile(fmu) as archive:
        members = {name: archive.read(name) for name in archive.namelist()}
    text = members["modelDescription.xml"].decode()
    for old, new in dependencies.items():
        assert old in text
        text = text.replace(old, new)
    with zipfile.ZipFile(path, "w") as archive:
        for name, content in (members | {"modelDescription.xml": text.encode()}).items():
            archive.writestr(name, content)
    return path


def test_arrays_of_fmi_3(tmp_path, reference_fmu):
    """Every input is copied to an output; the declared dependencies of one output are wrong."""
    number = {v.name: k for k, v in enumerate(reference.variables_of("feedthrough", "3.0"))}
    vector, flags = (f'<Output valueReference="{number[name]}"' for name in ("vector_out", "flags_out"))
    changed = {
        f"{vector}/>": f'{vector} dependencies=""/>',
        f"{flags}/>": f'{flags} dependencies="{number["flags_in"]}"/>',
    }
    fmu = with_dependencies(reference_fmu("feedthrough", "3.0"), tmp_path / "feedthrough.fmu", changed)
    report = probe_latency(fmu, ProbeSettings(steps=3, seconds=600.0))

    assert dict(fed(report)) == {
        name: name.replace("_out", "_in") for name in report.outputs if not name.startswith(("Str", "wor"))
    }
    assert set(delays(report).values()) == {(0, 0)}
    assert {pair.output for pair in report.of("contradicted")} == {f"vector_out[{k}]" for k in (1, 2, 3)}
    # element by element, although FMI 3.0 declares dependencies of whole arrays
    assert {pair.output: pair.input for pair in report.of("agrees")} == {
        f"flags_out[{k}]": f"flags_in[{k}]" for k in (1, 2)
    }
    assert "String_in" in report.texts


@pytest.mark.parametrize("version", ["1.0", "3.0"])
def test_integral_is_feedthrough_unless_the_fmu_declares_any_step(reference_fmu, version):
    settings = ProbeSettings(steps=3, starts={"rate": "2"})
    report = probe_latency(reference_fmu("integrator", version), settings)

    assert delays(report) == {("x", "u"): (0, 0)}
    assert fed(report) == ({("x", "u")} if version == "1.0" else set())  # FMI 1.0 does not say that it takes any step


@pytest.mark.parametrize("build", [vendor_fmu, vendor3_fmu], ids=["FMI 2.0", "FMI 3.0"])
def test_vendor_fmu_answers_while_flag_and_mode_allow_it(tmp_path, build):
    """It ignores attitudes while q_ok is not 3."""
    fmu = build(tmp_path)
    first = "q_IB[0]" if build is vendor_fmu else "q_IB[1]"
    awake = {first: "1", "Mode": "2", "q_ok": "3"}

    found = probe_latency(fmu, ProbeSettings(steps=5, starts=awake, amplitude=0.01))
    assert set(delays(found).values()) == {(0, 0)}
    answering = {(output.partition("[")[0], name.partition("[")[0]) for output, name in fed(found)}
    assert answering == {("TauCmd", "q_IB"), ("TauCmd", "w_meas")}
    blind = fed(probe_latency(fmu, ProbeSettings(steps=5, starts=awake | {"q_ok": "0"}, amplitude=0.01)))
    assert {name.partition("[")[0] for _, name in blind} == {"w_meas"}


def test_outputs_that_do_not_repeat_are_listed(tmp_path):
    report = probe_latency(build_delays(tmp_path, feeds=TRUE, flags=ANY_STEP, outputs=OUTPUTS), WATCHED)

    assert report.unrepeatable == ("noise",)
    assert delays(report) == DELAYS


def test_crash_is_reported_in_one_line(tmp_path):
    with pytest.raises(RunError, match=r"delays.fmu: crashed with SIGSEGV in fmi2DoStep at t = 0.2 s"):
        probe_latency(build_delays(tmp_path, "CRASHES"), WATCHED)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        (ProbeSettings(starts={"scales": "1"}), r"fmu.scales: no such parameter; fmu has .*scale"),
        (ProbeSettings(starts={"scale": "much"}), "scale: 'much'"),
        (ProbeSettings(amplitudes={"w": 1.0}), r"--amplitude w: no such Real input; there are u, v, slow, gated, idle"),
        (ProbeSettings(amplitude=-1.0), r"--amplitude: -1 must be a number > 0"),
        (ProbeSettings(step=0.0), r"--step-size 0: must be 1e-09 s or more"),
        (ProbeSettings(steps=0), r"--steps 0: must be 1 or more"),
        (ProbeSettings(seconds=0.0), r"--time-limit 0: must be > 0 s"),
    ],
)
def test_bad_setting_is_refused(good, settings, message):
    with pytest.raises(InputError, match=message):
        probe_latency(good, settings)


def test_command_prints_a_matrix_and_writes_json(good, wrong, tmp_path, capsys):
    file = tmp_path / "latency.json"

    assert main(["probe-latency", str(good), "--steps", "12", "--amplitude", "0.1", "--json", str(file)]) == 0
    printed = capsys.readouterr().out
    assert main(["probe-latency", str(wrong), "--steps", "12"]) == 1
    contradicted = capsys.readouterr().out

    rows = {line.split()[0]: line.split()[1:] for line in printed.splitlines() if line.startswith((*TRUE, "late"))}
    assert rows["late[2]"] == [".", "1-3", ".", ".", ".", "."]
    assert rows["sampled"] == [".", ".", "0-3f", ".", ".", "."]
    assert "no contradiction" in printed
    assert "direct <- u: not claimed, but answers within its step" in contradicted
    assert "late[2] <- v: claimed as feedthrough, but answers after 3 steps at the earliest" in contradicted
    written = json.loads(file.read_text(encoding="utf-8"))
    assert written["contradictions"] == 0
    assert {(p["output"], p["input"]): (p["least"], p["most"]) for p in written["pairs"]} == DELAYS


def test_bad_input_is_refused_in_one_line(good, tmp_path, capsys):
    for arguments in ([tmp_path / "none.fmu"], [good, "--set", "scale"], [good, "--amplitude", "u=x"],
                      [good, "--json", tmp_path / "no" / "folder.json"]):  # fmt: skip
        assert main(["probe-latency", *map(str, arguments)]) == 2
        assert len(capsys.readouterr().err.splitlines()) == 1
