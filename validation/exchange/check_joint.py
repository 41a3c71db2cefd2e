"""Loads an exported joint in MuJoCo, repeats the hysteresis test of the bench there, and reads the other files.

Usage: check_joint.py DIR, where DIR was written by `arcmin export joint DESIGN --hours ...`. Every check prints
its value and limit; the exit status is 1 if a limit is exceeded.
"""

import importlib.util
import json
import math
import re
import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import mujoco
import numpy as np

ARCMIN = math.pi / 180 / 60
failures = 0


def check(what, value, limit):
    global failures
    kept = value <= limit
    failures += not kept
    print(f"{'ok  ' if kept else 'FAIL'} {what}: {value:.3g} (limit {limit:.3g})")


def label(hours):
    return "h" + np.format_float_positional(hours, trim="-").replace(".", "_")


def held(path, hours, grows, armature=None):
    """Model with held input (only the gear hinges remain), step, and address of the gear hinge of one age.

    Where friction `grows` with the load, joint_mujoco.py sets the slip elements before every step.
    """
    spec = mujoco.MjSpec.from_file(str(path / "joint.mjcf.xml"))
    name = label(hours)
    for motor in list(spec.actuators):
        spec.delete(motor)
    for joint in list(spec.joints):
        if joint.name.startswith("drive_"):
            spec.delete(joint)
        elif armature is not None:
            joint.armature = armature
    model = spec.compile()
    data = mujoco.MjData(model)
    joint = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_JOINT, f"gear_{name}")
    friction = friction_module(path).LoadFriction(model, name) if grows else None

    def step():
        if friction:
            friction.update(data)
        mujoco.mj_step(model, data)

    return model, data, step, model.jnt_qposadr[joint], model.jnt_dofadr[joint]


def measured(path, hours, rated, grows):
    """Lost motion and stiffness by the definitions of the bench, for the body of one age with held input."""
    model, data, step, place, dof = held(path, hours, grows)

    def settle(torque, steps=400):
        # Slowly: an oscillation would move slip elements beyond the torque that is set.
        before = data.qfrc_applied[dof]
        for k in range(steps):
            data.qfrc_applied[dof] = before + (torque - before) * min(1, (k + 1) / (0.75 * steps))
            step()
        return data.qpos[place]

    shares = sorted({*np.linspace(-1, 1, 41), 0.03, -0.03, 0.5, -0.5}, reverse=True)
    for share in (0.1, 0.4, 0.7, 1.0):
        settle(share * rated)
    falling = {share: settle(share * rated) for share in shares}
    rising = {share: settle(share * rated) for share in reversed(shares)}
    lost = 0.5 * (falling[0.03] + rising[0.03]) - 0.5 * (falling[-0.03] + rising[-0.03])
    compliance = []
    for branch in (falling, rising):
        for sign in (1, -1):
            window = [share for share in shares if 0.5 - 1e-9 <= sign * share]
            torque = np.array([share * rated for share in window])
            angle = np.array([branch[share] for share in window])
            # The bench's regression: angle on torque, both about their means.
            t, a = torque - torque.mean(), angle - angle.mean()
            compliance.append((t @ a) / (t @ t))
    return lost, 1 / np.mean(compliance)


def damping_ratio(path, hours, rated, load, stiffness, grows):
    """Damping ratio of an arm about half of the rated torque with held input, released at three quarters, less that of
    the damper of the gear hinge."""
    model, data, step, place, dof = held(path, hours, grows, load)
    # Sixty steps of a swing at least: extreme values are read at steps.
    h = model.opt.timestep = min(model.opt.timestep, 2 * math.pi * math.sqrt(load / stiffness) / 60)
    # Wound up slowly without oscillation, then released.
    for k in range(round(0.6 / h)):
        data.qfrc_applied[dof] = 0.75 * rated * min(1, k * h / 0.3)
        data.qvel[dof] *= 0.5 ** (h / 1e-3)
        step()
    data.qfrc_applied[dof] = 0.5 * rated
    swing = []
    for _ in range(round(max(0.3 * math.sqrt(load / 12), 12 * 2 * math.pi * math.sqrt(load / stiffness)) / h)):
        step()
        swing.append(data.qpos[place])
    turns = [swing[0]]
    turns += [b for a, b, c in zip(swing, swing[1:], swing[2:]) if (b - a) * (c - b) < 0]
    whole = math.log((turns[0] - turns[1]) / (turns[2] - turns[3])) / (2 * math.pi)
    return whole - model.dof_damping[dof] / (2 * math.sqrt(stiffness * load))


def friction_module(place):
    spec = importlib.util.spec_from_file_location("joint_mujoco", place / "joint_mujoco.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def check_friction(place, joint):
    """Constant speed with the motor driving against a load, and with a load driving against the motor."""
    module, ratio = friction_module(place), abs(joint["ratio"])
    for state in joint["states"]:
        name = label(state["hours"])
        model = mujoco.MjModel.from_xml_path(str(place / "joint.mjcf.xml"))
        model.opt.timestep = 1e-4
        drive, gear = model.joint(f"drive_{name}"), model.joint(f"gear_{name}")
        motor = model.actuator(f"motor_{name}").id
        friction, worst = module.LoadFriction(model, name), 0.0
        # For a servo that is stable at this time step.
        gain = min(2000, 0.15 * model.dof_armature[drive.dofadr[0]] / model.opt.timestep)
        for line in state["losses"][1:3]:
            for share in (-1.0, -0.5, 0.5, 1.0):
                data, speed = mujoco.MjData(model), line["input_speed_rad_per_s"] / ratio
                data.qvel[drive.dofadr[0]] = speed
                load, taken = share * joint["rated_torque_n_m"], []
                for step in range(4000):
                    data.qfrc_applied[gear.dofadr[0]] = data.qfrc_applied[drive.dofadr[0]] = 0
                    data.xfrc_applied[model.body(f"flange_{name}").id, 5] = -load * min(1, step / 1000)
                    # A motor with constant speed.
                    data.ctrl[motor] = gain * (speed - data.qvel[drive.dofadr[0]])
                    friction.update(data)
                    mujoco.mj_step(model, data)
                    if step >= 3000:
                        taken.append(data.ctrl[motor])
                if load > 0:
                    expected = load / line["efficiency"][0] + ratio * line["friction_n_m"][0]
                else:
                    expected = load * line["efficiency"][1] + ratio * line["friction_n_m"][1]
                worst = max(worst, abs(np.mean(taken) - expected))
        # The fit's own largest residual, and for the servo and the solver's friction 1 N m, of small joints 1 %.
        check(f"joint_mujoco.py, {state['hours']:g} h: motor torque off the bench's, N m", worst,
              state["friction"]["residual_max_n_m"] + min(1, 0.01 * joint["rated_torque_n_m"]))  # fmt: skip


def check_mujoco(place, joint):
    rated = joint["rated_torque_n_m"]
    for state in joint["states"]:
        elements = state["hysteresis"]["elements"]
        half = sum(e["torque_n_m"] + 0.5 * rated * e["torque_per_load"] for e in elements)
        for grows in (False, True):
            what = f"MuJoCo {mujoco.__version__}, {state['hours']:g} h" + ", joint_mujoco.py" * grows
            lost, stiffness = measured(place, state["hours"], rated, grows)
            print(
                f"     {what}: lost motion {lost / ARCMIN:.4f}' (bench {state['lost_motion_rad'] / ARCMIN:.4f}'), "
                f"stiffness {stiffness * ARCMIN:.2f} N m/' (bench {state['stiffness_n_m_per_rad'] * ARCMIN:.2f})"
            )
            check(f"{what}: lost motion", abs(lost / state["lost_motion_rad"] - 1), 0.05)
            # The file alone has less than the friction under load, where that would hold the joint within its play.
            if half > 0.015 * rated and not grows:
                continue
            check(f"{what}: stiffness", abs(stiffness / state["stiffness_n_m_per_rad"] - 1), 0.05)
            # Of an arm of the weight of the example in the book, where the joint is of its size, and of the load that
            # the export is meant for.
            for load in [12.0] * (rated > 100) + [joint["load_inertia_kg_m2"]]:
                ratio = damping_ratio(place, state["hours"], rated, load, stiffness, grows)
                wanted = state["damping_ratio"]
                print(f"     {what}: damping ratio of {load:g} kg m2 {ratio:.4f} (hysteresis {wanted:.4f})")
                check(f"{what}: damping ratio of {load:g} kg m2 off that of the hysteresis", abs(ratio - wanted), 0.015)
    # The complete model at its own time step: the motion remains finite and small over a second with a cyclic torque.
    model = mujoco.MjModel.from_xml_path(str(place / "joint.mjcf.xml"))
    data = mujoco.MjData(model)
    largest = 0.0
    for step in range(round(1 / model.opt.timestep)):
        data.ctrl[:] = rated * math.sin(2 * math.pi * 5 * step * model.opt.timestep)
        mujoco.mj_step(model, data)
        largest = max(largest, float(np.abs(data.sensordata).max()))
    check("free run: largest wind-up over that at rated torque", largest * 0.5 * stiffness / rated, 2)
    check("free run: warnings", sum(int(w.number) for w in data.warning), 0)


URDF = {"robot", "link", "inertial", "mass", "inertia", "joint", "parent", "child", "axis", "limit", "dynamics"}
URDF |= {"transmission", "type", "hardwareInterface", "actuator", "mechanicalReduction"}


def check_texts(place, joint):
    """URDF, SDF, Modelica and MATLAB as texts: elements, order and numbers, without execution."""
    robot = ElementTree.parse(place / "joint.urdf").getroot()
    check("URDF: unknown elements", sum(e.tag not in URDF for e in robot.iter()), 0)
    links = {link.get("name") for link in robot.findall("link")}
    children = [j.find("child").get("link") for j in robot.findall("joint")]
    parents = [j.find("parent").get("link") for j in robot.findall("joint")]
    check("URDF: links that are no tree", len(links - set(children)) - 1 + len(children) - len(set(children)), 0)
    check("URDF: parents that are no links", sum(p not in links for p in parents), 0)
    reductions = [float(e.text) for e in robot.iter("mechanicalReduction")]
    check("URDF: reduction", max(abs(r - joint["ratio"]) for r in reductions), 1e-6)
    for state in joint["states"]:
        name = label(state["hours"])
        gear = next(j for j in robot.findall("joint") if j.get("name") == f"gear_{name}")
        upper = state["hysteresis"]["zero_rad"] + state["hysteresis"]["curve"]["half_gap_rad"]
        check(f"URDF {name}: dead band", abs(float(gear.find("limit").get("upper")) - upper), 1e-8 * (1 + upper))

    sdf = ElementTree.parse(place / "joint.sdf").getroot()
    check("SDF: version not 1.10", int(sdf.get("version") != "1.10"), 0)
    check("SDF: models", abs(len(sdf.findall("world/model")) - len(joint["states"])), 0)
    for model in sdf.findall("world/model"):
        links = {link.get("name") for link in model.findall("link")} | {"world"}
        wrong = [j for j in model.findall("joint") if {j.find("parent").text, j.find("child").text} - links]
        check(f"SDF {model.get('name')}: joints without links", len(wrong), 0)

    modelica = (place / "joint.mo").read_text()
    name = re.search(r"^package (\w+)", modelica, re.M)[1]
    check("Modelica: package not closed", int(not modelica.rstrip().endswith(f"end {name};")), 0)
    for opening, closing in ("()", "[]", "{}"):
        check(f"Modelica: {opening}{closing} unbalanced", abs(modelica.count(opening) - modelica.count(closing)), 0)
    opened = re.findall(r"^\s*(?:record|model|package) (\w+)", modelica, re.M)
    closed = re.findall(r"^\s*end (\w+);", modelica, re.M)
    check("Modelica: classes not closed", len(set(opened) ^ set(closed)), 0)
    for table in re.findall(r"lossTable = \[([^\]]*)\]", modelica):
        rows = [[float(cell) for cell in row.split(",")] for row in table.split(";")]
        check("Modelica: rows of a loss table without five columns", sum(len(row) != 5 for row in rows), 0)
        speeds = [row[0] for row in rows]
        check("Modelica: loss table does not start at 0 and rise", int(speeds[0] != 0 or speeds != sorted(set(speeds))), 0)
        check("Modelica: efficiencies outside of 0 to 1", sum(not 0 < eta < 1 for row in rows for eta in row[1:3]), 0)
    ratio = [float(text) for text in re.findall(r"ratio = ([-0-9.e]+)", modelica)]
    check("Modelica: ratio", max(abs(r - joint["ratio"]) for r in ratio), 1e-6)

    line = re.compile(r"^(%.*|joint\.h\w+\.\w+ = (\[[-0-9.e, ;]+\]|[-0-9.e]+);)$")
    script = (place / "joint.simscape.m").read_text().splitlines()
    check("Simscape: lines of another form", sum(not line.match(text) for text in script), 0)


def check_model(joint):
    """The hysteresis model, implemented independently, compared with the loop to which it was fitted."""
    for state in joint["states"]:
        model, loop = state["hysteresis"], state["torsion_loop"]
        elements = model["elements"]

        def elastic(angle):
            x = angle - model["zero_rad"]
            curve = model["sides"][x < 0]
            k, (t1, t2), gap = curve["stiffness_n_m_per_rad"], curve["torques_n_m"], curve["half_gap_rad"]
            corners = [gap, gap + t1 / k[0], gap + t1 / k[0] + (t2 - t1) / k[1]]
            slopes = [k[0], k[1] - k[0], k[2] - k[1]]
            return math.copysign(sum(s * max(0, abs(x) - c) for s, c in zip(slopes, corners)), x)

        states, last, left = [0.0] * len(elements), loop[0][1], []
        for turn in range(2):
            for torque, angle in loop:
                states = [
                    min(1, max(-1, z + (angle - last) / e["slip_rad"])) for z, e in zip(states, elements)
                ]
                last = angle
                g = elastic(angle)
                slip = sum((e["torque_n_m"] + e["torque_per_load"] * abs(g)) * z for z, e in zip(states, elements))
                if turn == 1:
                    left.append(torque - g - slip)
        rms = math.sqrt(np.mean(np.square(left)))
        what = f"hysteresis model, {state['hours']:g} h"
        check(f"{what}: residual against the one stated, N m", abs(rms - model["residual_rms_n_m"]), 1e-6)
        check(f"{what}: residual over rated torque", rms / joint["rated_torque_n_m"], 0.02)


def main():
    place = Path(sys.argv[1])
    joint = json.loads((place / "joint.json").read_text())
    check_model(joint)
    check_mujoco(place, joint)
    check_friction(place, joint)
    check_texts(place, joint)
    print("all kept" if failures == 0 else f"{failures} not kept")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
