"""Run a rigid spacecraft with reaction wheels in Basilisk: `python basilisk_wheels.py < case.json > result.json`.

For an interpreter with `bsk` alone (requirements.txt); `rigid_wheels.py` calls it.
"""

import json
import sys
import time

import numpy as np
from Basilisk.architecture import messaging
from Basilisk.simulation import reactionWheelStateEffector, spacecraft
from Basilisk.utilities import SimulationBaseClass, macros, simIncludeRW


def simulate(case):
    """Return the state at the end, and the time that a step took."""
    simulation = SimulationBaseClass.SimBaseClass()
    step = macros.sec2nano(case["step"])
    process = simulation.CreateNewProcess("process")
    process.addTask(simulation.CreateNewTask("task", step))
    body = spacecraft.Spacecraft()
    body.hub.mHub = case["mass"]
    body.hub.r_BcB_B = [[0.0], [0.0], [0.0]]
    # Basilisk counts the wheels' axial inertia to the hub
    axes = np.array(case["axes"])
    body.hub.IHubPntBc_B = (np.array(case["inertia"]) + (axes.T * case["wheel_inertia"]) @ axes).tolist()
    body.hub.r_CN_NInit = [[0.0], [0.0], [0.0]]
    body.hub.v_CN_NInit = [[0.0], [0.0], [0.0]]
    body.hub.sigma_BNInit = [[0.0], [0.0], [0.0]]
    body.hub.omega_BN_BInit = [[value] for value in case["rate"]]
    simulation.AddModelToTask("task", body)

    factory = simIncludeRW.rwFactory()
    jitter = any(case["force"]) or any(case["torque_of_imbalance"])
    model = messaging.JitterSimple if jitter else messaging.BalancedWheels
    columns = ("axes", "positions", "laterals", "speeds", "wheel_inertia", "force", "torque_of_imbalance")
    for axis, position, lateral, speed, inertia, force, torque in zip(*(case[name] for name in columns), strict=True):
        wheel = factory.create("custom", axis, Omega=0.0, Js=inertia, rWB_B=position, RWModel=model,
                               useMaxTorque=False)  # fmt: skip
        wheel.U_s, wheel.U_d = force, torque
        wheel.Omega, wheel.theta = speed, 0.0
        wheel.w2Hat0_B = [[value] for value in lateral]
        wheel.w3Hat0_B = [[value] for value in np.cross(axis, lateral).tolist()]
    effector = reactionWheelStateEffector.ReactionWheelStateEffector()
    factory.addToSpacecraft("wheels", effector, body)
    command = messaging.ArrayMotorTorqueMsgPayload()
    command.motorTorque = case["torques"]
    message = messaging.ArrayMotorTorqueMsg().write(command)
    effector.rwMotorCmdInMsg.subscribeTo(message)
    simulation.AddModelToTask("task", effector)

    simulation.InitializeSimulation()
    simulation.ConfigureStopTime(macros.sec2nano(case["stop"]))
    start = time.perf_counter()
    simulation.ExecuteSimulation()
    lasted = time.perf_counter() - start
    state = body.scStateOutMsg.read()
    speeds = effector.rwSpeedOutMsg.read().wheelSpeeds
    return {
        "mrp": list(state.sigma_BN),
        "rate": list(state.omega_BN_B),
        "velocity": list(state.v_BN_N),
        "speed": list(speeds)[: len(case["axes"])],
        "microseconds": 1e6 * lasted / round(case["stop"] / case["step"]),
    }


if __name__ == "__main__":
    print(json.dumps(simulate(json.load(sys.stdin))))
