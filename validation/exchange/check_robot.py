"""Checks `arcmin robot` against Pinocchio (kinematics, inverse dynamics) and MuJoCo (tool deviation).

Usage: check_robot.py DIR ARCMIN JOINT, where JOINT was written by `arcmin export joint DESIGN --hours 0,...`; DIR is for
temporary files. Every check prints its value and limit; the exit status is 1 if a limit is exceeded.
"""

import csv
import json
import math
import os
import subprocess
import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import mujoco
import numpy as np
import pinocchio

failures = 0


def check(what, value, limit):
    global failures
    kept = value <= limit
    failures += not kept
    print(f"{'ok  ' if kept else 'FAIL'} {what}: {value:.3g} (limit {limit:.3g})")


def column_name(axis):
    return "".join(c.lower() if c.isalnum() else "_" for c in axis).strip("_") + "_deg"


def table(path):
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


def run(arcmin, place, text, program):
    place.mkdir(parents=True, exist_ok=True)
    (place / "robot.toml").write_text(text)
    (place / "program.csv").write_text(program)
    command = [arcmin, "robot", "robot.toml", "--out", "out", "--quiet", "--force"]
    subprocess.run(command, cwd=place, check=True)
    return place / "out"


# Base and tip of a chain of revolute joints; other joints are made fixed for both programs.
ROBOTS = [
    ("ur_description/urdf/ur5_robot.urdf", "base_link", "ee_link"),
    ("panda_description/urdf/panda.urdf", "panda_link0", "panda_hand_tcp"),
    ("xarm_description/urdf/xarm7.urdf", "link_base", "link7"),
]


def chain_alone(path, base, tip, target):
    """The URDF with every joint that is not between base and tip made fixed, without meshes; names of the axes."""
    tree = ElementTree.parse(path)
    robot = tree.getroot()
    joints = {joint.find("child").get("link"): joint for joint in robot.findall("joint")}
    chain, link = [], tip
    while link != base:
        joint = joints[link]
        chain.append(joint)
        link = joint.find("parent").get("link")
    for joint in robot.findall("joint"):
        if joint not in chain:
            joint.set("type", "fixed")
        if joint.find("mimic") is not None:
            joint.remove(joint.find("mimic"))
    for link in robot.findall("link"):
        for tag in ("visual", "collision"):
            for node in link.findall(tag):
                link.remove(node)
    for name in ("transmission", "gazebo"):
        for node in robot.findall(name):
            robot.remove(node)
    tree.write(target)
    turning = [joint for joint in reversed(chain) if joint.get("type") != "fixed"]
    return [joint.get("name") for joint in turning]


def motion(model, names, seed):
    """Sums of sine waves within the limits of the joints, 2000 readings at intervals of 1 ms."""
    draw = np.random.default_rng(seed)
    time = 1e-3 * np.arange(2000)
    angles = []
    for name in names:
        joint = model.joints[model.getJointId(name)]
        low, high = -2.0, 2.0
        if joint.nq == 1:
            low = max(model.lowerPositionLimit[joint.idx_q], -2.5)
            high = min(model.upperPositionLimit[joint.idx_q], 2.5)
        waves = sum(
            a * np.sin(2 * math.pi * f * time + p)
            for a, f, p in zip(draw.uniform(0.2, 0.5, 3), (0.2, 0.35, 0.5), draw.uniform(0, 6, 3), strict=True)
        )
        waves *= 0.35 * (high - low) / np.ptp(waves)
        angles.append(0.5 * (low + high) + waves - 0.5 * (waves.max() + waves.min()))
    return time, np.array(angles)


def pinocchio_part(place, arcmin, joint):
    data_home = Path(pinocchio.__file__).parents[4] / "share" / "example-robot-data" / "robots"
    for number, (path, base, tip) in enumerate(ROBOTS):
        home = place / Path(path).stem
        home.mkdir(parents=True, exist_ok=True)
        urdf = home / "arm.urdf"
        names = chain_alone(data_home / path, base, tip, urdf)
        model = pinocchio.buildModelFromUrdf(str(urdf))
        time, angles = motion(model, names, number)
        header = ",".join(["time_s", *map(column_name, names)])
        rows = "\n".join(
            ",".join(map(repr, map(float, [t, *np.degrees(angles[:, k])]))) for k, t in enumerate(time)
        )
        sections = "".join(
            f'[[joint]]\naxis = "{name}"\ntable = "{joint}/joint.json"\nspeed_deg_s = 10000\ntorque_limit_n_m = 1e6\n'
            for name in names
        )
        text = (
            f'name = "{urdf.parent.name}"\nplanned_hours = 1\ngravity_m_s2 = [0, 0, -9.81]\n'
            f'[urdf]\nfile = "arm.urdf"\nbase = "{base}"\ntip = "{tip}"\n[model]\nages = 2\n{sections}'
            '[[program]]\nname = "waves"\nfile = "program.csv"\ncycles_per_hour = 100\n'
        )
        out = run(arcmin, home, text, f"{header}\n{rows}\n")
        data = model.createData()
        found = table(out / "motion.csv")
        by_time = [found[k : k + len(names)] for k in range(0, len(found), len(names))]
        # The base of the chain may be any link of the tree.
        frame = model.getFrameId(tip)
        torque_off, torque_most, place_off = 0.0, 0.0, 0.0
        path_rows = {row["time_s"]: row for row in table(out / "path.csv")}
        for rows_now in by_time:
            q, v, a, tau = pinocchio.neutral(model), np.zeros(model.nv), np.zeros(model.nv), np.zeros(model.nv)
            for row in rows_now:
                j = model.joints[model.getJointId(row["joint"])]
                angle = float(row["angle_rad"])
                if j.nq == 2:
                    q[j.idx_q : j.idx_q + 2] = math.cos(angle), math.sin(angle)
                else:
                    q[j.idx_q] = angle
                v[j.idx_v], a[j.idx_v] = float(row["speed_rad_s"]), float(row["acceleration_rad_s2"])
                tau[j.idx_v] = float(row["torque_n_m"])
            expected = pinocchio.rnea(model, data, q, v, a)
            torque_off = max(torque_off, np.abs(tau - expected).max())
            torque_most = max(torque_most, np.abs(expected).max())
            pinocchio.framesForwardKinematics(model, data, q)
            start = data.oMf[model.getFrameId(base)]
            here = start.actInv(data.oMf[frame].translation)
            row = path_rows[rows_now[0]["time_s"]]
            there = 1e-3 * np.array([float(row[f"{axis}_mm"]) for axis in "xyz"])
            place_off = max(place_off, np.abs(there - here).max())
        print(f"     {urdf.parent.name}: {len(names)} axes, {len(by_time)} postures, up to {torque_most:.0f} N m")
        check(f"{urdf.parent.name}: torques off Pinocchio's, relative", torque_off / torque_most, 1e-10)
        check(f"{urdf.parent.name}: places off Pinocchio's, m", place_off, 1e-10)


MASS, LENGTH, GRAVITY = 25.0, 1.0, 9.80665


def arcmin_arm(place, arcmin, joint, hours):
    """A mass on an arm of one metre that moves slowly over the top and back: time, angle, tangential displacement of the tool
    (new, worn), without transmission error, which the exported joint does not contain."""
    place.mkdir(parents=True, exist_ok=True)
    content = json.loads((joint / "joint.json").read_text())
    for state in content["states"]:
        state["transmission_error"] = []
    (place / "plain.json").write_text(json.dumps(content))
    # Over the top, back to 60°, then rest.
    ways = [(0.0, 180.0, 60.0), (180.0, 60.0, 40.0), (60.0, 60.0, 20.0), (60.0, 0.0, 20.0), (0.0, 0.0, 10.0)]
    lines, now = ["time_s,a_deg"], 0.0
    for start, end, seconds in ways:
        for k in range(round(10 * seconds)):
            x = k / (10 * seconds)
            angle = start + (end - start) * (x - math.sin(2 * math.pi * x) / (2 * math.pi))
            lines.append(f"{now + seconds * x!r},{angle!r}")
        now += seconds
    lines.append(f"{now!r},0.0")
    program = "\n".join(lines) + "\n"
    def text(planned):
        return (
            f'name = "arm"\nplanned_hours = {planned}\ngravity_m_s2 = [0, 0, -{GRAVITY}]\n'
            f'[[axis]]\nname = "a"\ndirection = [0, -1, 0]\nmass_kg = {MASS}\ncentre_mm = [{1000 * LENGTH}, 0, 0]\n'
            'inertia_kg_m2 = [0, 0, 0]\n'
            f'[tool]\nposition_mm = [{1000 * LENGTH}, 0, 0]\n'
            '[[joint]]\naxis = "a"\ntable = "plain.json"\n[controller]\ncompensates = "none"\n[model]\nages = 2\n'
            '[[program]]\nname = "p"\nfile = "program.csv"\ncycles_per_hour = 20\nsmoothing_ms = 0\n'
        )
    out = run(arcmin, place, text(1.0), program)
    moving = float(table(out / "loads.csv")[0]["moving_share"])
    out = run(arcmin, place, text(repr(hours / moving)), program)
    rows = table(out / "path.csv")
    angle = {row["time_s"]: float(row["angle_rad"]) for row in table(out / "motion.csv")}
    time = np.array([float(row["time_s"]) for row in rows])
    angles = np.array([angle[row["time_s"]] for row in rows])
    def along(prefix):
        x, z = ([float(row[f"{prefix}error_{axis}_mm"]) for row in rows] for axis in "xz")
        return 1e-3 * (-np.sin(angles) * x + np.cos(angles) * z)
    return time, angles, along("new_"), along("")


def mujoco_arm(joint, hours, angles):
    """The same arm in MuJoCo on the exported joint of one age, with held input and a rotating direction of gravity, which is
    equivalent at this low speed. Tangential displacement at the given angles in the second cycle."""
    name = "h" + np.format_float_positional(hours, trim="-").replace(".", "_")
    spec = mujoco.MjSpec.from_file(str(joint / "joint.mjcf.xml"))
    for motor in list(spec.actuators):
        spec.delete(motor)
    for hinge in list(spec.joints):
        if hinge.name.startswith("drive_"):
            spec.delete(hinge)
    arm = spec.body(f"flange_{name}").add_body(name="arm")
    arm.mass, arm.ipos, arm.inertia = MASS, [LENGTH, 0, 0], [1e-6, 1e-6, 1e-6]
    arm.explicitinertial = True
    model = spec.compile()
    data = mujoco.MjData(model)
    hinge = model.joint(f"gear_{name}")
    # The masses of the flanges are on their axes; without oscillation the model comes to rest faster.
    model.dof_damping[hinge.dofadr[0]] += 600
    found = []
    for turn in range(2):
        for angle in angles:
            # In the frame of the arm: at an angle of 0 gravity acts against the angle.
            model.opt.gravity[:] = -GRAVITY * np.array([math.sin(angle), math.cos(angle), 0.0])
            for _ in range(60):
                mujoco.mj_step(model, data)
            if turn == 1:
                found.append(LENGTH * data.qpos[hinge.qposadr[0]])
    return np.array(found)


def mujoco_part(place, arcmin, joint):
    hours = json.loads((joint / "joint.json").read_text())["states"][-1]["hours"]
    time, angles, new, worn = arcmin_arm(place / "arm", arcmin, joint, hours)
    for name, age, ours in (("new", 0.0, new), ("worn", hours, worn)):
        theirs = mujoco_arm(joint, age, angles)
        span = np.ptp(theirs)
        moving = time < 100
        held = (time > 110) & (time < 120)
        print(f"     {name}: {1e3 * span:.3f} mm between both sides on a metre, {MASS:g} kg")
        check(f"{name}: slow reversal, tool off MuJoCo's, of the whole way", np.abs(ours - theirs)[moving].max() / span, 0.05)
        check(f"{name}: hold at 60 degrees, off MuJoCo's", abs(ours[held].mean() / theirs[held].mean() - 1), 0.05)


def main():
    place, arcmin, joint = Path(sys.argv[1]).resolve(), os.path.abspath(sys.argv[2]), Path(sys.argv[3]).resolve()
    pinocchio_part(place, arcmin, joint)
    mujoco_part(place, arcmin, joint)
    sys.exit(1 if failures else 0)


main()
