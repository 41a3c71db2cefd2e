//! modelDescription.xml of FMI 2 and 3.

use std::fmt::Write as _;

use sha2::{Digest, Sha256};

use super::variable::{LOCAL_ERRORS, START_LOCAL_ERROR, references};
use super::{Depth, Kind, LoadFlange, Role, Variable, variables};

/// Attributes of the description in addition to the variables.
#[derive(Debug, Clone, PartialEq)]
pub struct ModelDescription {
    /// Name displayed by an importer.
    pub model_name: String,
    /// Name of the shared library without its extension.
    pub model_identifier: &'static str,
    /// Purpose in one sentence.
    pub description: String,
    /// Version of the program.
    pub version: String,
    /// Token that the library compares at instantiation.
    pub token: String,
    /// Model inside of the unit.
    pub depth: Depth,
    /// Variables of the load flange.
    pub load: LoadFlange,
    /// Initial age in hours.
    pub start_hours: f64,
    /// Smallest and largest age in hours.
    pub hours: [f64; 2],
    /// Initial seed; 0 for the errors of the design.
    pub start_seed: i32,
    /// Initial communication step in s.
    pub step_size: f64,
}

/// A GUID derived from the contents of a unit: equal bytes give the same token.
pub fn instantiation_token(parts: &[&[u8]]) -> String {
    let mut hash = Sha256::new();
    for part in parts {
        hash.update((part.len() as u64).to_le_bytes());
        hash.update(part);
    }
    let hex: String = hash.finalize().iter().take(16).map(|byte| format!("{byte:02x}")).collect();
    format!("{{{}-{}-{}-{}-{}}}", &hex[..8], &hex[8..12], &hex[12..16], &hex[16..20], &hex[20..])
}

/// (name, exponents of the base units, factor, display units with their factors: display = factor × value)
type Unit = (&'static str, &'static str, &'static [(&'static str, &'static str)]);

const UNITS: &[Unit] = &[
    ("rad", "rad=\"1\"", &[("deg", "57.29577951308232"), ("arcmin", "3437.746770784939")]),
    ("rad/s", "rad=\"1\" s=\"-1\"", &[("rpm", "9.549296585513721")]),
    ("rad/s2", "rad=\"1\" s=\"-2\"", &[]),
    ("N.m", "kg=\"1\" m=\"2\" s=\"-2\"", &[]),
    ("N", "kg=\"1\" m=\"1\" s=\"-2\"", &[]),
    ("Pa", "kg=\"1\" m=\"-1\" s=\"-2\"", &[("MPa", "1e-6")]),
    ("W", "kg=\"1\" m=\"2\" s=\"-3\"", &[]),
    ("h", "s=\"1\" factor=\"3600\"", &[]),
    ("s", "s=\"1\"", &[]),
    ("1", "", &[]),
];

fn units(tag: &str) -> String {
    let mut text = String::from("  <UnitDefinitions>\n");
    for (name, base, displays) in UNITS {
        let _ = write!(text, "    <{tag} name=\"{name}\">\n      <BaseUnit {base}/>\n");
        for (display, factor) in *displays {
            let _ = writeln!(text, "      <DisplayUnit name=\"{display}\" factor=\"{factor}\"/>");
        }
        let _ = writeln!(text, "    </{tag}>");
    }
    text.push_str("  </UnitDefinitions>\n");
    text.replace("<BaseUnit />", "<BaseUnit/>")
}

fn escaped(text: &str) -> String {
    let text = text.replace('\n', " ");
    crate::report::printable(&text)
        .replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}

impl ModelDescription {
    fn start(&self, variable: &Variable) -> String {
        match variable.reference {
            references::HOURS => format!("{:?}", self.start_hours),
            references::SEED => self.start_seed.to_string(),
            references::FRICTION | references::USE_ACCELERATION => "true".into(),
            references::LOCAL_ERROR => format!("{START_LOCAL_ERROR:?}"),
            _ => "0.0".into(),
        }
    }

    /// Limits of the hours.
    fn limits(&self, variable: &Variable) -> String {
        match variable.reference {
            references::HOURS => format!(" min=\"{:?}\" max=\"{:?}\"", self.hours[0], self.hours[1]),
            references::SEED => " min=\"0\"".into(),
            references::LOCAL_ERROR => {
                let [low, high] = LOCAL_ERRORS;
                format!(" min=\"{low:?}\" max=\"{high:?}\"")
            }
            _ => String::new(),
        }
    }

    fn head(&self) -> String {
        format!(
            "modelName=\"{}\" description=\"{}\" version=\"{}\" generationTool=\"arcmin {}\" \
             generationDateAndTime=\"2000-01-01T00:00:00Z\" variableNamingConvention=\"structured\"",
            escaped(&self.model_name),
            escaped(&self.description),
            escaped(&self.version),
            escaped(&self.version)
        )
    }

    /// FMI 2.0. The date is fixed, so that the same design gives the same bytes.
    pub fn fmi2(&self) -> String {
        let all = variables(self.depth, self.load);
        let mut text = format!(
            "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<fmiModelDescription fmiVersion=\"2.0\" guid=\"{}\" {}>\n  \
             <CoSimulation modelIdentifier=\"{}\" canHandleVariableCommunicationStepSize=\"true\" \
             canInterpolateInputs=\"true\" maxOutputDerivativeOrder=\"0\" canGetAndSetFMUstate=\"true\" \
             canSerializeFMUstate=\"true\" providesDirectionalDerivative=\"false\"/>\n",
            self.token,
            self.head(),
            self.model_identifier
        );
        text.push_str(&units("Unit"));
        text.push_str("  <LogCategories>\n    <Category name=\"logStatusError\"/>\n    <Category name=\"logAll\"/>\n  </LogCategories>\n");
        let _ = writeln!(
            text,
            "  <DefaultExperiment startTime=\"0.0\" stopTime=\"1.0\" stepSize=\"{:?}\"/>",
            self.step_size
        );
        text.push_str("  <ModelVariables>\n");
        for variable in &all {
            let role = match variable.role {
                Role::Input => "causality=\"input\" variability=\"continuous\"",
                Role::Output => "causality=\"output\" variability=\"continuous\" initial=\"calculated\"",
                Role::Parameter => "causality=\"parameter\" variability=\"fixed\" initial=\"exact\"",
            };
            let tag = match variable.kind {
                Kind::Real => "Real",
                Kind::Integer => "Integer",
                Kind::Boolean => "Boolean",
            };
            let _ = writeln!(
                text,
                "    <ScalarVariable name=\"{}\" valueReference=\"{}\" description=\"{}\" {role}>\n      <{tag}{}{}{}/>\n    \
                 </ScalarVariable>",
                variable.name,
                variable.reference,
                escaped(variable.description),
                unit_attributes(variable),
                self.limits(variable),
                if variable.role == Role::Output {
                    String::new()
                } else {
                    format!(" start=\"{}\"", self.start(variable))
                },
            );
        }
        text.push_str("  </ModelVariables>\n  <ModelStructure>\n");
        for section in ["Outputs", "InitialUnknowns"] {
            let _ = writeln!(text, "    <{section}>");
            for (index, _) in all.iter().enumerate().filter(|(_, variable)| variable.role == Role::Output) {
                let _ = writeln!(text, "      <Unknown index=\"{}\"/>", index + 1);
            }
            let _ = writeln!(text, "    </{section}>");
        }
        text.push_str("  </ModelStructure>\n</fmiModelDescription>\n");
        text
    }

    /// FMI 3.0, with the flanges as terminals in a file of their own ([`ModelDescription::terminals`]).
    pub fn fmi3(&self) -> String {
        let all = variables(self.depth, self.load);
        let mut text = format!(
            "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<fmiModelDescription fmiVersion=\"3.0\" instantiationToken=\"{}\" \
             {}>\n  <CoSimulation modelIdentifier=\"{}\" canHandleVariableCommunicationStepSize=\"true\" \
             canGetAndSetFMUState=\"true\" canSerializeFMUState=\"true\" maxOutputDerivativeOrder=\"0\"/>\n",
            self.token,
            self.head(),
            self.model_identifier
        );
        text.push_str(&units("Unit"));
        text.push_str("  <LogCategories>\n    <Category name=\"logStatusError\"/>\n    <Category name=\"logAll\"/>\n  </LogCategories>\n");
        let _ = writeln!(
            text,
            "  <DefaultExperiment startTime=\"0.0\" stopTime=\"1.0\" stepSize=\"{:?}\"/>",
            self.step_size
        );
        let _ = writeln!(
            text,
            "  <ModelVariables>\n    <Float64 name=\"time\" valueReference=\"{}\" causality=\"independent\" \
             variability=\"continuous\" description=\"Time\" unit=\"s\"/>",
            references::TIME
        );
        for variable in &all {
            let role = match variable.role {
                Role::Input => "causality=\"input\" variability=\"continuous\"",
                Role::Output => "causality=\"output\" variability=\"continuous\" initial=\"calculated\"",
                Role::Parameter => "causality=\"parameter\" variability=\"fixed\" initial=\"exact\"",
            };
            let tag = match variable.kind {
                Kind::Real => "Float64",
                Kind::Integer => "Int32",
                Kind::Boolean => "Boolean",
            };
            let start = match variable.role {
                Role::Output => String::new(),
                _ => format!(" start=\"{}\"", self.start(variable)),
            };
            let _ = writeln!(
                text,
                "    <{tag} name=\"{}\" valueReference=\"{}\" {role} description=\"{}\"{}{}{start}/>",
                variable.name,
                variable.reference,
                escaped(variable.description),
                unit_attributes(variable),
                self.limits(variable),
            );
        }
        text.push_str("  </ModelVariables>\n  <ModelStructure>\n");
        for tag in ["Output", "InitialUnknown"] {
            for variable in all.iter().filter(|variable| variable.role == Role::Output) {
                let _ = writeln!(text, "    <{tag} valueReference=\"{}\"/>", variable.reference);
            }
        }
        text.push_str("  </ModelStructure>\n</fmiModelDescription>\n");
        text
    }

    /// terminalsAndIcons.xml of FMI 3: both flanges as those of the Modelica Standard Library.
    pub fn terminals(&self) -> String {
        let mut text = String::from(
            "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<fmiTerminalsAndIcons fmiVersion=\"3.0\">\n  <Terminals>\n",
        );
        for side in ["a", "b"] {
            let _ = writeln!(
                text,
                "    <Terminal name=\"flange_{side}\" matchingRule=\"plug\" \
                 terminalKind=\"Modelica.Mechanics.Rotational.Interfaces.Flange_{side}\">"
            );
            for (member, kind) in [("phi", "signal"), ("tau", "inflow")] {
                let _ = writeln!(
                    text,
                    "      <TerminalMemberVariable variableName=\"flange_{side}.{member}\" memberName=\"{member}\" \
                     variableKind=\"{kind}\"/>"
                );
            }
            text.push_str("    </Terminal>\n");
        }
        text.push_str("  </Terminals>\n</fmiTerminalsAndIcons>\n");
        text
    }
}

fn unit_attributes(variable: &Variable) -> String {
    let mut text = String::new();
    if !variable.unit.is_empty() {
        let _ = write!(text, " unit=\"{}\"", variable.unit);
    }
    if !variable.display_unit.is_empty() {
        let _ = write!(text, " displayUnit=\"{}\"", variable.display_unit);
    }
    text
}
