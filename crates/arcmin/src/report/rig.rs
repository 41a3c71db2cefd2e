//! The page of the test bench: loop, stiffness split, transmission error with named orders, efficiency, bearing loads.

use super::{
    Axis, Block, Colour, Column, HeatMap, KeyFigure, Page, Plot, Provenance, Reference, Section, Series, Shares, Style, Table, Tone, Verdict, Width,
    significant,
};
use crate::dynamics::SpectrumLine;
use crate::machine::Machine;
use crate::rig::{BearingLoad, Branch, EfficiencyMap, ErrorCurve, LoopFigures, LoopPoint, NamedOrder, RunningTorques, StiffnessSplit};
use crate::units::{ARCMIN, RPM};

/// All results of the bench for one state of the machine.
#[derive(Debug, Clone)]
pub struct RigState {
    pub hours: f64,
    /// One loop per crank position.
    pub loops: Vec<Vec<LoopPoint>>,
    pub figures: Vec<LoopFigures>,
    pub split: StiffnessSplit,
    /// Forward and backward held lightly, forward and backward at rated torque.
    pub curves: Vec<ErrorCurve>,
    /// At rated torque, forward.
    pub spectrum: Vec<SpectrumLine>,
    pub orders: Vec<NamedOrder>,
    pub efficiency: EfficiencyMap,
    pub torques: RunningTorques,
    pub bearings: Vec<BearingLoad>,
}

impl RigState {
    fn mean(&self, of: fn(&LoopFigures) -> f64) -> f64 {
        self.figures.iter().map(of).sum::<f64>() / self.figures.len().max(1) as f64
    }

    /// Means over the crank positions: rad, N·m/rad.
    pub fn lost_motion(&self) -> f64 {
        self.mean(|f| f.lost_motion)
    }

    pub fn backlash(&self) -> f64 {
        self.mean(|f| f.backlash)
    }

    pub fn stiffness(&self) -> f64 {
        self.mean(|f| f.stiffness)
    }

    pub fn soft_stiffness(&self) -> f64 {
        self.mean(|f| f.soft_stiffness)
    }
}

/// Results of a bench run, lent for rendering.
#[derive(Debug, Clone)]
pub struct RigPage<'a> {
    pub machine: &'a Machine,
    pub provenance: Provenance,
    pub new: &'a RigState,
    pub worn: Option<&'a RigState>,
    pub measured: Option<(&'a [LoopPoint], LoopFigures)>,
    pub friction_assumed: bool,
}

impl RigPage<'_> {
    /// The page, ready to be rendered.
    pub fn page(&self) -> Page {
        Page {
            title: self.machine.name.clone(),
            subtitle: "Virtual test bench".into(),
            provenance: self.provenance.clone(),
            verdict: self.verdict(),
            sections: self.sections(),
        }
    }

    fn state(&self) -> &RigState {
        self.worn.unwrap_or(self.new)
    }

    fn verdict(&self) -> Verdict {
        let state = self.state();
        let lost = state.lost_motion();
        let limit = self.machine.limits.lost_motion;
        let tone = if lost <= limit { Tone::Good } else { Tone::Bad };
        let mut verdict = Verdict::new(
            tone,
            format!(
                "Lost motion {} arcmin {} the limit of {} arcmin.",
                significant(lost / ARCMIN, 3),
                if lost <= limit { "stays within" } else { "exceeds" },
                significant(limit / ARCMIN, 3)
            ),
        );
        let figure = |label: &str, value: f64, unit: &str, note: &str| KeyFigure {
            label: label.into(),
            value: significant(value, 3),
            unit: unit.into(),
            note: note.into(),
            tone: Tone::Neutral,
        };
        verdict.figures = vec![
            figure("Lost motion", lost / ARCMIN, "arcmin", "between the mid-points at ± 3 % of rated torque"),
            figure("Backlash", state.backlash() / ARCMIN, "arcmin", "width of the loop at zero torque"),
            figure("Torsional stiffness", state.stiffness() * ARCMIN, "N·m/arcmin", "slope between 50 and 100 % of rated torque"),
            figure("Efficiency", 100.0 * state.efficiency.rated, "%", "at rated torque and speed"),
        ];
        verdict
    }

    /// The sections, for this page or as part of another.
    pub fn sections(&self) -> Vec<Section> {
        let mut bench = vec![Block::Plot(self.loops())];
        if self.friction_assumed {
            bench.push(Block::Note(
                Tone::Caution,
                "The design gives no friction. The width of the loop, the efficiency and the running torques rest on assumed coefficients: flank 0.06, bearings \
                 0.002, gear mesh 0.06, seals 4 N·m, oil 1e-4 N·m·s."
                    .into(),
            ));
        }
        bench.push(Block::Shares(self.split()));
        bench.push(Block::Note(
            Tone::Neutral,
            "Bearings, shafts and supports are assumptions where the design file says so. Rings, discs and housing are rigid; a real reducer is softer by \
             their share."
                .into(),
        ));
        vec![
            Section::new("bench", "Hysteresis and stiffness", bench),
            Section::new("error", "Transmission error of one output turn", self.transmission()),
            Section::new("losses", "Efficiency and torques", self.losses()),
            Section::new("bearings", "Bearing loads and life", self.bearings()),
            Section::new("literature", "Literature", vec![Block::References(references())]),
        ]
    }

    fn loops(&self) -> Plot {
        let mut plot =
            Plot::new("Hysteresis loop, input locked", Axis::new("Torque at the output", "N·m"), Axis::new("Angle of the output", "arcmin"));
        let mut add = |points: &[LoopPoint], name: String, colour: Colour, strong: bool| {
            for branch in [Branch::Falling, Branch::Rising] {
                let line = points.iter().filter(|p| p.branch == branch).map(|p| (p.torque, p.angle / ARCMIN));
                let mut series = Series::line(format!("{name}, {}", branch.word()), line).coloured(colour);
                series.strong = strong;
                plot.series.push(series);
            }
        };
        for (state, name, colour) in [(Some(self.new), "new".to_owned(), 0), (self.worn, format!("{} h", self.state().hours), 1)] {
            if let Some(points) = state.and_then(|state| state.loops.first()) {
                add(points, name, Colour::Palette(colour), true);
            }
        }
        if let Some((points, _)) = &self.measured {
            add(points, "measured".to_owned(), Colour::Reference, false);
        }
        let f = &self.state().figures;
        let spread = |of: fn(&LoopFigures) -> f64| {
            let fold = |start: f64, pick: fn(f64, f64) -> f64| f.iter().map(of).fold(start, pick);
            format!("{} to {}", significant(fold(f64::INFINITY, f64::min) / ARCMIN, 3), significant(fold(f64::NEG_INFINITY, f64::max) / ARCMIN, 3))
        };
        plot.noted(format!(
            "First of {} crank positions. Over all of them lost motion runs from {} arcmin, backlash from {} arcmin; definitions as in GB/T 35089.",
            f.len(),
            spread(|f| f.lost_motion),
            spread(|f| f.backlash)
        ))
    }

    fn split(&self) -> Shares {
        let split = &self.state().split;
        let rows = split
            .parts
            .iter()
            .map(|(part, c)| (part.name().to_owned(), 1e3 * c.max(0.0) / ARCMIN, format!("{} %", significant(100.0 * c / split.whole, 3))))
            .collect();
        let sum: f64 = split.parts.iter().map(|part| part.1).sum();
        Shares {
            title: "Where the compliance sits, 50 to 100 % of rated torque".into(),
            unit: "arcmin per kN·m".into(),
            rows,
            note: format!(
                "Energy split gᵀKg along the motion per unit torque; the parts add up to {} % of the compliance read from two balances.",
                significant(100.0 * sum / split.whole, 4)
            ),
        }
    }

    fn transmission(&self) -> Vec<Block> {
        let state = self.state();
        let mut plot = Plot::new("Transmission error", Axis::new("Output angle", "°"), Axis::new("θ_out − θ_in/i", "arcmin"));
        for curve in &state.curves {
            let way = if curve.direction > 0.0 { "forward" } else { "backward" };
            let points = curve.points.iter().map(|(angle, error)| (angle.to_degrees().abs(), error / ARCMIN));
            plot.series.push(Series::line(format!("{way}, {} N·m", significant(curve.torque, 3)), points));
        }
        let bars = state.spectrum.iter().filter(|line| (1..=200).contains(&line.order)).map(|line| (line.order as f64, line.amplitude / ARCMIN));
        let spectrum =
            Plot::new("Spectrum at rated torque, forward", Axis::new("Order of the output turn", ""), Axis::new("Amplitude", "arcmin").from_zero())
                .with(Series::new("amplitude", Style::Bars, bars));
        let table = Table {
            title: "Strongest orders".into(),
            columns: vec![Column::number("Order", ""), Column::number("Amplitude", "arcmin"), Column::text("Likely cause")],
            rows: state.orders.iter().map(|o| vec![o.order.to_string(), significant(o.amplitude / ARCMIN, 3), o.cause.clone()]).collect(),
            note: String::new(),
        };
        vec![Block::Plot(plot), Block::Plot(spectrum), Block::Table(table)]
    }

    fn losses(&self) -> Vec<Block> {
        let map = &self.state().efficiency;
        let heat = HeatMap {
            title: "Efficiency".into(),
            x: Axis::new("Torque at the output", "N·m"),
            y: Axis::new("Input speed", "rpm"),
            value: Axis::new("Efficiency", "%"),
            x_values: map.torques.clone(),
            y_values: map.speeds.iter().map(|speed| speed / RPM).collect(),
            cells: map.efficiency.iter().flatten().map(|e| Some(100.0 * e)).collect(),
            note: "From the balance of the running machine with friction at pins, bearings, meshes, seals and oil.".into(),
            width: Width::Half,
        };
        let t = &self.state().torques;
        let row = |name: &str, value: f64| vec![name.to_owned(), if value.is_finite() { significant(value, 3) } else { "self-locking".into() }];
        let table = Table {
            title: "Torques without load".into(),
            columns: vec![Column::text("Torque"), Column::number("Value", "N·m")],
            rows: vec![
                row("Running without load, at the input", t.no_load),
                row("Starting without load, at the input", t.starting),
                row("Back-driving, at the output", t.back_driving),
            ],
            note: String::new(),
        };
        vec![Block::HeatMap(heat), Block::Table(table)]
    }

    fn bearings(&self) -> Vec<Block> {
        let bearings = &self.state().bearings;
        let mut plot =
            Plot::new("Bearing forces over a crank turn at rated torque", Axis::new("Crank angle", "°"), Axis::new("Radial force", "N").from_zero());
        for bearing in bearings {
            let step = 360.0 / bearing.forces.len().max(1) as f64;
            plot.series.push(Series::line(bearing.name.clone(), bearing.forces.iter().enumerate().map(|(i, f)| (step * i as f64, *f))));
        }
        let rows = bearings
            .iter()
            .map(|b| {
                vec![
                    b.name.clone(),
                    significant(b.mean_force(), 3),
                    significant(b.largest_element, 3),
                    significant(b.equivalent, 3),
                    significant(b.rating / 1e3, 3),
                    significant(b.life_h(), 3),
                ]
            })
            .collect();
        let table = Table {
            title: "Basic rating life, ISO 281".into(),
            columns: vec![
                Column::text("Bearing"),
                Column::number("Mean force", "N"),
                Column::number("Largest roller", "N"),
                Column::number("Equivalent load", "N"),
                Column::number("Rating C", "kN"),
                Column::number("L10h", "h"),
            ],
            rows,
            note: "Without the axial load of tapered rollers and without life modification factors.".into(),
        };
        vec![Block::Plot(plot), Block::Table(table)]
    }
}

fn references() -> Vec<Reference> {
    let entry =
        |key: &str, citation: &str, used_for: &str| Reference { key: key.into(), citation: citation.into(), doi: None, used_for: used_for.into() };
    vec![
        entry("Harris", "T. A. Harris, M. N. Kotzalas: Rolling Bearing Analysis, 5th ed., CRC Press 2006", "stiffness of rollers between raceways"),
        entry("ISO281", "ISO 281:2007 Rolling bearings: Dynamic load ratings and rating life", "bearing life"),
        entry(
            "GBT35089",
            "GB/T 35089-2018 Precision gear transmission for robots: Test method",
            "definitions of lost motion, backlash and stiffness",
        ),
    ]
}
