# Written by python/tools/stubs.py from what the library declares.

import os
from collections.abc import Mapping, Sequence
from typing import Any, Literal

from arcmin._arcmin import Design
from arcmin._progress import Progress
from arcmin._results import Result

# A path, or the columns of the table themselves.
_File = str | os.PathLike[str] | Mapping[str, Any]

registry: list[dict[str, Any]]

__all__ = [
    "check",
    "CheckResult",
    "profile",
    "ProfileResult",
    "contact",
    "ContactResult",
    "wear",
    "WearResult",
    "calibrate",
    "CalibrateResult",
    "simulate",
    "SimulateResult",
    "rig",
    "RigResult",
    "life",
    "LifeResult",
    "tao2024",
    "Tao2024Result",
]

class CheckResult(Result):
    @property
    def errors(self) -> Any: ...
    @property
    def warnings(self) -> Any: ...
    @property
    def checks(self) -> Any: ...
    @property
    def findings(self) -> Any: ...

def check(
    design: Design | str | os.PathLike[str],
    *,
    explain: bool = False,
    progress: Progress = None,
    threads: int | None = None,
) -> CheckResult: ...

class ProfileResult(Result):
    @property
    def ratio(self) -> Any: ...
    @property
    def short_width_coefficient(self) -> Any: ...
    @property
    def inflection_deg(self) -> Any: ...
    @property
    def min_convex_flank_radius_mm(self) -> Any: ...
    @property
    def min_convex_flank_radius_at_deg(self) -> Any: ...
    @property
    def wear_um(self) -> Any: ...
    @property
    def points_per_lobe(self) -> Any: ...

def profile(
    design: Design | str | os.PathLike[str],
    *,
    points: int = 200,
    wear_um: float = 0.0,
    progress: Progress = None,
    threads: int | None = None,
) -> ProfileResult: ...

class ContactResult(Result):
    @property
    def method(self) -> Any: ...
    @property
    def torque_n_m(self) -> Any: ...
    @property
    def friction(self) -> Any: ...
    @property
    def hours(self) -> Any: ...
    @property
    def wear_um(self) -> Any: ...
    @property
    def max_force_n(self) -> Any: ...
    @property
    def loaded_pairs(self) -> Any: ...
    @property
    def max_pressure_mpa(self) -> Any: ...
    @property
    def te_loaded_arcmin(self) -> Any: ...
    @property
    def te_loaded_peak_to_peak_arcmin(self) -> Any: ...
    @property
    def play_arcmin(self) -> Any: ...
    @property
    def free_travel_arcmin(self) -> Any: ...
    @property
    def preload_n(self) -> Any: ...
    @property
    def preload_friction_n_m(self) -> Any: ...
    @property
    def torsional_stiffness_n_m_per_arcmin(self) -> Any: ...
    @property
    def disc_torque_shares(self) -> Any: ...
    @property
    def largest_torque_residual_n_m(self) -> Any: ...
    @property
    def joints(self) -> Any: ...
    @property
    def discs(self) -> Any: ...
    @property
    def bodies(self) -> Any: ...

def contact(
    design: Design | str | os.PathLike[str],
    *,
    joints: Literal["ideal", "bearings"] = "ideal",
    discs: Literal["rigid", "elastic"] = "rigid",
    bodies: Literal["rigid", "elastic"] = "rigid",
    errors: Literal["given", "drawn", "none"] | None = None,
    seed: int | None = None,
    batch_seed: int | None = None,
    batch_share: float = 0.5,
    element: Literal["plane-stress", "solid"] = "plane-stress",
    bores: Literal["per-bore", "common"] = "per-bore",
    mode_frequency_hz: float = 20000.0,
    damping_ratio: float = 0.02,
    vtu: bool = False,
    method: Literal["equilibrium", "closed-form"] = "equilibrium",
    torque_nm: float | None = None,
    wear_um: float = 0.0,
    hours: float = 0.0,
    friction: bool = False,
    positions: int = 360,
    progress: Progress = None,
    threads: int | None = None,
) -> ContactResult: ...

class WearResult(Result):
    @property
    def mode(self) -> Any: ...
    @property
    def hours(self) -> Any: ...
    @property
    def max_depth_um(self) -> Any: ...
    @property
    def max_depth_at_deg(self) -> Any: ...
    @property
    def max_pin_depth_um(self) -> Any: ...
    @property
    def play_arcmin(self) -> Any: ...
    @property
    def preload_n(self) -> Any: ...
    @property
    def preload_friction_n_m(self) -> Any: ...
    @property
    def max_force_n(self) -> Any: ...
    @property
    def loaded_pairs(self) -> Any: ...
    @property
    def te_loaded_arcmin(self) -> Any: ...
    @property
    def wear_coefficient_per_pa(self) -> Any: ...
    @property
    def flank_updates(self) -> Any: ...
    @property
    def runs_away_h(self) -> Any: ...
    @property
    def depth_increment_um(self) -> Any: ...
    @property
    def hours_to_50_um(self) -> Any: ...
    @property
    def joints(self) -> Any: ...
    @property
    def discs(self) -> Any: ...
    @property
    def bodies(self) -> Any: ...

def wear(
    design: Design | str | os.PathLike[str],
    *,
    joints: Literal["ideal", "bearings"] = "bearings",
    discs: Literal["rigid", "elastic"] = "rigid",
    bodies: Literal["rigid", "elastic"] = "rigid",
    errors: Literal["given", "drawn", "none"] | None = None,
    seed: int | None = None,
    batch_seed: int | None = None,
    batch_share: float = 0.5,
    element: Literal["plane-stress", "solid"] = "plane-stress",
    bores: Literal["per-bore", "common"] = "per-bore",
    mode_frequency_hz: float = 20000.0,
    damping_ratio: float = 0.02,
    vtu: bool = False,
    mode: Literal["coupled", "tao2024"] = "coupled",
    hours: float | None = None,
    points: int = 30,
    increment_um: float = 0.8,
    progress: Progress = None,
    threads: int | None = None,
) -> WearResult: ...

class CalibrateResult(Result):
    @property
    def wear_coefficient_per_pa(self) -> Any: ...
    @property
    def wear_coefficient_mm2_per_n(self) -> Any: ...
    @property
    def wear_coefficient_low_per_pa(self) -> Any: ...
    @property
    def wear_coefficient_high_per_pa(self) -> Any: ...
    @property
    def confidence(self) -> Any: ...
    @property
    def running_in_factor(self) -> Any: ...
    @property
    def running_in_factor_low(self) -> Any: ...
    @property
    def running_in_factor_high(self) -> Any: ...
    @property
    def running_in_duration_h(self) -> Any: ...
    @property
    def running_in_duration_low_h(self) -> Any: ...
    @property
    def running_in_duration_high_h(self) -> Any: ...
    @property
    def fitted(self) -> Any: ...
    @property
    def relative_rms(self) -> Any: ...
    @property
    def correlations(self) -> Any: ...
    @property
    def cautions(self) -> Any: ...
    @property
    def hours_to_lost_motion_limit(self) -> Any: ...
    @property
    def hours_to_lost_motion_limit_low(self) -> Any: ...
    @property
    def hours_to_lost_motion_limit_high(self) -> Any: ...
    @property
    def remaining_life_h(self) -> Any: ...
    @property
    def remaining_life_low_h(self) -> Any: ...
    @property
    def remaining_life_high_h(self) -> Any: ...
    @property
    def machines(self) -> Any: ...
    @property
    def observations(self) -> Any: ...
    @property
    def joints(self) -> Any: ...
    @property
    def discs(self) -> Any: ...
    @property
    def bodies(self) -> Any: ...

def calibrate(
    design: Design | str | os.PathLike[str],
    data: _File,
    *,
    joints: Literal["ideal", "bearings"] = "bearings",
    discs: Literal["rigid", "elastic"] = "rigid",
    bodies: Literal["rigid", "elastic"] = "rigid",
    errors: Literal["given", "drawn", "none"] | None = None,
    seed: int | None = None,
    batch_seed: int | None = None,
    batch_share: float = 0.5,
    element: Literal["plane-stress", "solid"] = "plane-stress",
    bores: Literal["per-bore", "common"] = "per-bore",
    mode_frequency_hz: float = 20000.0,
    damping_ratio: float = 0.02,
    vtu: bool = False,
    fit_until_h: float | None = None,
    running_in_h: float | None = None,
    fit_running_in: bool = False,
    reading_error_percent: float | None = None,
    progress: Progress = None,
    threads: int | None = None,
) -> CalibrateResult: ...

class SimulateResult(Result):
    @property
    def ratio(self) -> Any: ...
    @property
    def mean_ratio(self) -> Any: ...
    @property
    def hours(self) -> Any: ...
    @property
    def wear_um(self) -> Any: ...
    @property
    def facet_mm(self) -> Any: ...
    @property
    def complete(self) -> Any: ...
    @property
    def error(self) -> Any: ...
    @property
    def reached_s(self) -> Any: ...
    @property
    def orders(self) -> Any: ...
    @property
    def largest_pin_force_n(self) -> Any: ...
    @property
    def joints(self) -> Any: ...
    @property
    def discs(self) -> Any: ...
    @property
    def bodies(self) -> Any: ...

def simulate(
    design: Design | str | os.PathLike[str],
    *,
    joints: Literal["ideal", "bearings"] = "ideal",
    discs: Literal["rigid", "elastic"] = "rigid",
    bodies: Literal["rigid", "elastic"] = "rigid",
    errors: Literal["given", "drawn", "none"] | None = None,
    seed: int | None = None,
    batch_seed: int | None = None,
    batch_share: float = 0.5,
    element: Literal["plane-stress", "solid"] = "plane-stress",
    bores: Literal["per-bore", "common"] = "per-bore",
    mode_frequency_hz: float = 20000.0,
    damping_ratio: float = 0.02,
    vtu: bool = False,
    flank: Literal["smooth", "faceted", "nodes"] = "smooth",
    facet_mm: float = 1.0,
    wear_um: float | None = None,
    hours: float | None = None,
    load: Literal["none", "constant", "sine", "table", "stepped", "duty-cycle"] = "none",
    torque_nm: float | None = None,
    period_s: float = 0.3,
    load_file: _File | None = None,
    drag_nm: float = 0.0,
    moment_nm: float = 0.0,
    axial_n: float = 0.0,
    radial_n: float = 0.0,
    drive: Literal["speed", "angle", "speed-table", "torque-table", "governed"] = "speed",
    speed_rpm: float | None = None,
    rise_s: float = 0.1,
    drive_file: _File | None = None,
    gain: float = 0.5,
    end_s: float = 0.8,
    window_start_s: float | None = None,
    sample_s: float = 0.0002,
    contact: Literal["line-hertz", "linear", "palmgren", "tao2024", "impact"] | None = None,
    contact_stiffness: float | None = None,
    contact_exponent: float = 1.1,
    tolerance: float = 5e-05,
    fixed_step_s: float | None = None,
    starts: int = 4,
    resume: bool = False,
    progress: Progress = None,
    threads: int | None = None,
) -> SimulateResult: ...

class RigResult(Result):
    @property
    def lost_motion_arcmin(self) -> Any: ...
    @property
    def backlash_arcmin(self) -> Any: ...
    @property
    def stiffness_n_m_per_arcmin(self) -> Any: ...
    @property
    def soft_stiffness_n_m_per_arcmin(self) -> Any: ...
    @property
    def middle_stiffness_n_m_per_arcmin(self) -> Any: ...
    @property
    def hours(self) -> Any: ...
    @property
    def efficiency(self) -> Any: ...
    @property
    def friction_assumed(self) -> Any: ...
    @property
    def no_load_running_torque_n_m(self) -> Any: ...
    @property
    def starting_torque_n_m(self) -> Any: ...
    @property
    def back_driving_torque_n_m(self) -> Any: ...
    @property
    def te_rated_peak_to_peak_arcmin(self) -> Any: ...
    @property
    def te_held_peak_to_peak_arcmin(self) -> Any: ...
    @property
    def max_force_n(self) -> Any: ...
    @property
    def max_pressure_mpa(self) -> Any: ...
    @property
    def transmission_error(self) -> Any: ...
    @property
    def orders(self) -> Any: ...
    @property
    def shortest_bearing_life_h(self) -> Any: ...
    @property
    def wall_s(self) -> Any: ...
    @property
    def joints(self) -> Any: ...
    @property
    def discs(self) -> Any: ...
    @property
    def bodies(self) -> Any: ...

def rig(
    design: Design | str | os.PathLike[str],
    *,
    joints: Literal["ideal", "bearings"] = "bearings",
    discs: Literal["rigid", "elastic"] = "rigid",
    bodies: Literal["rigid", "elastic"] = "rigid",
    errors: Literal["given", "drawn", "none"] | None = None,
    seed: int | None = None,
    batch_seed: int | None = None,
    batch_share: float = 0.5,
    element: Literal["plane-stress", "solid"] = "plane-stress",
    bores: Literal["per-bore", "common"] = "per-bore",
    mode_frequency_hz: float = 20000.0,
    damping_ratio: float = 0.02,
    vtu: bool = False,
    hours: float = 0.0,
    measured: Sequence[_File] | None = None,
    positions: int = 5,
    te_positions: int = 1024,
    moment_nm: float = 0.0,
    axial_n: float = 0.0,
    radial_n: float = 0.0,
    frictionless: bool = False,
    progress: Progress = None,
    threads: int | None = None,
) -> RigResult: ...

class LifeResult(Result):
    @property
    def ratio(self) -> Any: ...
    @property
    def hours_to_limit(self) -> Any: ...
    @property
    def hours_to_lost_motion_limit(self) -> Any: ...
    @property
    def searched_h(self) -> Any: ...
    @property
    def service_life_h(self) -> Any: ...
    @property
    def lost_motion_arcmin(self) -> Any: ...
    @property
    def lost_motion_new_arcmin(self) -> Any: ...
    @property
    def limit_lost_motion_arcmin(self) -> Any: ...
    @property
    def contact_lost_motion_arcmin(self) -> Any: ...
    @property
    def max_depth_um(self) -> Any: ...
    @property
    def max_depth_at_deg(self) -> Any: ...
    @property
    def max_pin_depth_um(self) -> Any: ...
    @property
    def play_arcmin(self) -> Any: ...
    @property
    def te_no_load_arcmin(self) -> Any: ...
    @property
    def te_loaded_arcmin(self) -> Any: ...
    @property
    def te_loaded_peak_to_peak_arcmin(self) -> Any: ...
    @property
    def preload_n(self) -> Any: ...
    @property
    def preload_friction_n_m(self) -> Any: ...
    @property
    def ste_mean_arcmin(self) -> Any: ...
    @property
    def ste_max_arcmin(self) -> Any: ...
    @property
    def dte_mean_arcmin(self) -> Any: ...
    @property
    def dte_max_arcmin(self) -> Any: ...
    @property
    def max_force_n(self) -> Any: ...
    @property
    def max_pressure_mpa(self) -> Any: ...
    @property
    def loaded_pairs(self) -> Any: ...
    @property
    def bearing_system_life_h(self) -> Any: ...
    @property
    def wear_coefficient_per_pa(self) -> Any: ...
    @property
    def flank_updates(self) -> Any: ...
    @property
    def advice(self) -> Any: ...
    @property
    def stages(self) -> Any: ...
    @property
    def joints(self) -> Any: ...
    @property
    def discs(self) -> Any: ...
    @property
    def bodies(self) -> Any: ...

def life(
    design: Design | str | os.PathLike[str],
    *,
    joints: Literal["ideal", "bearings"] = "bearings",
    discs: Literal["rigid", "elastic"] = "rigid",
    bodies: Literal["rigid", "elastic"] = "rigid",
    errors: Literal["given", "drawn", "none"] | None = None,
    seed: int | None = None,
    batch_seed: int | None = None,
    batch_share: float = 0.5,
    element: Literal["plane-stress", "solid"] = "plane-stress",
    bores: Literal["per-bore", "common"] = "per-bore",
    mode_frequency_hz: float = 20000.0,
    damping_ratio: float = 0.02,
    vtu: bool = False,
    points: int = 30,
    quasi_static: bool = False,
    progress: Progress = None,
    threads: int | None = None,
) -> LifeResult: ...

class Tao2024Result(Result):
    @property
    def ratio(self) -> Any: ...
    @property
    def hours(self) -> Any: ...
    @property
    def max_depth_um(self) -> Any: ...
    @property
    def play_arcmin(self) -> Any: ...
    @property
    def te_loaded_arcmin(self) -> Any: ...
    @property
    def wear_coefficient_per_pa(self) -> Any: ...
    @property
    def closed_form_settles(self) -> Any: ...
    @property
    def joints(self) -> Any: ...
    @property
    def discs(self) -> Any: ...
    @property
    def bodies(self) -> Any: ...

def tao2024(
    design: Design | str | os.PathLike[str],
    *,
    joints: Literal["ideal", "bearings"] = "ideal",
    discs: Literal["rigid", "elastic"] = "rigid",
    bodies: Literal["rigid", "elastic"] = "rigid",
    errors: Literal["given", "drawn", "none"] | None = None,
    seed: int | None = None,
    batch_seed: int | None = None,
    batch_share: float = 0.5,
    element: Literal["plane-stress", "solid"] = "plane-stress",
    bores: Literal["per-bore", "common"] = "per-bore",
    mode_frequency_hz: float = 20000.0,
    damping_ratio: float = 0.02,
    vtu: bool = False,
    starts: int = 4,
    quasi_static: bool = False,
    progress: Progress = None,
    threads: int | None = None,
) -> Tao2024Result: ...
