"""The sentence that says what limits a loop: the smallest disk margin of all loops, as gain and phase."""

import math

from flexbench.studies.margins.tables import limit_text


def test_the_smallest_disk_margin_limits_and_stands_for_a_gain_and_a_phase():
    # a loop with the disk margin of 2/3 stays stable for factors of 1/2 to 2 and for 2 atan(1/3) = 36.9 deg
    design = {"x": {"disk": 1.1, "disk_at": 0.2}, "all wheels": {"disk": 2.0 / 3.0, "disk_at": 1.25}}
    measured = {"y": {"value": {"disk": 0.9, "disk_at": 3.0}}, "z": {"problem": "no line is coherent"}}
    content = {"analysis": {"margins": design, "exact": {"delay": 0.0123}}, "measured": {"margins": measured}}
    assert limit_text(content) == (
        f"What limits: `design: all wheels` at 1.25 Hz, with a disk margin of 0.67: its gain may change by"
        f" {20.0 * math.log10(2.0):.1f} dB up or down, or its phase by 37 deg; a further delay of 12.300 ms on all"
        " inputs destabilises it."
    )

    measured["y"]["value"]["disk"] = 0.3
    assert limit_text(content).startswith("What limits: `measured: y` at 3 Hz, with a disk margin of 0.30")
    assert limit_text({"measured": {"margins": measured}}).endswith("or its phase by 17 deg.")
    measured["y"]["value"]["disk"] = math.inf
    assert limit_text({"measured": {"margins": measured}}) == ""
    assert limit_text({}) == ""
