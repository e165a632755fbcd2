"""A closed loop with native FMUs of FMI 3.0 in the master: array variables, and bits that are those of FMI 2.0."""

from dataclasses import replace

import numpy as np
import pytest

from flexbench.loop.native_fmus import with_native_fmus
from fmus.native.fmi3_variant import fmi3_variant
from fmus.native.native_toy import compiler_is_missing
from lockstep import load_system, read_signals, simulate


@pytest.mark.skipif(bool(compiler_is_missing()), reason=compiler_is_missing() or "available")
def test_plant_and_sensors_of_fmi_3_give_the_bits_of_fmi_2(delivered, tmp_path):
    system = with_native_fmus(load_system(delivered / "centralised" / "fine_pointing.ssd"))
    fmus = {name: fmi3_variant(delivered / "centralised" / "native" / f"{name}.fmu", tmp_path / f"{name}.fmu")
            for name in ("plant", "sensors")}  # fmt: skip
    of_fmi3 = replace(
        system, components=tuple(replace(c, source=fmus.get(c.name, c.source)) for c in system.components)
    )
    overrides = {"plant.seed": 3, "sensors.seed": 3, "plant.initial.mrp[2]": 1e-6}
    found = []
    for name, each in (("two", system), ("three", of_fmi3)):
        simulate(each, tmp_path / name, stop_time=0.2, record=["all"], record_period=0.005, overrides=overrides)
        found.append(read_signals(tmp_path / name))

    assert found[0].columns.keys() == found[1].columns.keys()
    assert all(np.array_equal(values, found[1].columns[name]) for name, values in found[0].columns.items())
    assert np.ptp(found[0]["plant.attitude.mrp"], axis=0).all()
