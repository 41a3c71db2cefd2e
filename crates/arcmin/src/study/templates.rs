//! Study files to start from, one for each kind of question.

/// A commented study file.
#[derive(Debug, Clone, Copy)]
pub struct Template {
    /// Name to choose it by.
    pub name: &'static str,
    /// The question in one line.
    pub summary: &'static str,
    /// Study file, TOML.
    pub text: &'static str,
}

impl Template {
    /// The file for another design.
    pub fn about(&self, design: &str) -> String {
        let escaped = design.replace('\\', "\\\\").replace('"', "\\\"");
        self.text.replacen("design = \"rv-40e-81.toml\"", &format!("design = \"{escaped}\""), 1)
    }
}

/// All of them.
pub const TEMPLATES: [Template; 8] = [
    Template {
        name: "yield",
        summary: "share of the machines of a series that keep their limits",
        text: include_str!("../../studies/yield.toml"),
    },
    Template {
        name: "tighten",
        summary: "which tolerance to tighten first, by gain per unit and per cost",
        text: include_str!("../../studies/tighten.toml"),
    },
    Template {
        name: "unknowns",
        summary: "band of the life from the unknowns, and the input to measure first",
        text: include_str!("../../studies/unknowns.toml"),
    },
    Template {
        name: "morris",
        summary: "which of many keys have an effect",
        text: include_str!("../../studies/morris.toml"),
    },
    Template {
        name: "sobol-indices",
        summary: "share of the variance by key, alone and in interaction",
        text: include_str!("../../studies/sobol-indices.toml"),
    },
    Template {
        name: "grid",
        summary: "all combinations of given levels",
        text: include_str!("../../studies/grid.toml"),
    },
    Template { name: "cases", summary: "a list of cases", text: include_str!("../../studies/cases.toml") },
    Template {
        name: "optimise",
        summary: "search for the best design, with the scatter of the series",
        text: include_str!("../../studies/optimise.toml"),
    },
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::StudyFile;

    /// Each is a study that can be run; the first sample of the quick ones is.
    #[test]
    fn templates_are_studies() {
        let design = crate::templates::design("rv-40e-81").unwrap().into();
        for template in TEMPLATES {
            let file = StudyFile::parse(template.text, template.name)
                .unwrap_or_else(|e| panic!("{e} {:?}", e.hint()));
            let study = file
                .study(&design, "test")
                .unwrap_or_else(|e| panic!("{}: {e} {:?}", template.name, e.help()));
            assert!(study.plan.rows() > 0, "{}", template.name);
            assert!(study.design_of(&study.plan.row(0)).is_ok(), "{}", template.name);
            if matches!(template.name, "grid" | "cases" | "sobol-indices") {
                study.compute(&study.plan.row(0), &crate::analyses::NoHost).unwrap();
            }
            assert!(template.about("my \"own\".toml").contains("design = \"my \\\"own\\\".toml\""));
        }
    }
}
