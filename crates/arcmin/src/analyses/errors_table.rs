//! Manufacturing errors of the machine computed, as every analysis that has them lists them.

use crate::fidelity::Fidelity;
use crate::geometry::FlankDirection;
use crate::machine::{BoreError, ManufacturingErrors, RunOut};
use crate::results::{Table, TableOf, digits, quantities as q};
use crate::units::{ARCMIN, DEG, UM};

/// One deviation that is not zero, counted as in the design file.
pub(crate) struct Deviation {
    part: String,
    quantity: &'static str,
    value: f64,
    unit: &'static str,
}

/// `errors.csv`.
pub(crate) const TABLE: TableOf<Deviation> = TableOf {
    name: "errors",
    what: "One row per manufacturing error of the machine; parts are counted from 1",
    columns: || {
        vec![
            q::PART.of(|d: &Deviation| d.part.clone().into()),
            q::QUANTITY.of(|d| d.quantity.into()),
            q::VALUE.with(digits(6)).of(|d| d.value.into()),
            q::UNIT.of(|d| d.unit.into()),
        ]
    },
};

/// The table of a machine that has errors.
pub(crate) fn table(fidelity: &Fidelity) -> Option<Table> {
    let deviations = deviations(&fidelity.errors);
    (!deviations.is_empty()).then(|| TABLE.fill(&deviations))
}

fn deviations(e: &ManufacturingErrors) -> Vec<Deviation> {
    let mut found = Vec::new();
    let mut add = |part: &str, quantity: &'static str, value: f64, unit: &'static str| {
        if value != 0.0 {
            found.push(Deviation { part: part.to_owned(), quantity, value, unit });
        }
    };
    add("pin circle", "radius", e.pin_circle_radius / UM, "um");
    add("all pins", "radius", e.pin_radius / UM, "um");
    for (i, pin) in e.pins.iter().enumerate() {
        let part = format!("pin {}", i + 1);
        for (quantity, value) in
            [("radial", pin.radial), ("tangential", pin.tangential), ("radius", pin.radius)]
        {
            add(&part, quantity, value / UM, "um");
        }
    }
    for (j, disc) in e.discs.iter().enumerate() {
        for h in &disc.flank.harmonics {
            let part = format!("disc {} flank, {} order {}", j + 1, direction(h.direction), h.order);
            add(&part, "amplitude", h.amplitude / UM, "um");
            add(&part, "phase", h.phase / DEG, "deg");
        }
        if let Some(measured) = &disc.flank.measured {
            add(&format!("disc {} flank, measured", j + 1), "deepest", measured.deepest().0 / UM, "um");
        }
    }
    for (k, eccentrics) in e.eccentrics.iter().enumerate() {
        for (j, eccentric) in eccentrics.iter().enumerate() {
            let part = format!("eccentric of disc {} on crankshaft {}", j + 1, k + 1);
            add(&part, "eccentricity", eccentric.eccentricity / UM, "um");
            add(&part, "phase", eccentric.phase / ARCMIN, "arcmin");
        }
    }
    let disc_bores = e.discs.iter().enumerate().flat_map(|(j, disc)| {
        let bores = disc.bores.iter().enumerate();
        bores.map(move |(k, bore)| (format!("bore of disc {} for crankshaft {}", j + 1, k + 1), bore))
    });
    let carrier_bores = e.carrier_bores.iter().enumerate();
    let carrier_bores =
        carrier_bores.map(|(k, bore)| (format!("bore of the carrier for crankshaft {}", k + 1), bore));
    for (part, BoreError { radial, tangential, diameter }) in disc_bores.chain(carrier_bores) {
        for (quantity, value) in [("radial", radial), ("tangential", tangential), ("diameter", diameter)] {
            add(&part, quantity, value / UM, "um");
        }
    }
    let numbered = |list: &[RunOut], what: &str| -> Vec<(String, RunOut)> {
        let named = |(k, run_out): (usize, &RunOut)| (format!("{what} of crankshaft {}", k + 1), *run_out);
        list.iter().enumerate().map(named).collect()
    };
    let single = [("pin circle", e.pin_circle_offset), ("carrier", e.carrier), ("sun", e.sun)]
        .map(|(name, run_out)| (name.to_owned(), run_out));
    for (part, RunOut { amplitude, phase }) in
        numbered(&e.journals, "journals").into_iter().chain(numbered(&e.planets, "planet")).chain(single)
    {
        if amplitude != 0.0 {
            add(&part, "run-out", amplitude / UM, "um");
            add(&part, "phase", phase / DEG, "deg");
        }
    }
    found
}

fn direction(direction: FlankDirection) -> &'static str {
    match direction {
        FlankDirection::Normal => "profile",
        FlankDirection::Inwards => "radial",
        FlankDirection::Around => "pitch",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The nominal machine has no table; a drawn one has a row for every part drawn.
    #[test]
    fn only_deviating_parts_are_listed() {
        assert!(table(&Fidelity::ideal()).is_none());
        let design = crate::templates::design("tao2024").unwrap();
        let machine = design.machine();
        let errors = ManufacturingErrors::draw(&machine, &design.drawing_tolerances().unwrap(), 1);
        let table = table(&Fidelity::ideal().with_errors(errors, 1)).unwrap();
        assert!(table.rows() > 3 * machine.ring.pin_count, "{}", table.rows());
    }
}
