use super::{Finding, Severity, severity_if};
use crate::geometry::{Profile, Tip};
use crate::load::closed_form;
use crate::machine::{Machine, RingPartner};
use crate::units::{DEG, MM, UM};

/// Usual range of K1 for RV reducers; below it the teeth have a poor transmission angle, above it the flank
/// becomes sharp (handbooks: 0.5…0.8, manufacturers' designs up to 0.85).
const SHORT_WIDTH_RANGE: (f64, f64) = (0.45, 0.87);
/// Ratio of the smallest convex flank radius to the pin radius below which pressure and grinding reach their
/// limits.
const SHARPEST_TO_PIN: f64 = 0.2;

/// Ratio of the narrowest land of a tip to the pin radius; an assumption.
const NARROWEST_LAND: f64 = 0.1;

/// Flank of a disc as cut, and pins of the ring as installed (m).
pub struct Teeth<'a> {
    /// Flank as cut, modification included.
    pub profile: &'a Profile,
    /// Radius of the circle of the pin centres as installed, m.
    pub pin_circle_radius: f64,
    /// Radius of the pins as installed, m.
    pub pin_radius: f64,
    /// Separate pins need metal between their seats.
    pub partner: RingPartner,
}

impl Teeth<'_> {
    /// Checks of any disc in a ring of pins.
    pub fn check(&self) -> Vec<Finding> {
        let pins = (self.partner != RingPartner::Teeth).then(|| pin_overlap(self));
        let first = [undercut(self), sharpness(self)].into_iter().chain(pins);
        let tip = self.profile.tip().map(|tip| tip_land(self, tip));
        first.chain([short_width_coefficient(self), root_conformity(self)]).chain(tip).collect()
    }
}

pub(super) fn check(machine: &Machine) -> Vec<Finding> {
    let (profile, ring) = (machine.profile(), &machine.ring);
    let teeth = Teeth {
        profile: &profile,
        pin_circle_radius: ring.pin_circle_radius,
        pin_radius: ring.pin_radius,
        partner: RingPartner::Pins,
    };
    let mut findings = teeth.check();
    findings.extend(root_depth(machine));
    findings.extend(modification_gap(machine));
    findings
}

/// Compares radii where the pin path has a convex part, and curvatures where it has none and the radii are
/// unbounded.
fn undercut(Teeth { profile, .. }: &Teeth<'_>) -> Finding {
    let (curvature, at) = profile.largest_trace_curvature();
    let is_hollow = curvature <= 0.0;
    let broken = curvature * profile.pin_radius >= 1.0;
    let (message, value, limit, unit) = if is_hollow {
        let message = format!(
            "the pin path is hollow up to the tip, with a convex curvature of {:.4} 1/mm at {:.1}°: no pin undercuts the \
             flank",
            curvature * MM,
            at / DEG
        );
        (message, curvature * MM, MM / profile.pin_radius, "1/mm")
    } else {
        let message = format!(
            "the generating pin radius {:.3} mm {} the smallest convex radius of the pin path, {:.3} mm at {:.1}°",
            profile.pin_radius / MM,
            if broken { "exceeds" } else { "stays below" },
            1.0 / curvature / MM,
            at / DEG
        );
        (message, profile.pin_radius / MM, 1.0 / curvature / MM, "mm")
    };
    Finding {
        code: "undercut",
        severity: severity_if(broken, Severity::Error),
        message,
        value,
        limit,
        unit,
        why: "if the pin radius exceeds the smallest convex radius of the pin path, the generating pin cuts off a part of the flank (undercut)",
        change: "smaller pins, smaller eccentricity, or a larger pin circle",
    }
}

/// As [`undercut`], for the flank, the offset of the pin path by the pin radius.
fn sharpness(Teeth { profile, pin_radius, .. }: &Teeth<'_>) -> Finding {
    let (trace, at) = profile.largest_trace_curvature();
    let limit = SHARPEST_TO_PIN * pin_radius;
    let (broken, message, value, limit, unit) = if trace <= 0.0 {
        let curvature = trace / (1.0 - profile.pin_radius * trace);
        let message = format!(
            "the flank is hollow up to the tip, with a convex curvature of {:.4} 1/mm at {:.1}°",
            curvature * MM,
            at / DEG
        );
        (false, message, curvature * MM, MM / limit, "1/mm")
    } else {
        let radius = 1.0 / trace - profile.pin_radius;
        let message =
            format!("the sharpest convex flank radius is {:.3} mm, at {:.1}°", radius / MM, at / DEG);
        (radius < limit, message, radius / MM, limit / MM, "mm")
    };
    Finding {
        code: "flank-sharpness",
        severity: severity_if(broken, Severity::Warning),
        message,
        value,
        limit,
        unit,
        why: "contact pressure increases with the curvature of the flank, and wear with the sliding; a flank with a small radius wears fastest",
        change: "smaller pins, smaller eccentricity, or fewer lobes on the same circle",
    }
}

fn pin_overlap(teeth: &Teeth<'_>) -> Finding {
    let half_pitch = std::f64::consts::PI / teeth.profile.pin_count as f64;
    let distance = 2.0 * teeth.pin_circle_radius * half_pitch.sin();
    let diameter = 2.0 * teeth.pin_radius;
    // Wall between the pin seats, which holds the pins.
    let web = distance - diameter;
    let severity = match web {
        web if web <= 0.0 => Severity::Error,
        web if web < 0.2 * diameter => Severity::Warning,
        _ => Severity::Info,
    };
    Finding {
        code: "pin-overlap",
        severity,
        message: format!(
            "neighbouring pins are {:.3} mm apart, centre to centre; their diameter is {:.3} mm",
            distance / MM,
            diameter / MM
        ),
        value: distance / MM,
        limit: diameter / MM,
        unit: "mm",
        why: "pins must not touch each other, and the housing needs metal between their seats (a fifth of the diameter at least)",
        change: "thinner or fewer pins, or a larger pin circle",
    }
}

fn short_width_coefficient(Teeth { profile, .. }: &Teeth<'_>) -> Finding {
    let k1 = profile.short_width_coefficient();
    let (low, high) = SHORT_WIDTH_RANGE;
    Finding {
        code: "short-width-coefficient",
        severity: severity_if(k1 < low || k1 > high, Severity::Warning),
        message: format!(
            "K1 = {} = {k1:.4}; usual is {low} to {high}",
            if profile.tooth_difference == 1 { "a z_p/R_p" } else { "a z_p/(m R_p)" }
        ),
        value: k1,
        limit: if k1 < low { low } else { high },
        unit: "",
        why: "K1 determines the shape of the teeth: low values cause large radial forces on the bearings, high values flanks of small radius and thin lobes",
        change: "ratio of eccentricity × pin count to pin-circle radius",
    }
}

/// End of the flank, and width of the lobe tips.
fn tip_land(Teeth { profile, pin_radius, .. }: &Teeth<'_>, tip: &Tip) -> Finding {
    let land = tip.land(profile.lobe_count());
    let limit = NARROWEST_LAND * pin_radius;
    // The lever arm is largest where cos φ = K1.
    let longest = profile.short_width_coefficient().min(1.0).acos();
    let is_short = tip.end < longest;
    Finding {
        code: "tip-land",
        severity: severity_if(land < limit || is_short, Severity::Warning),
        message: format!(
            "the lobes end at a diameter of {:.3} mm with lands of {:.3} mm; their flanks reach to {:.1}° of meshing angle{}",
            2.0 * tip.radius / MM,
            land / MM,
            tip.end / DEG,
            match is_short {
                true => format!(", less than the {:.1}° of the longest lever", longest / DEG),
                false => String::new(),
            }
        ),
        value: land / MM,
        limit: limit / MM,
        unit: "mm",
        why: "a tip narrower than a tenth of the pin radius breaks or cannot be manufactured; pins beyond the end of the flank carry \
              nothing, and the others carry more",
        change: match is_short {
            true => "a larger tip diameter (`disc.tip_diameter_mm`), or remove the key",
            false => "a smaller tip diameter (`disc.tip_diameter_mm`), or remove the key",
        },
    }
}

fn root_conformity(Teeth { profile, pin_radius, partner, .. }: &Teeth<'_>) -> Finding {
    let flank = profile.flank_curvature_radius(1.0);
    let pin = *pin_radius;
    // Difference of the radii of curvature of root and pin.
    let difference = flank - pin;
    Finding {
        code: "root-conformity",
        severity: severity_if(difference <= 0.0, Severity::Error),
        message: format!(
            "at the root the flank's radius {:.4} mm {} that of the {}, {:.4} mm, by {:.1} µm",
            flank / MM,
            if difference > 0.0 { "exceeds" } else { "falls short of" },
            partner.one(),
            pin / MM,
            difference.abs() / UM
        ),
        value: flank / MM,
        limit: pin / MM,
        unit: "mm",
        why: "a pin or ring tooth in the root is a nearly conformal contact: displacements of the size of this difference move the contact \
              from one flank to the other, and a root with a smaller radius than the pin touches it at two points",
        change: "a larger equidistant offset, or a smaller pin radius",
    }
}

fn root_depth(machine: &Machine) -> Option<Finding> {
    let disc = &machine.disc;
    let crank_circle = machine.gear_stage.centre_distance();
    let bores =
        (0..machine.crankshafts.count).map(|_| ("a crank bore", crank_circle + disc.crank_bore_radius));
    let holes = disc.holes.iter().map(|hole| ("a hole", hole.centre_radius + hole.radius));
    let centre = (disc.centre_hole_radius > 0.0).then_some(("the centre hole", disc.centre_hole_radius));
    let windows = disc.windows.iter().map(|window| ("a window", window.outer_radius));
    let (name, reach) = bores.chain(holes).chain(windows).chain(centre).max_by(|a, b| a.1.total_cmp(&b.1))?;
    Some(rim(&machine.profile(), machine.ring.pin_radius, name, reach))
}

/// Thickness (m) of metal between the roots and the outermost point of an opening of the disc.
pub fn rim(profile: &Profile, pin_radius: f64, name: &str, reach: f64) -> Finding {
    let rim = profile.root_radius() - reach;
    let limit = 0.75 * pin_radius;
    Finding {
        code: "rim-thickness",
        severity: severity_if(rim < limit, Severity::Warning),
        message: format!("the thickness of the metal between the roots and {name} is {:.2} mm", rim / MM),
        value: rim / MM,
        limit: limit / MM,
        unit: "mm",
        why: "a thin rim bends under the tooth forces and cracks at the root; three quarters of the pin radius is a common lower limit",
        change: "a smaller opening, or one closer to the centre",
    }
}

fn modification_gap(machine: &Machine) -> Option<Finding> {
    let cut = &machine.disc.modification;
    let k1 =
        machine.crankshafts.eccentricity * machine.ring.pin_count as f64 / machine.ring.pin_circle_radius;
    // The closed form is valid for curtate flanks only.
    if k1 >= 1.0 {
        return None;
    }
    let (gap, at) = (1..180)
        .map(|degrees| {
            (
                closed_form::initial_gap(k1, cut.equidistant_offset, cut.radial_offset, degrees as f64 * DEG),
                degrees,
            )
        })
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .unwrap_or((0.0, 0));
    // First order in the offsets: the error is their square divided by the pin radius.
    let broken = gap < -0.01 * UM;
    Some(Finding {
        code: "modification-gap",
        severity: severity_if(broken, Severity::Warning),
        message: if broken {
            format!(
                "after rotation to first contact the offsets leave a gap of {:.2} µm at {at}°: negative, another tooth touches first",
                gap / UM
            )
        } else {
            "the offsets leave no negative gap after rotation to first contact".to_owned()
        },
        value: gap / UM,
        limit: 0.0,
        unit: "µm",
        why: "the closed form of load sharing (Tao2024, eqs. 5–10) assumes that the pin at the longest lever touches first; otherwise its forces are wrong",
        change: "use `--method equilibrium`, or choose offsets with a negative radial and a positive equidistant part in proportion",
    })
}
