# %% [markdown]
# # A robot joint with new and aged reducer: MuJoCo
#
# `arcmin export joint` computes the test bench results of the reducer at some hours and writes a MuJoCo
# model: a hinge for wind-up and backlash. Here the drive is held, with a slow alternating torque at
# the flange.

# %%
import subprocess
import sys
import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import mujoco
import numpy as np

import arcmin

folder = Path(tempfile.mkdtemp())
(folder / "design.toml").write_text(arcmin.Design.template("tao2024").to_toml())
export = [sys.executable, "-m", "arcmin", "export", "joint", "design.toml", "--hours", "0,6000", "--out", "."]
subprocess.run(export, cwd=folder, check=True, capture_output=True)
model = mujoco.MjModel.from_xml_path(str(folder / "joint.mjcf.xml"))


# %%
def wind_up_arcmin(label, torque_n_m=412.0, period_s=4.0):
    """Wind-up against torque over the second of two slow swings."""
    data = mujoco.MjData(model)
    gear, drive = model.joint(f"gear_{label}"), model.joint(f"drive_{label}")
    torques, angles = [], []
    while data.time < 2 * period_s:
        torque = torque_n_m * np.sin(2 * np.pi * data.time / period_s)
        data.qfrc_applied[gear.dofadr[0]] = torque
        mujoco.mj_step(model, data)
        data.qpos[drive.qposadr[0]] = 0.0
        data.qvel[drive.dofadr[0]] = 0.0
        if data.time > period_s:
            torques.append(torque)
            angles.append(data.qpos[gear.qposadr[0]] * 180 / np.pi * 60)
    return np.array(torques), np.array(angles)


# %%
spans = {}
figure, axes = plt.subplots(figsize=(6, 3), layout="constrained")
for label, words in {"h0": "new", "h6000": "after 6000 h"}.items():
    torques, angles = wind_up_arcmin(label)
    axes.plot(angles[::10], torques[::10], label=words)
    near = np.abs(torques) < 0.03 * 412
    spans[label] = float(np.ptp(angles[near]))
    print(f"{label}: {spans[label]:.3f} arcmin within ±3 % of the rated torque, {np.ptp(angles):.3f} in all")
assert spans["h6000"] > spans["h0"] > 0
axes.set(xlabel="wind-up in ′", ylabel="torque in N·m")
axes.legend()
