//! The flank of the cycloid disc: points, normals, curvature, modifications.

use std::f64::consts::TAU;

use super::{AnalysisError, Host, Outcome, TextBlock};
use crate::design::{Design, default, options};
use crate::geometry::{Profile, Relief, Vec2};
use crate::report::{Axis, Block, KeyFigure, Page, Plot, Provenance, Section, Series, Tone, Verdict};
use crate::results::{
    DeclaredTable, PLAIN, Summary, SummaryOf, Table, TableOf, Value, decimals, digits, quantities as q,
    quantity,
};
use crate::units::{DEG, MM, UM, wrap_angle};

pub(crate) const ABOUT: &str = "Compute the flank of the cycloid disc: points, normals, curvature";
pub(crate) const GUIDE: &str = "Computes the flank of the cycloid disc over one full turn, with its modifications and with uniform \
    wear if given.";
pub(crate) const EXAMPLES: &[&str] = &[
    "arcmin profile my-reducer.toml --points 400",
    "arcmin profile my-reducer.toml --wear-um 60 --out flank60",
];

options! {
    /// Options of `profile`.
    pub struct Options {
        /// Points per lobe.
        points: usize => default(200.0, 4.0, 1e5),
        /// Uniform wear depth of the whole flank.
        wear_um: f64 => default(0.0, 0.0, 1000.0),
    }
}

/// A point of the flank.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FlankPoint {
    /// Parameter around the disc in rad.
    pub tau: f64,
    /// Meshing angle in rad.
    pub meshing_angle: f64,
    /// The worn flank, in m.
    pub worn: Vec2,
    /// The flank as cut, in m.
    pub unworn: Vec2,
    /// Unit normal into the metal.
    pub normal: Vec2,
    /// Curvature radius of the worn flank in m, concave positive; infinite where straight.
    pub curvature_radius: f64,
}

/// The flank around the disc.
#[derive(Debug, Clone)]
pub struct FlankProfile {
    /// Points in the order of τ, all around the disc.
    pub points: Vec<FlankPoint>,
    /// Flank as cut.
    pub profile: Profile,
    /// Uniform wear in m.
    pub wear: f64,
    /// Points on one lobe.
    pub points_per_lobe: usize,
    ratio: f64,
    name: String,
}

pub(super) const PROFILE: TableOf<FlankPoint> = TableOf {
    name: "profile",
    what: "One row per point of the flank, one full turn of the disc",
    columns: || {
        vec![
            quantity("tau_deg", decimals(4), "Parameter around the disc.")
                .of(|p: &FlankPoint| (p.tau / DEG).into()),
            q::MESHING_ANGLE.of(|p| (p.meshing_angle / DEG).into()),
            quantity("x_mm", decimals(6), "The flank less the wear.").of(|p| (p.worn.x / MM).into()),
            quantity("y_mm", decimals(6), "The flank less the wear, across.").of(|p| (p.worn.y / MM).into()),
            quantity("normal_x", decimals(6), "Unit normal into the metal.").of(|p| p.normal.x.into()),
            quantity("normal_y", decimals(6), "Unit normal into the metal, across.")
                .of(|p| p.normal.y.into()),
            quantity(
                "curvature_radius_mm",
                digits(6),
                "Curvature radius of the worn flank, positive where concave; empty where the flank is straight.",
            )
            .of(|p| (p.curvature_radius / MM).into()),
            quantity("unworn_x_mm", decimals(6), "The flank as cut.").of(|p| (p.unworn.x / MM).into()),
            quantity("unworn_y_mm", decimals(6), "The flank as cut, across.")
                .of(|p| (p.unworn.y / MM).into()),
        ]
    },
};

pub(crate) const SUMMARY: SummaryOf<FlankProfile> = SummaryOf {
    entries: || {
        vec![
            q::RATIO.of(|o: &FlankProfile| o.ratio.into()),
            quantity(
                "short_width_coefficient",
                decimals(4),
                "K1 = a z_p/R_p, below 1; at 1 the trochoid has cusps.",
            )
            .of(|o| o.profile.short_width_coefficient().into()),
            quantity(
                "inflection_deg",
                decimals(3),
                "Meshing angle where the flank turns from concave to convex.",
            )
            .of(|o| Value::from(o.profile.inflection().map(|angle| angle / DEG))),
            quantity(
                "min_convex_flank_radius_mm",
                decimals(3),
                "Smallest convex radius of the flank less the wear depth. At zero or below the flank is undercut.",
            )
            .of(|o| (o.sharpest() / MM).into()),
            quantity(
                "min_convex_flank_radius_at_deg",
                decimals(2),
                "Meshing angle of the sharpest convex radius.",
            )
            .of(|o| Value::from((!o.is_hollow()).then(|| o.profile.sharpest_convex_trace().1 / DEG))),
            q::WEAR_UM.of(|o| (o.wear / UM).into()),
            quantity("points_per_lobe", PLAIN, "Points per lobe of the table.")
                .of(|o| o.points_per_lobe.into()),
        ]
    },
};

pub(crate) fn tables() -> Vec<DeclaredTable> {
    vec![PROFILE.into()]
}

/// Computes the flank.
///
/// # Errors
/// None today; the type is that of every analysis.
pub fn run(design: &Design, options: &Options, _host: &dyn Host) -> Result<FlankProfile, AnalysisError> {
    let machine = design.machine();
    let (ratio, name) = (machine.kinematics().ratio(), machine.name.clone());
    Ok(flank(machine.profile(), &machine.designed_relief(), ratio, name, options))
}

/// The flank of one disc of a drive of this ratio and name.
pub(super) fn flank(
    profile: Profile,
    relief: &Relief,
    ratio: f64,
    name: String,
    options: &Options,
) -> FlankProfile {
    let wear = options.wear_um * UM;
    let worn = relief.plus(&Relief::uniform(wear));
    let (lobes, per_lobe) = (profile.lobe_count(), options.points);
    // If the flank ends at a tip, points on the flank only, none on the tip circle.
    let on_flanks = profile.tip().map(|_| profile.around_lobe(per_lobe));
    let point = |index: usize| {
        if let Some(places) = &on_flanks {
            let (lobe, tau) = (index / per_lobe, places[index % per_lobe]);
            let around = TAU * lobe as f64 / lobes as f64 + tau;
            return FlankPoint::meshing_at(&profile, relief, &worn, around, profile.meshing_angle(tau));
        }
        let tau = TAU * index as f64 / (lobes * per_lobe) as f64;
        // From the whole number of steps within the lobe: exact at root and tip, equal on every lobe.
        let meshing_angle = wrap_angle(-TAU * (index % per_lobe) as f64 / per_lobe as f64);
        FlankPoint::meshing_at(&profile, relief, &worn, tau, meshing_angle)
    };
    FlankProfile {
        points: (0..lobes * per_lobe).map(point).collect(),
        ratio,
        name,
        profile,
        wear,
        points_per_lobe: per_lobe,
    }
}

impl FlankPoint {
    /// The point at `tau` (rad) of a flank with the relief it was made with, and of the worn one.
    pub fn at(profile: &Profile, relief: &Relief, worn: &Relief, tau: f64) -> FlankPoint {
        FlankPoint::meshing_at(profile, relief, worn, tau, profile.meshing_angle(tau))
    }

    fn meshing_at(
        profile: &Profile,
        relief: &Relief,
        worn: &Relief,
        tau: f64,
        meshing_angle: f64,
    ) -> FlankPoint {
        let outward = profile.outward_normal(tau);
        let less = |relief: &Relief| profile.flank_point(tau) - relief.at(meshing_angle).depth * outward;
        FlankPoint {
            tau,
            meshing_angle,
            worn: less(worn),
            unworn: less(relief),
            normal: -outward,
            curvature_radius: worn_curvature_radius(profile, worn, meshing_angle),
        }
    }
}

/// Curvature radius in m of the flank less the depth w: 1/ρ of the parallel curve, less w″ along the flank.
fn worn_curvature_radius(profile: &Profile, worn: &Relief, meshing_angle: f64) -> f64 {
    let cos = meshing_angle.cos();
    let curvature = profile.flank_curvature(cos);
    let sample = worn.at(meshing_angle);
    let length = profile.flank_length_per_meshing_angle(cos);
    1.0 / (curvature / (1.0 + sample.depth * curvature) - sample.bend / (length * length))
}

impl FlankProfile {
    /// Sharpest convex radius of the flank less the wear, in m.
    pub fn sharpest(&self) -> f64 {
        self.profile.sharpest_convex_trace().0 - self.profile.pin_radius - self.wear
    }

    /// Whether no part of the flank is convex: it ends at a tip before its inflection.
    fn is_hollow(&self) -> bool {
        self.sharpest().is_infinite()
    }

    pub(super) fn sentence(&self) -> String {
        let sharpest = match self.is_hollow() {
            true => "flank hollow up to the tip".to_owned(),
            false => format!(
                "sharpest convex flank radius {:.3} mm at {:.2}°",
                self.sharpest() / MM,
                self.profile.sharpest_convex_trace().1 / DEG
            ),
        };
        format!(
            "K1 {:.4}, inflection {}, {sharpest}",
            self.profile.short_width_coefficient(),
            self.profile.inflection().map_or("none".to_owned(), |angle| format!("{:.3}°", angle / DEG)),
        )
    }
}

impl Outcome for FlankProfile {
    fn summary(&self) -> Summary {
        SUMMARY.fill(self)
    }

    fn tables(&self) -> Vec<Table> {
        vec![PROFILE.fill(&self.points)]
    }

    fn text_blocks(&self) -> Vec<TextBlock> {
        vec![TextBlock::line(self.sentence())]
    }

    fn page(&self) -> Page {
        let undercut = self.sharpest() <= 0.0;
        let tone = if undercut { Tone::Bad } else { Tone::Neutral };
        let around = self.points.iter().chain(self.points.first());
        let mut outline = Plot::new("Flank of the disc", Axis::new("x", "mm"), Axis::new("y", "mm"))
            .with(Series::line("flank", around.map(|p| (p.worn.x / MM, p.worn.y / MM))))
            .noted("The flank as cut, less the wear, around the whole disc, in mm. Drag a box to enlarge one lobe.")
            .half();
        outline.equal_scales = true;
        let lobe = || {
            let mut lobe: Vec<&FlankPoint> = self.points.iter().take(self.points_per_lobe).collect();
            lobe.sort_by(|a, b| a.meshing_angle.total_cmp(&b.meshing_angle));
            lobe
        };
        let curvature = Plot::new(
            "Curvature of one lobe",
            Axis::new("Meshing angle", "°"),
            Axis::new("Curvature, concave positive", "1/mm"),
        )
        .with(Series::line(
            "1/ρ",
            lobe().into_iter().map(|p| (p.meshing_angle / DEG, MM / p.curvature_radius)),
        ))
        .noted(
            "Curvature 1/ρ in 1/mm: positive where the flank is concave, around the root (0°), and negative where it is \
             convex. It changes its sign at the inflection; at its minimum the radius of the convex flank is smallest.",
        )
        .half();
        let depth = Plot::new(
            "Metal removed beyond the cut",
            Axis::new("Meshing angle", "°"),
            Axis::new("Depth", "µm").from_zero(),
        )
        .with(Series::line(
            "depth",
            lobe().into_iter().map(|p| {
                let cut = self.profile.flank_point(p.tau);
                (p.meshing_angle / DEG, (cut - p.worn).norm() / UM)
            }),
        ))
        .noted(
            "Depth in µm normal to the flank by rotation, free form and wear. The two offsets are part of the cut.",
        )
        .half();
        let mut blocks = vec![Block::Plot(outline), Block::Plot(curvature)];
        if depth.series.iter().any(|series| series.points.y.iter().flatten().any(|depth| *depth > 1e-6)) {
            blocks.push(Block::Plot(depth));
        }
        let mut verdict = Verdict::new(
            tone,
            match undercut {
                true => "The flank is undercut: a pin cannot roll on all of it.".to_owned(),
                false => format!("{}.", self.sentence()),
            },
        );
        let inflection = self.profile.inflection();
        verdict.figures = vec![
            KeyFigure::new(
                "Short-width coefficient K1",
                format!("{:.4}", self.profile.short_width_coefficient()),
                "",
                match self.profile.tooth_difference {
                    1 => "eccentricity times pins over the radius of the pin circle",
                    _ => "eccentricity times pins over tooth difference and radius of the pin circle",
                },
            ),
            KeyFigure::new(
                "Inflection",
                inflection.map_or("none".to_owned(), |angle| format!("{:.3}", angle / DEG)),
                if inflection.is_some() { "°" } else { "" },
                "meshing angle at which the flank turns from hollow to convex",
            ),
            KeyFigure {
                tone,
                ..KeyFigure::new(
                    "Sharpest convex radius",
                    match self.is_hollow() {
                        true => "none".to_owned(),
                        false => format!("{:.3}", self.sharpest() / MM),
                    },
                    if self.is_hollow() { "" } else { "mm" },
                    match self.is_hollow() {
                        true => "the flank is hollow up to the tip".to_owned(),
                        false => format!(
                            "at {:.2}°; below 0 the flank is undercut",
                            self.profile.sharpest_convex_trace().1 / DEG
                        ),
                    },
                )
            },
        ];
        Page {
            title: self.name.clone(),
            subtitle: "Flank of the cycloid disc".to_owned(),
            provenance: Provenance::default(),
            verdict,
            sections: vec![Section::new("flank", "Flank", blocks)],
        }
    }

    fn as_any(&self) -> &dyn std::any::Any {
        self
    }
}
