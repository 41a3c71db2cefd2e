//! Study files to start from: for each kind of question one about RV reducers and one about drives of eccentrics.

use crate::design::Family;

/// A commented study file.
#[derive(Debug, Clone, Copy)]
pub struct Template {
    /// Name to choose it by.
    pub name: &'static str,
    /// The question in one line.
    pub summary: &'static str,
    rv: &'static str,
    eccentrics: &'static str,
}

impl Template {
    /// Study file (TOML) of a family and the shipped design that it is about.
    fn of(&self, family: Family) -> (&'static str, &'static str) {
        match family {
            Family::Rv => (self.rv, "rv-40e-81.toml"),
            Family::Eccentric | Family::TwoRing | Family::TwoStage => (self.eccentrics, "nema17-19.toml"),
        }
    }

    /// Study file (TOML) about the shipped design `rv-40e-81.toml`, or for drives of eccentrics `nema17-19.toml`.
    pub fn text(&self, family: Family) -> &'static str {
        self.of(family).0
    }

    /// The file about another design of a family.
    pub fn about(&self, design: &str, family: Family) -> String {
        let (text, shipped) = self.of(family);
        let escaped = design.replace('\\', "\\\\").replace('"', "\\\"");
        text.replacen(&format!("design = \"{shipped}\""), &format!("design = \"{escaped}\""), 1)
    }
}

macro_rules! template {
    ($name:literal, $summary:literal) => {
        Template {
            name: $name,
            summary: $summary,
            rv: include_str!(concat!("../../studies/rv/", $name, ".toml")),
            eccentrics: include_str!(concat!("../../studies/eccentrics/", $name, ".toml")),
        }
    };
}

/// All of them.
pub const TEMPLATES: [Template; 8] = [
    template!("yield", "share of the machines of a series that keep their limits"),
    template!("tighten", "which tolerance to tighten first, by gain per unit and per cost"),
    template!("unknowns", "band of the life from the unknowns, and the input to measure first"),
    template!("morris", "which of many keys have an effect"),
    template!("sobol-indices", "share of the variance by key, alone and in interaction"),
    template!("grid", "all combinations of given levels"),
    template!("cases", "a list of cases"),
    template!("optimise", "search for the best design, with the scatter of the series"),
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analyses::stage::AnyDesign;
    use crate::study::StudyFile;
    use crate::templates;

    /// Each template is a valid study for every family, given the sections of the design that it needs; for the quick ones the
    /// first sample is computed.
    #[test]
    fn templates_are_studies() {
        let unknowns = "[unknowns]\n\"disc.modification.equidistant_offset_um\" = { deviation = 1 }\n";
        let tolerances = "[tolerances]\npin_circle_radius_um = 1\n";
        let with = |text: &str, more: &str| match text.contains(more.lines().next().unwrap()) {
            true => text.to_owned(),
            false => format!("{text}\n{more}"),
        };
        for name in ["rv-40e-81"].into_iter().chain(templates::DRIVES.map(|drive| drive.name)) {
            let design = match templates::find_drive(name) {
                None => templates::design(name).unwrap().into(),
                Some(drive) => {
                    let text = with(&with(drive.text, tolerances), unknowns);
                    AnyDesign::parse(&text, drive.file).unwrap()
                }
            };
            let family = design.family();
            for template in TEMPLATES {
                let file = StudyFile::parse(template.text(family), template.name)
                    .unwrap_or_else(|e| panic!("{e} {:?}", e.hint()));
                let study = file
                    .study(&design, "test")
                    .unwrap_or_else(|e| panic!("{name}, {}: {e} {:?}", template.name, e.help()));
                assert!(study.plan.rows() > 0, "{}", template.name);
                assert!(study.design_of(&study.plan.row(0)).is_ok(), "{}", template.name);
                if matches!(template.name, "grid" | "cases" | "sobol-indices" | "morris") {
                    study.compute(&study.plan.row(0), &crate::analyses::NoHost).unwrap();
                }
                let about = template.about("my \"own\".toml", family);
                assert!(about.contains("design = \"my \\\"own\\\".toml\""));
            }
        }
    }
}
