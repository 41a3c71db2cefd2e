"""Load-dependent friction of a joint of joint.mjcf.xml, updated before every step.

    from joint_mujoco import LoadFriction

    friction = LoadFriction(model, "h0")
    while ...:
        friction.update(data)
        mujoco.mj_step(model, data)

MuJoCo has constant friction. This class updates two values: the friction of hinge 'drive' with the torque of the motor,
c + mean |tau| + difference tau z, where z is the sign of the speed, which reverses within the relaxation; and the slip
torques of hinge 'gear' with the elastic torque. The parameters are those of <custom> in the model.
"""

import math

import mujoco
import numpy as np


class LoadFriction:
    def __init__(self, model, age="h0", prefix=""):
        """For the joint of one age; `prefix` is the prefix of the names of this file in your model."""
        at = lambda kind, name: mujoco.mj_name2id(model, kind, prefix + name)
        kinds = mujoco.mjtObj

        def numeric(name):
            index = at(kinds.mjOBJ_NUMERIC, name)
            if index < 0:
                raise ValueError(f"the model has no numeric {prefix}{name}: copy <custom> of joint.mjcf.xml too")
            start = model.numeric_adr[index]
            return model.numeric_data[start : start + model.numeric_size[index]].copy()

        self.model, self.z = model, 0.0
        self.constant, self.viscous, self.mean, self.difference, self.relaxation = numeric(f"friction_{age}")
        # A model with a fixed input has no hinge 'drive'.
        hinge = at(kinds.mjOBJ_JOINT, f"drive_{age}")
        self.drive = model.jnt_dofadr[hinge] if hinge >= 0 else None
        if hinge >= 0:
            # The file contains the viscous friction without load; here the load-dependent part is separate.
            model.dof_damping[self.drive] = self.viscous
        self.gear = model.jnt_qposadr[at(kinds.mjOBJ_JOINT, f"gear_{age}")]
        self.slips = []
        while (tendon := at(kinds.mjOBJ_TENDON, f"slip{len(self.slips) + 1}_{age}")) >= 0:
            torque, growth = numeric(f"slip_{age}")[2 * len(self.slips) :][:2]
            self.slips.append((tendon, torque, growth))
        curve = [at(kinds.mjOBJ_TENDON, f"{side}{k}_{age}") for side in ("up", "down") for k in (1, 2, 3)]
        self.curve = [t for t in curve if t >= 0]

    def elastic(self, wind_up):
        """Torque of the torsion curve at a wind-up in rad."""
        model = self.model
        low, high = model.tendon_lengthspring[self.curve].T
        return float(np.sum(model.tendon_stiffness[self.curve] * (wind_up - np.clip(wind_up, low, high))))

    def update(self, data):
        if self.drive is not None:
            self.update_drive(data)
        load = abs(self.elastic(data.qpos[self.gear]))
        for tendon, torque, growth in self.slips:
            self.model.tendon_stiffness[tendon] = (torque + growth * load) / self.model.tendon_springyield[tendon]

    def update_drive(self, data):
        model, drive = self.model, self.drive
        speed = data.qvel[drive]
        sign = math.copysign(1.0, speed) if speed else 0.0
        self.z = sign + (self.z - sign) * math.exp(-abs(speed) * model.opt.timestep / self.relaxation)
        motor = data.qfrc_actuator[drive] + data.qfrc_applied[drive]
        grown = self.mean * abs(motor) + self.difference * motor * self.z
        model.dof_frictionloss[drive] = max(0.0, self.constant + grown)
