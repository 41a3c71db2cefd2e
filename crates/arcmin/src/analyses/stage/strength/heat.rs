//! The temperature at which the drive gives off its losses by its surface, and the part that softens first.

use crate::analyses::stage::EccentricDrive;
use crate::analyses::stage::meshing::Rests;
use crate::analyses::{AnalysisError, NoHost};
use crate::checks::{Finding, Severity, severity_if};
use crate::dynamics::StageLosses;
use crate::machine::{REFERENCE_C, StageThermal};
use crate::units::UM;

/// A drive at the mean loss of its duty.
#[derive(Debug, Clone)]
pub struct HeatBalance {
    /// Loss of the drive, without a motor, W.
    pub loss: f64,
    /// m².
    pub surface: f64,
    thermal: StageThermal,
    /// °C.
    pub temperature: f64,
    /// Whether the coefficients of friction are assumed.
    assumed: bool,
    /// The part that softens first, with its material and temperature in °C.
    pub softest: Option<(&'static str, String, f64)>,
    /// Growth (m) of the gap between flank and ring pins by different thermal expansion of housing and discs.
    pub gap_growth: Option<f64>,
}

/// Positions over a turn of the input.
const POSITIONS: usize = 12;

impl HeatBalance {
    /// # Errors
    /// [`AnalysisError`] where a static equilibrium is not found.
    pub(super) fn of(design: &impl EccentricDrive) -> Result<HeatBalance, AnalysisError> {
        let thermal = design.thermal();
        let bodies = design.bodies();
        let length: f64 = bodies.iter().map(|body| 2.0 * body.discs as f64 * body.width).sum();
        let surfaces = bodies.iter().map(|body| body.mesh.housing_surface(length));
        let surface = thermal.surface.unwrap_or_else(|| surfaces.fold(0.0, f64::max));
        let (friction, assumed) = design.friction();
        let mut rests = Rests::new(design, &[], 0.0, &NoHost)?;
        let angles = design.angles(POSITIONS);
        let mut loss = 0.0;
        for row in design.duty_points().iter().filter(|row| row.wears()) {
            let mut losses = vec![StageLosses::default(); friction.len()];
            for angle in &angles {
                let place = rests.at(*angle, row.torque)?;
                for (mean, here) in losses.iter_mut().zip(rests.joints().losses(&place, &friction)) {
                    mean.add(1.0 / angles.len() as f64, &here);
                }
            }
            let output = (row.torque * row.input_speed / design.ratio()).abs();
            loss += row.share * output * (1.0 / design.efficiency(row.torque, &losses).forward - 1.0);
        }
        let temperature = thermal.temperature(loss, surface);
        let parts = bodies.iter().flat_map(|body| {
            let pins = body.pins.map(|(_, beam)| ("output pins", &beam.material));
            [Some(("discs", body.disc)), Some((body.mesh.partner().all_of_ring(), body.ring)), pins]
                .into_iter()
                .flatten()
        });
        let softening = parts.filter_map(|(part, material)| {
            Some((part, material.name.clone(), material.softening_temperature?))
        });
        let softest = softening.min_by(|a, b| a.2.total_cmp(&b.2));
        let gap_growth = thermal.housing_expansion.and_then(|housing| {
            let body = bodies.last()?;
            let strain = housing - body.disc.thermal_expansion?;
            Some(body.mesh.ring_circle_radius * strain * (temperature - REFERENCE_C))
        });
        Ok(HeatBalance { loss, surface, thermal, temperature, assumed, softest, gap_growth })
    }
}

fn softening(severity: Severity, message: String, [value, limit]: [f64; 2]) -> Finding {
    Finding {
        code: "softening",
        severity,
        message,
        value,
        limit,
        unit: "°C",
        why: "plastics soften at their glass transition or heat deflection temperature and creep well below it; contacts are warmer than \
              the mean of the drive that is computed here",
        change: "less friction or speed, a larger or ventilated surface ([thermal]), a motor that is kept apart, or another material",
    }
}

pub(super) fn findings(heat: &Result<HeatBalance, String>) -> Vec<Finding> {
    let heat = match heat {
        Ok(heat) => heat,
        Err(why) => {
            let message = format!("no temperature can be computed: {why}");
            return vec![softening(Severity::Warning, message, [0.0; 2])];
        }
    };
    let mut all = Vec::new();
    if let Some((part, material, limit)) = &heat.softest {
        let StageThermal { ambient, transfer, other_heat, .. } = heat.thermal;
        let motor =
            if other_heat > 0.0 { format!(" and {other_heat} W of the motor") } else { String::new() };
        let assumed = if heat.assumed { ", friction assumed" } else { "" };
        let message = format!(
            "losses of {:.2} W{motor} leave a surface of {:.0} cm² by {transfer} W/(m²·K) at {:.0} °C, in surroundings of {ambient} \
             °C{assumed}; the lowest limit is {limit} °C, of {material} ({part})",
            heat.loss,
            heat.surface * 1e4,
            heat.temperature
        );
        let severity = severity_if(heat.temperature > *limit, Severity::Warning);
        all.push(softening(severity, message, [heat.temperature, *limit]));
    }
    all.extend(heat.gap_growth.map(|growth| Finding {
        code: "thermal-gap",
        severity: Severity::Info,
        message: format!(
            "at {:.0} °C the radius of the ring has grown against the discs by {:.1} µm",
            heat.temperature,
            growth / UM
        ),
        value: growth / UM,
        limit: 0.0,
        unit: "µm",
        why: "discs that expand more than their housing close the gap of the flank; results are those of the drive as drawn, at 20 °C",
        change: "discs and housing of one material, or an equidistant offset that leaves room",
    }));
    all
}
