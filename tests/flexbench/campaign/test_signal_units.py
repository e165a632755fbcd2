"""A metric of a signal is in the signal's own unit: another one would label numbers that were never converted."""

import shutil

import pytest

from flexbench.campaign.metrics import read_metrics
from flexbench.campaign.signal_units import check_signal_units, declared_unit
from fmus.vendor.vendor_fmu import vendor_fmu
from lockstep import Component, InputError, System

pytestmark = pytest.mark.skipif(
    shutil.which("gcc") is None, reason="an FMU whose outputs have units is compiled with gcc"
)


def vendor_system(folder):
    """Return a system of an FMU whose torques are in mN.m."""
    component = Component(name="vendor", source=vendor_fmu(folder), period=10_000_000)
    return System(name="one", tick=1_000_000, components=(component,))


@pytest.fixture
def check(tmp_path):
    """Return a function that checks the unit of a metric of a torque, which its FMU gives in mN.m."""
    system = vendor_system(tmp_path)

    def checked(**entry):
        metrics, sources = read_metrics({"peak": {"of": "vendor.TauCmd[0]", "take": "max", **entry}}, "a.toml")
        check_signal_units(metrics, sources, [system], "a.toml")

    return checked


def test_the_unit_of_the_signal_or_none_is_taken(check):
    check(unit="mN.m")
    check()


def test_another_unit_is_refused_with_that_of_the_signal(check):
    message = r"a.toml: metric.peak: unit = 'N.m': vendor.TauCmd\[0\] is in mN.m, .*write unit = 'mN.m'"
    with pytest.raises(InputError, match=message):
        check(unit="N.m")


def test_a_signal_of_another_system_takes_any(check):
    check(of="other.speed", unit="rpm")


def test_the_unit_of_a_variable_is_that_of_its_fmu(tmp_path):
    system = vendor_system(tmp_path)

    assert declared_unit(system, "vendor.TauCmd[0]") == "mN.m"
    assert declared_unit(system, "vendor.TauCmd[9]") is None
    assert declared_unit(system, "other.TauCmd[0]") is None
