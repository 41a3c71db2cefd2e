//! Entries of the summary of `check` for drives of eccentrics: strength, heat, and the play as made.

use super::made::{MadePlay, ToleranceShare, in_arcmin};
use super::strength::{HeatBalance, Strength};
use crate::analyses::check::Check;
use crate::results::{Column, PLAIN, Value, decimals, digits, quantity};
use crate::units::UM;

/// Entries of a summary for the strength of parts, empty if unknown.
pub(in crate::analyses) fn strength_entries() -> Vec<Column<Check>> {
    fn heat(outcome: &Check, of: fn(&HeatBalance) -> f64) -> Value {
        let heat = outcome.strength.as_ref().and_then(|strength| strength.heat.as_ref().ok());
        Value::from(heat.map(of))
    }
    vec![
        quantity("strength.first", PLAIN, "Part that yields first as the torque rises, and its load.").of(
            |o: &Check| {
                let first = o.strength.as_ref().and_then(|strength| strength.order().into_iter().next());
                Value::from(first.map(|first| first.borne.bearing.words(first.borne.ring).join(", ")))
            },
        ),
        quantity("strength.first_torque_n_m", digits(4), "Output torque at which it yields.").of(|o| {
            let first = o.strength.as_ref().and_then(|strength| strength.order().into_iter().next());
            Value::from(first.and_then(|first| first.torque))
        }),
        quantity(
            "strength.order",
            PLAIN,
            "All parts in the order in which they yield, with the columns of strength.csv.",
        )
        .of(|o| o.strength.as_ref().map_or(Value::List(Vec::new()), Strength::order_value)),
        quantity("heat.loss_w", digits(4), "Mean loss over the duty, without a motor.")
            .of(|o| heat(o, |heat| heat.loss)),
        quantity(
            "heat.temperature_c",
            decimals(1),
            "Steady temperature with this loss and that of a motor, by [thermal].",
        )
        .of(|o| heat(o, |heat| heat.temperature)),
    ]
}

/// Entries of a summary for the play as made, empty without tolerances.
pub(in crate::analyses) fn made_entries() -> Vec<Column<Check>> {
    fn in_um(outcome: &Check, share: f64) -> Value {
        let depth = outcome.made.as_ref().and_then(|made| made.overlaps.quantile(share));
        Value::from(depth.map(|depth| depth / UM))
    }
    fn made(outcome: &Check, of: fn(&MadePlay) -> Option<f64>) -> Value {
        in_arcmin(outcome.made.as_ref().and_then(of))
    }
    vec![
        quantity(
            "play_as_made.nominal_arcmin",
            decimals(3),
            "Two-sided play of the drive without errors, from the gaps of all contacts: the least over a turn of \
                 the output.",
        )
        .of(|o| made(o, |made| made.nominal)),
        quantity(
            "play_as_made.systematic_arcmin",
            decimals(3),
            "The same with the systematic deviations of [process], without scatter. Empty without such deviations, \
                 or if the drive jams with them.",
        )
        .of(|o| made(o, |made| made.systematic.flatten())),
        quantity(
            "play_as_made.mean_arcmin",
            decimals(3),
            "The same for drives drawn from the tolerances: mean of those that do not jam.",
        )
        .of(|o| made(o, |made| made.drawn.mean())),
        quantity("play_as_made.low_arcmin", decimals(3), "5 % of these drives have less.")
            .of(|o| made(o, |made| made.drawn.quantile(0.05))),
        quantity("play_as_made.high_arcmin", decimals(3), "5 % of these drives have more.")
            .of(|o| made(o, |made| made.drawn.quantile(0.95))),
        quantity(
            "play_as_made.jam_rate",
            decimals(4),
            "Share of the drawn drives that jam: at some position of the input no position of the discs leaves all \
                 gaps open.",
        )
        .of(|o| Value::from(o.made.as_ref().map(|made| made.drawn.jam_rate))),
        quantity(
            "play_as_made.overlap_median_um",
            decimals(2),
            "Depth to be removed equally from all flanks and walls of holes so that a jammed drive is free: median \
                 of these drives.",
        )
        .of(|o| in_um(o, 0.5)),
        quantity("play_as_made.overlap_high_um", decimals(2), "The same: 95 % quantile of the drives that jam.")
            .of(|o| in_um(o, 0.95)),
        quantity(
            "play_as_made.overlap_place",
            PLAIN,
            "Place of most overlaps: ring pins (ring teeth of a ring of one piece), output pins, or both if neither \
                 alone suffices.",
        )
        .of(|o| {
            let found = o.made.as_ref().and_then(|made| Some((made.overlaps.place()?.0, made.ring)));
            Value::from(found.map(|(place, ring)| place.words(ring)))
        }),
        quantity(
            "play_as_made.tighten_first",
            PLAIN,
            "Tolerance with the largest share of the variance of the play.",
        )
        .of(|o| {
            let first = o.made.as_ref().and_then(|made| made.tolerances.first());
            Value::from(first.map(ToleranceShare::path))
        }),
    ]
}
