"""A machine driven step by step."""

from __future__ import annotations

import math
import pickle

import pytest

import arcmin


def test_speed_in_angle_out(design: arcmin.Design) -> None:
    sim = arcmin.Simulation(design, load_torque_n_m=100, wear_um=10)
    assert sim.time_s == 0.0 and sim.ratio == 81.0
    state = sim.advance(0.001, motor_speed_rad_s=50)
    for _ in range(9):
        state = sim.advance(0.001)
    assert math.isclose(state.time_s, 0.01) and math.isclose(state.input_angle_rad, 0.5)
    error = (state.output_angle_rad - state.input_angle_rad / 81) * 60 * 180 / math.pi
    assert math.isclose(error, state.transmission_error_arcmin, rel_tol=1e-9)
    assert state.output_torque_n_m == 100


def test_torque_in_angle_out(design: arcmin.Design) -> None:
    """A free motor: the work supplied is stored or dissipated (within 1 %)."""
    sim = arcmin.Simulation(design, motor="torque", wear_um=10)
    work = 0.0
    state = sim.state
    for _ in range(40):
        before = state.input_angle_rad
        state = sim.advance(5e-4, motor_torque_n_m=2.0)
        work += 2.0 * (state.input_angle_rad - before)
    assert state.input_speed_rad_s > 1
    assert state.kinetic_energy_j + state.elastic_energy_j < work * 1.01


def test_steps_do_not_change_the_motion(design: arcmin.Design) -> None:
    fine, coarse = (arcmin.Simulation(design, load_torque_n_m=50, wear_um=5) for _ in range(2))
    fine.set_motor(speed_rad_s=0, acceleration_rad_s2=1000)
    coarse.set_motor(speed_rad_s=0, acceleration_rad_s2=1000)
    for _ in range(16):
        a = fine.advance(2.0**-10)
    b = coarse.advance(2.0**-6)
    assert a.output_angle_rad == b.output_angle_rad and a.output_speed_rad_s == b.output_speed_rad_s


def test_saved_and_pickled_simulations_continue_bit_by_bit(design: arcmin.Design) -> None:
    sim = arcmin.Simulation(design, joints="ideal", load_torque_n_m=100, wear_um=10)
    sim.advance(0.002, motor_speed_rad_s=20)
    saved, other = sim.save(), pickle.loads(pickle.dumps(sim))
    first = sim.advance(0.003).output_angle_rad
    assert other.advance(0.003).output_angle_rad == first
    sim.restore(saved)
    assert sim.time_s == 0.002 and sim.advance(0.003).output_angle_rad == first


def test_wrong_inputs(design: arcmin.Design) -> None:
    sim = arcmin.Simulation(design)
    for wrong in (
        lambda: sim.advance(-1.0),
        lambda: sim.advance(float("nan")),
        lambda: sim.advance(0.001, motor_torque_n_m=1.0),
        lambda: sim.set_motor(speed_rad_s=1, torque_n_m=1),
        lambda: sim.set_load(torque_n_m=float("inf")),
        lambda: arcmin.Simulation(design, motor="hand"),
        lambda: arcmin.Simulation(design, joints="glue"),
        lambda: arcmin.Simulation(design, wear_um=1, hours=1),
        lambda: arcmin.Simulation(design, drag_n_m=-1),
    ):
        with pytest.raises(arcmin.OptionError):
            wrong()
    with pytest.raises(arcmin.ArcminError):
        sim.restore(b"nothing")
    with pytest.raises(TypeError):
        arcmin.Simulation(3)
