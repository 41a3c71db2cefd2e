//! A machine known from its data sheet alone, scaled from a shipped design.
//!
//! Rules. s is the ratio of the outer diameters (without one, the cube root of the ratio of the torques): all
//! dimensions across the axis go with s. w = (T/T₀)/s³, kept between 0.7 and 1.6, stretches what lies along the
//! axis, so that pressures stay near those of the template. Masses go with s³ w, inertias with s⁵ w, mesh
//! stiffness with s w, stiffness of supports and damping with s. Teeth are chosen to give the ratio with the
//! template's pins; the module follows from the circle of the crankshafts. The rated speed is 15 rpm at the
//! output, the service life 6000 h, as makers rate them.

use super::Template;

/// What a data sheet says.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DataSheet {
    pub ratio: f64,
    /// Rated torque in N·m.
    pub torque: f64,
    /// mm.
    pub outer_diameter_mm: Option<f64>,
    /// N·m/arcmin.
    pub stiffness_n_m_per_arcmin: Option<f64>,
    /// arcmin.
    pub lost_motion_arcmin: Option<f64>,
}

/// Why no machine can be scaled so.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ScaleError {
    #[error("{what} of {value} is outside of {low} to {high}")]
    Range { what: &'static str, value: f64, low: f64, high: f64 },
    #[error("no teeth give a ratio of {ratio} with {pins} pins; the nearest ratio is {nearest:.4}")]
    Teeth { ratio: f64, pins: f64, nearest: f64 },
    #[error("the template has no `{0}` to scale")]
    Missing(&'static str),
}

/// Rated speed of the output in rpm and life in h of makers.
const RATED_SPEED_RPM: f64 = 15.0;
const RATED_LIFE_H: f64 = 6000.0;
const STRETCH: (f64, f64) = (0.7, 1.6);

/// A template with everything scaled; clearance and compliance are still open.
#[derive(Debug, Clone, PartialEq)]
pub struct Scaled {
    template: Template,
    sheet: DataSheet,
    /// s and w.
    pub scale: f64,
    pub stretch: f64,
    /// Teeth of sun and planet.
    pub teeth: (u32, u32),
    module_mm: f64,
}

/// Three decimals, so that sums of scaled dimensions stay sums.
fn thousandths(value: f64) -> f64 {
    (1e3 * value).round() / 1e3
}

/// Shortest decimal with nine digits.
fn plain(value: f64) -> String {
    let rounded: f64 = format!("{value:.8e}").parse().unwrap_or(value);
    format!("{rounded}")
}

impl Scaled {
    /// # Errors
    /// [`ScaleError`] for values that are not believable and ratios that no teeth give.
    pub fn new(template: Template, sheet: DataSheet) -> Result<Scaled, ScaleError> {
        let within = |what, value: f64, low, high| {
            if (low..=high).contains(&value) {
                Ok(())
            } else {
                Err(ScaleError::Range { what, value, low, high })
            }
        };
        within("a ratio", sheet.ratio, 20.0, 400.0)?;
        within("a torque in N·m", sheet.torque, 1.0, 1e5)?;
        within("an outer diameter in mm", sheet.outer_diameter_mm.unwrap_or(100.0), 30.0, 2000.0)?;
        within("a stiffness in N·m/arcmin", sheet.stiffness_n_m_per_arcmin.unwrap_or(1.0), 0.1, 1e5)?;
        within("a lost motion in arcmin", sheet.lost_motion_arcmin.unwrap_or(1.0), 0.01, 100.0)?;
        let given = |section: &str, key: &'static str| {
            let found = lines(template.text).find(|line| line.section == section && line.key == Some(key));
            found.and_then(|line| line.value.parse::<f64>().ok()).ok_or(ScaleError::Missing(key))
        };
        let pins = given("ring", "pin_count")?;
        let (sun, planet) = (given("gear_stage", "sun_teeth")?, given("gear_stage", "planet_teeth")?);
        let torque = given("load", "rated_torque_n_m")?;
        let scale = match sheet.outer_diameter_mm {
            Some(diameter) => diameter / template.outer_diameter_mm,
            None => (sheet.torque / torque).cbrt(),
        };
        let scale = thousandths(scale);
        within("a size against the template", scale, 0.2, 5.0)?;
        let stretch = thousandths((sheet.torque / torque / scale.powi(3)).clamp(STRETCH.0, STRETCH.1));
        let teeth = teeth(sheet.ratio, pins, sun + planet)?;
        let centre = scale * 0.5 * given("gear_stage", "module_mm")? * (sun + planet);
        let module_mm = (1e4 * 2.0 * centre / f64::from(teeth.0 + teeth.1)).round() / 1e4;
        Ok(Scaled { template, sheet, scale, stretch, teeth, module_mm })
    }

    /// Ratio that the teeth give.
    pub fn ratio(&self) -> f64 {
        let pins = lines(self.template.text)
            .find(|line| line.section == "ring" && line.key == Some("pin_count"))
            .and_then(|line| line.value.parse::<f64>().ok());
        1.0 + pins.unwrap_or(0.0) * f64::from(self.teeth.1) / f64::from(self.teeth.0)
    }

    /// The design file with this clearance of the turning-arm bearings (µm) and torsional stiffness of the carrier
    /// (N·m/arcmin; left out where rigid); `notes` say in the head how they were found.
    pub fn text(&self, clearance_um: Option<f64>, carrier: Option<f64>, notes: &[String]) -> String {
        let name = self.template.name;
        let mut out = String::new();
        let mut head = vec![
            format!("First model of a machine known from its data sheet, scaled from {name}: nothing here is measured."),
            format!(
                "Size x {} (outer diameter against {} mm of the template), along the axis x {} besides.",
                plain(self.scale),
                plain(self.template.outer_diameter_mm),
                plain(self.stretch)
            ),
            "\"data sheet\": given; \"scaled\": by the rules of `arcmin new --help`; \"calibrated\": set so that the \
             test bench finds"
                .to_owned(),
            "the data sheet's figure; \"template\": kept, with the template's own words.".to_owned(),
        ];
        head.extend(notes.iter().cloned());
        for line in &head {
            out.push_str(&format!("# {line}\n"));
        }
        out.push('\n');
        let mut in_head = true;
        for line in lines(self.template.text) {
            in_head &= line.key.is_none();
            if in_head {
                continue;
            }
            let Some(key) = line.key else {
                out.push_str(line.raw);
                out.push('\n');
                if let ("carrier", Some(stiffness), true) = (line.section, carrier, line.raw.starts_with('['))
                {
                    out.push_str(&format!(
                        "torsional_stiffness_n_m_per_arcmin = {}  # calibrated: what the stiffness of the data sheet leaves\n",
                        plain(stiffness)
                    ));
                }
                if line.section == "unknowns" && line.raw.starts_with('[') {
                    if carrier.is_some() {
                        out.push_str(
                            "\"carrier.torsional_stiffness_n_m_per_arcmin\" = { factor = 1.5 } # stands for all that the \
                             template holds rigid\n",
                        );
                    }
                    out.push_str(
                        "\"load.input_speed_rpm\" = { factor = 1.5 } # the duty is not on a data sheet\n",
                    );
                }
                continue;
            };
            let path = format!("{}.{key}", line.section);
            if line.section == "unknowns" {
                out.push_str(&self.unknown(&line, clearance_um));
            } else if let Some((value, why)) = self.value(&path, line.value, clearance_um) {
                out.push_str(&format!("{key} = {value}  # {why}\n"));
            } else if line.comment.is_empty() {
                out.push_str(&format!("{key} = {}  # template\n", line.value));
            } else {
                out.push_str(&format!("{key} = {}  # template: {}\n", line.value, line.comment));
            }
        }
        out
    }

    /// The new value of a key and where it is from; `None` where the template's stays.
    fn value(&self, path: &str, old: &str, clearance_um: Option<f64>) -> Option<(String, String)> {
        let (s, w, sheet) = (self.scale, self.stretch, &self.sheet);
        let old_number = || old.parse::<f64>().ok();
        let speed = || plain(RATED_SPEED_RPM * self.ratio());
        let data = |value: f64| Some((plain(value), "data sheet".to_owned()));
        let (base, sun, planet) = (self.template.name, self.teeth.0, self.teeth.1);
        match path {
            ".name" => {
                return Some((
                    format!("\"like {base}, {} N m, ratio {}\"", plain(sheet.torque), plain(sheet.ratio)),
                    "scaled".into(),
                ));
            }
            ".description" => {
                return Some((
                    format!("\"Scaled from {base} and calibrated to a data sheet\""),
                    "scaled".into(),
                ));
            }
            "load.rated_torque_n_m" | "duty.torque_n_m" => return data(sheet.torque),
            "load.input_speed_rpm" | "duty.input_speed_rpm" => {
                return Some((speed(), "15 rpm at the output, as makers rate it".into()));
            }
            "gear_stage.ratio" => return data(sheet.ratio),
            "gear_stage.sun_teeth" => return Some((sun.to_string(), "scaled: gives the ratio".into())),
            "gear_stage.planet_teeth" => return Some((planet.to_string(), "scaled: gives the ratio".into())),
            "gear_stage.module_mm" => {
                return Some((
                    plain(self.module_mm),
                    "scaled: follows from teeth and crankshaft circle".into(),
                ));
            }
            "crankshafts.circle_radius_mm" => {
                let radius = 0.5 * self.module_mm * f64::from(sun + planet);
                return Some((plain(radius), "scaled: follows from teeth and module".into()));
            }
            "limits.service_life_h" => return Some((plain(RATED_LIFE_H), "life of makers' ratings".into())),
            "limits.lost_motion_arcmin" => {
                let limit = old_number()?;
                let found = sheet.lost_motion_arcmin.filter(|lost| *lost >= limit)?;
                return Some((plain(1.5 * found), "half more than the data sheet's".into()));
            }
            "bearings.turning_arm.clearance_um" => {
                let clearance = clearance_um?;
                return Some((
                    plain(clearance),
                    "calibrated: gives the lost motion of the data sheet".into(),
                ));
            }
            _ => {}
        }
        let key = path.rsplit('.').next()?;
        let factor = match key {
            "pin_circle_radius_mm"
            | "pin_radius_mm"
            | "crank_bore_diameter_mm"
            | "centre_hole_diameter_mm"
            | "eccentricity_mm"
            | "shaft_diameter_mm"
            | "roller_diameter_mm"
            | "pitch_diameter_mm"
            | "radial_stiffness_n_per_um"
            | "damping_n_s_per_m"
            | "mesh_damping_n_s_per_m" => s,
            "width_mm"
            | "face_width_mm"
            | "roller_length_mm"
            | "crank_support_span_mm"
            | "mesh_stiffness_n_per_um" => s * w,
            "mass_kg" => s.powi(3) * w,
            "inertia_kg_m2" | "sun_inertia_kg_m2" | "motor_inertia_kg_m2" => s.powi(5) * w,
            _ => return None,
        };
        let old = old_number()?;
        Some((plain(old * factor), format!("scaled: x {}", plain((factor * 1e6).round() / 1e6))))
    }

    /// A range of what is not known, moved along with its key.
    fn unknown(&self, line: &Line<'_>, clearance_um: Option<f64>) -> String {
        let unchanged = format!("{}\n", line.raw);
        let Some(path) = line.key.map(|key| key.trim_matches('"').replace("[0]", "")) else {
            return unchanged;
        };
        let (section, key) = path.rsplit_once('.').unwrap_or(("", path.as_str()));
        let Some(of) = lines(self.template.text).find(|l| l.section == section && l.key == Some(key)) else {
            return unchanged;
        };
        let new = self.value(&path, of.value, clearance_um).and_then(|(text, _)| text.parse::<f64>().ok());
        let (Some(new), Ok(old)) = (new, of.value.parse::<f64>()) else { return unchanged };
        let bounds = |name: &str| {
            let rest = line.value.split(&format!("{name} = ")).nth(1)?;
            let end = rest.find([',', ' ', '}']).unwrap_or(rest.len());
            rest[..end].parse::<f64>().ok()
        };
        let (Some(low), Some(high)) = (bounds("low"), bounds("high")) else { return unchanged };
        let factor = if old == 0.0 || new == 0.0 { 1.0 } else { new / old };
        let (a, b) = (low * factor, high * factor);
        format!(
            "{} = {{ low = {}, high = {} }} # template, scaled: {}\n",
            line.key.unwrap_or_default(),
            plain(a.min(b).min(new)),
            plain(a.max(b).max(new)),
            line.comment
        )
    }
}

/// Teeth of sun and planet that give a ratio with so many pins, their sum nearest to the template's.
fn teeth(ratio: f64, pins: f64, sum: f64) -> Result<(u32, u32), ScaleError> {
    let wanted = (ratio - 1.0) / pins;
    let mut best: Option<(u32, u32)> = None;
    let mut nearest = (f64::INFINITY, 0.0);
    for sun in 8..=60_u32 {
        let planet = (wanted * f64::from(sun)).round();
        if !(8.0..=400.0).contains(&planet) {
            continue;
        }
        let found = 1.0 + pins * planet / f64::from(sun);
        let error = (found / ratio - 1.0).abs();
        if error < nearest.0 {
            nearest = (error, found);
        }
        // Ratios are printed with few digits; a design file accepts the same.
        let distance = |pair: (u32, u32)| (f64::from(pair.0 + pair.1) - sum).abs();
        let pair = (sun, planet as u32);
        if error < 4e-4 && best.is_none_or(|best| distance(pair) < distance(best)) {
            best = Some(pair);
        }
    }
    best.ok_or(ScaleError::Teeth { ratio, pins, nearest: nearest.1 })
}

/// A line of a design file.
struct Line<'a> {
    raw: &'a str,
    /// Without brackets; empty before the first.
    section: &'a str,
    key: Option<&'a str>,
    value: &'a str,
    comment: &'a str,
}

/// The lines of a shipped design: one key a line, comments behind.
fn lines(text: &str) -> impl Iterator<Item = Line<'_>> {
    let mut section = "";
    text.lines().map(move |raw| {
        let code = raw.trim();
        if code.starts_with('[') {
            section = code.split('#').next().unwrap_or("").trim().trim_matches(['[', ']']);
            return Line { raw, section, key: None, value: "", comment: "" };
        }
        let comment_at = comment_of(code);
        let (body, comment) = match comment_at {
            Some(at) => (code[..at].trim(), code[at + 1..].trim()),
            None => (code, ""),
        };
        match body.split_once(" = ") {
            Some((key, value)) => Line { raw, section, key: Some(key.trim()), value: value.trim(), comment },
            None => Line { raw, section, key: None, value: "", comment },
        }
    })
}

/// Where a comment starts: the first # outside of quotation marks.
fn comment_of(code: &str) -> Option<usize> {
    let mut quoted = false;
    code.char_indices()
        .find(|(_, c)| {
            quoted ^= *c == '"';
            *c == '#' && !quoted
        })
        .map(|(at, _)| at)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::checks::{Severity, check_design};
    use crate::design::Design;
    use crate::templates::{TAO2024, TEMPLATES};

    /// Catalogue figures of the RV-E series: name, torque, ratio, outer diameter.
    const CATALOGUE: [(&str, f64, f64, f64); 4] = [
        ("RV-20E", 167.0, 105.0, 145.0),
        ("RV-80E", 784.0, 121.0, 222.0),
        ("RV-110E", 1078.0, 111.0, 244.0),
        ("RV-320E", 3136.0, 129.0, 325.0),
    ];

    fn sheet(torque: f64, ratio: f64, diameter: f64) -> DataSheet {
        DataSheet {
            ratio,
            torque,
            outer_diameter_mm: Some(diameter),
            stiffness_n_m_per_arcmin: None,
            lost_motion_arcmin: None,
        }
    }

    /// Every size is a design without error findings from either template, with the ratio asked for.
    #[test]
    fn the_series_is_scaled_without_error_findings() {
        for template in TEMPLATES {
            for (name, torque, ratio, diameter) in CATALOGUE {
                let scaled = Scaled::new(template, sheet(torque, ratio, diameter)).unwrap();
                let text = scaled.text(Some(7.5), Some(300.0), &["a note".into()]);
                let design = Design::parse(&text, name)
                    .unwrap_or_else(|e| panic!("{name}: {e} {:?}\n{text}", e.hint()));
                let machine = design.machine();
                assert!((machine.kinematics().ratio() / ratio - 1.0).abs() < 5e-4, "{name}");
                assert!((machine.rated.torque - torque).abs() < 1e-9);
                let errors: Vec<_> =
                    check_design(&design).into_iter().filter(|f| f.severity == Severity::Error).collect();
                assert!(errors.is_empty(), "{name} like {}: {errors:?}", template.name);
                assert!(text.contains("calibrated") && text.contains("scaled: x"));
            }
        }
    }

    /// Scaled by one, with its own data, the template stays what it is.
    #[test]
    fn the_template_is_like_itself() {
        let template = TAO2024;
        let scaled = Scaled::new(template, sheet(412.0, 81.0, template.outer_diameter_mm)).unwrap();
        let (old, new) = (
            crate::templates::tao2024(),
            Design::parse(&scaled.text(None, None, &[]), "like").unwrap().machine(),
        );
        assert_eq!(scaled.teeth, (18, 36));
        assert_eq!(old.ring, new.ring);
        assert_eq!(old.bearings, new.bearings);
        assert_eq!((old.disc.mass, old.disc.inertia), (new.disc.mass, new.disc.inertia));
    }

    #[test]
    fn what_cannot_be_scaled_is_refused() {
        let template = TAO2024;
        assert!(matches!(Scaled::new(template, sheet(412.0, 10.0, 190.0)), Err(ScaleError::Range { .. })));
        assert!(matches!(Scaled::new(template, sheet(f64::NAN, 81.0, 190.0)), Err(ScaleError::Range { .. })));
        assert!(matches!(Scaled::new(template, sheet(412.0, 81.0, 5.0)), Err(ScaleError::Range { .. })));
        // 118.5 = 1 + 40 · 47/16.
        assert_eq!(Scaled::new(template, sheet(412.0, 118.5, 190.0)).unwrap().teeth, (16, 47));
    }
}
