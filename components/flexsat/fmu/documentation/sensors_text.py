"""The documentation text of the sensors."""

from __future__ import annotations

from .component_text import ComponentText, Equation

SENSORS = ComponentText(
    title="Sensors and wheel jitter",
    summary="Star tracker, gyros, accelerometers and wheel encoders with noise, and the jitter that the wheels cause.",
    models=(
        "Four instruments that sample the truth of the plant: a star tracker (coarse, or the fine guidance sensor)"
        " every star_tracker.period; gyros, accelerometers and encoders every fast_period. Noise is white, normal,"
        " and given as the standard deviation of a sample. Accelerometers sense through a second-order Butterworth"
        " low-pass, which is stepped at every step.",
        "The jitter of the wheels: the first harmonic of static and dynamic imbalance from each wheel's true angle"
        " and speed, further harmonics if the wheels have a table of them, and broadband noise that stands for the"
        " rest, held over fast_period. Each wheel has factors on the four numbers of its jitter. The sum over the"
        " wheels of one mount is given as a force and a torque on that mount, in body axes, to connect to the"
        " plant's inputs of the same names.",
        "Gyros and accelerometers are numbered as above. One encoder a wheel. Off by default: biases that walk,"
        " scale factors, misalignment, the star tracker's low-frequency error, and its blinding by Sun and Earth. Left"
        " out: quantisation, latency.",
    ),
    equations=(
        Equation(
            formula="<b>q</b><sub>m</sub> = δ<b>q</b>(<b>ε</b>) ⊗ <b>q</b>,   <b>ε</b> ~ N(0, σ²)",
            meaning="star tracker: the true attitude turned by a small rotation vector with sigma about each axis",
            source="P, section 4",
        ),
        Equation(
            formula="<i>y</i> = <i>x</i> + ν,   ν ~ N(0, σ²)",
            meaning="gyros and encoders, one draw a sample; encoder angles carry no noise",
            source="P, section 4",
        ),
        Equation(
            formula="<i>y</i>″/ω<sub>c</sub>² + √2 <i>y</i>′/ω<sub>c</sub> + <i>y</i> = <i>a</i>,   ω<sub>c</sub> ="
            " 2π <i>f</i>",
            meaning="anti-aliasing filter, sampled exactly for an input that is linear between steps",
            source="P, section 4",
        ),
        Equation(
            formula="<b>f</b> = <i>C</i><sub>f</sub> Ω² (sin θ, cos θ),   <b>t</b> = <i>C</i><sub>t</sub> Ω² (−cos"
            " θ, sin θ),   θ = angle + Ω <i>h</i>/2",
            meaning="harmonic jitter of a wheel along its lateral axes at speed Omega, at the middle of the step"
            " that it is held over",
            source="P, section 4",
        ),
    ),
    timing=(
        "All steps are equally long: as the first one, or as step_size where that parameter is set. fast_period is a"
        " whole multiple of the step, and star_tracker.period one of fast_period: with the stock periods steps of"
        " 5 ms, 2.5 ms, 1 ms and so on. Any other step is refused.",
        "doStep(t, h) reads the inputs at t; its outputs hold from t on. A host that reads them after the step, at"
        " t+h, sees what was measured at t. To close a loop without delay, step the sensors first, then the"
        " controller, then the plant, and set the plant's outputs, true at t, as the sensors' inputs before"
        " doStep(t, h).",
        "After initialisation, before the first step, the instruments show rest: attitude zero, encoders the nominal"
        " speeds, star_tracker.valid false.",
    ),
    state=(
        "The state is complete, the random generators included: a run that continues from a saved state, here or in"
        " another process, draws the same noise.",
        "All noise follows from seed. Measurement noise and jitter come from separate streams: switching jitter off"
        " does not change the noise of the instruments.",
    ),
)
