"""Delays of our own FMUs, measured, against the time semantics that their pages promise; no claim is contradicted."""

import shutil

import pytest

from flexbench.cli.parser import main
from fmus.vendor.vendor_fmu import vendor_fmu
from lockstep.check.latency.probe_latency import ProbeSettings, probe_latency


def arrays(report):
    """Return least and most steps, and whether any is feedthrough, by the arrays of output and input."""
    found = {}
    answering = [pair for pair in report.pairs if pair.least is not None]
    clear = {folded(pair) for pair in answering if pair.clear}
    for pair in answering:
        key = folded(pair)
        if pair.clear or key not in clear:
            least, most, fed = found.get(key, (pair.least, pair.most, False))
            found[key] = min(least, pair.least), max(most, pair.most), fed or pair.feedthrough
    return found


def folded(pair):
    """Return the arrays of a pair."""
    return pair.output.partition("[")[0], pair.input.partition("[")[0]


@pytest.fixture
def probed(fmus):
    """Return a measured component of the centralised configuration."""

    def probe(component, **settings):
        report = probe_latency(
            fmus / "centralised" / f"{component}.fmu", ProbeSettings(seconds=600.0, **settings)
        )  # one by one, also on a busy machine
        assert not report.of("contradicted")
        assert not report.of("no claim")
        assert not report.unrepeatable
        assert not report.refused
        return report

    return probe


def test_sensors_answer_in_the_step_in_which_they_sample(probed):
    """Gyros, accelerometers and encoders sample every 5 ms, the star tracker every 100 ms, in steps of 1 ms."""
    found = arrays(probed("sensors"))

    fast = {("gyro.rate", "gyro_site.rate"), ("accelerometer.acceleration", "accelerometer_site.acceleration"),
            ("encoder.speed", "wheel.speed"), ("encoder.angle", "wheel.angle")}  # fmt: skip
    assert {pair: found[pair] for pair in fast} == dict.fromkeys(fast, (0, 4, True))
    assert found["star_tracker.mrp", "attitude.quaternion"] == (0, 99, True)
    assert not [pair for pair in found if pair[0] == "gyro.rate" and pair not in fast]
    # every wheel shakes in every step
    assert found["jitter.force_y", "wheel.speed"][::2] == (0, True)


def test_what_the_plant_integrates_is_no_feedthrough_and_its_accelerations_are(probed):
    found = arrays(probed("plant", steps=12, amplitude=0.1))

    assert found["wheel.speed", "wheel.torque"] == (0, 0, False)
    assert found["attitude.mrp", "external.torque"] == (0, 0, False)
    assert found["accelerometer_site.acceleration", "external.force"][::2] == (0, True)
    assert {output for (output, _), answer in found.items() if answer[2]} == {"accelerometer_site.acceleration"}


def test_the_controller_answers_at_once(probed):
    """To encoder angles too: the robust design commands a torque against the jitter that they foretell."""
    report = probed("controller", steps=8, amplitude=1e-4)  # a run begins at an attitude of more than 1e-3 rad
    found = arrays(report)

    for measured in ("gyro.rate", "encoder.speed", "star_tracker.mrp", "encoder.angle"):
        least, _, fed = found["wheel.torque", measured]
        assert (least, fed) == (0, True), measured
    # a rotation is commanded before the slew begins: in a run that goes on its inputs must not move
    assert "command.start_time" in report.unmoved


@pytest.mark.skipif(shutil.which("gcc") is None, reason="the controller is compiled with gcc")
def test_flags_that_block_every_answer_are_named(tmp_path, capsys):
    """The vendor's controller commands nothing but in mode 2, and ignores attitudes that are not marked as valid."""
    assert main(["probe-latency", str(vendor_fmu(tmp_path))]) == 0

    assert "more inputs have an answer with --set Mode=2 --set q_ok=3" in capsys.readouterr().out
