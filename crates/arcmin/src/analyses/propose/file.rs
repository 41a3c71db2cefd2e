//! The design file of a proposed single stage, every value with its reason.

use super::process::{Makes, STEEL};
use super::sizes::Proposal;
use crate::design::Choice;

impl Proposal {
    /// The design file with discs of this width; its head contains `notes`.
    pub fn text(&self, width_mm: f64, notes: &[String]) -> String {
        let (demand, making) = (&self.demand, self.demand.process.making());
        let (process, diameter) = (demand.process.word(), demand.outer_diameter_mm);
        let (difference, e, circle) = (demand.tooth_difference, self.eccentricity_mm, self.circle_mm);
        let pins = self.lobes + difference;
        let k1 = e * pins as f64 / (difference as f64 * circle);
        let [pin, roller] = self.output_mm;
        let bearing = &self.bearing;
        let hole = 0.5 * roller + e + self.gaps.hole_um * 1e-3;
        let mut out = format!(
            "# A single-stage drive proposed from ratio {}, {} N·m and an outer diameter of {diameter} mm, discs {process}.\n\
             # \"asked\": given; \"rule\": by the rules of the chapter on single stages; \"assumed\": neither.\n\
             # It is a first design: `arcmin check`, `contact` and `rig` compute its properties.\n",
            demand.ratio, demand.torque
        );
        for note in notes {
            out.push_str(&format!("# {note}\n"));
        }
        let mut line = |text: &str, why: &str| {
            if why.is_empty() {
                out.push_str(&format!("{text}\n"));
            } else {
                let before = text.len() - text.trim_start().len();
                out.push_str(&format!("{}{:<44} # {why}\n", &text[..before], &text[before..]));
            }
        };
        let rule = |why: &str| format!("rule: {why}");
        line("", "");
        line(
            &format!(
                "name = \"Single stage {} : 1, {} N·m, {diameter} mm, {process}\"",
                demand.ratio, demand.torque
            ),
            "",
        );
        line("description = \"Proposed from ratio, torque and outer diameter\"", "");
        line("fixed_member = \"ring\"", "assumed: the output pins turn, against the input");
        line("\n[drive]\nfamily = \"eccentric\"", "");
        line("\n[ring]", "");
        if difference == 1 {
            line(&format!("pin_count = {pins}"), &rule("lobes = ratio, one pin more"));
        } else {
            line(
                &format!("pin_count = {pins}"),
                &rule(&format!("lobes = {difference} x ratio, {difference} pins more")),
            );
            line(&format!("tooth_difference = {difference}"), "asked");
        }
        line(
            &format!("pin_circle_radius_mm = {circle}"),
            &rule(&format!(
                "half the outer diameter less pin radius and a housing of {} of the diameter",
                making.housing
            )),
        );
        line(
            &format!("pin_radius_mm = {}", self.pin_mm),
            &rule(&format!("dowel pin of {} mm (ISO 8734)", 2.0 * self.pin_mm)),
        );
        line(&format!("material = \"{STEEL}\""), "hardened dowel pins");
        line("pin_mounting = \"fixed\"", "assumed: a fixed pin slides");
        line("\n[disc]", "");
        line("count = 2", &rule("two discs balance each other"));
        line(
            &format!("width_mm = {width_mm}"),
            &rule("the least, in steps of 0.5 mm, that keeps the pressure of pins and holes below the limit"),
        );
        line(&format!("material = {}", making.disc_text()), making.material_source);
        line(
            &format!("crank_bore_diameter_mm = {}", bearing.outer),
            &rule(&format!("seat of the {}", bearing.name)),
        );
        line("\n[disc.modification]", "");
        let (gaps, least) = (self.gaps, making.gaps);
        let reason = |gap: f64, least: f64| match gap > least {
            true => format!(
                "rule: one of twenty drawn drives jams at most; {least} at least: {}",
                making.clearance_source
            ),
            false => making.clearance_source.to_owned(),
        };
        line(
            &format!("equidistant_offset_um = {}", gaps.profile_um),
            &reason(gaps.profile_um, least.profile_um),
        );
        line("\n[eccentric]", "");
        let formula = if difference == 1 { "e z_p/R" } else { "e z_p/(m R)" };
        line(&format!("eccentricity_mm = {e}"), &rule(&format!("K1 = {formula} = {k1:.3}, of 0.55 to 0.75")));
        line("\n[output_pins]", "");
        line(&format!("count = {}", self.output_count), &rule("of 6 to 12, with walls between the holes"));
        line(
            &format!("circle_radius_mm = {}", self.output_circle_mm),
            &rule("as far outside as the rim under the roots allows"),
        );
        line(
            &format!("pin_radius_mm = {}", 0.5 * pin),
            &rule("bends with less than 300 MPa; of equal widths the least bending"),
        );
        line(
            &format!("roller_radius_mm = {}", 0.5 * roller),
            &match roller > pin {
                true => rule(&format!("bush {pin} x {roller} mm (ISO 3547)")),
                false => rule("no bush fits a pin of this diameter: it slides"),
            },
        );
        line(
            &format!("hole_clearance_um = {}", gaps.hole_um),
            &format!("{}; holes of {:.3} mm diameter", reason(gaps.hole_um, least.hole_um), 2.0 * hole),
        );
        line("support = \"both-ends\"", "assumed: plates on both sides");
        line(&format!("material = \"{STEEL}\""), "hardened pins and bushes");
        line("\n[bearings]", "");
        line(
            &format!("input_radial_stiffness_n_per_um = {}", making.supports[0]),
            "assumed, with the seats in the housing",
        );
        line(&format!("output_radial_stiffness_n_per_um = {}", making.supports[1]), "likewise");
        line("\n[bearings.eccentric]", &bearing.name);
        line(&format!("kind = \"{}\"", bearing.kind.word()), "");
        line(
            &format!("roller_count = {}", bearing.rollers),
            "assumed from the size; take the maker's, and dynamic_load_rating_kn with it",
        );
        line(&format!("roller_diameter_mm = {}", bearing.roller_diameter), "likewise");
        if let Some(length) = bearing.length() {
            line(&format!("roller_length_mm = {length}"), &rule("0.8 of the width of the cage"));
        }
        line(
            &format!("pitch_diameter_mm = {}", bearing.pitch()),
            &rule(&format!("bore {} mm leaves a shaft of {:.1} mm", bearing.bore, self.shaft_mm)),
        );
        line(&format!("clearance_um = {}", bearing.clearance_um), "assumed: diametral");
        line("\n[load]", "");
        line(&format!("rated_torque_n_m = {}", demand.torque), "asked");
        line(&format!("input_speed_rpm = {}", demand.speed_rpm), "asked, or 600 by default");
        let [wear, low, high] = making.wear_per_pa;
        line("\n[wear.coupled]", "");
        line(&format!("coefficient_per_pa = {wear:e}"), making.wear_source);
        line("\n[unknowns]", "`arcmin life --band` and studies with unknowns = true vary these");
        line(
            &format!(
                "\"wear.coupled.coefficient_per_pa\" = {{ low = {low:e}, high = {high:e}, distribution = \"log-uniform\" }}"
            ),
            "",
        );
        line("\n[limits]", "");
        line(&format!("lost_motion_arcmin = {}", making.lost_motion_arcmin), "assumed");
        line(&format!("contact_pressure_mpa = {}", making.pressure_mpa), making.pressure_source);
        line(&format!("service_life_h = {}", making.service_life_h), "assumed");
        line("\n[tolerances]", demand.process.tolerances_source());
        for (key, value) in demand.process.tolerances() {
            line(&format!("{key} = {value}"), "");
        }
        out
    }
}
