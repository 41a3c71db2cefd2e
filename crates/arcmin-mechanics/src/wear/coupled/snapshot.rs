use super::CoupledOptions;
use crate::geometry::Relief;
use crate::load::{Meshing, ShareLoad};
use crate::machine::Machine;

/// Worn surfaces at one exposure.
///
/// One flank serves all lobes of a disc, since every lobe meets every pin within a turn of the output. Where
/// all discs are alike it serves all of them, and one pin all pins; with manufacturing errors that tell them
/// apart there is a flank per disc, and per disc every pin.
#[derive(Debug, Clone, PartialEq)]
pub struct WearSnapshot {
    /// x = ∫ k dt in s/Pa.
    pub exposure: f64,
    /// Depth lost by the flank as a function of the meshing angle: of all discs, or per disc.
    pub flanks: Vec<Relief>,
    /// Depth lost by the pins as a function of the pin angle: of all pins, or pin by pin for the first disc,
    /// then the next.
    pub pins: Vec<Relief>,
    /// The same as the contact sees them: averaged over its width.
    pub(super) flanks_seen: Vec<Relief>,
    pub(super) pins_seen: Vec<Relief>,
}

impl WearSnapshot {
    pub(super) fn unworn(options: &CoupledOptions, flanks: usize, pins: usize) -> WearSnapshot {
        let flanks = vec![Relief::from_samples(vec![0.0; options.flank_points]); flanks];
        let pins = vec![Relief::from_samples(vec![0.0; options.pin_points]); pins];
        WearSnapshot { exposure: 0.0, flanks_seen: flanks.clone(), pins_seen: pins.clone(), flanks, pins }
    }

    /// The same depth (m) off every flank, pins as new.
    pub fn uniform(depth: f64) -> WearSnapshot {
        let (flanks, pins) = (vec![Relief::uniform(depth)], vec![Relief::uniform(0.0)]);
        WearSnapshot { exposure: 0.0, flanks_seen: flanks.clone(), pins_seen: pins.clone(), flanks, pins }
    }

    /// The flank with the deepest wear.
    pub fn flank(&self) -> &Relief {
        deepest(&self.flanks)
    }

    /// The pin that has lost most.
    pub fn pin(&self) -> &Relief {
        deepest(&self.pins)
    }

    /// Depth of the (first) flank averaged over the width of the contact: what load sharing and dynamics use.
    pub fn flank_seen_by_contact(&self) -> &Relief {
        &self.flanks_seen[0]
    }

    /// Depths of the flanks averaged over the width of the contact: of all discs, or per disc.
    pub fn flanks_seen_by_contact(&self) -> &[Relief] {
        &self.flanks_seen
    }

    /// Depths of the pins averaged over the width of the contact: of all pins, or pin by pin for the first
    /// disc, then the next.
    pub fn pins_seen_by_contact(&self) -> &[Relief] {
        &self.pins_seen
    }

    /// Depth of the (first) pin averaged over the width of the contact.
    pub fn pin_seen_by_contact(&self) -> &Relief {
        &self.pins_seen[0]
    }

    /// One pin of a ring of `count` as the contact sees it when it meets a disc.
    pub(super) fn pin_seen(&self, disc: usize, pin: usize, count: usize) -> &Relief {
        &self.pins_seen[if self.pins_seen.len() == 1 { 0 } else { disc * count + pin }]
    }

    /// Puts the worn surfaces, as the contact sees them, on top of the designed relief.
    pub fn put_on<S: ShareLoad>(&self, designed: &Relief, meshing: &mut S) {
        let flanks = self.flanks_seen.iter().map(|flank| designed.plus(flank)).collect();
        meshing.set_surfaces(flanks, self.pins_seen.clone());
    }

    /// The same on joints that look at another ring of the same drive than this one.
    pub fn put_on_other<S: ShareLoad>(&self, ring: usize, designed: &Relief, meshing: &mut S) {
        let flanks = self.flanks_seen.iter().map(|flank| designed.plus(flank)).collect();
        meshing.set_other_surfaces(ring, flanks, self.pins_seen.clone());
    }

    /// Meshing of a machine with these worn surfaces.
    pub fn meshing(&self, machine: &Machine) -> Meshing {
        let mut meshing = machine.meshing(self.flank_seen_by_contact());
        meshing.set_pin_relief(self.pin_seen_by_contact().clone());
        meshing
    }
}

/// Of several with the same depth the first.
fn deepest(reliefs: &[Relief]) -> &Relief {
    reliefs[1..].iter().fold(&reliefs[0], |deepest, other| {
        if other.deepest().0 > deepest.deepest().0 { other } else { deepest }
    })
}
