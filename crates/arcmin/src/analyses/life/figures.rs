//! Figures of the report of a life.

use super::ages::Age;
use super::{Life, page};
use crate::analyses::wear::stations;
use crate::dynamics::RunResult;
use crate::geometry::Relief;
use crate::life::LifePoint;
use crate::load::Cycle;
use crate::report::{
    Annotation, Axis, Block, Colour, Plot, Series, SolidState, Solids, Style, Tone, compact, depths,
    envelope, positions, significant, thinned,
};
use crate::scene::of_machine;
use crate::units::{ARCMIN, DEG, MPA, UM};

/// Largest number of distinguishable curves in one figure.
const CURVES: usize = 5;
/// Steps of the meshing angle over which the largest value is taken, in degrees.
const STEP_DEG: f64 = 2.5;

fn hours() -> Axis {
    Axis::new("Running time", "h")
}

fn meshing_angle() -> Axis {
    Axis::new("Meshing angle |φ|", "°").between(0.0, 180.0)
}

/// Sign of the meshing angles that carry the rated torque: positive torque loads the negative ones.
fn loaded_side(life: &Life) -> f64 {
    if life.machine.rated.torque < 0.0 { 1.0 } else { -1.0 }
}

fn over(life: &Life, value: impl Fn(&LifePoint) -> f64) -> Vec<(f64, f64)> {
    life.prediction.points.iter().map(|point| (point.hours(), value(point))).collect()
}

fn play(life: &Life) -> Vec<(f64, f64)> {
    let points = life.prediction.points.iter();
    points.filter_map(|point| Some((point.hours(), point.travel?.play.arcmin()))).collect()
}

pub(super) fn accuracy(life: &Life) -> Vec<Block> {
    let mut angles = Plot::new(
        "Accuracy over running time",
        hours(),
        Axis::new("Angle at the output", "arcmin").from_zero(),
    )
    .with(
        Series::line("lost motion of the machine at ±3 % torque", over(life, |p| p.lost_motion.arcmin()))
            .strong()
            .coloured(Colour::Palette(0)),
    )
    .with(
        Series::new("play, one-sided", Style::Dashed, play(life))
            .coloured(Colour::Palette(2)),
    )
    .with(
        Series::line("size of the error at rated torque", over(life, |p| p.accuracy.loaded_error.arcmin().abs()))
            .coloured(Colour::Palette(1)),
    )
    .noted(
        "Lost motion, play and output error in arcmin over the running time in h. Under a torque of constant sign, \
         wear adds a nearly constant lag of the output, which is lost motion when the torque reverses [GBT40731].",
    );
    let limit = life.machine.limits.lost_motion / ARCMIN;
    angles.limit_at(limit, format!("{} arcmin of lost motion allowed", compact(limit, 3)));
    let end = life.last().hours();
    // Far beyond the computed life it would compress the curves.
    if let Some(at) = life.prediction.hours_to_limit.filter(|at| *at <= 1.1 * end) {
        let label = format!("limit reached, {at:.0} h");
        angles.annotations.push(Annotation::Vertical { at, label, tone: Tone::Bad });
    }
    let mut pressure =
        Plot::new("Largest contact pressure", hours(), Axis::new("Pressure", "MPa").from_zero())
            .with(Series::line("largest of all pins", over(life, |p| p.accuracy.max_pressure / MPA)))
            .noted(
                "Largest Hertz pressure in MPa between pin and flank at rated torque over one full period.",
            )
            .half();
    let allowed = life.machine.limits.contact_pressure / MPA;
    pressure.limit_at(allowed, format!("{} MPa allowed", compact(allowed, 4)));
    let pairs = Plot::new("Pins that carry, per disc", hours(), Axis::new("Loaded pairs", "").from_zero())
        .with(Series::line("mean over the cycle", over(life, |p| p.accuracy.loaded_pairs)))
        .noted("Number of loaded pins of one disc at rated torque, mean over the cycle.")
        .half();
    vec![Block::Plot(angles), Block::Plot(pressure), Block::Plot(pairs), Block::Table(page::life_table(life))]
}

/// At most [`CURVES`] of these points.
pub(super) fn shown(points: usize) -> impl Iterator<Item = usize> {
    stations(points, CURVES)
}

/// Points of the prediction with their colours.
fn shown_points(life: &Life) -> Vec<(&LifePoint, Colour)> {
    let points = &life.prediction.points;
    shown(points.len()).map(|index| (&points[index], colour(life, index))).collect()
}

fn colour(life: &Life, index: usize) -> Colour {
    Colour::Ordered(index as f64 / life.prediction.points.len().saturating_sub(1).max(1) as f64)
}

fn name(point: &LifePoint) -> String {
    if point.hours() == 0.0 { "new".to_owned() } else { format!("{:.0} h", point.hours()) }
}

pub(super) fn wear(life: &Life) -> Vec<Block> {
    let depth = Plot::new(
        "Deepest wear over running time",
        hours(),
        Axis::new("Largest depth", "µm").from_zero(),
    )
    .half()
    .with(Series::line("flank", over(life, |p| p.accuracy.max_depth / UM)).strong())
    .noted(format!(
        "Largest wear depth in µm over the running time in h, by the wear law [Archard1953] with k = {} 1/Pa; the \
             worn flank changes the load sharing, which reduces the wear rate.",
        significant(life.prediction.exposure.coefficient, 3)
    ));
    let side = loaded_side(life);
    let along = |flank: &Relief, side: f64| -> Vec<(f64, f64)> {
        let at = |half: i32| (0.5 * f64::from(half), flank.at(side * 0.5 * f64::from(half) * DEG).depth / UM);
        (0..=360).map(at).collect()
    };
    let mut flank =
        Plot::new("Wear along the flank", meshing_angle(), Axis::new("Worn depth", "µm").from_zero()).half();
    for (point, colour) in shown_points(life).into_iter().filter(|(point, _)| point.accuracy.max_depth > 0.0)
    {
        flank.series.push(Series::line(name(point), along(&point.accuracy.flank, side)).coloured(colour));
    }
    let end = life.last();
    let other = along(&end.accuracy.flank, -side);
    // Beyond the contact width next to the root, the other flank wears only if the duty reverses.
    if other.iter().any(|(_, depth)| *depth > 0.2 * end.accuracy.max_depth / UM) {
        let series = Series::new(format!("other flank, {}", name(end)), Style::Dashed, other);
        flank.series.push(series.coloured(Colour::Reference));
    }
    flank.note = match end.accuracy.max_depth_at {
        Some(at) => format!(
            "Wear depth of the flank at several times. The largest is {} µm at {:.0}°, where the product of force and sliding is largest.",
            significant(end.accuracy.max_depth / UM, 3),
            (at / DEG).abs()
        ),
        None => "The flanks have lost no metal.".to_owned(),
    };
    let profile = life.machine.profile();
    let sliding = Plot::new("Specific sliding", meshing_angle(), Axis::new("Sliding ξ", "").from_zero())
        .half()
        .with(Series::line(
            "disc flank",
            (0..=360).map(|half| {
                let phi = 0.5 * f64::from(half);
                (phi, profile.specific_sliding((phi * DEG).cos()))
            }),
        ))
        .noted("Specific sliding ξ: sliding speed over the speed of the contact along the flank, without unit. The wear depth per pass is k·(F/B)·ξ.");
    vec![Block::Plot(depth), Block::Plot(flank), Block::Plot(sliding)]
}

pub(super) fn load(life: &Life) -> Vec<Block> {
    let side = loaded_side(life);
    let contact = life.machine.line_contact();
    let pins_alike = life.last().accuracy.pin_loads.is_empty();
    let over = if pins_alike { "one pin pitch" } else { "one full period" };
    let mut force = Plot::new(
        "Contact force along the flank",
        meshing_angle(),
        Axis::new("Contact force", "N").from_zero(),
    )
    .half()
    .noted(format!(
        "Largest contact force in N of all pins at rated torque, within each step of the meshing angle over {over}. Wear \
         moves the load from the zones of largest sliding towards the root."
    ));
    let mut pressure = Plot::new(
        "Hertz pressure along the flank",
        meshing_angle(),
        Axis::new("Largest pressure", "MPa").from_zero(),
    )
    .half()
    .noted(
        "Largest Hertz pressure in MPa at rated torque within each step of the meshing angle: line contact with the relative \
         curvature of the flank there [Johnson1985].",
    );
    let mut largest = 0.0_f64;
    for (index, cycle) in &life.pitches {
        let (point, colour) = (&life.prediction.points[*index], colour(life, *index));
        // Loads that are alike on all pins are sampled most densely over one pitch.
        let peaks = if pins_alike { cycle.flank_forces() } else { point.accuracy.flank_peaks.clone() };
        let on_side = || peaks.iter().filter(|f| f.meshing_angle * side >= 0.0);
        let forces = envelope(on_side().map(|f| (f.meshing_angle * side / DEG, f.force)), STEP_DEG);
        let pressures = envelope(
            on_side().map(|f| {
                let pressure = contact.pressure(f.force, 1.0 / f.relative_curvature) / MPA;
                (f.meshing_angle * side / DEG, pressure)
            }),
            STEP_DEG,
        );
        largest = pressures.iter().map(|point| point.1).fold(largest, f64::max);
        force.series.push(Series::line(name(point), forces).coloured(colour));
        pressure.series.push(Series::line(name(point), pressures).coloured(colour));
    }
    let allowed = life.machine.limits.contact_pressure / MPA;
    // A limit far away would compress the curves.
    if allowed < 2.0 * largest {
        pressure.limit_at(allowed, format!("{} MPa allowed", compact(allowed, 4)));
    }
    let mut blocks = vec![Block::Plot(force), Block::Plot(pressure)];
    blocks.extend(pins(life).map(Block::Plot));
    blocks.push(Block::Plot(loaded_error(life)));
    blocks
}

/// Mean load of each pin over one full period, if the loads of the pins differ.
fn pins(life: &Life) -> Option<Plot> {
    let (new, end) = (life.first(), life.last());
    if end.accuracy.pin_loads.is_empty() {
        return None;
    }
    let mut plot = Plot::new(
        "Mean load of every pin",
        Axis::new("Pin, counted from the x axis", "").counted(),
        Axis::new("Mean contact force", "N").from_zero(),
    )
    .noted(
        "Contact force in N on each pin at rated torque, summed over the discs and averaged over a turn of the output, \
         including unloaded times. Without manufacturing errors all pins have the same mean load.",
    );
    for (point, colour, style) in
        [(new, Colour::Palette(0), Style::Line), (end, Colour::Palette(1), Style::LineMarkers)]
    {
        let mut forces = vec![0.0; life.machine.ring.pin_count];
        for load in &point.accuracy.pin_loads {
            if let Some(force) = forces.get_mut(load.pin) {
                *force += load.mean_force;
            }
        }
        let points = forces.into_iter().enumerate().map(|(pin, force)| ((pin + 1) as f64, force));
        plot.series.push(Series::new(name(point), style, points).coloured(colour));
    }
    Some(plot)
}

/// Loaded transmission error over one pin pitch of crank angle.
fn loaded_error(life: &Life) -> Plot {
    let mut plot = Plot::new(
        "Loaded transmission error over the crank angle",
        Axis::new("Crank angle", "°"),
        Axis::new("Error less its mean", "arcsec"),
    );
    let mut means = Vec::new();
    for (index, cycle) in &life.pitches {
        let (point, colour) = (&life.prediction.points[*index], colour(life, *index));
        let mean = cycle.mean_error().radians();
        let steps = cycle.positions.len().max(1);
        means.push(format!("{} {} arcmin", name(point), significant(mean / ARCMIN, 3)));
        let points = cycle.positions.iter().enumerate().map(|(step, position)| {
            let angle = cycle.period / DEG * step as f64 / steps as f64;
            (angle, (position.output_error.radians() - mean) / ARCMIN * 60.0)
        });
        plot.series.push(Series::line(name(point), points).coloured(colour));
    }
    plot.note = format!(
        "Transmission error less its mean over one pin pitch at rated torque, quasi-static. Pairs that come into and out of contact cause the ripple. Mean: {}.",
        means.join(", ")
    );
    plot
}

pub(super) fn mechanism(life: &Life) -> Vec<Block> {
    let [(new, first), .., (end, last)] = &life.pitches[..] else { return Vec::new() };
    let called = |index: &usize| name(&life.prediction.points[*index]);
    let states = [(called(new), first), (called(end), last)];
    let errors = if life.fidelity.errors.is_zero() {
        ""
    } else {
        " Manufacturing errors are too small to be visible. The forces of the first pin pitch are repeated."
    };
    let law = life.machine.line_contact();
    let state = |(index, cycle): (&usize, &Cycle)| SolidState {
        label: called(index),
        depth_um: vec![depths(life.prediction.points[*index].state.surfaces.flank())],
        rings: vec![positions(cycle, law)],
    };
    let scene = of_machine(&life.machine);
    vec![Block::Solids(Solids {
        title: format!("{} in its bearings", life.machine.name),
        note: format!(
            "Contact forces of the load-sharing equilibrium at {} N·m. The arrows act on the discs; their lines of action meet in \
             the pitch point.{errors} {}",
            compact(life.machine.rated.torque, 4),
            scene.assumed
        ),
        scene,
        states: vec![state((new, first)), state((end, last))],
        instead: Some(crate::report::mechanism(&life.machine, &states)),
    })]
}

/// STE and DTE over the hours, and the runs of the new and of the worn machine.
pub(super) fn motion(life: &Life, caveat: Option<String>) -> Vec<Block> {
    let mut plot = Plot::new(
        "Transmission error in motion over running time",
        hours(),
        Axis::new("Size of the transmission error", "arcmin").from_zero(),
    )
    .noted(format!(
        "Mean and largest magnitude of the transmission error in arcmin by the multibody model with the fidelity of the \
         prediction; the input accelerates within {} s. STE: without load, over {} s. DTE: under one period of {} s of a sinusoidal load with the rated torque as amplitude.",
        super::ages::RISE,
        super::ages::UNLOADED,
        super::ages::PERIOD
    ));
    for (loaded, name, colour) in [(false, "STE", 0), (true, "DTE", 1)] {
        for (part, style, of) in [
            ("mean", Style::LineMarkers, (|s| s.mean_abs) as fn(&crate::dynamics::ErrorStatistics) -> f64),
            ("largest", Style::Dashed, |s| s.max_abs),
        ] {
            let point = |age: &Age| Some((age.hours, of(&age.statistics()[usize::from(loaded)]?) / ARCMIN));
            let points: Vec<(f64, f64)> = life.ages.iter().filter_map(point).collect();
            plot.series.push(
                Series::new(format!("{name}, {part}"), style, points).coloured(Colour::Palette(colour)),
            );
        }
    }
    let mut blocks = vec![Block::Plot(plot)];
    blocks.extend(caveat.map(|text| Block::Note(Tone::Neutral, text)));
    let Some((new, end)) = life.ages.first().zip(life.ages.last()) else { return blocks };
    for (title, note, of) in [
        (
            "Without load",
            "Transmission error in arcmin over time in s without load: the output moves freely within the clearance.",
            (|age| &age.unloaded) as fn(&Age) -> &RunResult,
        ),
        (
            "Under the sinusoidal load",
            "Transmission error in arcmin over time in s under the sinusoidal load: the reversing torque loads one flank and then the other.",
            |age| &age.loaded,
        ),
    ] {
        let mut plot = Plot::new(title, Axis::new("Time", "s"), Axis::new("Transmission error", "arcmin"))
            .half()
            .noted(note);
        for (age, colour) in [(end, 1), (new, 0)] {
            let series = &of(age).series;
            let time: Vec<f64> = series.iter().map(|sample| sample.time).collect();
            let error: Vec<f64> = series.iter().map(|sample| sample.transmission_error / ARCMIN).collect();
            let name = if age.hours == 0.0 { "new".to_owned() } else { format!("{:.0} h", age.hours) };
            plot.series.push(Series::line(name, thinned(&time, &error)).coloured(Colour::Palette(colour)));
        }
        blocks.push(Block::Plot(plot));
    }
    blocks
}
