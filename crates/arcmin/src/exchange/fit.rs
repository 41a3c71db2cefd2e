//! Pose of a measured flank: rotation, centre and offset of the best fit.

use nalgebra::{Matrix4, Vector4};

use super::points::PointSet;
use super::{ExchangeError, Outline, OutlineTable};
use crate::geometry::{Vec2, quarter_turn, turned, unit};
use crate::units::{UM, wrap_angle};

/// A point that does not belong to the flank.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Outlier {
    /// Line in the file.
    pub line: usize,
    /// Distance from the fitted flank in m, outside positive.
    pub distance: f64,
}

/// Pose of a measured flank relative to the designed one.
#[derive(Debug, Clone, PartialEq)]
pub struct FlankFit {
    /// Rotation of the measured flank in rad, counter-clockwise, within half a lobe.
    pub rotation: f64,
    /// Its centre in the frame of the file, m.
    pub centre: Vec2,
    /// Its equidistant offset in m, outwards positive, after subtraction of the probe radius.
    pub offset: f64,
    /// Robust standard deviation of the residuals in m.
    pub deviation: f64,
    /// Points that do not belong to the flank and are excluded.
    pub outliers: Vec<Outlier>,
    /// τ on the disc in rad and distance in m (outwards positive, including the offset) of every accepted
    /// point.
    pub distances: Vec<(f64, f64)>,
}

/// Rotation, centre and offset.
#[derive(Debug, Clone, Copy)]
struct Pose {
    rotation: f64,
    centre: Vec2,
    offset: f64,
}

/// Tukey's constant: weights are zero beyond this number of standard deviations.
const TUKEY: f64 = 4.685;

impl Pose {
    fn local(&self, point: Vec2) -> Vec2 {
        turned(point - self.centre, unit(-self.rotation))
    }
}

/// Fits an outline to points by the Gauss–Newton method on their distances with Tukey's weights.
///
/// The distance of a ball's centre from the flank is exactly that of the contact point plus the ball's radius,
/// because parallel curves have the same normals; therefore `probe_radius` is subtracted from every distance.
/// The start is the centre of the circle through the points and the best of 48 rotations over a lobe.
///
/// # Errors
/// Fewer than 50 points, points that do not lie on a closed flank of this size, or an ambiguous fit.
pub(super) fn fit(
    outline: &Outline,
    set: &PointSet,
    probe_radius: f64,
    free_centre: bool,
) -> Result<FlankFit, ExchangeError> {
    let wrong = |message: String, remedy: &str| ExchangeError::Fit { message, remedy: remedy.into() };
    if set.points.len() < 50 {
        let message = format!("{} points are too few for a fit", set.points.len());
        return Err(wrong(message, "measure the whole flank with several points a lobe"));
    }
    let profile = outline.profile();
    let expected = profile.pin_circle_radius - profile.pin_radius + probe_radius;
    let centre = if free_centre { circle_centre(&set.points, expected) } else { Some(Vec2::zeros()) };
    let Some(centre) = centre else {
        return Err(wrong("the points do not lie around a disc".to_owned(), "measure around the whole disc"));
    };
    let mut radii: Vec<f64> = set.points.iter().map(|p| (p - centre).norm()).collect();
    radii.sort_by(f64::total_cmp);
    let middle = radii[radii.len() / 2];
    // The radius of the edge varies by the eccentricity about its mean circle.
    if (middle - expected).abs() > 2.5 * profile.eccentricity + 0.02 * expected {
        let message = format!(
            "the points lie around a circle of {:.3} mm, the flank of this design around {:.3} mm",
            middle * 1e3,
            expected * 1e3
        );
        return Err(wrong(message, "check the design, the unit (mm) and the radius of the probe"));
    }
    let table = outline.table();
    let stride = (set.points.len() / 1500).max(1);
    let few: Vec<Vec2> = set.points.iter().step_by(stride).copied().collect();
    let pitch = outline.lobe_pitch();
    let mut starts: Vec<(f64, Pose)> = (0..48)
        .map(|i| Pose { rotation: pitch * (f64::from(i) / 48.0 - 0.5), centre, offset: 0.0 })
        .map(|pose| {
            let found = distances(outline, &table, &few, &pose, probe_radius);
            (median(&mut found.iter().map(|(_, d)| d.abs()).collect::<Vec<_>>()), pose)
        })
        .collect();
    starts.sort_by(|a, b| a.0.total_cmp(&b.0));
    let best = starts[..3]
        .iter()
        .map(|(_, start)| refine(outline, &table, &few, *start, probe_radius, free_centre))
        .min_by(|a, b| a.1.total_cmp(&b.1));
    let Some((start, _)) = best else {
        return Err(wrong("no start for the fit".to_owned(), "measure more points"));
    };
    let (pose, scale) = refine(outline, &table, &set.points, start, probe_radius, free_centre);
    let size = 0.25 * profile.eccentricity;
    if !(scale < size) {
        let message =
            format!("the standard deviation of the points after the best fit is {:.1} µm", scale / UM);
        return Err(wrong(message, "check that the file is the flank of this design, in mm"));
    }
    check_normals(outline, set, &pose, &table)?;
    let rotation = wrap_angle(pose.rotation);
    let lobes = (rotation / pitch).round();
    // The flank is periodic with the lobes; the smallest rotation is returned.
    let pose = Pose { rotation: rotation - lobes * pitch, ..pose };
    let limit = TUKEY * scale.max(1e-9);
    let mut outliers = Vec::new();
    let mut belonging = Vec::new();
    for (index, (tau, distance)) in
        distances(outline, &table, &set.points, &pose, probe_radius).into_iter().enumerate()
    {
        // Points on lands of tips do not belong to flanks.
        if profile.is_on_land(tau) {
            continue;
        }
        if (distance - pose.offset).abs() > limit {
            outliers.push(Outlier { line: set.lines[index], distance: distance - pose.offset });
        } else {
            belonging.push((tau, distance));
        }
    }
    Ok(FlankFit {
        rotation: pose.rotation,
        centre: pose.centre,
        offset: pose.offset,
        deviation: scale,
        outliers,
        distances: belonging,
    })
}

/// The normals in the file must agree with those of the flank within 15° for nine of ten points; a mirrored
/// file, or one with exchanged columns, fails this check.
fn check_normals(
    outline: &Outline,
    set: &PointSet,
    pose: &Pose,
    table: &OutlineTable,
) -> Result<(), ExchangeError> {
    let Some(normals) = &set.normals else { return Ok(()) };
    let agreeing = set
        .points
        .iter()
        .zip(normals)
        .filter(|(point, normal)| {
            let (_, tau) = outline.distance(pose.local(**point), table);
            let own = turned(outline.at(tau).outward_normal(), unit(pose.rotation));
            own.dot(normal).abs() > 0.966
        })
        .count();
    if 10 * agreeing >= 9 * set.points.len() {
        return Ok(());
    }
    Err(ExchangeError::Fit {
        message: format!("only {agreeing} of {} normals agree with the fitted flank", set.points.len()),
        remedy: "check the order of the columns and the direction of the z axis, or remove the normals"
            .into(),
    })
}

/// Foot and distance of every point, less the probe radius.
fn distances(
    outline: &Outline,
    table: &OutlineTable,
    points: &[Vec2],
    pose: &Pose,
    probe_radius: f64,
) -> Vec<(f64, f64)> {
    use rayon::prelude::*;
    points
        .par_iter()
        .map(|point| {
            let (distance, tau) = outline.distance(pose.local(*point), table);
            (tau, distance - probe_radius)
        })
        .collect()
}

/// Iteratively reweighted least squares from a start: the pose and the robust standard deviation.
fn refine(
    outline: &Outline,
    table: &OutlineTable,
    points: &[Vec2],
    start: Pose,
    probe_radius: f64,
    free_centre: bool,
) -> (Pose, f64) {
    let mut pose = start;
    let mut scale = f64::INFINITY;
    for _ in 0..40 {
        let found = distances(outline, table, points, &pose, probe_radius);
        let on_flank = |tau: f64| !outline.profile().is_on_land(tau);
        let on_flanks = found.iter().filter(|(tau, _)| on_flank(*tau));
        let mut sizes: Vec<f64> = on_flanks.map(|(_, d)| (d - pose.offset).abs()).collect();
        scale = 1.482_602 * median(&mut sizes);
        let limit = TUKEY * scale.max(1e-9);
        let mut matrix = Matrix4::<f64>::zeros();
        let mut load = Vector4::<f64>::zeros();
        for ((tau, distance), point) in found.iter().zip(points) {
            let rest = distance - pose.offset;
            let share = rest / limit;
            if share.abs() >= 1.0 || !on_flank(*tau) {
                continue;
            }
            let weight = (1.0 - share * share).powi(2);
            let normal = turned(outline.at(*tau).outward_normal(), unit(pose.rotation));
            // d = (R(−θ)(x − c) − f)·n: a displacement of the centre by δ reduces d by δ·n, a rotation by δθ by
            // δθ n·J(x − c).
            let turn = normal.dot(&quarter_turn(point - pose.centre));
            let row = match free_centre {
                true => Vector4::new(normal.x, normal.y, turn, 1.0),
                false => Vector4::new(0.0, 0.0, turn, 1.0),
            };
            matrix += weight * row * row.transpose();
            load += weight * rest * row;
        }
        if !free_centre {
            matrix[(0, 0)] = 1.0;
            matrix[(1, 1)] = 1.0;
        }
        let Some(step) = matrix.cholesky().map(|factors| factors.solve(&load)) else { break };
        pose.centre += Vec2::new(step[0], step[1]);
        pose.rotation += step[2].clamp(-0.1 * outline.lobe_pitch(), 0.1 * outline.lobe_pitch());
        pose.offset += step[3];
        let size = step[0].abs()
            + step[1].abs()
            + step[3].abs()
            + step[2].abs() * outline.profile().pin_circle_radius;
        // Convergence at a tenth of a nanometre.
        if size < 1e-10 {
            break;
        }
    }
    (pose, scale)
}

/// Centre of the best circle through the points: Kåsa's fit, repeated without points whose deviation exceeds
/// three times the median; `None` for points on a line.
fn circle_centre(points: &[Vec2], expected: f64) -> Option<Vec2> {
    let mut used: Vec<Vec2> = points.to_vec();
    let mut centre = Vec2::zeros();
    for _ in 0..4 {
        let mean = used.iter().sum::<Vec2>() / used.len() as f64;
        let mut matrix = nalgebra::Matrix3::<f64>::zeros();
        let mut load = nalgebra::Vector3::<f64>::zeros();
        for p in &used {
            let q = (p - mean) / expected;
            let row = nalgebra::Vector3::new(q.x, q.y, 1.0);
            matrix += row * row.transpose();
            load += q.norm_squared() * row;
        }
        let solution = matrix.cholesky()?.solve(&load);
        centre = mean + 0.5 * expected * Vec2::new(solution[0], solution[1]);
        if !(centre - mean).norm().is_finite() {
            return None;
        }
        let radii: Vec<f64> = points.iter().map(|p| (p - centre).norm()).collect();
        let middle = median(&mut radii.clone());
        let off: Vec<f64> = radii.iter().map(|r| (r - middle).abs()).collect();
        let limit = 3.0 * median(&mut off.clone());
        used = points.iter().zip(&off).filter(|(_, off)| **off <= limit).map(|(p, _)| *p).collect();
        if used.len() < 10 {
            return None;
        }
    }
    // Points on a part of the edge only do not determine the centre.
    let mut angles: Vec<f64> = used.iter().map(|p| (p - centre).y.atan2((p - centre).x)).collect();
    angles.sort_by(f64::total_cmp);
    let mut gap = angles[0] + std::f64::consts::TAU - angles[angles.len() - 1];
    gap = angles.windows(2).map(|pair| pair[1] - pair[0]).fold(gap, f64::max);
    (gap < 2.0).then_some(centre)
}

fn median(values: &mut [f64]) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}
