//! `arcmin export joint`: the reducer as a joint of a robot model.

use arcmin::analyses::AnalysisError;
use arcmin::analyses::joint::{GivenMasses, JointOptions, joint};
use arcmin::exchange::{JointExport, JointState, RunningFriction};
use arcmin::fidelity::FidelityOptions;
use arcmin::report::significant;
use arcmin::units::ARCMIN;
use clap::{Arg, ArgMatches, Command};

use super::Ending;
use super::export::{Given, choice, directory, number, out, path};
use crate::failure::Failure;
use crate::run::{Cache, Terminal, print_line, write_file};

pub fn command() -> Command {
    Command::new("joint")
        .about("Write the reducer as a joint for MuJoCo, URDF, SDF, Modelica, Simscape and controllers, new and worn")
        .long_about(
            "Runs the test bench at each age and writes the parameters of the joint with source and units.\n\nFiles: joint.mjcf.xml \
             (MuJoCo 4) with joint_mujoco.py (friction that grows with load), joint.urdf, joint.sdf, joint.mo (Modelica), \
             joint.simscape.m, joint.json (all data), and tables for controllers: joint.wind_up.csv, joint.te.csv \
             (transmission error as harmonics), joint.loss.csv.",
        )
        .after_help("Examples:\n  arcmin export joint my-reducer.toml --hours 0,2000,6000")
        .arg(path("DESIGN", "Design file"))
        .arg(
            Arg::new("hours")
                .long("hours")
                .value_name("HOURS,…")
                .default_value("0")
                .help("Ages in hours of the duty, separated by commas"),
        )
        .args(fidelity_args())
        .arg(number("positions", "5", "Number of crank positions for the hysteresis loop"))
        .arg(number("te-positions", "1024", "Number of points of the transmission error over one output turn, of drives of eccentrics over the part of it that repeats"))
        .arg(number("timestep-ms", "1", "Time step of MuJoCo in ms"))
        .arg(
            Arg::new("load-inertia-kg-m2")
                .long("load-inertia-kg-m2")
                .value_name("X")
                .value_parser(clap::value_parser!(f64))
                .help("Load inertia in kg·m²; the damping for tools without hysteresis depends on it [default: \
                       10 times the inertia of the motor side]"),
        )
        .args(mass_args())
        .arg(out())
}

/// Masses of drives whose design gives none.
pub(super) fn mass_args() -> [Arg; 3] {
    let arg = |name: &'static str, help: &'static str| {
        Arg::new(name).long(name).value_name("X").value_parser(clap::value_parser!(f64)).help(help)
    };
    [
        arg(
            "input-inertia-kg-m2",
            "Drives of eccentrics: inertia of input shaft and motor in kg·m² [default: none]",
        ),
        arg(
            "output-inertia-kg-m2",
            "Drives of eccentrics: inertia of the output in kg·m² [default: assumed, a body of steel]",
        ),
        arg("output-mass-kg", "Drives of eccentrics: mass of the output in kg [default: assumed likewise]"),
    ]
}

pub(super) fn masses(given: &Given<'_>) -> Result<GivenMasses, Failure> {
    Ok(GivenMasses {
        input_inertia: given.within_if_any("input-inertia-kg-m2", 0.0, 1e9)?,
        output_inertia: given.within_if_any("output-inertia-kg-m2", 1e-12, 1e9)?,
        output_mass: given.within_if_any("output-mass-kg", 1e-6, 1e9)?,
    })
}

/// Options of the model: discs and errors.
pub(super) fn fidelity_args() -> [Arg; 3] {
    [
        choice("discs", "rigid", vec!["rigid", "elastic"]).help("Model of the discs"),
        Arg::new("errors").long("errors").value_parser(["given", "drawn", "none"]).help(
            "Manufacturing errors: those of the design, drawn from its tolerances, or none [default: given, if the design has any]",
        ),
        Arg::new("seed")
            .long("seed")
            .value_name("N")
            .value_parser(clap::value_parser!(u32))
            .help("Seed of a drawn machine"),
    ]
}

pub(super) fn fidelity(matches: &ArgMatches, joints: &str) -> Result<FidelityOptions, Failure> {
    let mut text = format!("joints = \"{joints}\"\n");
    for key in ["discs", "errors"] {
        if let Some(word) = matches.get_one::<String>(key) {
            text.push_str(&format!("{key} = \"{word}\"\n"));
        }
    }
    if let Some(seed) = matches.get_one::<u32>("seed") {
        text.push_str(&format!("seed = {seed}\n"));
    }
    FidelityOptions::parse(&text, "the options").map_err(|error| failed(AnalysisError::from(error)))
}

pub(super) fn failed(error: AnalysisError) -> Failure {
    Failure::Analysis { error, options: None, finding: None }
}

/// Ages with commas between.
pub(super) fn ages(text: &str) -> Result<Vec<f64>, Failure> {
    let one = |word: &str| {
        let age = word.trim().parse::<f64>().ok().filter(|age| (0.0..=1e7).contains(age));
        age.ok_or_else(|| Failure::Usage {
            message: format!("\"{}\" is not an age in hours", word.trim()),
            help: "write ages such as --hours 0,2000,6000, each from 0 to 10000000".to_owned(),
        })
    };
    text.split(',').map(one).collect()
}

pub fn run(matches: &ArgMatches) -> Result<Ending, Failure> {
    let given = Given(matches);
    let (path, design) = given.any_design()?;
    let options = JointOptions {
        fidelity: fidelity(matches, "bearings")?,
        hours: ages(given.word("hours"))?,
        positions: given.within("positions", 1.0, 360.0)? as usize,
        error_positions: given.within("te-positions", 64.0, 65536.0)? as usize,
        timestep: 1e-3 * given.within("timestep-ms", 1e-3, 100.0)?,
        load_inertia: given.within_if_any("load-inertia-kg-m2", 1e-6, 1e9)?,
        masses: masses(&given)?,
    };
    let out = directory(matches, &path, "export")?;
    let host = Terminal::new(&path, &out, Cache::of_user(&out), false);
    let found = joint(&design, &options, &host).map_err(failed)?;
    host.clear();
    let json = found.json().map_err(|cause| Failure::Json { cause: cause.to_string() })?;
    let files = [
        ("joint.mjcf.xml", found.mjcf()),
        ("joint_mujoco.py", found.mujoco_python()),
        ("joint.urdf", found.urdf()),
        ("joint.sdf", found.sdf()),
        ("joint.mo", found.modelica()),
        ("joint.simscape.m", found.simscape()),
        ("joint.wind_up.csv", found.wind_up_table()),
        ("joint.te.csv", found.wave_table()),
        ("joint.loss.csv", found.loss_table()),
        ("joint.json", json),
    ];
    for (name, text) in &files {
        write_file(&out.join(name), text.as_bytes())?;
    }
    print_line(&text_of(&found))?;
    print_line(&format!("{} in {}", files.map(|(name, _)| name).join(", "), out.display()))?;
    Ok(Ending::Fine)
}

/// Text for the terminal.
fn text_of(found: &JointExport) -> String {
    let row = |name: &str, of: &dyn Fn(&JointState) -> String| {
        let cells: Vec<String> = found.states.iter().map(|state| format!("{:>10}", of(state))).collect();
        format!("{name:34}{}", cells.concat())
    };
    let arcmin = |rad: f64| format!("{:.4}", rad / ARCMIN);
    let stiffness = |k: f64| significant(k * ARCMIN, 4);
    let mut lines = vec![format!("{}: {}", found.design_name, found.model)];
    if found.friction_assumed {
        lines.push("friction is assumed: the design gives none".to_owned());
    }
    if found.inertia_assumed {
        lines.push(format!(
            "output assumed as a body of steel of {} kg and {} kg·m²: the design gives none",
            significant(found.inertia.output_kg, 3),
            significant(found.inertia.output_kg_m2, 3)
        ));
    }
    lines.push(row("", &|s| format!("{:.0} h", s.hours)));
    lines.push(row("lost motion ′", &|s| arcmin(s.lost_motion_rad)));
    lines.push(row("backlash ′", &|s| arcmin(s.backlash_rad)));
    lines.push(row("stiffness N·m/′", &|s| stiffness(s.stiffness_n_m_per_rad)));
    lines.push(row("dead band ′", &|s| arcmin(2.0 * s.hysteresis.curve.half_gap_rad)));
    lines.push(row("   its middle ′", &|s| arcmin(s.hysteresis.zero_rad)));
    for (index, name) in ["K1 N·m/′", "K2 N·m/′", "K3 N·m/′"].into_iter().enumerate() {
        lines.push(row(name, &|s| stiffness(s.hysteresis.curve.stiffness_n_m_per_rad[index])));
        for (side, name) in ["   positive torque", "   negative torque"].into_iter().enumerate() {
            lines.push(row(name, &|s| stiffness(s.hysteresis.sides[side].stiffness_n_m_per_rad[index])));
        }
    }
    for (index, name) in ["T1 N·m", "T2 N·m"].into_iter().enumerate() {
        lines.push(row(name, &|s| format!("{:.1}", s.hysteresis.curve.torques_n_m[index])));
    }
    lines.push(row("hysteresis loss J a cycle", &|s| format!("{:.4}", s.hysteresis_loss_j)));
    lines.push(row("hysteresis model, error N·m rms", &|s| format!("{:.2}", s.hysteresis.residual_rms_n_m)));
    lines.push(row("   largest N·m", &|s| format!("{:.2}", s.hysteresis.residual_max_n_m)));
    lines.push(row("   as angle ′ rms", &|s| arcmin(s.hysteresis.residual_rms_rad)));
    lines.push(row("damping ratio of a swing", &|s| format!("{:.3}", s.damping_ratio)));
    let friction = |of: fn(&RunningFriction) -> f64| move |s: &JointState| significant(of(&s.friction), 3);
    lines.push(row("friction: constant N·m", &friction(|f| f.coulomb_n_m)));
    lines.push(row("   viscous N·m·s/rad", &friction(|f| f.viscous_n_m_s_per_rad)));
    lines.push(row("   per motor torque, mean", &friction(|f| f.load_mean)));
    lines.push(row("   half driving less driven", &friction(|f| f.load_difference)));
    lines.push(row("   relaxation ′", &friction(|f| f.relaxation_rad / ARCMIN)));
    lines.push(row("   error N·m rms", &friction(|f| f.residual_rms_n_m)));
    lines.push(row("efficiency", &|s| format!("{:.3}", s.efficiency)));
    lines.push(row("running torque without load N·m", &|s| {
        format!("{:.2}", (s.no_load_torque_n_m * found.ratio).abs())
    }));
    lines.join("\n")
}
