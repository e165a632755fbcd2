"""The text parts of the documentation of the FMUs of missions; their tables are made from the ports."""

from __future__ import annotations

from .component_text import ComponentText, Equation

_SAMPLED = (
    "doStep(t, h) reads the inputs at t; its outputs hold from t on. To close a loop, step in the order sensors,"
    " controller, mission, environment, thrusters, plant."
)

ENVIRONMENT = ComponentText(
    title="Environment",
    summary="Forces and torques of a circular orbit: sunlight, gravity gradient, magnetic field, and a constant.",
    models=(
        "A circular orbit round a spherical Earth, without perturbations. Sunlight acts on one flat plate that is lit"
        " on either side, at its centre of pressure; the Earth's shadow is a cylinder. The magnetic field is that of a"
        " dipole which stands still in inertial axes, and acts on a residual dipole of the spacecraft.",
        "Any FMU with an input attitude.quaternion and outputs external.force and external.torque can stand in its"
        " place. Left out: drag, albedo, higher harmonics of both fields, motion of the Sun, penumbra.",
    ),
    equations=(
        Equation(
            formula="<b>T</b><sub>g</sub> = 3 μ/<i>R</i>³ <b>r</b> × J <b>r</b>",
            meaning="gravity gradient; r is the unit vector to the Earth in body axes, J the inertia",
            source="Wertz (1978), eq. 17-31",
        ),
        Equation(
            formula="<b>F</b> = −<i>p A</i> cos θ [(1 − ρ<sub>s</sub>) <b>s</b> + 2 (ρ<sub>s</sub> cos θ +"
            " ρ<sub>d</sub>/3) <b>n</b>]",
            meaning="sunlight on the plate; s points to the Sun, n is the normal of the lit side, rho_s and rho_d the"
            " shares that are reflected and scattered",
            source="Wertz (1978), eq. 17-57",
        ),
        Equation(
            formula="<b>T</b><sub>m</sub> = <b>m</b> × <b>B</b>,   <b>B</b> = <i>B</i><sub>0</sub> (<i>R</i>"
            "<sub>0</sub>/<i>R</i>)³ [<b>k</b> − 3 (<b>k</b>·<b>r</b>) <b>r</b>]",
            meaning="magnetic torque on the residual dipole m; k points to the magnetic pole in the north",
            source="Wertz (1978), appendix H",
        ),
    ),
    timing=("Any step is accepted.", _SAMPLED),
    state=("There is nothing to remember between steps, and nothing is random.",),
)

THRUSTERS = ComponentText(
    title="Thrusters",
    summary="Thrusters that fire pulses of at least a minimum impulse at a fixed rate, with noise and a lag.",
    models=(
        "Twelve thrusters at places and with directions of their own; as they start they are six couples, two along"
        " each axis. A pulse begins with a period and has full thrust for as long as its impulse takes. A command of"
        " less than the minimum impulse gives no pulse. Thrust follows the valve with a first-order lag, and differs"
        " from pulse to pulse by noise. Force and torque of an environment are added, so that one component drives the"
        " external inputs of the plant.",
        "Left out: propellant and its mass, misalignment, plumes, ageing.",
    ),
    equations=(
        Equation(
            formula="τ <i>f</i>′ = <i>u</i> − <i>f</i>",
            meaning="lag, sampled exactly; outputs are means over the step, so that their sum times the step is the"
            " impulse without error",
            source="first-order hold of the valve over a step",
        ),
    ),
    timing=("All steps are equally long, and thrust.period is a whole multiple of them.", _SAMPLED),
    state=("The state is complete, the random generator included. All noise follows from seed.",),
)

MISSION = ComponentText(
    title="Mission manager",
    summary="Modes, timeline, off-loading of the wheels and failed wheels, between a controller and the wheels.",
    models=(
        "A state machine of six modes, whose commands come from a timeline in the parameters. The torque that the"
        " controller demands goes to the wheels unchanged, as long as all of them work and no thruster fires.",
        "Off-loading: thrusters give the torque that brings the momentum of the wheels back to that of their nominal"
        " speeds, and the wheels answer that torque at once, so that the attitude stays. The torque of the thrusters"
        " is the optimum of a quadratic programme, solved anew in each period: a constant over the time left.",
        "A failed wheel is found by comparing its encoder with the commanded torque; its torque is given to the others"
        " through the pseudo-inverse of their axes, and the controller learns by applied.wheel.torque what acted.",
    ),
    equations=(
        Equation(
            formula="min Σ|<b>T</b><sub>k</sub>|²,   Σ<b>T</b><sub>k</sub> <i>P</i> = −<b>h</b>,"
            "   |<b>T</b><sub>k</sub>| ≤ <i>T</i><sub>max</sub>",
            meaning="torque of the thrusters over the periods P that are left, for a momentum h of the wheels",
            source="P, section 6: the second case of guidance, with pointing held",
        ),
        Equation(
            formula="<i>r</i><sub>k</sub> = Ω<sub>k</sub> − Ω̂<sub>k</sub>,   Ω̂′ = τ/<i>J</i> + <i>r/T</i>",
            meaning="residual of a wheel: a torque d that is lost leaves r = d T/J",
            source="observer of the wheel speed",
        ),
        Equation(
            formula="<b>τ</b><sub>w</sub> += E<sub>w</sub> (E<sub>w</sub><sup>T</sup>E<sub>w</sub>)<sup>-1</sup>"
            " E<sub>f</sub><sup>T</sup> (<b>τ</b><sub>f</sub> − <b>g</b><sub>f</sub>)",
            meaning="torque of the wheels w that work, for those f that failed and give g",
            source="least squares",
        ),
    ),
    timing=("All steps are equally long: those of the controller.", _SAMPLED),
    state=("The state is complete; nothing is random.",),
)
