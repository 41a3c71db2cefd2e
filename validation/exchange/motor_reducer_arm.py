"""A joint of a robot: controller, motor and arm in Python, the reducer as an FMU between them.

Usage: motor_reducer_arm.py UNIT [PICTURE]. UNIT was written by `arcmin export fmu DESIGN --load-flange motion`: its
inputs are the motions of both flanges, its outputs their torques. The motor follows a smooth path by its own encoder,
as in servo drives; the motion of the arm includes the reducer's backlash and elasticity. Ends with status 1 if the arm
does not reach its target.
"""

import math
import sys

import numpy as np
from fmpy import extract, read_model_description
from fmpy.fmi3 import FMU3Slave

ARCMIN = math.pi / 180 / 60
RATIO = 81
MOTOR_INERTIA = 2e-4  # kg m2, motor alone
ARM_INERTIA = 12.0  # kg m2, with load
GRAVITY = 200.0  # N m at the horizontal arm
STEP = 5e-5  # s, of motor, arm and communication
MOVE, TIME = math.radians(60), 0.8  # of the arm, in rad and s
BANDWIDTH = 2 * math.pi * 25  # of the motor's position loop, rad/s


def path(t):
    """Angle, speed and acceleration of the arm's set point: a polynomial of degree five."""
    x = min(t / TIME, 1)
    return (
        MOVE * x**3 * (10 + x * (6 * x - 15)),
        MOVE / TIME * 30 * x**2 * (1 - x) ** 2,
        MOVE / TIME**2 * 60 * x * (1 - x) * (1 - 2 * x) if x < 1 else 0.0,
    )


def simulate(unit, end=1.2):
    description = read_model_description(unit)
    reference = {v.name: v.valueReference for v in description.modelVariables}
    fmu = FMU3Slave(
        guid=description.guid,
        unzipDirectory=extract(unit),
        modelIdentifier=description.coSimulation.modelIdentifier,
        instanceName="reducer",
    )
    fmu.instantiate()
    fmu.enterInitializationMode(startTime=0)
    fmu.exitInitializationMode()
    inputs = [reference[f"flange_{side}.{what}"] for side in "ab" for what in ("phi", "w", "a")]
    outputs = [reference[name] for name in ("flange_a.tau", "flange_b.tau")]
    gain = (MOTOR_INERTIA + ARM_INERTIA / RATIO**2) * BANDWIDTH**2
    damping = 2 * 0.9 * (MOTOR_INERTIA + ARM_INERTIA / RATIO**2) * BANDWIDTH
    motor, arm = np.zeros(3), np.zeros(3)
    tau_a = tau_b = 0.0
    rows = []
    for k in range(round(end / STEP)):
        t = k * STEP
        angle, speed, acceleration = (RATIO * x for x in path(t))
        # Position controller with feed-forward torques of the path.
        feed = (MOTOR_INERTIA + ARM_INERTIA / RATIO**2) * acceleration + GRAVITY * math.cos(arm[0]) / RATIO
        torque = gain * (angle - motor[0]) + damping * (speed - motor[1]) + feed
        motor[2] = (torque - tau_a) / MOTOR_INERTIA
        # The torque at the load flange acts on the arm with the opposite sign.
        arm[2] = (-tau_b - GRAVITY * math.cos(arm[0])) / ARM_INERTIA
        for body in (motor, arm):
            body[1] += STEP * body[2]
            body[0] += STEP * body[1]
        # Accelerations would create an explicit loop with inertias in the unit: they are not set.
        fmu.setFloat64(inputs, [motor[0], motor[1], 0.0, arm[0], arm[1], 0.0])
        fmu.doStep(currentCommunicationPoint=t, communicationStepSize=STEP)
        tau_a, tau_b = fmu.getFloat64(outputs)
        rows.append((t + STEP, RATIO * path(t + STEP)[0] - motor[0], path(t + STEP)[0] - arm[0], torque, tau_b))
    fmu.terminate()
    fmu.freeInstance()
    return np.array(rows)


def main():
    rows = simulate(sys.argv[1])
    t, motor, arm, torque, _ = rows.T
    late = t > 1.1
    print(f"     motor off its path at the end: {np.abs(motor[late]).max() / RATIO / ARCMIN:.3f}' at the output")
    print(f"     arm off its path at the end: {np.abs(arm[late]).max() / ARCMIN:.3f}', underway {np.abs(arm).max() / ARCMIN:.2f}'")
    arrived = np.isfinite(rows).all() and np.abs(arm[late]).max() < 20 * ARCMIN
    print(f"{'ok  ' if arrived else 'FAIL'} the arm arrives")
    if len(sys.argv) > 2:
        import matplotlib

        matplotlib.use("svg")
        matplotlib.rcParams["svg.hashsalt"] = "arcmin"
        import matplotlib.pyplot as plt

        figure, (above, below) = plt.subplots(2, sharex=True, figsize=(7, 5), layout="constrained")
        above.plot(t, motor / RATIO / ARCMIN, label="motor (by its encoder, at the output)")
        above.plot(t, arm / ARCMIN, label="arm")
        above.set_ylabel("behind the path in ′")
        above.legend()
        below.plot(t, torque)
        below.set_ylabel("motor torque in N·m")
        below.set_xlabel("time in s")
        figure.savefig(sys.argv[2], metadata={"Date": None})
    return 0 if arrived else 1


if __name__ == "__main__":
    sys.exit(main())
