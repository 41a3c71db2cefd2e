//! A series of machines: how far tolerances spread the accuracy over life.

use crate::life::Series;
use crate::report::{Axis, Block, Colour, Column, Plot, Section, Style, Table, Tone, compact, significant};
use crate::units::{ARCMIN, UM};

/// Section of a series; `seeds` are those of its machines, in their order.
pub fn series_section(series: &Series, seeds: &[u64], limit_arcmin: f64) -> Section {
    let mut blocks = vec![Block::Plot(band(series, limit_arcmin))];
    blocks.extend(reached(series).map(Block::Plot));
    let failed: Vec<String> = seeds
        .iter()
        .zip(&series.machines)
        .filter_map(|(seed, machine)| machine.as_ref().err().map(|error| format!("seed {seed}: {error}")))
        .collect();
    if !failed.is_empty() {
        blocks.push(Block::Note(Tone::Caution, format!("Left out of all figures: {}.", failed.join("; "))));
    }
    blocks.push(Block::Table(table(series, seeds)));
    Section::new("series", "Machines of a series", blocks)
}

fn hours() -> Axis {
    Axis::new("Running time", "h")
}

fn band(series: &Series, limit: f64) -> Plot {
    let quantiles: Vec<(f64, [f64; 5])> = series
        .hours
        .iter()
        .enumerate()
        .filter_map(|(index, hours)| Some((*hours, series.lost_motion(index)?.0.map(|lost| lost / ARCMIN))))
        .collect();
    let between = |low: usize, high: usize| quantiles.iter().map(move |(hours, q)| (*hours, q[low], q[high]));
    let count = series.followed().count();
    let mut plot = Plot::new(
        "Lost motion of the machines of a series",
        hours(),
        Axis::new("Lost motion", "arcmin").from_zero(),
    )
    .with(
        crate::report::Series::band(format!("all {count} machines"), between(0, 4))
            .coloured(Colour::Reference),
    )
    .with(crate::report::Series::band("10 % to 90 % of them", between(1, 3)).coloured(Colour::Palette(0)))
    .with(
        crate::report::Series::line("median", quantiles.iter().map(|(hours, q)| (*hours, q[2])))
            .strong()
            .coloured(Colour::Palette(0)),
    )
    .with(
        crate::report::Series::new(
            "without manufacturing errors",
            Style::Dashed,
            series.hours.iter().zip(&series.nominal.lost_motion).map(|(hours, lost)| (*hours, lost / ARCMIN)),
        )
        .coloured(Colour::Palette(1)),
    );
    plot.limit_at(limit, format!("limit {} arcmin lost motion", compact(limit, 3)));
    plot.note = "Machines drawn one by one from the tolerances of the design, each worn in its bearings with its own errors; the wear coefficient, which scatters \
                 from machine to machine as well, is one for all. Lost motion at ±3 % of rated torque, mean over the whole ring."
        .into();
    plot
}

/// Share of the machines past their limit against the hours; nothing if none reaches it.
fn reached(series: &Series) -> Option<Plot> {
    let mut hours_to: Vec<f64> = series.followed().filter_map(|life| life.hours_to_limit).collect();
    hours_to.sort_by(f64::total_cmp);
    let count = series.followed().count() as f64;
    let (first, last) = (*hours_to.first()?, *hours_to.last()?);
    let steps =
        hours_to.iter().enumerate().map(|(index, hours)| (*hours, 100.0 * (index + 1) as f64 / count));
    let points = [(0.0, 0.0), (first, 0.0)]
        .into_iter()
        .chain(steps)
        .chain([(1.1 * last, 100.0 * hours_to.len() as f64 / count)]);
    let mut plot = Plot::new(
        "Machines past their limit",
        hours().from_zero(),
        Axis::new("Share of the machines", "%").between(0.0, 100.0),
    )
    .with(crate::report::Series::new("past the limit", Style::Step, points).strong());
    let never = series.followed().filter(|life| life.hours_to_limit.is_none()).count();
    let searched = series.followed().map(|life| life.searched_hours).fold(f64::INFINITY, f64::min);
    plot.note = match never {
        0 => format!("All reach it, the first after {first:.0} h, the last after {last:.0} h."),
        never => format!(
            "{never} of {count} do not reach it within the {searched:.0} h and more that were computed."
        ),
    };
    Some(plot)
}

fn table(series: &Series, seeds: &[u64]) -> Table {
    let row = |name: String, life: &crate::life::MachineLife| {
        let ends = [life.lost_motion.first(), life.lost_motion.last()]
            .map(|lost| significant(lost.copied().unwrap_or(f64::NAN) / ARCMIN, 3));
        let [new, worn] = ends;
        let limit = life
            .hours_to_limit
            .map_or(format!("> {:.0}", life.searched_hours), |hours| format!("{hours:.0}"));
        vec![name, new, worn, limit, significant(life.max_depth / UM, 3)]
    };
    let drawn = seeds
        .iter()
        .zip(&series.machines)
        .filter_map(|(seed, life)| Some(row(format!("seed {seed}"), life.as_ref().ok()?)));
    Table {
        title: "Machine by machine".into(),
        columns: vec![
            Column::text("Machine"),
            Column::number("Lost motion, new", "arcmin"),
            Column::number("at the end of the service life", "arcmin"),
            Column::number("Hours to the limit", "h"),
            Column::number("Deepest wear", "µm"),
        ],
        rows: std::iter::once(row("without errors".into(), &series.nominal)).chain(drawn).collect(),
        note: String::new(),
    }
}
