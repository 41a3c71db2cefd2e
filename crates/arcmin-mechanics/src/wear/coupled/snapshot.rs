use super::CoupledOptions;
use crate::geometry::Relief;
use crate::load::{Meshing, ShareLoad};
use crate::machine::Machine;

/// Worn surfaces at one exposure.
///
/// All lobes of a disc have the same flank, because every lobe meets every pin within a turn of the output. If
/// all discs are equal, one flank represents all of them and one pin all pins; with manufacturing errors that
/// make them different there is one flank for each disc, and for each disc every pin.
#[derive(Debug, Clone, PartialEq)]
pub struct WearSnapshot {
    /// x = ∫ k dt in s/Pa.
    pub exposure: f64,
    /// Wear depth of the flank in m as a function of the meshing angle: one for all discs, or one for each
    /// disc.
    pub flanks: Vec<Relief>,
    /// Wear depth of the pins in m as a function of the pin angle: one for all pins, or one for each pin, those
    /// of the first disc before those of the next.
    pub pins: Vec<Relief>,
    /// The same depths averaged over the width of the contact.
    pub(super) effective_flanks: Vec<Relief>,
    pub(super) effective_pins: Vec<Relief>,
}

impl WearSnapshot {
    pub(super) fn unworn(options: &CoupledOptions, flanks: usize, pins: usize) -> WearSnapshot {
        let flanks = vec![Relief::from_samples(vec![0.0; options.flank_points]); flanks];
        let pins = vec![Relief::from_samples(vec![0.0; options.pin_points]); pins];
        WearSnapshot::new(flanks, pins)
    }

    /// Depths that do not vary within the width of the contact, so that the averaged ones are the same.
    fn new(flanks: Vec<Relief>, pins: Vec<Relief>) -> WearSnapshot {
        let (effective_flanks, effective_pins) = (flanks.clone(), pins.clone());
        WearSnapshot { exposure: 0.0, flanks, pins, effective_flanks, effective_pins }
    }

    /// The same wear depth (m) on every flank, without wear of pins.
    pub fn uniform(depth: f64) -> WearSnapshot {
        WearSnapshot::new(vec![Relief::uniform(depth)], vec![Relief::uniform(0.0)])
    }

    /// The flank with the deepest wear.
    pub fn flank(&self) -> &Relief {
        deepest(&self.flanks)
    }

    /// The pin with the deepest wear.
    pub fn pin(&self) -> &Relief {
        deepest(&self.pins)
    }

    /// Depth of the (first) flank averaged over the width of the contact: what load sharing and dynamics use.
    pub fn effective_flank(&self) -> &Relief {
        &self.effective_flanks[0]
    }

    /// Depths of the flanks averaged over the width of the contact: of all discs, or per disc.
    pub fn effective_flanks(&self) -> &[Relief] {
        &self.effective_flanks
    }

    /// Depths of the pins averaged over the width of the contact: of all pins, or pin by pin for the first
    /// disc, then the next.
    pub fn effective_pins(&self) -> &[Relief] {
        &self.effective_pins
    }

    /// Depth of the (first) pin averaged over the width of the contact.
    pub fn effective_pin(&self) -> &Relief {
        &self.effective_pins[0]
    }

    /// The averaged depth of one pin of a ring with `count` pins, for its contact with a disc.
    pub(super) fn effective_pin_of(&self, disc: usize, pin: usize, count: usize) -> &Relief {
        &self.effective_pins[if self.effective_pins.len() == 1 { 0 } else { disc * count + pin }]
    }

    /// Sets the reliefs of the joints: the averaged wear depths added to the designed relief.
    pub fn apply_to<S: ShareLoad>(&self, designed: &Relief, meshing: &mut S) {
        let flanks = self.effective_flanks.iter().map(|flank| designed.plus(flank)).collect();
        meshing.set_surfaces(flanks, self.effective_pins.clone());
    }

    /// The same for joints in which this ring is not the loaded one but another ring of the drive.
    pub fn apply_to_other_ring<S: ShareLoad>(&self, ring: usize, designed: &Relief, meshing: &mut S) {
        let flanks = self.effective_flanks.iter().map(|flank| designed.plus(flank)).collect();
        meshing.set_other_surfaces(ring, flanks, self.effective_pins.clone());
    }

    /// Meshing of a machine with these worn surfaces.
    pub fn meshing(&self, machine: &Machine) -> Meshing {
        let mut meshing = machine.meshing(self.effective_flank());
        meshing.set_pin_relief(self.effective_pin().clone());
        meshing
    }
}

/// The deepest; of several with the same depth the first.
fn deepest(reliefs: &[Relief]) -> &Relief {
    reliefs[1..].iter().fold(&reliefs[0], |deepest, other| {
        if other.deepest().0 > deepest.deepest().0 { other } else { deepest }
    })
}
