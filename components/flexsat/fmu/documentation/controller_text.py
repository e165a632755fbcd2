"""The documentation text of the controller."""

from __future__ import annotations

from .component_text import ComponentText, Equation

CONTROLLER = ComponentText(
    title="LQG attitude controller",
    summary="Estimates attitude, rate, deformation and wheel speeds, and commands the torque of every wheel.",
    models=(
        "A sampled controller: a Kalman filter with structural modes and the accelerometers' filters in its model,"
        " a linear-quadratic regulator on attitude, rate, modes and wheel speeds, slew guidance, and saturation.",
        "The star tracker has a sample every 20th step only; the gain is periodic: star_tracker.valid marks the new"
        " sample, and the gain of the step follows from how long ago that was.",
        "Attitudes are quaternions: the star tracker's sample counts as the small rotation from the predicted attitude,"
        " and the regulator's error is the rotation from the reference to the estimate, so that slews up to 180 deg are"
        " flown about any axis. With as_published they are sums of a quarter of the angle, as in the release. A first"
        " sample farther than initial.capture_angle from zero is the attitude at which the run begins.",
        "Guidance plans rest-to-rest slews by command.rotation from command.start_time on, each from where the one"
        " before ended: bang-coast-bang within slew.authority of torque and speed band, its torque shaped by a"
        " three-tap filter with zeros at the dominant mode. The shaped torque leads the start time by about 0.15 s;"
        " a slew commanded later than that begins at once. A rotation of zero is no slew. A command that would begin"
        " during a slew is refused, or with command.during_slew = replan takes its place: the slew is braked, and the"
        " new one leads to the commanded rotation from where the first began. With slew.guidance = qp the profile is"
        " the optimum of P's quadratic programme, solved when the slew is planned: attitude and rate errors squared,"
        " torque and wheel momentum bounded, at rest on the commanded attitude at its end, without overshoot. A slew"
        " that is replanned then goes on from the rate at which the body turns, where that is quicker than braking.",
        "Each wheel has its own limits: wheel.torque_limit_factor (0: it is not used), wheel.speed_band_factor, and"
        " wheel.speed_offset, its speed at rest less the nominal one. A slew divides its torque between the wheels by"
        " what they have left of their bands, by their torque limits, or by the geometric mean of both, whichever is"
        " the quickest; the regulator shares equally, and its torques are limited by wheel.",
        "Slews keep keep_out.axis, such as a boresight, outside up to two cones about inertial directions, with every"
        " guidance. A slew that would enter a cone becomes a chain of up to five turns round it, at rest between them;"
        " one that begins or ends within a cone is refused.",
        "The filter predicts with the torque it commanded itself, unless applied.valid is true: then with"
        " applied.wheel.torque, the torque that the controller in command applied in the step before. This controller"
        " can therefore run in shadow of another one, and its torque then differs by the control law alone.",
        "Known delays of measurement and actuation, whole milliseconds up to 20, are bridged by propagating the"
        " estimate with the torques already commanded. It carries a model of one spacecraft: a controller for the"
        " other layout of wheels is another FMU.",
    ),
    equations=(
        Equation(
            formula="<b>x̂</b><sub>k</sub><sup>−</sup> = <b>A</b> <b>x̂</b><sub>k−1</sub> + <b>B</b>"
            " <b>τ</b><sub>k−1</sub> + <b>B</b><sub>j</sub> <b>j</b><sub>k−1</sub>",
            meaning="prediction over a period with the torques at work and the expected harmonic jitter j",
            source="P, section 6; delays are an addition of flexsat",
        ),
        Equation(
            formula="<b>x̂</b><sub>k</sub> = <b>x̂</b><sub>k</sub><sup>−</sup> + <b>K</b><sub>φ</sub>"
            " (<b>y</b><sub>k</sub> − <b>C</b> <b>x̂</b><sub>k</sub><sup>−</sup>)",
            meaning="correction; phi counts the steps since the star tracker's last sample; y: gyros,"
            " accelerometers, encoder speeds less nominal, rotation of the measured attitude from the predicted one",
            source="P, section 6",
        ),
        Equation(
            formula="<b>τ</b> = <b>τ</b><sub>ref</sub> − <b>F</b> (<b>x̂</b> − <b>x</b><sub>ref</sub>)",
            meaning="regulator about the reference (reference.*) with feed-forward torque (reference.torque)",
            source="P, section 6",
        ),
        Equation(
            formula="|τ<sub>i</sub>| ≤ τ<sub>max,i</sub>,   |Ω̂<sub>i</sub> + τ<sub>i</sub>"
            " <i>T</i>/<i>I</i><sub>w</sub>| ≤ ΔΩ<sub>i</sub>",
            meaning="saturation: motor torque, then the torque that would leave the speed band within a period T",
            source="P, section 6",
        ),
    ),
    timing=(
        "It samples every 5 ms, which the gains were designed for, first in its first step. All steps are equally long:"
        " 5 ms, or a whole fraction of it in a host with one rate, such as 1 ms; then the outputs hold from one sample"
        " to the next, and inputs between samples are not read. Any other step is refused: a longer one would leave out"
        " samples.",
        "doStep(t, h) reads the inputs at t; its outputs hold from t on. wheel.torque depends on the measurements of"
        " the same t (feedthrough). For a loop without delay, step it after the sensors and before the plant in the"
        " same instant.",
        "If measurements arrive late or torques act late, set delay.measurement and delay.actuation; one sample of"
        " delay that is not compensated leads to a limit cycle.",
        "After initialisation, before the first step, all outputs are zero.",
    ),
    state=(
        "The state is complete: estimate, commanded torques, phase, reference, plan. It can be saved, restored,"
        " serialised, and deserialised in another process, and the run continues bitwise.",
        "Nothing in it is random.",
    ),
)
