//! Joints and discs in the commands that have these options.

use crate::common::*;

#[test]
fn bearings_serve_load_sharing() {
    let directory = with_design();
    let d = directory.path();
    good(d, &["contact", "d.toml", "--joints", "bearings", "--positions", "36", "--out", "c"]);
    let told = summary(d, "c");
    assert!(figure(&told, "te_loaded_arcmin") < -1.0 && told["joints"] == "bearings", "{told}");
    assert_eq!(told["disc_torque_shares"].as_array().unwrap().len(), 2);
}

/// The elastic disc is exported to ParaView completely: a file with its proper end, with displacement and
/// modes.
#[test]
fn the_elastic_disc_is_written_for_paraview() {
    let directory = with_design();
    let d = directory.path();
    good(
        d,
        &["contact", "d.toml", "--discs", "elastic", "--positions", "8", "--vtu", "--out", "o", "--quiet"],
    );
    let text = read(d, "o/disc.vtu");
    assert!(text.trim_end().ends_with("</VTKFile>"));
    assert!(text.contains("displacement (m)") && text.contains("mode 8"));
}

/// Elastic discs in bearings for all commands with this option; a single reduction is used by all. Bores on one
/// common master node are refused before meshing.
#[test]
#[ignore = "long"]
fn elastic_discs_run_in_bearings() {
    let directory = with_machine_of_paper();
    let d = directory.path();
    let elastic = ["--discs", "elastic", "--joints", "bearings", "--cache", "cache", "--quiet"];
    refused(d, &[&["simulate", "d.toml", "--bores", "common"][..], &elastic].concat());
    assert!(!d.join("cache").exists());
    for (command, more) in [
        ("simulate", &["--load", "constant", "--rise-s", "0.02", "--end-s", "0.1"][..]),
        ("contact", &["--positions", "8"]),
        ("wear", &["--hours", "20", "--points", "1"]),
        ("rig", &["--positions", "1", "--te-positions", "64"]),
    ] {
        good(d, &[&[command, "d.toml", "--out", command][..], &elastic, more].concat());
        let told = summary(d, command);
        let physics = (told["joints"].as_str(), told["discs"].as_str());
        assert_eq!(physics, (Some("bearings"), Some("elastic")), "{told}");
    }
    let told = summary(d, "simulate");
    assert!(figure(&told, "solver.energy_residual") < 1e-6, "{told}");
    assert!((-2.6..-2.0).contains(&figure(&told, "te.mean_arcmin")), "{told}");
    assert!(read(d, "rig/stiffness.csv").contains("cycloid discs"));
    assert_eq!(names(&d.join("cache")).len(), 1, "one reduction serves all");
}
