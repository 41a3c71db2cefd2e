//! Values printed in the paper.

use crate::machine::Machine;

/// Values printed in the text of Tao2024 (section 4) in arcmin and h; its curves are not digitised.
pub(super) const STE_MEAN_AT_10_UM: f64 = 0.5351;
pub(super) const STE_LARGEST: (f64, f64) = (6450.0, 4.11);
pub(super) const DTE_MEAN_AT_10_UM: f64 = 0.2278;
pub(super) const DTE_EXCURSION_AT_10_UM: f64 = 5.2;
pub(super) const DTE_LARGEST: (f64, f64) = (6450.0, 3.51);
pub(super) const FLEXIBLE_MEAN_AT_10_UM: f64 = 1.7342;
pub(super) const FLEXIBLE_MAX_AT_10_UM: f64 = 7.5;
pub(super) const FLEXIBLE_LARGEST: (f64, f64) = (7500.0, 6.77);

/// The paper's numbers belong to its own machine only.
pub(super) fn is_its_machine(machine: &Machine) -> bool {
    let near = |value: f64, of: f64| (value / of - 1.0).abs() < 1e-6;
    machine.ring.pin_count == 40
        && near(machine.ring.pin_circle_radius, 64e-3)
        && near(machine.ring.pin_radius, 3e-3)
        && near(machine.crankshafts.eccentricity, 1.3e-3)
}
