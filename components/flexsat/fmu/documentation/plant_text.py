"""The documentation text of the plant."""

from __future__ import annotations

from .component_text import ComponentText, Equation

PLANT = ComponentText(
    title="Flexible spacecraft",
    summary="A 30 m segmented telescope structure on a bus, free in space, turned by reaction wheels.",
    models=(
        "A free rigid body with structural modes and its reaction wheels: translation, attitude, deformation and"
        " wheel spin, fully coupled through the mass matrix. The structure is 60 hexagonal tiles of 2 m side in four"
        " rings around a hexagonal hole whose six corners are fixed to the bus: a Kirchhoff plate in bending,"
        " discrete Kirchhoff triangles on a mesh of 138 nodes and 216 triangles.",
        "Each wheel spins about its own axis on a bearing without friction, unless wheel.friction_torque is set:"
        " dry friction of at most that torque, which brakes the wheel against its mount and then holds it. A large"
        " value models a seized wheel. It may change at any time in a run. The motor torque acts on the wheel and"
        " back on the structure at its mount. Motor torque is the input: it is rounded to whole steps of"
        " wheel.torque_step, then limited to wheel.torque_limit times wheel.torque_limit_factor. Torque that speeds a"
        " wheel up is limited further where it has a wheel.speed_limit: above wheel.full_torque_speed the limit falls,"
        " in a line, to zero there; without one, to what reaches it within the step. 0 is no limit, no fall, no step."
        " Gyroscopic torques of the wheels act on body and modes.",
        "Appendages that turn have their angles as parameters, appendage.angle, which may change at any time in a run:"
        " a quasi-static change that keeps modal displacements, the momenta of all coordinates, and the angular"
        " momentum. Neither the torque nor the rate of the drive is modelled.",
        "Left out: gravity gradient and other environment (external.force and external.torque are there for it),"
        " in-plane deformation, large deformation, viscous friction, thermal effects.",
        "Mounts are the sites that carry wheels, in the order of the sites.",
    ),
    equations=(
        Equation(
            formula="<b>p</b>′ = ¼ [(1 − <b>p</b>·<b>p</b>) <b>I</b> + 2 [<b>p</b>×] + 2"
            " <b>p</b><b>p</b><sup>T</sup>] <b>w</b>",
            meaning="attitude p (MRP) from the body rate w; replaced by its shadow when it grows longer than 1",
            source="P, equations of motion",
        ),
        Equation(
            formula="<i>m</i> <b>v</b>′ + <b>L</b><sub>v</sub> <b>η</b>″ + <b>w</b> × (<i>m</i> <b>v</b> +"
            " <b>L</b><sub>v</sub> <b>η</b>′) = <b>F</b>",
            meaning="velocity v of the body origin; modal coordinates eta, mass-normalised; F all forces",
            source="P, equations of motion",
        ),
        Equation(
            formula="<b>J</b> <b>w</b>′ + <b>L</b><sub>w</sub> <b>η</b>″ + <b>w</b> × (<b>J</b> <b>w</b> +"
            " <b>L</b><sub>w</sub> <b>η</b>′) + Σ<sub>i</sub> (<b>w</b> + <b>N</b><sub>i</sub> <b>η</b>′) ×"
            " <b>h</b><sub>i</sub> = −<b>E</b><sup>T</sup> <b>τ</b> + <b>T</b>",
            meaning="body rate w; N_i the slope of the modes at wheel i, h_i = rho_i e_i its momentum along its axis"
            " e_i, E the axes stacked, tau the motor torques, T all other torques",
            source="P, equations of motion",
        ),
        Equation(
            formula="<b>L</b><sub>v</sub><sup>T</sup> <b>v</b>′ + <b>L</b><sub>w</sub><sup>T</sup> <b>w</b>′ +"
            " <b>η</b>″ + <b>F</b><sub>d</sub> <b>η</b>′ + <b>Ω</b>² <b>η</b> + Σ<sub>i</sub>"
            " <b>N</b><sub>i</sub><sup>T</sup> [(<b>w</b> + <b>N</b><sub>i</sub> <b>η</b>′) × <b>h</b><sub>i</sub>]"
            " − (<b>L</b><sub>v</sub><sup>T</sup>/<i>m</i>) [<b>w</b> × (<i>m</i> <b>v</b> + <b>L</b><sub>v</sub>"
            " <b>η</b>′)] = −Σ<sub>i</sub> <b>N</b><sub>i</sub><sup>T</sup> <b>e</b><sub>i</sub> τ<sub>i</sub> +"
            " <b>f</b><sub>η</sub>",
            meaning="modes; damping F_d, squared frequencies Omega², f_eta the modal part of jitter. The term with"
            " L_v^T/m has the opposite sign to P's, so that a uniform velocity of the whole spacecraft changes"
            " nothing",
            source="P, equations of motion",
        ),
        Equation(
            formula="ρ<sub>i</sub>′ = τ<sub>i</sub>,   Ω<sub>i</sub> = ρ<sub>i</sub>/<i>I</i><sub>w</sub> −"
            " <b>e</b><sub>i</sub> · (<b>w</b> + <b>N</b><sub>i</sub> <b>η</b>′)",
            meaning="axial momentum of a wheel (inertial), and its speed relative to its mount, which is wheel.speed",
            source="P, equations of motion",
        ),
        Equation(
            formula="<i>y</i> = <b>a</b>·[<b>v</b>′ + <b>w</b>′ × <b>r</b> + <b>d</b>″ + <b>w</b> × <b>v</b> +"
            " <b>w</b> × (<b>w</b> × <b>r</b>)]",
            meaning="acceleration along an accelerometer's axis a at r, with d the displacement of the mount",
            source="P, equation for y_amu",
        ),
        Equation(
            formula="√(<b>η</b>·<b>η</b>/<i>m</i>)",
            meaning="rms_deformation: root mean square over the mass",
            source="P, section 5",
        ),
    ),
    timing=(
        "Any step > 0 is accepted; steps need not be equal. 1 ms is recommended. A new step length costs a few"
        " milliseconds the first time; the last eight are kept ready.",
        "doStep(t, h) holds the inputs over [t, t+h). The outputs are true at t+h; after initialisation they are"
        " true at the start time. accelerometer_site.acceleration jumps with the inputs, the only direct feedthrough:"
        " read after a step it is that with the inputs held over the step, and read after inputs were set, without a"
        " step, that with the new ones. Everything else follows from the state.",
        "The linear structure is carried by its matrix exponential, exact for any step. The gyroscopic and momentum"
        " terms are evaluated once, at a predicted mid-step: second order in the step. At 5 ms the step is stable up"
        " to body rates of 0.2 rad/s, at 1 ms up to 0.5 rad/s. A motion that diverges is an error, not a number.",
    ),
    state=(
        "The state is complete: attitude, structure, wheel momenta and angles. It can be saved, restored, serialised,"
        " and deserialised in another process, and the run continues bitwise.",
        "What is random is drawn from seed during initialisation: initial wheel angles and the initial attitude"
        " error. Nothing random happens afterwards.",
    ),
)
