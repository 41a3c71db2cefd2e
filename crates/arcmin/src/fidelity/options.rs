use crate::design::{Choice, Stated, default, default_word, optional, options};
use crate::dynamics::FlexibleOptions;

/// Largest seed, 2⁵³ − 1: files store seeds as doubles, which represent all whole numbers exactly up to this one.
pub(crate) const LARGEST_SEED: f64 = 9_007_199_254_740_991.0;

options! {
    /// How finely the machine is modelled.
    pub struct FidelityOptions {
        /// Joints between the bodies.
        joints: Stated<Joints> => default_word("ideal"),
        /// Model of the cycloid discs.
        discs: Stated<DiscBodies> => default_word("rigid"),
        /// Model of carrier, housing with pin grooves, crank seats and rims of the disc bores. Elastic bodies need joints in
        /// bearings; they make the discs elastic as well, with windows for the pillars of the carrier.
        bodies: Stated<FrameBodies> => default_word("rigid"),
        /// Manufacturing errors; they need joints in bearings. Left out: the errors of the design's section `errors`, if it has
        /// one.
        errors: Option<ErrorSource> => optional(0.0, 0.0),
        /// Seed of the machine drawn with errors = drawn. Left out: 1.
        seed: Option<usize> => optional(0.0, LARGEST_SEED),
        /// Seed of the batch of the drawn machine. Machines of one batch share a part of their errors.
        batch_seed: Option<usize> => optional(0.0, LARGEST_SEED),
        /// Share of the variance of every tolerance that is common to one batch, 0 to 1.
        batch_share: f64 => default(0.5, 0.0, 1.0),
        /// Elastic discs: type of the finite elements.
        element: Element => default_word("plane-stress"),
        /// Elastic discs: constraint of the bores. Joints in bearings need per-bore.
        bores: Bores => default_word("per-bore"),
        /// Elastic discs: cut-off frequency of the modes. Modes above it contribute their static compliance only.
        mode_frequency_hz: f64 => default(MODE_FREQUENCY, 0.0, 1e6),
        /// Elastic discs: damping ratio of every mode.
        damping_ratio: f64 => default(DAMPING_RATIO, 0.0, 0.99),
        /// Elastic discs: write disc.vtu (ParaView) with mesh, displacement and stress under rated torque, and
        /// the lowest modes.
        vtu: bool => optional(0.0, 0.0),
    }
}

const MODE_FREQUENCY: f64 = 20e3;
const DAMPING_RATIO: f64 = 0.02;

impl FidelityOptions {
    pub(super) fn dynamics(&self) -> FlexibleOptions {
        FlexibleOptions { mode_frequency: self.mode_frequency_hz, damping_ratio: self.damping_ratio }
    }
}

/// How the bodies are joined.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Joints {
    /// Without clearance and compliance.
    Ideal,
    /// Every body free in its bearings.
    Bearings,
}

impl Choice for Joints {
    const WORDS: &'static [(&'static str, &'static str)] =
        &[("ideal", "no clearance, no compliance"), ("bearings", "clearance and compliance of all bearings")];
    const VALUES: &'static [Joints] = &[Joints::Ideal, Joints::Bearings];
}

/// Whether the discs deform.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DiscBodies {
    /// Discs are rigid but for their contacts.
    Rigid,
    /// Finite elements, reduced to modes and flank compliances.
    Elastic,
}

impl Choice for DiscBodies {
    const WORDS: &'static [(&'static str, &'static str)] = &[
        ("rigid", "rigid discs"),
        ("elastic", "finite elements, reduced to modes and compliances of the flank"),
    ];
    const VALUES: &'static [DiscBodies] = &[DiscBodies::Rigid, DiscBodies::Elastic];
}

/// Whether carrier, housing and rims deform.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FrameBodies {
    /// Carrier, housing and rims are rigid.
    Rigid,
    /// Finite elements of the design's solids, condensed to their seats.
    Elastic,
}

impl Choice for FrameBodies {
    const WORDS: &'static [(&'static str, &'static str)] = &[
        ("rigid", "rigid carrier and housing"),
        ("elastic", "finite elements of the solids, condensed to their interfaces"),
    ];
    const VALUES: &'static [FrameBodies] = &[FrameBodies::Rigid, FrameBodies::Elastic];
}

/// Source of the manufacturing errors.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ErrorSource {
    /// Those of the design's `[errors]`.
    Given,
    /// Drawn from the design's `[tolerances]`.
    Drawn,
    /// The nominal machine.
    None,
}

impl Choice for ErrorSource {
    const WORDS: &'static [(&'static str, &'static str)] = &[
        ("given", "errors of the design's section [errors]"),
        ("drawn", "errors drawn from the design's section [tolerances] with a seed"),
        ("none", "nominal machine"),
    ];
    const VALUES: &'static [ErrorSource] = &[ErrorSource::Given, ErrorSource::Drawn, ErrorSource::None];
}

/// Finite elements of an elastic disc.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Element {
    /// Six-node triangles in plane stress.
    PlaneStress,
    /// Ten-node tetrahedra through the width.
    Solid,
}

impl Choice for Element {
    const WORDS: &'static [(&'static str, &'static str)] = &[
        ("plane-stress", "six-node triangles in plane stress"),
        ("solid", "ten-node tetrahedra through the width"),
    ];
    const VALUES: &'static [Element] = &[Element::PlaneStress, Element::Solid];
}

/// Support of the bores of an elastic disc.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Bores {
    /// Each bore carries its own bearing.
    PerBore,
    /// One rigid spider for all bores.
    Common,
}

impl Choice for Bores {
    const WORDS: &'static [(&'static str, &'static str)] =
        &[("per-bore", "each bore has its own bearing"), ("common", "one rigid spider connects all bores")];
    const VALUES: &'static [Bores] = &[Bores::PerBore, Bores::Common];
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn defaults_are_those_of_the_model() {
        let options = FidelityOptions::parse("", "options").unwrap();
        assert_eq!(options.dynamics(), FlexibleOptions::default());
        assert_eq!(
            (options.joints.value, options.discs.value, options.errors),
            (Joints::Ideal, DiscBodies::Rigid, None)
        );
    }
}
