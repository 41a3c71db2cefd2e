//! Exports, imports, and designs made from a data sheet.

use crate::common::*;

/// A single crank position and few places for a short run of the bench.
const SHORT: [&str; 4] = ["--positions", "1", "--te-positions", "64"];

#[test]
fn a_joint_is_written_for_every_tool_and_repeats_to_the_byte() {
    let directory = with_machine_of_paper();
    let d = directory.path();
    let said = good(d, &[&["export", "joint", "d.toml", "--out", "a"][..], &SHORT].concat());
    assert!(said.contains("lost motion") && said.contains("friction is assumed"), "{said}");
    good(d, &[&["export", "joint", "d.toml", "--out", "b"][..], &SHORT].concat());
    let names = [
        "joint.mjcf.xml",
        "joint_mujoco.py",
        "joint.urdf",
        "joint.sdf",
        "joint.mo",
        "joint.simscape.m",
        "joint.json",
        "joint.wind_up.csv",
        "joint.te.csv",
        "joint.loss.csv",
    ];
    for name in names {
        let text = read(d, &format!("a/{name}"));
        assert!(text == read(d, &format!("b/{name}")), "{name} differs");
        assert!(!text.contains("NaN") && !text.contains("inf,"), "{name}");
    }
    let json: serde_json::Value = serde_json::from_str(&read(d, "a/joint.json")).unwrap();
    assert_eq!(json["ratio"], 81.0);
    assert!(json["catalogue"][0]["lost_motion_arcmin"].as_f64().unwrap() > 0.3);
}

/// Every format is reproducible to the byte; a single disc has its own contour; a missing disc is refused.
#[test]
fn profiles_are_reproducible_and_contain_the_requested_disc() {
    let directory = with_machine_of_paper();
    let d = directory.path();
    for format in ["dxf", "step", "stl", "3mf", "csv", "svg"] {
        let file = |out: &str| {
            good(
                d,
                &["export", "profile", "d.toml", "--format", format, "--tolerance-um", "20", "--out", out],
            );
            std::fs::read(d.join(out).join(format!("profile.{format}"))).unwrap()
        };
        assert!(file("a") == file("b"), "{format} differs");
    }
    for (options, polylines, splines) in
        [(&["--disc", "2"][..], 1, 0), (&["--disc", "2", "--contour", "spline"], 0, 1), (&[], 1, 1)]
    {
        good(d, &[&["export", "profile", "d.toml", "--out", "c"][..], options].concat());
        let text = read(d, "c/profile.dxf");
        let count = |kind: &str| text.lines().filter(|line| *line == kind).count();
        assert_eq!((count("LWPOLYLINE"), count("SPLINE")), (polylines, splines), "{options:?}");
        assert_eq!(text.contains("DISC_1"), options.is_empty());
    }
    let said = refused(d, &["export", "profile", "d.toml", "--disc", "3"]);
    assert!(said.contains("there is no disc 3: the design has 2"), "{said}");
}

#[test]
fn ages_that_are_none_are_refused() {
    let directory = with_design();
    for hours in ["0,x", "-1", "", "0,,5", "nan", "1e9"] {
        let said = refused(directory.path(), &["export", "joint", "d.toml", &format!("--hours={hours}")]);
        assert!(
            said.contains("is not an age in hours") && said.contains("--hours 0,2000,6000"),
            "{hours}: {said}"
        );
    }
}

/// Any file may replace the library here: only the packing is tested.
#[test]
fn a_unit_is_complete_and_reproducible() {
    let directory = with_design();
    let d = directory.path();
    write(d, "library.so", "a library");
    for (fmi, folder) in [("2", "linux64"), ("3", "x86_64-linux")] {
        let unit = |out: &str| {
            let options = ["--fmi", fmi, "--model", "multibody", "--library", "library.so", "--out", out];
            good(d, &[&["export", "fmu", "d.toml"][..], &options].concat());
            std::fs::read(d.join(out).join("d.fmu")).unwrap()
        };
        let (one, two) = (unit("a"), unit("b"));
        assert!(one == two, "FMI {fmi}: bytes differ");
        let names = String::from_utf8_lossy(&one).into_owned();
        for name in [
            "modelDescription.xml",
            "resources/design.toml",
            "resources/unit.json",
            "documentation/index.html",
        ] {
            assert!(names.contains(name), "FMI {fmi}: {name}");
        }
        if cfg!(all(target_os = "linux", target_arch = "x86_64")) {
            assert!(names.contains(&format!("binaries/{folder}/arcmin_fmu.so")));
        }
    }
    let said = refused(d, &["export", "fmu", "d.toml", "--library", "nowhere.so"]);
    assert!(said.contains("nowhere.so"), "{said}");
}

#[test]
fn a_data_sheet_that_is_none_is_refused() {
    let directory = with_design();
    let d = directory.path();
    let like = |more: &[&str]| refused(d, &[&["new", "--like", "rv-40e"][..], more].concat());
    assert!(like(&["x.toml"]).contains("--ratio"));
    assert!(like(&["--ratio", "81", "--torque-nm", "412"]).contains("one file"));
    assert!(like(&["--ratio", "5", "--torque-nm", "412", "x.toml"]).contains("a ratio of 5"));
    assert!(like(&["--ratio", "81", "--torque-nm", "nan", "x.toml"]).contains("a torque"));
    assert!(like(&["--ratio", "81", "--torque-nm", "412", "d.toml"]).contains("exists already"));
    let said = refused(d, &["new", "--like", "rv-1", "--ratio", "81", "--torque-nm", "412", "x.toml"]);
    assert!(said.contains("rv-1"), "{said}");
    assert!(!d.join("x.toml").exists());
}

/// Both imports write the keys for the design and a page for review, with their source.
#[test]
fn imports_print_their_results() {
    let directory = with_design();
    let d = directory.path();
    good(d, &["export", "profile", "d.toml", "--format", "csv", "--out", "flank"]);
    std::fs::rename(d.join("flank/profile.csv"), d.join("points.csv")).unwrap();
    good(d, &["import", "flank", "d.toml", "points.csv", "--out", "o"]);
    let log: String = (0..400)
        .map(|i| f64::from(i) * 0.05)
        .map(|t| format!("{t},{},{}\n", 200.0 + 50.0 * (3.0 * t).sin(), 10.0 * t.sin()))
        .collect();
    write(d, "log.csv", &format!("time_s,torque_n_m,output_speed_rpm\n{log}"));
    good(d, &["import", "duty", "d.toml", "log.csv", "--out", "o"]);
    for (name, words) in [
        ("flank.html", ["points of points.csv lie", "Deviation of each lobe", "import flank d.toml"]),
        ("duty.html", ["readings of log.csv became", "Time in motion", "import duty d.toml"]),
    ] {
        let page = std::fs::read_to_string(d.join("o").join(name)).unwrap();
        for word in words {
            assert!(page.contains(word), "{name}: {word}");
        }
    }
}

/// Drives of eccentrics accept both imports: a flank displaced inwards by 12 µm is read as an offset or as a
/// harmonic under the keys of its ring or stage, and a log becomes rows of its duty.
#[test]
#[ignore = "long"]
fn drives_of_eccentrics_take_imports() {
    for (template, files) in [
        ("nema17-19", [("profile", "1", "disc", "errors"); 2]),
        ("steel-59", [("profile", "1", "disc", "errors"); 2]),
        (
            "two-ring-225",
            [("profile", "1", "disc", "errors"), ("second_profile", "2", "second_disc", "second_errors")],
        ),
        (
            "two-stage-500",
            [
                ("first_stage_profile", "1", "first_stage.disc", "first_stage.errors"),
                ("profile", "2", "disc", "errors"),
            ],
        ),
    ] {
        let directory = tempfile::tempdir().unwrap();
        let d = directory.path();
        good(d, &["new", template, "d.toml"]);
        good(
            d,
            &["export", "profile", "d.toml", "--format", "csv", "--offset-um", "-12", "--flank", "as-cut"],
        );
        for (name, stage, disc, errors) in files {
            let points = format!("out/d/export/{name}.csv");
            let import = |form: &str| {
                good(
                    d,
                    &["import", "flank", "d.toml", &points, "--stage", stage, "--as", form, "--out", "o"],
                );
                read(d, "o/flank.toml")
            };
            let found = import("harmonics");
            let row =
                found.split(&format!("[[{errors}.flanks]]")).nth(1).unwrap_or_else(|| panic!("{found}"));
            let amplitude = row.split("amplitude_um = ").nth(1).unwrap().lines().next().unwrap();
            let size: f64 = amplitude.parse().unwrap();
            assert!(row.contains("order = 0") && (size - 12.0).abs() < 0.1, "{found}");
            write(d, "made.toml", &format!("{}\n{found}", read(d, "d.toml")));
            good(d, &["check", "made.toml", "--out", "c"]);
            let offset = import("modification");
            assert!(offset.contains(&format!("[{disc}.modification]")), "{offset}");
            let um = offset.split("equidistant_offset_um = ").nth(1).unwrap().lines().next().unwrap();
            let nominal = read(d, "d.toml").contains("equidistant_offset_um = 10");
            let least = if nominal { 22.0 } else { 16.9 };
            assert!(um.parse::<f64>().unwrap() > least - 0.3, "{offset}");
        }
        let said = refused(d, &["import", "flank", "d.toml", "out/d/export/profile.csv", "--as", "measured"]);
        assert!(said.contains("name no measured flanks"), "{said}");
        let torque = if template == "nema17-19" { 2.0 } else { 40.0 };
        let log: String = (0..400)
            .map(|i| f64::from(i) * 0.05)
            .map(|t| format!("{t},{},{}\n", torque * (1.0 + 0.2 * (3.0 * t).sin()), 1.0 * t.sin()))
            .collect();
        write(d, "log.csv", &format!("time_s,torque_n_m,output_speed_rpm\n{log}"));
        good(d, &["import", "duty", "d.toml", "log.csv", "--out", "o"]);
        let rows = read(d, "o/duty.toml");
        let text: String = read(d, "d.toml").split("[[duty]]").next().unwrap().to_owned();
        write(d, "loaded.toml", &format!("{text}\n{rows}"));
        good(d, &["check", "loaded.toml", "--out", "c"]);
    }
    let directory = tempfile::tempdir().unwrap();
    let d = directory.path();
    good(d, &["new", "nema17-19", "d.toml"]);
    good(d, &["export", "profile", "d.toml", "--format", "csv", "--out", "p"]);
    let said = refused(d, &["import", "flank", "d.toml", "p/profile.csv", "--stage", "2"]);
    assert!(said.contains("no ring or stage 2"), "{said}");
}

/// A measured flank in any format is accepted by the design, and the machine has the same life as with the
/// flank itself: the missing metal is preserved.
#[test]
fn the_design_accepts_imported_files() {
    let directory = with_machine_of_paper();
    let d = directory.path();
    let fine = ["--tolerance-um", "0.1"];
    good(d, &[&["export", "profile", "d.toml", "--format", "csv", "--out", "flank"][..], &fine].concat());
    // The stamp stands in comments.
    let table: String = read(d, "flank/profile.csv")
        .lines()
        .filter(|l| !l.starts_with('#'))
        .map(|l| format!("{l}\n"))
        .collect();
    write(d, "profile.csv", &table);
    let number = |name: &str| -> Vec<f64> {
        column(d, "profile.csv", name).iter().map(|cell| cell.parse().unwrap()).collect()
    };
    let (x, y) = (number("x_mm"), number("y_mm"));
    let (nx, ny) = (number("outward_normal_x"), number("outward_normal_y"));
    let rows: String = (0..x.len())
        .map(|i| {
            // Ten micrometres everywhere, twenty more where the normal is radial: at roots and tips.
            let radius = x[i].hypot(y[i]);
            let depth = 1e-3 * (10.0 + 20.0 * ((x[i] * nx[i] + y[i] * ny[i]) / radius).powi(8));
            format!("{:.6},{:.6}\n", x[i] - depth * nx[i], y[i] - depth * ny[i])
        })
        .collect();
    write(d, "points.csv", &format!("x_mm,y_mm\n{rows}"));
    let bare = read(d, "d.toml");
    let mut plays = Vec::new();
    for form in ["modification", "harmonics", "measured"] {
        good(d, &["import", "flank", "d.toml", "points.csv", "--as", form, "--out", "."]);
        let keys = read(d, "flank.toml");
        assert!(keys.contains("# Missing metal that all lobes have in common"), "{keys}");
        let design = if form == "modification" {
            let (before, rest) = bare.split_once("[disc.modification]").unwrap();
            format!("{before}{keys}{}", &rest[rest.find("\n[").unwrap()..])
        } else {
            let other = keys.replace("disc = 1", "disc = 2");
            format!("{bare}\n{keys}\n{other}")
        };
        write(d, "with.toml", &design);
        good(d, &["check", "with.toml"]);
        let errors = if form == "modification" { "none" } else { "given" };
        good(d, &["contact", "with.toml", "--joints", "bearings", "--errors", errors, "--out", "c"]);
        plays.push(figure(&summary(d, "c"), "play_arcmin"));
    }
    let (low, high) = plays.iter().fold((f64::MAX, f64::MIN), |(l, h), p| (l.min(*p), h.max(*p)));
    assert!(high - low < 0.02 * high, "{plays:?}");
    write(d, "with.toml", &bare);
    good(d, &["contact", "with.toml", "--joints", "bearings", "--out", "c"]);
    assert!(figure(&summary(d, "c"), "play_arcmin") < 0.8 * low, "{plays:?}");
}

/// A hostile file of every input format is refused with its line and a remedy, and nothing is written.
#[test]
fn hostile_imports_are_refused_with_line_and_remedy() {
    let directory = with_design();
    let d = directory.path();
    let deep = format!("{}\n", "9".repeat(5000));
    let flanks: [(&str, String); 8] = [
        ("points.csv", "x_mm,y_mm\n1,2\n3,nan\n".into()),
        ("points.csv", "x_mm,y_mm\n1,2\n3\n".into()),
        ("points.csv", "x_mm,y_mm\n1e300,2\n3,4\n".into()),
        ("points.csv", "x_mm,y_mm\n".into()),
        ("points.csv", "\u{0}\u{1}\u{2}".into()),
        ("points.csv", format!("x_mm,y_mm\n{deep}")),
        ("points.txt", "XYZIJK METRIC\n1 2 3 a b c\n".into()),
        ("points.vda", "HEADER = HEADER / 1\nP1 = PSET / 3, 1, 2\nEND = END\n".into()),
    ];
    for (name, text) in flanks {
        write(d, name, &text);
        let said = refused(d, &["import", "flank", "d.toml", name]);
        assert!(said.contains("help:"), "{name}: {text:.40}: {said}");
        assert!(!said.contains("panicked"), "{said}");
    }
    let logs = [
        "time_s,torque_n_m,speed_rpm\n0,1,2\n0,1,2\n".to_owned(),
        "time_s,torque_n_m,speed_rpm\n0,1,2\n1,inf,2\n".to_owned(),
        "time_s,torque_n_m\n0,1\n1,2\n".to_owned(),
        "time_s,current_a,speed_rpm\n0,1,2\n1,1,2\n".to_owned(),
        "nothing".to_owned(),
        String::new(),
        deep,
    ];
    for text in logs {
        write(d, "log.csv", &text);
        let said = refused(d, &["import", "duty", "d.toml", "log.csv"]);
        assert!(said.contains("help:") && !said.contains("panicked"), "{text:.40}: {said}");
    }
    assert!(!d.join("out/d/import/flank.toml").exists() && !d.join("out/d/import/duty.toml").exists());
}

/// A name is data: it cannot end a comment of a source text and contains no character that XML forbids.
#[test]
fn names_do_no_harm_in_other_programs() {
    let directory = with_design();
    let d = directory.path();
    edit(d, "name = \"RV-40E-81 of Tao2024\"", "name = \"a\\u001B[2J---b\\nsystem('x')\\u202Ec\"");
    good(d, &["export", "joint", "d.toml", "--hours", "0", "--out", "j"]);
    for name in names(&d.join("j")) {
        let text = read(d, &format!("j/{name}"));
        assert!(!text.contains(['\u{1b}', '\u{202e}']), "{name}");
        assert!(!text.lines().any(|line| line.starts_with("system")), "{name}");
        if text.starts_with("<?xml") {
            let comments = text.split("<!--").skip(1).map(|rest| rest.split("-->").next().unwrap());
            assert!(comments.into_iter().all(|comment| !comment.contains("--")), "{name}");
        }
    }
    write(d, "library.so", "a library");
    good(d, &["export", "fmu", "d.toml", "--fmi", "2", "--library", "library.so", "--out", "f"]);
    let unit = names(&d.join("f")).remove(0);
    let bytes = std::fs::read(d.join("f").join(unit)).unwrap();
    let mut archive = zip::ZipArchive::new(std::io::Cursor::new(bytes)).unwrap();
    let mut description = String::new();
    let mut file = archive.by_name("modelDescription.xml").unwrap();
    std::io::Read::read_to_string(&mut file, &mut description).unwrap();
    assert!(!description.contains(['\u{1b}', '\u{202e}']));
}
