use crate::dynamics::SpectrumLine;
use crate::machine::{Machine, RollerBearing};

/// One order of the transmission error with its usual cause.
#[derive(Debug, Clone, PartialEq)]
pub struct NamedOrder {
    /// Order, periods per turn of the output.
    pub order: usize,
    /// Amplitude in rad.
    pub amplitude: f64,
    /// All causes of this order, which one turn cannot distinguish, separated by "; or".
    pub cause: String,
}

/// The strongest orders, largest first, each with its likely causes. `samples` is the number of positions of
/// the measured turn: orders above half of them are aliased.
pub fn name_orders(
    spectrum: &[SpectrumLine],
    machine: &Machine,
    samples: usize,
    count: usize,
) -> Vec<NamedOrder> {
    /// Lines below this part of the largest are not listed.
    const SMALLEST_LISTED: f64 = 0.002;
    let mut lines: Vec<&SpectrumLine> =
        spectrum.iter().filter(|line| line.order > 0 && 2 * line.order <= samples).collect();
    lines.sort_by(|a, b| b.amplitude.total_cmp(&a.amplitude));
    let least = SMALLEST_LISTED * lines.first().map_or(0.0, |line| line.amplitude);
    let named = |line: &SpectrumLine| {
        let causes = causes(machine, line.order, samples);
        NamedOrder {
            order: line.order,
            amplitude: line.amplitude,
            cause: if causes.is_empty() { "no single cause known".to_owned() } else { causes.join("; or ") },
        }
    };
    lines.into_iter().take(count).filter(|line| line.amplitude > least).map(named).collect()
}

/// All causes of an order within the resolution of one output turn, the most direct ones first.
///
/// Errors fixed to the housing appear at multiples of z_c, since the crankshafts turn z_c times relative to the
/// ring; errors that rotate with the carrier appear at multiples of z_p. Their combinations give sums and
/// differences.
fn causes(machine: &Machine, order: usize, samples: usize) -> Vec<String> {
    let is = |value: f64| (order as f64 - value).abs() < 0.5;
    let (pins, discs, cranks) = (machine.ring.pin_count, machine.disc_count, machine.crankshafts.count);
    let lobes = pins - 1;
    let sun = machine.kinematics().housing_fixed_ratio() - 1.0;
    let times = |multiple: usize, base: &str| {
        if multiple == 1 { base.to_owned() } else { format!("{multiple} × {base}") }
    };
    let mut found = Vec::new();
    if order == 1 {
        found.push("ring and carrier together (z_p − z_c): run-out or bores of the carrier with run-out of the ring; outside of the machine, run-out of a coupling or encoder".to_owned());
    }
    if order == cranks && cranks > 1 {
        found.push(format!(
            "{cranks} crankshafts passing errors fixed to the housing: centre of the pin circle"
        ));
    }
    if order.is_multiple_of(lobes) {
        let multiple = order / lobes;
        let met = if multiple.is_multiple_of(discs) && discs > 1 {
            format!(" (each meshes with {discs} discs per turn of the crankshafts)")
        } else {
            String::new()
        };
        found.push(format!(
            "ring, {}: position or size of pins{met}, centre and roundness of the pin circle",
            times(multiple, &format!("z_c ({lobes})"))
        ));
    }
    if order.is_multiple_of(pins) {
        let multiple = order / pins;
        let base = times(multiple, &format!("z_p ({pins})"));
        found.push(match multiple {
            1 => {
                format!("{base}: run-out or pitch of a disc, an eccentric, a journal, or run-out of a planet")
            }
            _ => format!(
                "{base}: pitch of a disc in {multiple} waves, multiples of eccentrics, journals and planets"
            ),
        });
        if multiple.is_multiple_of(cranks.max(2)) {
            found.push(
                "variation of stiffness of bearings and shafts with the rotating load, without any error"
                    .to_owned(),
            );
        }
    }
    if is(sun) {
        found.push("run-out of the sun (its turn against the carrier, i − 1)".to_owned());
    }
    if is(sun + 1.0) {
        found.push("run-out of the sun relative to the housing (i)".to_owned());
    }
    let folded = |value: f64| (value - samples as f64 * (value / samples as f64).round()).abs();
    for (value, what) in [
        ((lobes * pins) as f64, "pins passing lobes (z_c z_p)"),
        (sun * machine.gear_stage.sun_teeth as f64, "tooth mesh of sun and planets (z_1 (i − 1))"),
    ] {
        if is(value) {
            found.push(what.to_owned());
        } else if value > 0.5 * samples as f64 && is(folded(value)) {
            found.push(format!("{what}, {value:.0}, aliased by {samples} positions"));
        }
    }
    for (bearing, what) in [
        (&machine.bearings.turning_arm, "turning-arm bearings"),
        (&machine.bearings.crank_support, "crank supports"),
    ] {
        let passing = rollers_passing(bearing, pins);
        if let Some(shift) = (0..=8)
            .find(|shift| is((passing - (shift * pins) as f64).abs()) || is(passing + (shift * pins) as f64))
        {
            let with = if shift == 0 { String::new() } else { format!(", with {}", times(shift, "z_p")) };
            found.push(format!("rolling elements of the {what} ({passing:.1}{with})"));
        }
    }
    if found.is_empty() {
        let pairs = (1..=4_usize).flat_map(|a| (1..=4_usize).map(move |b| (a, b)));
        if let Some((a, b)) = pairs
            .filter(|(a, b)| order == a * lobes + b * pins || order == (a * lobes).abs_diff(b * pins))
            .min_by_key(|(a, b)| a + b)
        {
            let sign = if order == a * lobes + b * pins { '+' } else { '−' };
            found.push(format!(
                "ring and turning parts together ({} {sign} {})",
                times(b, "z_p"),
                times(a, "z_c")
            ));
        }
    }
    found
}

/// Passes of rolling elements at a point of the carrier (and of a disc) per output turn: Z w z_p. The inner
/// ring turns z_p times relative to the outer one and the cage follows by w = (1 − d cos α/D)/2.
fn rollers_passing(bearing: &RollerBearing, pins: usize) -> f64 {
    let share = 0.5 * (1.0 - bearing.roller_diameter * bearing.contact_angle.cos() / bearing.pitch_diameter);
    bearing.roller_count as f64 * share * pins as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_cause_within_the_resolution_is_named() {
        let machine = crate::templates::tao2024();
        let of = |order| causes(&machine, order, 1024).join(" | ");
        assert!(of(40).contains("z_p (40): run-out or pitch of a disc") && !of(40).contains("z_c"));
        assert!(
            of(39).starts_with("ring, z_c (39)")
                && of(78).contains("2 × z_c (39)")
                && of(78).contains("meshes with 2 discs")
        );
        // 80 has three causes, 81 is the run-out of the sun, 78 has neither.
        for word in ["2 × z_p (40)", "the rotating load", "run-out of the sun (its turn against the carrier"]
        {
            assert!(of(80).contains(word), "{word}: {}", of(80));
        }
        assert!(of(81).starts_with("run-out of the sun") && !of(78).contains("sun"));
        // 14 rollers, w = 0.4: 224 per output turn; 240 − 224 = 16 and 224 − 160 = 64.
        for order in [224, 16, 64] {
            assert!(of(order).contains("turning-arm bearings (224.0"), "{order}: {}", of(order));
        }
        assert!(
            of(1).contains("z_p − z_c") && of(79).contains("z_p + z_c") && of(2).contains("2 crankshafts")
        );
        // Order 1560 measured at 1024 positions appears at 2·1024 − 1560 = 488; at 4096 positions at 1560.
        assert!(
            of(488).contains("aliased by 1024")
                && causes(&machine, 1560, 4096).join("").contains("pins passing lobes")
        );
        assert!(of(17).is_empty());
    }

    #[test]
    fn strongest_orders_come_first_and_the_weak_have_no_name() {
        let machine = crate::templates::tao2024();
        let line = |order, amplitude| SpectrumLine { order, amplitude };
        let named = name_orders(
            &[line(0, 9.0), line(3, 1e-4), line(17, 0.5), line(40, 1.0), line(900, 3.0)],
            &machine,
            1024,
            8,
        );
        assert_eq!(named.iter().map(|n| n.order).collect::<Vec<_>>(), [40, 17]);
        assert_eq!(named[1].cause, "no single cause known");
    }
}
