//! From measured points to keys of the design.

use std::f64::consts::TAU;
use std::fmt::Write as _;

use super::fit::{self, FlankFit};
use super::points::read_points;
use super::split::{self, FlankSplit};
use super::{ExchangeError, Outline, PointSet, trimmed};
use crate::geometry::{FlankDirection, FlankHarmonic, Profile, Relief, unit};
use crate::machine::{Machine, RingMesh};
use crate::report::{Axis, Plot, Series, Style};
use crate::units::{ARCMIN, DEG, UM};

/// Form in which the deviations are written.
#[derive(Debug, Clone, PartialEq)]
pub enum FlankTarget {
    /// A table for `[[errors.measured_flanks]]`: disc (from 0) and the name under which the table is stored.
    MeasuredFlank {
        /// Disc, counted from 0.
        disc: usize,
        /// Name of the table beside the design file.
        file: String,
    },
    /// `[[errors.flanks]]`, harmonics around the disc (from 0).
    Harmonics {
        /// Disc, counted from 0.
        disc: usize,
    },
    /// `[disc.modification]`: what all lobes have in common, against the theoretical flank of the installed
    /// ring.
    Modification,
}

/// Choices of an import of a measured flank.
#[derive(Debug, Clone, PartialEq)]
pub struct FlankImportOptions {
    /// Form in which the deviations are written.
    pub target: FlankTarget,
    /// Radius of the probe's ball in m where the points are its centres; 0 for points on the flank.
    pub probe_radius: f64,
    /// The origin of the file is the axis of the disc; its run-out then counts. Otherwise the centre is
    /// fitted, and with it the first order of run-out and pitch is gone.
    pub origin_is_axis: bool,
}

/// A measured flank.
#[derive(Debug, Clone, PartialEq)]
pub struct FlankImport {
    /// Points as read.
    pub points: PointSet,
    /// Pose and offset against the designed flank.
    pub fit: FlankFit,
    /// Deviations divided into what all lobes share and what goes around the disc.
    pub split: FlankSplit,
    /// `angle_deg,depth_um` for [`FlankTarget::MeasuredFlank`].
    pub csv: Option<String>,
    /// The keys of the design.
    pub toml: String,
    /// Deviation around the disc, over the tooth, and lobe by lobe.
    pub plots: Vec<Plot>,
}

/// The flank that was to be cut, and where its deviations stand in the design file.
#[derive(Debug, Clone, PartialEq)]
pub struct DesignedFlank {
    /// That the installed ring would generate.
    theoretical: Profile,
    /// As cut, and what is taken off it.
    profile: Profile,
    relief: Relief,
    discs: usize,
    /// Sections of errors and of the disc.
    errors: &'static str,
    disc: &'static str,
}

impl From<&Machine> for DesignedFlank {
    fn from(machine: &Machine) -> DesignedFlank {
        DesignedFlank {
            theoretical: machine.profile().with_pins(machine.ring.pin_circle_radius, machine.ring.pin_radius),
            profile: machine.profile(),
            relief: machine.designed_relief(),
            discs: machine.disc_count,
            errors: "errors",
            disc: "disc",
        }
    }
}

impl DesignedFlank {
    /// Of one of so many discs in a ring, its sections of errors and of the disc.
    pub fn in_ring(mesh: &RingMesh, discs: usize, [errors, disc]: [&'static str; 2]) -> DesignedFlank {
        DesignedFlank {
            theoretical: mesh.profile.with_pins(mesh.ring_circle_radius, mesh.ring_pin_radius),
            profile: mesh.profile.clone(),
            relief: mesh.relief.clone(),
            discs,
            errors,
            disc,
        }
    }
}

/// Reads measured points, finds where they lie, and splits their deviations.
///
/// Deviations are depths of missing metal against the designed flank (for a modification: against the
/// theoretical one), the fitted offset included, the fitted rotation and centre not.
///
/// # Errors
/// Points that cannot be read or fitted, too few or too unevenly spread for what is asked, a disc that the
/// design does not have.
pub fn import_flank(
    design: impl Into<DesignedFlank>,
    bytes: &[u8],
    file: &str,
    options: &FlankImportOptions,
) -> Result<FlankImport, ExchangeError> {
    let design = design.into();
    if let FlankTarget::MeasuredFlank { disc, .. } | FlankTarget::Harmonics { disc } = options.target
        && disc >= design.discs
    {
        return Err(ExchangeError::NoDisc { disc: disc + 1, count: design.discs });
    }
    let millimetres = options.probe_radius * 1e3;
    if !(0.0..=100.0).contains(&millimetres) {
        let what = "a radius of the probe in mm";
        return Err(ExchangeError::Option { what, value: millimetres, low: 0.0, high: 100.0 });
    }
    let points = read_points(bytes, file)?;
    let (profile, relief) = match options.target {
        FlankTarget::Modification => (design.theoretical, Relief::uniform(0.0)),
        _ => (design.profile, design.relief),
    };
    let outline = Outline::new(profile.clone(), relief, 0.0)?;
    let fit = fit::fit(&outline, &points, options.probe_radius, !options.origin_is_axis)?;
    let depths: Vec<(f64, f64)> = fit.distances.iter().map(|(tau, distance)| (*tau, -distance)).collect();
    let split = split::split(&profile, &depths).ok_or_else(|| ExchangeError::Fit {
        message: format!("{} points do not cover every one of {} lobes", depths.len(), profile.lobe_count()),
        remedy: "measure both flanks of every lobe, some ten points each".into(),
    })?;
    let mut csv = None;
    let toml = match &options.target {
        FlankTarget::MeasuredFlank { disc, file } => {
            csv = Some(measured_table(&depths, &profile)?);
            let name = file.replace(['"', '\\'], "_");
            format!(
                "{}[[{}.measured_flanks]]\ndisc = {}\nfile = \"{name}\"\n",
                head(&fit, &split),
                design.errors,
                disc + 1
            )
        }
        FlankTarget::Harmonics { disc } => {
            head(&fit, &split) + &harmonics(&split, (design.errors, *disc), profile.lobe_count())
        }
        FlankTarget::Modification => {
            head(&fit, &split) + &modification(&profile, &depths, &split, design.disc)?
        }
    };
    let plots = plots(&profile, &depths, &split);
    Ok(FlankImport { points, fit, split, csv, toml, plots })
}

fn um(metres: f64) -> String {
    trimmed(metres / UM, 3)
}

fn head(fit: &FlankFit, split: &FlankSplit) -> String {
    let (cumulative, single, run_out) = split.pitch_and_run_out();
    let (low, high) = split.common_range();
    format!(
        "# Best fit: rotation {} arcmin, centre ({}, {}) um, offset {} um, {} points, {} outliers.\n\
         # Missing metal that all lobes have in common: {} um in the mean, {} to {} um.\n\
         # Pitch: cumulative {} um, single {} um; radial run-out {} um; not explained: {} um (standard deviation).\n",
        trimmed(fit.rotation / ARCMIN, 4),
        um(fit.centre.x),
        um(fit.centre.y),
        um(fit.offset),
        fit.distances.len(),
        fit.outliers.len(),
        um(split.modification[0]),
        um(low),
        um(high),
        um(cumulative),
        um(single),
        um(run_out),
        um(split.rest),
    )
}

/// Depths over rising angles; points closer than a millionth of a lobe become one. Over the lands of tips, which no pin reads, they
/// go straight from flank to flank.
fn measured_table(depths: &[(f64, f64)], profile: &Profile) -> Result<String, ExchangeError> {
    let lobes = profile.lobe_count();
    let mut sorted = depths.to_vec();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (pitch, same) = (TAU / lobes as f64, 1e-6 * TAU / lobes as f64);
    let mut merged: Vec<(f64, f64, f64)> = Vec::new();
    for (tau, depth) in sorted {
        match merged.last_mut() {
            Some((first, sum, count)) if tau - *first < same => {
                *sum += depth;
                *count += 1.0;
            }
            _ => merged.push((tau, depth, 1.0)),
        }
    }
    let mut over_lands = Vec::new();
    for (i, (from, depth, count)) in merged.iter().enumerate() {
        let (to, last) = match merged.get(i + 1) {
            Some((to, last, count)) => (*to, last / count),
            None => (merged[0].0 + TAU, merged[0].1 / merged[0].2),
        };
        if to - from > 0.2 * pitch && profile.is_on_land(0.5 * (from + to)) {
            let at =
                |share: f64| (from + share * (to - from), depth / count * (1.0 - share) + last * share, 1.0);
            over_lands.extend((1..4).map(|k| at(0.25 * f64::from(k))));
        }
    }
    // Of the land over the end of the turn part begins it.
    over_lands.iter_mut().for_each(|point: &mut (f64, f64, f64)| point.0 = point.0.rem_euclid(TAU));
    merged.extend(over_lands);
    merged.sort_by(|a, b| a.0.total_cmp(&b.0));
    let next = |i: usize| merged.get(i + 1).map_or(merged[0].0 + TAU, |p| p.0);
    if let Some(at) = (0..merged.len()).find(|i| next(*i) - merged[*i].0 > 0.25 * pitch) {
        return Err(ExchangeError::Fit {
            message: format!(
                "behind {:.3}° on the disc there are no points for {:.3}°; {lobes} lobes need one every {:.3}°",
                merged[at].0 / DEG,
                (next(at) - merged[at].0) / DEG,
                0.25 * pitch / DEG
            ),
            remedy: "measure more densely, or write harmonics instead".into(),
        });
    }
    let mut text = String::from("angle_deg,depth_um\n");
    for (tau, sum, count) in merged {
        let _ = writeln!(text, "{},{}", trimmed(tau / DEG, 9), trimmed(sum / count / UM, 6));
    }
    Ok(text)
}

fn harmonics(split: &FlankSplit, (errors, disc): (&str, usize), lobes: usize) -> String {
    // Amplitudes below three of their standard deviations are noise.
    let noise = (3.0 * split.rest * (2.0 / split.points as f64).sqrt()).max(0.01 * UM);
    let written = |h: &&FlankHarmonic| h.order <= HIGHEST_ORDER && h.amplitude.abs() > noise;
    let common = split.common_harmonics(lobes);
    let mut text = String::new();
    for h in common.iter().chain(&split.harmonics).filter(written) {
        let kind = match h.direction {
            FlankDirection::Inwards => "radial",
            FlankDirection::Around => "pitch",
            FlankDirection::Normal => "profile",
        };
        let _ = writeln!(
            text,
            "\n[[{errors}.flanks]]\ndisc = {}\nkind = \"{kind}\"\norder = {}\namplitude_um = {}\nphase_deg = {}",
            disc + 1,
            h.order,
            um(h.amplitude),
            trimmed(h.phase / DEG, 6)
        );
    }
    text
}

/// Highest order around the disc that a design takes.
const HIGHEST_ORDER: usize = 4000;
/// Largest depth and offset that a design takes, m.
const DEEPEST: f64 = 500.0 * UM;

/// The depth as equidistant and radial offset and rotation, by least squares over all points, where these
/// describe what all lobes have in common; else its least depth as equidistant offset and the rest as free
/// form.
///
/// The three depths are 1, cos ψ and sin ψ of the angle ψ between normal and radius, which stays below some
/// 55°: they trade against each other, so that together they are known far better than each alone.
fn modification(
    profile: &Profile,
    depths: &[(f64, f64)],
    split: &FlankSplit,
    section: &str,
) -> Result<String, ExchangeError> {
    let basis = |phi: f64| {
        let tau = -phi / profile.lobe_count() as f64;
        let outwards = profile.outward_normal(tau).dot(&unit(tau));
        // A larger circle moves the flank outwards: less metal is missing.
        [1.0, -outwards, profile.lever_arm(phi).abs()]
    };
    let solve = |rotation: bool| -> Option<[f64; 3]> {
        let mut matrix = nalgebra::Matrix3::<f64>::zeros();
        let mut load = nalgebra::Vector3::<f64>::zeros();
        for (tau, depth) in depths {
            let mut row = nalgebra::Vector3::from(basis(profile.meshing_angle(*tau)));
            row[2] *= if rotation { 1.0 / profile.largest_lever_arm() } else { 0.0 };
            matrix += row * row.transpose();
            load += *depth * row;
        }
        if !rotation {
            matrix[(2, 2)] = 1.0;
        }
        let solution = matrix.cholesky()?.solve(&load);
        Some([solution[0], solution[1], solution[2] / profile.largest_lever_arm()])
    };
    // A rotation adds nothing to the metal; without one, both offsets take its share.
    let both = solve(true).filter(|solution| solution[2] >= 0.0).or_else(|| solve(false));
    let off = |keys: &[f64; 3]| {
        let rest = |phi: f64| {
            let [_, outwards, lever] = basis(phi);
            (split.common_depth(phi) - keys[0] - keys[1] * outwards - keys[2] * lever).powi(2)
        };
        (Relief::grid(720).map(rest).sum::<f64>() / 720.0).sqrt()
    };
    let known = 0.2 * UM + split.common_noise();
    let described = |keys: &[f64; 3]| off(keys) < known && keys[0].abs().max(keys[1].abs()) < DEEPEST;
    let (keys, free) = match both.filter(described) {
        Some(keys) => (keys, Vec::new()),
        None => {
            let (least, deepest) = split.common_range();
            if least.abs() > DEEPEST || deepest - least > DEEPEST {
                return Err(ExchangeError::Fit {
                    message: format!("metal of {} to {} um is missing", um(least), um(deepest)),
                    remedy: "a modification reaches to 500 um: check the design, the unit (mm) and the radius of the probe"
                        .into(),
                });
            }
            ([least, 0.0, 0.0], free_form(split, least))
        }
    };
    let mut text = format!(
        "[{section}.modification]\nequidistant_offset_um = {}\nradial_offset_um = {}\nrotation_arcmin = {}\n",
        um(keys[0]),
        um(keys[1]),
        trimmed(keys[2] / ARCMIN, 5)
    );
    if !free.is_empty() {
        let pair = |point: &[f64; 2]| format!("[{}, {}]", trimmed(point[0] / DEG, 3), um(point[1].max(0.0)));
        let pairs: Vec<String> = free.iter().map(pair).collect();
        let _ = writeln!(text, "free_form_deg_um = [{}]", pairs.join(", "));
    }
    Ok(text)
}

/// The common depth beyond the least one, from which the design's curve is off by a tenth of a micrometre at
/// most: points every ten degrees, and between them where it takes more, down to one degree.
fn free_form(split: &FlankSplit, least: f64) -> Vec<[f64; 2]> {
    let depth = |phi: f64| split.common_depth(phi) - least;
    let mut angles: Vec<f64> = (-18..18).map(|i| 10.0 * f64::from(i)).collect();
    loop {
        let points: Vec<[f64; 2]> = angles.iter().map(|angle| [angle * DEG, depth(angle * DEG)]).collect();
        let relief = Relief::through(&points);
        let mut added = Vec::new();
        for (index, angle) in angles.iter().enumerate() {
            let next = angles.get(index + 1).copied().unwrap_or(180.0);
            let off = |i: i32| {
                let phi = (angle + (next - angle) * f64::from(i) / 8.0) * DEG;
                (relief.at(phi).depth - depth(phi)).abs()
            };
            if next - angle >= 2.0 && (1..8).map(off).fold(0.0, f64::max) > 0.1 * UM {
                added.push(0.5 * (angle + next));
            }
        }
        if added.is_empty() {
            return points;
        }
        angles.extend(added);
        angles.sort_by(f64::total_cmp);
    }
}

fn plots(profile: &Profile, depths: &[(f64, f64)], split: &FlankSplit) -> Vec<Plot> {
    let thinned = || depths.iter().step_by((depths.len() / 4000).max(1));
    let around = Plot::new(
        "Deviation around the disc",
        Axis::new("angle on the disc", "°"),
        Axis::new("missing metal", "µm"),
    )
    .with(Series::markers("measured", thinned().map(|(tau, depth)| (tau / DEG, depth / UM))))
    .noted("Missing metal in µm against the flank of the design over the angle on the disc, after the best fit and without \
         outliers.");
    let common = Relief::grid(361).map(|phi| (phi / DEG, split.common_depth(phi) / UM));
    let tooth = Plot::new(
        "Deviation over the tooth",
        Axis::new("meshing angle", "°"),
        Axis::new("missing metal", "µm"),
    )
    .with(Series::markers(
        "all lobes",
        thinned().map(|(tau, depth)| (profile.meshing_angle(*tau) / DEG, depth / UM)),
    ))
    .with(Series::line("common to all lobes", common).strong())
    .noted("Missing metal in µm over the meshing angle: measured points of all lobes, and the part common to all lobes.");
    let each = |values: &[f64]| -> Vec<(f64, f64)> {
        values.iter().enumerate().map(|(k, value)| (k as f64 + 1.0, value / UM)).collect()
    };
    let lobes = Plot::new("Deviation of each lobe", Axis::new("lobe", ""), Axis::new("deviation", "µm"))
        .with(Series::new("cumulative pitch", Style::LineMarkers, each(&split.pitch)))
        .with(Series::new("radial", Style::LineMarkers, each(&split.radial)))
        .noted("Deviation of each lobe from the design in µm: cumulative pitch error and radial error.");
    vec![around, tooth, lobes]
}
