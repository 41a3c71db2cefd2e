//! Tables and figures of a run.

use super::motion::HasMotion;
use super::{Motion, Simulate};
use crate::dynamics::{ErrorStatistics, ForceSample, Sample, SpectrumLine, StartSpread};
use crate::fidelity::Fidelity;
use crate::results::{
    Column, DeclaredTable, PLAIN, SummaryOf, Table, TableOf, Value, decimals, digits, quantities as q,
    quantity,
};
use crate::rig::{NamedOrder, name_orders};
use crate::units::{ARCMIN, DEG, MM, UM};

const SERIES: TableOf<Sample> = TableOf {
    name: "timeseries",
    what: "One row per time",
    columns: || {
        vec![
            q::TIME.of(|s: &Sample| s.time.into()),
            quantity("input_speed_deg_s", decimals(2), "Speed of the input.")
                .of(|s| (s.input_speed / DEG).into()),
            quantity("output_speed_deg_s", decimals(3), "Speed of the output.")
                .of(|s| (s.output_speed / DEG).into()),
            quantity("load_n_m", decimals(1), "External torque at the output, against positive motion.")
                .of(|s| s.load.into()),
            q::TE.of(|s| (s.transmission_error / ARCMIN).into()),
        ]
    },
};

const FORCES: TableOf<ForceSample> = TableOf {
    name: "forces",
    what: "One row per time: forces",
    columns: || {
        vec![
            q::TIME.of(|s: &ForceSample| s.time.into()),
            q::LARGEST_PIN_FORCE.of(|s| s.forces.largest_pin_force.into()),
            quantity("loaded_pins", PLAIN, "Pins that carry force, over all discs.")
                .of(|s| s.forces.loaded_pins.into()),
            quantity(
                "mesh_force_n",
                decimals(1),
                "Force along the line of action, all sun–planet meshes together.",
            )
            .of(|s| s.forces.mesh_force.into()),
        ]
    },
};

const SPECTRUM: TableOf<SpectrumLine> = TableOf {
    name: "spectrum",
    what: "One row per spectral line of the transmission error; only for runs whose window covers a turn of the \
         output",
    columns: || {
        vec![
            q::ORDER.of(|line: &SpectrumLine| line.order.into()),
            q::AMPLITUDE.of(|line| (line.amplitude / ARCMIN).into()),
        ]
    },
};

pub(crate) fn tables() -> Vec<DeclaredTable> {
    vec![SERIES.into(), FORCES.into(), SPECTRUM.into()]
}

pub(crate) fn fill(run: &Motion) -> Vec<Table> {
    let result = &run.result;
    let mut tables = vec![SERIES.fill(&result.series), FORCES.fill(&result.forces)];
    tables.extend(result.spectrum.as_ref().map(|lines| SPECTRUM.fill(lines)));
    tables
}

/// Lines of a spectrum with their likely causes.
pub(crate) fn orders_value(orders: &[NamedOrder]) -> Value {
    let one = |order: &NamedOrder| {
        Value::Record(vec![
            ("order", order.order.into()),
            ("amplitude_arcmin", (order.amplitude / ARCMIN).into()),
            ("cause", Value::from(order.cause.clone())),
        ])
    };
    Value::List(orders.iter().map(one).collect())
}

/// Statistics of the transmission error over the window, rad in, arcmin out.
fn statistics<O: HasMotion>() -> Vec<Column<O>> {
    type Of = (&'static str, &'static str, fn(&ErrorStatistics) -> f64);
    const ALL: &[Of] = &[
        ("te.mean_arcmin", "Mean transmission error over the window.", |s| s.mean),
        ("te.mean_abs_arcmin", "Mean of |TE| over the window.", |s| s.mean_abs),
        ("te.max_abs_arcmin", "Largest |TE| in the window.", |s| s.max_abs),
        ("te.peak_to_peak_arcmin", "Peak to peak of the transmission error in the window.", |s| {
            s.peak_to_peak
        }),
        ("te.rms_arcmin", "Root mean square of the transmission error in the window.", |s| s.rms),
        ("te.lowest_arcmin", "Lowest transmission error in the window.", |s| s.lowest),
        ("te.highest_arcmin", "Highest transmission error in the window.", |s| s.highest),
    ];
    let mut all: Vec<Column<O>> = ALL
        .iter()
        .enumerate()
        .map(|(index, (key, what, _))| {
            Column::numbered(quantity(key, decimals(4), what), index, |o: &O, index| {
                o.motion().result.statistics.map(|s| ALL[index].2(&s) / ARCMIN).into()
            })
        })
        .collect();
    all.push(
        quantity("te.window_s", decimals(4), "Length of the window.")
            .of(|o: &O| o.motion().result.statistics.map(|s| s.duration).into()),
    );
    all
}

fn of_spread<O: HasMotion>(value: fn(&StartSpread) -> Value) -> impl Fn(&O) -> Value {
    move |o| o.motion().spread.as_ref().map_or(Value::Absent, value)
}

/// Ratio, end of the run, transmission error over the window.
pub(crate) fn error_entries<O: HasMotion>() -> Vec<Column<O>> {
    let mut entries = vec![
        q::RATIO.of(|o: &O| o.motion().ratio.into()),
        quantity("mean_ratio", digits(8), "Turn of the input over that of the output in the window.")
            .of(|o: &O| o.motion().result.mean_ratio.into()),
        quantity("complete", PLAIN, "Whether the run came to its end.")
            .of(|o: &O| o.motion().broke_off.is_none().into()),
        quantity("error", PLAIN, "Why the run broke off.").of(|o: &O| o.motion().broke_off.clone().into()),
        quantity("reached_s", decimals(4), "Time reached.").of(|o: &O| o.motion().result.reached.into()),
    ];
    entries.extend(statistics());
    entries
}

/// Perturbed starts, steps and energy balance of the integration, largest force.
pub(crate) fn solver_entries<O: HasMotion>() -> Vec<Column<O>> {
    vec![
        quantity("perturbed_starts.starts", PLAIN, "Runs from other starts, of an unloaded machine.")
            .of(|o: &O| of_spread(|s| s.runs.len().into())(o)),
        quantity(
            "perturbed_starts.chaotic",
            PLAIN,
            "Whether the motion is chaotic: the mean then depends on the start and is no result.",
        )
        .of(|o: &O| of_spread(|s| s.is_chaotic().into())(o)),
        quantity("perturbed_starts.mean_spread_arcmin", decimals(4), "Spread of the mean over the starts.")
            .of(|o: &O| of_spread(|s| (s.mean / ARCMIN).into())(o)),
        quantity("perturbed_starts.rms_spread_arcmin", decimals(4), "Spread of the RMS over the starts.")
            .of(|o: &O| of_spread(|s| (s.rms / ARCMIN).into())(o)),
        quantity("perturbed_starts.band_arcmin", decimals(4), "Largest |TE| over all starts.")
            .of(|o: &O| of_spread(|s| (s.band / ARCMIN).into())(o)),
        quantity("solver.steps", PLAIN, "Accepted time steps.")
            .of(|o: &O| o.motion().result.counts.accepted.into()),
        quantity("solver.rejected_steps", PLAIN, "Steps taken again with a smaller length.")
            .of(|o: &O| o.motion().result.counts.rejected.into()),
        quantity("solver.evaluations", PLAIN, "Evaluations of all forces.")
            .of(|o: &O| o.motion().result.counts.evaluations.into()),
        quantity("solver.tangents", PLAIN, "Tangents among these evaluations.")
            .of(|o: &O| o.motion().result.counts.tangents.into()),
        quantity("solver.wall_s", decimals(2), "Seconds of computation.").of(|o: &O| o.motion().wall.into()),
        quantity(
            "solver.energy_residual",
            digits(2),
            "Residual of the energy balance, as a share of the turnover: input − load − losses − change of \
             stored energy.",
        )
        .of(|o: &O| o.motion().result.energy.residual().into()),
        quantity("energy.input_j", digits(5), "Work of the drive.")
            .of(|o: &O| o.motion().result.energy.input.into()),
        quantity("energy.load_j", digits(5), "Work done on the load.")
            .of(|o: &O| o.motion().result.energy.load.into()),
        quantity("energy.dissipated_j", digits(5), "Work lost in dampers and friction.")
            .of(|o: &O| o.motion().result.energy.dissipated.into()),
        quantity("energy.stored_j", digits(5), "Elastic and kinetic energy at the end.")
            .of(|o: &O| o.motion().result.energy.current.into()),
        quantity("energy.turnover_j", digits(5), "Work that went through the machine, signs left out.")
            .of(|o: &O| o.motion().result.energy.turnover.into()),
        q::LARGEST_PIN_FORCE.of(|o: &O| o.motion().largest_pin_force().into()),
    ]
}

pub(crate) const SUMMARY: SummaryOf<Simulate> = SummaryOf {
    entries: || {
        let mut entries = error_entries::<Simulate>();
        entries.extend([
            q::HOURS.of(|o: &Simulate| o.worn.hours.into()),
            q::WEAR_UM.of(|o| (o.worn.deepest() / UM).into()),
            quantity("facet_mm", decimals(3), "Edge length of a faceted flank.")
                .of(|o| o.facet.map(|size| size / MM).into()),
            q::ORDERS.of(|o: &Simulate| {
                let named = |lines: &Vec<SpectrumLine>| {
                    orders_value(&name_orders(lines, &o.machine, 2 * lines.len(), 8))
                };
                o.result.spectrum.as_ref().map_or(Value::Absent, named)
            }),
        ]);
        entries.extend(solver_entries());
        entries.extend(Fidelity::entries());
        entries
    },
};

impl Motion {
    /// Over the whole run, in N.
    pub fn largest_pin_force(&self) -> f64 {
        self.result.forces.iter().map(|f| f.forces.largest_pin_force).fold(0.0, f64::max)
    }
}
