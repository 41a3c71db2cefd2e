//! A machine of which only the data sheet is known, scaled from a shipped design.
//!
//! Rules. s is the ratio of the pin circle radius to that of the template. If the outer diameter is given,
//! similar machines have s = D/D₀. If the cube root of the ratio of torques is larger, as for compact machines,
//! the pin circle scales with it instead, up to D = 2.56 R_p; ring and flange of the housing then share the
//! remaining width. Without a diameter s is this cube root. w = (T/T₀)/s³, limited to 0.7 to 1.6, scales axial
//! lengths, so that pressures are near those of the template. [`super::rules`] gives the scaling of every
//! number with s and w. The numbers of teeth give the ratio with the template's pins, with clearance between
//! the planets; the module follows from the circle of the crankshafts. The rated speed is 15 rpm at the output
//! and the service life 6000 h, as in makers' ratings. Diameters of crankshafts can be scaled together with
//! their bearings, with rollers of the same diameter.

use super::lines::{Line, lines, number};
use super::rules::{Rule, rule};
use super::teeth::teeth;
use super::{OutOfRange, Template};

/// Values of a data sheet.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct DataSheet {
    /// Ratio of input to output speed, 20 to 400.
    pub ratio: f64,
    /// Rated torque in N·m.
    pub torque: f64,
    /// Outer diameter in mm.
    pub outer_diameter_mm: Option<f64>,
    /// Number of crankshafts.
    pub crankshafts: Option<f64>,
    /// Torsional stiffness in N·m/arcmin.
    pub stiffness_n_m_per_arcmin: Option<f64>,
    /// Moment stiffness of the main bearings in N·m/arcmin.
    pub moment_stiffness_n_m_per_arcmin: Option<f64>,
    /// Lost motion in arcmin.
    pub lost_motion_arcmin: Option<f64>,
    /// Starting torque at the input in N·m.
    pub starting_torque_n_m: Option<f64>,
    /// Back-driving torque at the output in N·m.
    pub back_driving_torque_n_m: Option<f64>,
}

/// Quantity set by a calibration; all others are scaled.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tuning {
    /// Clearance of the turning-arm bearings, µm.
    pub clearance_um: Option<f64>,
    /// Diameter of the eccentrics relative to the scaled ones.
    pub crankshafts: f64,
    /// Torsional stiffness of the carrier in N·m/arcmin; `None` for a rigid one.
    pub carrier: Option<f64>,
    /// Drag of the seals in N·m at the output.
    pub seal_drag: Option<f64>,
    /// Axial approach of the main bearings' rows, µm.
    pub preload_um: Option<f64>,
}

impl Default for Tuning {
    fn default() -> Tuning {
        Tuning { clearance_um: None, crankshafts: 1.0, carrier: None, seal_drag: None, preload_um: None }
    }
}

/// Reason why no machine can be scaled.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ScaleError {
    /// A value of the data sheet is outside the range of the rules.
    #[error(transparent)]
    Range(#[from] OutOfRange),
    /// No numbers of teeth of sun and planet are close enough to the ratio.
    #[error("no teeth give a ratio of {ratio} with {pins} pins; the nearest ratio is {nearest:.4}")]
    Teeth {
        /// Required ratio.
        ratio: f64,
        /// Pins of the template's ring.
        pins: f64,
        /// Nearest possible ratio.
        nearest: f64,
    },
    /// The tips of neighbouring planets would meet on the circle of the crankshafts.
    #[error("at a ratio of {ratio} the planets of {cranks} crankshafts would touch each other")]
    Planets {
        /// Required ratio.
        ratio: f64,
        /// Number of crankshafts.
        cranks: f64,
    },
    /// Path of a key that the scaling needs but the template does not contain.
    #[error("the template has no `{0}` to scale")]
    Missing(&'static str),
}

/// Rated speed of the output in rpm and service life in h, as in makers' ratings.
const RATED_SPEED_RPM: f64 = 15.0;
const RATED_LIFE_H: f64 = 6000.0;
const STRETCH: (f64, f64) = (0.7, 1.6);
/// Outer radius over pin circle radius: of the templates, and the smallest one.
const OUTER: (f64, f64) = (1.48, 1.28);
/// Seats of the main bearings over pin circle radius, as the default of designs.
const SEAT: f64 = 1.12;
/// Part of the flange's width without the bolt faces, in pin circle radii, as the default of designs.
const FACE_LAND: f64 = 0.05;

/// A scaled template; values set by a calibration are still missing.
#[derive(Debug, Clone, PartialEq)]
pub struct Scaled {
    template: Template,
    sheet: DataSheet,
    /// s, ratio of the pin circle radius to that of the template.
    pub scale: f64,
    /// w, scale of axial lengths, 0.7 to 1.6.
    pub stretch: f64,
    torque_ratio: f64,
    /// Numbers of teeth of sun and planet.
    pub teeth: (u32, u32),
    module_mm: f64,
    crankshafts: f64,
    /// Diameter of the template's eccentrics.
    eccentric_mm: f64,
    pin_circle_mm: f64,
}

/// Rounds to three decimals, so that sums of scaled dimensions remain consistent.
fn thousandths(value: f64) -> f64 {
    (1e3 * value).round() / 1e3
}

/// Shortest decimal number with nine digits.
fn plain(value: f64) -> String {
    let rounded: f64 = format!("{value:.8e}").parse().unwrap_or(value);
    format!("{rounded}")
}

impl Scaled {
    /// # Errors
    /// [`ScaleError`] for values out of range and ratios that no numbers of teeth give.
    pub fn new(template: Template, sheet: DataSheet) -> Result<Scaled, ScaleError> {
        let within = OutOfRange::check;
        within("a ratio", sheet.ratio, 20.0, 400.0)?;
        within("a torque in N·m", sheet.torque, 1.0, 1e5)?;
        for (what, value, low, high) in [
            ("an outer diameter in mm", sheet.outer_diameter_mm, 30.0, 2000.0),
            ("a number of crankshafts", sheet.crankshafts, 2.0, 6.0),
            ("a stiffness in N·m/arcmin", sheet.stiffness_n_m_per_arcmin, 0.1, 1e5),
            ("a moment stiffness in N·m/arcmin", sheet.moment_stiffness_n_m_per_arcmin, 0.1, 1e6),
            ("a lost motion in arcmin", sheet.lost_motion_arcmin, 0.01, 100.0),
            ("a starting torque in N·m", sheet.starting_torque_n_m, 1e-4, 1e4),
            ("a back-driving torque in N·m", sheet.back_driving_torque_n_m, 1e-3, 1e5),
        ] {
            within(what, value.unwrap_or(low), low, high)?;
        }
        let given = |path: &'static str| number(template.text, path).ok_or(ScaleError::Missing(path));
        let pins = given("ring.pin_count")?;
        let (sun, planet) = (given("gear_stage.sun_teeth")?, given("gear_stage.planet_teeth")?);
        let torque_ratio = sheet.torque / given("load.rated_torque_n_m")?;
        let by_torque = torque_ratio.cbrt();
        let scale = thousandths(match sheet.outer_diameter_mm {
            Some(diameter) => {
                let similar = diameter / template.outer_diameter_mm;
                by_torque.clamp(similar, similar * OUTER.0 / OUTER.1)
            }
            None => by_torque,
        });
        within("a size against the template", scale, 0.2, 5.0)?;
        let stretch = thousandths((torque_ratio / scale.powi(3)).clamp(STRETCH.0, STRETCH.1));
        let crankshafts = match sheet.crankshafts {
            Some(count) => count.round(),
            None => given("crankshafts.count")?,
        };
        let teeth = teeth(sheet.ratio, pins, sun + planet, crankshafts)?;
        let centre = scale * 0.5 * given("gear_stage.module_mm")? * (sun + planet);
        let module_mm = (1e4 * 2.0 * centre / f64::from(teeth.0 + teeth.1)).round() / 1e4;
        let eccentric_mm = given("bearings.turning_arm.pitch_diameter_mm")?
            - given("bearings.turning_arm.roller_diameter_mm")?;
        let pin_circle_mm = scale * given("ring.pin_circle_radius_mm")?;
        Ok(Scaled {
            template,
            sheet,
            scale,
            stretch,
            torque_ratio,
            teeth,
            module_mm,
            crankshafts,
            eccentric_mm,
            pin_circle_mm,
        })
    }

    /// Ratio by the numbers of teeth.
    pub fn ratio(&self) -> f64 {
        let pins = number(self.template.text, "ring.pin_count").unwrap_or(0.0);
        1.0 + pins * f64::from(self.teeth.1) / f64::from(self.teeth.0)
    }

    /// Outer diameter in mm, and outer radius over pin circle radius, of a machine whose housing is slimmer
    /// than the template's.
    fn slim_housing(&self) -> Option<(f64, f64)> {
        let diameter = self.sheet.outer_diameter_mm?;
        let outer = 0.5 * diameter / self.pin_circle_mm;
        (outer < 0.995 * OUTER.0).then_some((diameter, outer))
    }

    /// Ring of the housing in pin circle radii: the same share of the radial width outside the bearing seats as
    /// in a housing by the rules (1.25 of 1.12 to 1.48).
    fn slim_ring(outer: f64) -> f64 {
        SEAT + (1.25 - SEAT) / (OUTER.0 - SEAT) * (outer - SEAT)
    }

    /// The design file; `notes` describe calibrated values in its head.
    pub fn text(&self, tuning: &Tuning, notes: &[String]) -> String {
        let name = self.template.name;
        let mut out = String::new();
        let mut head = vec![
            format!("First model of a machine known from its data sheet, scaled from {name}, without measured values."),
            format!(
                "Size of the pin circle x {} (outer diameter of the template {} mm, rated torque x {}), along the axis \
                 x {} besides.",
                plain(self.scale),
                plain(self.template.outer_diameter_mm),
                plain(thousandths(self.torque_ratio)),
                plain(self.stretch)
            ),
            "\"data sheet\": given; \"scaled\": by the rules of `arcmin new --help`; \"calibrated\": set so that the \
             test bench finds"
                .to_owned(),
            "the data sheet's figure; \"kept\": as in the template, and why; \"template\": its own words.".to_owned(),
        ];
        head.extend(notes.iter().cloned());
        for line in &head {
            out.push_str(&format!("# {line}\n"));
        }
        out.push('\n');
        let has_rows = lines(self.template.text).any(|line| line.section == "bearings.main.rows");
        let mut in_head = true;
        for line in lines(self.template.text) {
            in_head &= line.key.is_none();
            if in_head {
                continue;
            }
            let Some(key) = line.key else {
                let starts = line.raw.starts_with('[');
                if let (true, "contact", false, Some(preload)) =
                    (starts, line.section, has_rows, tuning.preload_um)
                {
                    out.push_str(&format!(
                        "[bearings.main.rows]\npreload_um = {}  # {PRELOAD}\n\n",
                        plain(preload)
                    ));
                }
                out.push_str(line.raw);
                out.push('\n');
                if starts {
                    out.push_str(&self.inserted(line.section, tuning));
                }
                continue;
            };
            let path = format!("{}.{key}", line.section);
            if line.section == "unknowns" {
                out.push_str(&self.unknown(&line, tuning));
                continue;
            }
            let (value, why) = match self.value(&path, line.value, tuning) {
                Some((value, why)) => (value, why),
                None => match rule(&path) {
                    Some(Rule::Kept(reason)) => (line.value.to_owned(), format!("kept: {reason}")),
                    _ if line.comment.is_empty() => (line.value.to_owned(), "template".to_owned()),
                    _ => (line.value.to_owned(), format!("template: {}", line.comment)),
                },
            };
            out.push_str(&format!("{key} = {value}  # {why}\n"));
        }
        out
    }

    /// Keys that the template leaves out, behind the head of their section.
    fn inserted(&self, section: &str, tuning: &Tuning) -> String {
        let mut out = String::new();
        match section {
            "carrier" => {
                if let Some(stiffness) = tuning.carrier {
                    out.push_str(&format!(
                        "torsional_stiffness_n_m_per_arcmin = {}  # calibrated: what rigid bodies hold rigid; elastic ones \
                         leave it aside\n",
                        plain(stiffness)
                    ));
                }
            }
            "housing.solid" => {
                if let Some((diameter, outer)) = self.slim_housing() {
                    let face = (outer - Scaled::slim_ring(outer) - FACE_LAND) * self.pin_circle_mm;
                    out.push_str(&format!(
                        "flange_diameter_mm = {}  # data sheet\nbolt_face_diameter_mm = {}  # scaled: the flange's \
                         width less 0.05 R_p\n",
                        plain(diameter),
                        plain(thousandths(face))
                    ));
                }
            }
            "unknowns" => {
                if tuning.carrier.is_some() {
                    out.push_str(
                        "\"carrier.torsional_stiffness_n_m_per_arcmin\" = { factor = 1.5 } # stands for all that rigid \
                         bodies hold rigid\n",
                    );
                }
                out.push_str(
                    "\"load.input_speed_rpm\" = { factor = 1.5 } # the duty is not on a data sheet\n",
                );
            }
            _ => {}
        }
        out
    }

    /// The new value of a key and its source; `None` if the template's value is kept.
    fn value(&self, path: &str, old: &str, tuning: &Tuning) -> Option<(String, String)> {
        if let Some(found) = self.calibrated(path, tuning).or_else(|| self.given(path, old)) {
            return Some(found);
        }
        let (s, w) = (self.scale, self.stretch);
        let factor = match rule(path)? {
            Rule::Size { s: a, w: b } => s.powf(a) * w.powf(b),
            Rule::Grade => s.cbrt(),
            Rule::Seal => (s * s).min(self.torque_ratio),
            Rule::Crank => return self.crank(path, old.parse().ok()?, tuning.crankshafts),
            Rule::Sheet | Rule::Kept(_) => return None,
        };
        let old: f64 = old.parse().ok()?;
        Some((plain(old * factor), format!("scaled: x {}", plain((factor * 1e6).round() / 1e6))))
    }

    /// Value set by a calibration.
    fn calibrated(&self, path: &str, tuning: &Tuning) -> Option<(String, String)> {
        // In a template without friction seals would be the only friction.
        if tuning.seal_drag.is_some()
            && number(self.template.text, path) == Some(0.0)
            && let Some((_, value)) = ASSUMED_FRICTION.iter().find(|(key, _)| *key == path)
        {
            return Some((
                plain(*value),
                "assumed, as on the test bench for designs without friction".to_owned(),
            ));
        }
        let (value, why) = match path {
            "bearings.turning_arm.clearance_um" => {
                (tuning.clearance_um?, "calibrated: gives the lost motion of the data sheet")
            }
            "friction.seal_drag_n_m" => {
                (tuning.seal_drag?, "calibrated: gives the starting or back-driving torque of the data sheet")
            }
            "bearings.main.rows.preload_um" => (tuning.preload_um?, PRELOAD),
            _ => return None,
        };
        Some((plain(value), why.to_owned()))
    }

    /// Value from the data sheet or derived from it.
    fn given(&self, path: &str, old: &str) -> Option<(String, String)> {
        let sheet = &self.sheet;
        let (base, sun, planet) = (self.template.name, self.teeth.0, self.teeth.1);
        let data = |value: f64| Some((plain(value), "data sheet".to_owned()));
        let entry = |value: String, why: &str| Some((value, why.to_owned()));
        match path {
            ".name" => entry(
                format!("\"like {base}, {} N m, ratio {}\"", plain(sheet.torque), plain(sheet.ratio)),
                "scaled",
            ),
            ".description" => entry(format!("\"Scaled from {base} to a data sheet\""), "scaled"),
            "load.rated_torque_n_m" | "duty.torque_n_m" => data(sheet.torque),
            "load.input_speed_rpm" | "duty.input_speed_rpm" => {
                entry(plain(RATED_SPEED_RPM * self.ratio()), "15 rpm at the output, as makers rate it")
            }
            "crankshafts.count" => sheet.crankshafts.and_then(|_| data(self.crankshafts)),
            "gear_stage.ratio" => data(sheet.ratio),
            "gear_stage.sun_teeth" => entry(sun.to_string(), "scaled: gives the ratio"),
            "gear_stage.planet_teeth" => entry(planet.to_string(), "scaled: gives the ratio"),
            "gear_stage.module_mm" => {
                entry(plain(self.module_mm), "scaled: follows from teeth and crankshaft circle")
            }
            "crankshafts.circle_radius_mm" => entry(
                plain(0.5 * self.module_mm * f64::from(sun + planet)),
                "scaled: follows from teeth and module",
            ),
            "limits.service_life_h" => entry(plain(RATED_LIFE_H), "life of makers' ratings"),
            "limits.lost_motion_arcmin" => {
                let limit: f64 = old.parse().ok()?;
                let found = sheet.lost_motion_arcmin.filter(|lost| *lost >= limit)?;
                entry(plain(1.5 * found), "half more than the data sheet's")
            }
            "housing.solid.body_diameter_mm" => {
                let (_, outer) = self.slim_housing()?;
                let diameter = 2.0 * Scaled::slim_ring(outer) * self.pin_circle_mm;
                entry(
                    plain(thousandths(diameter)),
                    "scaled: shares what the outer diameter leaves with the flange",
                )
            }
            _ => None,
        }
    }

    /// Diameters of the crankshafts, increased by the same amount as the eccentrics, so that shoulders and
    /// rings are kept; as many rollers as fit on the larger circle.
    fn crank(&self, path: &str, old: f64, factor: f64) -> Option<(String, String)> {
        let more = (factor - 1.0) * self.scale * self.eccentric_mm;
        let why = if factor == 1.0 {
            "scaled".to_owned()
        } else {
            format!(
                "calibrated: eccentrics x {} give the stiffness of the data sheet",
                plain(thousandths(factor))
            )
        };
        let Some(bearing) = path.strip_suffix(".roller_count") else {
            return Some((plain(thousandths(self.scale * old + more)), why));
        };
        let pitch = self.scale * number(self.template.text, &format!("{bearing}.pitch_diameter_mm"))?;
        let count = (old * (pitch + more) / pitch * (1.0 + 1e-9)).floor().max(3.0);
        Some((plain(count), why))
    }

    /// Range of an unknown, scaled with its key.
    fn unknown(&self, line: &Line<'_>, tuning: &Tuning) -> String {
        let unchanged = format!("{}\n", line.raw);
        let Some(path) = line.key.map(|key| key.trim_matches('"').replace("[0]", "")) else {
            return unchanged;
        };
        // Dimensions from the data sheet, or between the bearing seats and its outer diameter, are known.
        let counted = path == "crankshafts.count" && self.sheet.crankshafts.is_some();
        if counted || (path == "housing.solid.body_diameter_mm" && self.slim_housing().is_some()) {
            return String::new();
        }
        let (section, key) = path.rsplit_once('.').unwrap_or(("", path.as_str()));
        let bounds = |name: &str| {
            let rest = line.value.split(&format!("{name} = ")).nth(1)?;
            let end = rest.find([',', ' ', '}']).unwrap_or(rest.len());
            rest[..end].parse::<f64>().ok()
        };
        let (Some(low), Some(high)) = (bounds("low"), bounds("high")) else { return unchanged };
        let of = lines(self.template.text).find(|l| l.section == section && l.key == Some(key));
        let old = of.as_ref().and_then(|of| of.value.parse::<f64>().ok());
        let new =
            of.and_then(|of| self.value(&path, of.value, tuning)).and_then(|(text, _)| text.parse().ok());
        // A range around zero, or of a key with its default, is scaled by the rule of the key.
        let by_rule = || {
            let (text, _) = self.value(&path, "1", &Tuning::default())?;
            matches!(rule(&path)?, Rule::Size { .. } | Rule::Seal | Rule::Grade).then_some(())?;
            text.parse::<f64>().ok()
        };
        let factor = match (old, new) {
            (Some(old), Some(new)) if old != 0.0 && new != 0.0 => Some(new / old),
            _ => by_rule(),
        };
        let Some(factor) = factor.filter(|factor| *factor != 1.0) else { return unchanged };
        let (a, b) = (low * factor, high * factor);
        let nominal = new.or(old).unwrap_or(a);
        format!(
            "{} = {{ low = {}, high = {} }} # template, scaled: {}\n",
            line.key.unwrap_or_default(),
            plain(a.min(b).min(nominal)),
            plain(a.max(b).max(nominal)),
            line.comment
        )
    }
}

/// Friction coefficients, if seals are calibrated in a machine from a template without friction.
const ASSUMED_FRICTION: [(&str, f64); 4] = [
    ("friction.flank_coefficient", 0.06),
    ("friction.pin_seat_coefficient", 0.06),
    ("friction.bearing_coefficient", 0.002),
    ("friction.gear_mesh_coefficient", 0.06),
];

const PRELOAD: &str = "calibrated: gives the moment stiffness of the data sheet";

#[cfg(test)]
#[path = "like_tests.rs"]
mod tests;
