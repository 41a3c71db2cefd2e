use crate::dynamics::SpectrumLine;
use crate::machine::Machine;

/// One order of the transmission error with what usually causes it.
#[derive(Debug, Clone, PartialEq)]
pub struct NamedOrder {
    /// Per turn of the output.
    pub order: usize,
    /// rad.
    pub amplitude: f64,
    pub cause: String,
}

/// The strongest orders, largest first, each with its likely cause.
pub fn name_orders(spectrum: &[SpectrumLine], machine: &Machine, count: usize) -> Vec<NamedOrder> {
    let mut lines: Vec<&SpectrumLine> = spectrum.iter().filter(|line| line.order > 0).collect();
    lines.sort_by(|a, b| b.amplitude.total_cmp(&a.amplitude));
    lines.into_iter().take(count).map(|line| NamedOrder { order: line.order, amplitude: line.amplitude, cause: cause(line.order, machine) }).collect()
}

fn cause(order: usize, machine: &Machine) -> String {
    let pins = machine.ring.pin_count;
    let lobes = pins - 1;
    let ratio = machine.kinematics().housing_fixed_ratio().abs();
    let sun_mesh = (ratio - 1.0) * machine.gear_stage.sun_teeth as f64;
    let near = |value: f64| (order as f64 - value).abs() < 0.5;
    let of = |base: usize| order.is_multiple_of(base).then(|| order / base);
    if order == 1 {
        return "carrier: eccentricity, bores, main bearing".to_owned();
    }
    if order == machine.crankshafts.count {
        return "position of the crankshafts or their bores".to_owned();
    }
    if near(ratio) {
        return "run-out of the sun".to_owned();
    }
    if near(ratio - 1.0) {
        let turns = (ratio - 1.0) / pins as f64;
        return format!(
            "run-out of the sun against the carrier; {turns:.0} × crankshaft turn: stiffness of bearings and shafts as the load goes round"
        );
    }
    if near(sun_mesh) {
        return "tooth mesh of sun and planets".to_owned();
    }
    if let Some(multiple) = of(pins) {
        let what = String::from("pins: pitch, radius, pin circle; planet run-out, which turns as often against the carrier");
        return if multiple == 1 { what } else { format!("{multiple} × {pins}: {what}") };
    }
    if let Some(multiple) = of(lobes) {
        let what = "disc: profile, pitch, eccentricity, bores";
        return if multiple == 1 { what.to_owned() } else { format!("{multiple} × {lobes}: {what}") };
    }
    if order < 10 { "low order: pin or lobe pitch around the ring".to_owned() } else { "mixed".to_owned() }
}
