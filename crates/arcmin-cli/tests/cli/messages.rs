//! Errors of designs and options, word for word.

use crate::common::*;

const LENGTH_WITHOUT_UNIT: &str = "  × `pin_radius` lacks its unit
    ╭─[d.toml:14:1]
 13 │ pin_circle_radius_mm = 64             # Tao2024, Table 1
 14 │ pin_radius = 3                     # Tao2024, Table 1
    · ──────────
 15 │ material = \"GCr15\"                    # Tao2024, Table 2
    ╰────
  help: units are part of the keys: write `pin_radius_mm = 3` if 3 is in mm
";

const ABSURD_VALUE: &str = "  × `pin_radius_mm` is out of range
    ╭─[d.toml:14:17]
 13 │ pin_circle_radius_mm = 64             # Tao2024, Table 1
 14 │ pin_radius_mm = 3000                     # Tao2024, Table 1
    ·                 ────
 15 │ material = \"GCr15\"                    # Tao2024, Table 2
    ╰────
  help: the allowed range is 0.1 to 200 mm; if the value is in µm, write pin_radius_mm = 3
";

const UNKNOWN_SECTION: &str = "  × unknown key `lead` in the design file
     ╭─[d.toml:107:2]
 106 │\x20
 107 │ [lead]
     ·  ────
 108 │ rated_torque_n_m = 412                # Tao2024, at the output
     ╰────
  help: did you mean `load`?
";

const TWO_TYPOS: &str = "  × unknown key `lobe_conut` in [disc]
    ╭─[d.toml:21:1]
 20 │ count = 2                             # Tao2024
 21 │ lobe_conut = 39                       # Tao2024, Table 1
    · ──────────
 22 │ widht_mm = 8.75                       # Tao2024, Table 1
    · ────┬───
    ·     ╰── unknown key `widht_mm` in [disc]: did you mean `width_mm`?
 23 │ material = \"GCr15\"                    # Tao2024, Table 2
    ╰────
  help: did you mean `lobe_count`?
";

const NO_TOML: &str = "  × this is not valid TOML: unclosed table, expected `]`
   ╭─[d.toml:1:6]
 1 │ [load
   ·      ▲
   ╰────
";

#[test]
fn design_errors_show_the_line_and_the_remedy() {
    let directory = with_machine_of_paper();
    let d = directory.path();
    edit(d, "pin_radius_mm = 3 ", "pin_radius = 3 ");
    assert_eq!(refused(d, &["check", "d.toml"]), LENGTH_WITHOUT_UNIT);
    edit(d, "pin_radius = 3 ", "pin_radius_mm = 3000 ");
    assert_eq!(refused(d, &["check", "d.toml"]), ABSURD_VALUE);
    edit(d, "pin_radius_mm = 3000 ", "pin_radius_mm = 3 ");
    edit(d, "[load]", "[lead]");
    assert_eq!(refused(d, &["profile", "d.toml"]), UNKNOWN_SECTION);
    edit(d, "[lead]", "[load]");
    edit(d, "lobe_count", "lobe_conut");
    edit(d, "\nwidth_mm", "\nwidht_mm");
    assert_eq!(refused(d, &["contact", "d.toml"]), TWO_TYPOS);
    write(d, "d.toml", "[load\n");
    assert_eq!(refused(d, &["check", "d.toml"]), NO_TOML);
    assert_eq!(names(d), ["d.toml"], "nothing is created for a design that cannot be read");
}

#[test]
fn a_missing_design_and_a_binary_one_are_clear_errors() {
    let directory = tempfile::tempdir().unwrap();
    let d = directory.path();
    assert_eq!(
        refused(d, &["check", "nowhere.toml"]),
        "  × cannot read nowhere.toml: No such file or directory (os error 2)\n  \
         help: `arcmin new FILE` writes a design file to start from\n"
    );
    std::fs::write(d.join("b.toml"), [0xff, 0xfe, 0x00]).unwrap();
    assert_eq!(
        refused(d, &["check", "b.toml"]),
        "  × cannot read b.toml: the file is neither UTF-8 nor Latin-1 nor UTF-16 text\n  \
         help: save it as UTF-8\n"
    );
}

/// Wrong options are reported in the notation of the command line.
#[test]
fn option_errors_name_the_option() {
    let directory = with_design();
    let d = directory.path();
    for (arguments, text) in [
        (
            &["contact", "--torque-nm", "abc"][..],
            "  × --torque-nm must be a number\n  help: write a number from -1e7 to 1e7 N·m\n",
        ),
        (
            &["contact", "--torque-nm", "1,5"],
            "  × --torque-nm must be a number\n  help: write a decimal point: --torque-nm 1.5\n",
        ),
        (
            &["contact", "--torque-nm", "nan"],
            "  × --torque-nm is not a finite number\n  help: write a finite number\n",
        ),
        (
            &["contact", "--hours", "-1"],
            "  × --hours must not be negative\n  help: the allowed range is 0 to 1e7\n",
        ),
        (
            &["contact", "--wear-um", "1e9"],
            "  × --wear-um is out of range\n  help: the allowed range is 0 to 1000 µm\n",
        ),
        (
            &["profile", "--points", "0"],
            "  × --points must be positive\n  help: the allowed range is 4 to 100000\n",
        ),
        (
            &["profile", "--points", "4.5"],
            "  × --points must be a whole number\n  help: write a whole number from 4 to 100000\n",
        ),
        (
            &["contact", "--wear-um", "3", "--hours", "5"],
            "  × uniform wear (--wear-um) and wear by the duty (--hours) exclude each other\n  \
             help: leave one of them out\n",
        ),
        (&["simulate", "--load", "table"], "  × this load needs a file\n  help: name it with --load-file\n"),
        (
            &["calibrate", "nowhere.csv"],
            "  × nowhere.csv: cannot be read: No such file or directory (os error 2)\n  \
             help: check its name and path\n",
        ),
    ] {
        let all = [&arguments[..1], &["d.toml"], &arguments[1..]].concat();
        assert_eq!(refused(d, &all), text, "{arguments:?}");
    }
    // Words are checked before the design is read.
    let said = refused(d, &["contact", "d.toml", "--joints", "welded"]);
    assert!(
        said.contains("invalid value 'welded' for '--joints") && said.contains("ideal, bearings"),
        "{said}"
    );
    assert!(refused(d, &["profil", "d.toml"]).contains("'profile'"));
}

/// Options that cannot be combined are refused with reason and remedy.
#[test]
fn invalid_combinations_are_refused_with_a_reason() {
    let directory = with_design();
    let d = directory.path();
    write(d, "load.csv", "time_s,torque_n_m\n0,0\n1,412\n");
    write(d, "drive.csv", "time_s,speed_rpm\n0,0\n1,1500\n");
    let ideal_only = "help: use --joints ideal, --discs rigid";
    for (arguments, words) in [
        (
            &["contact", "--joints", "bearings", "--method", "closed-form"][..],
            &["the closed form does not support bearings", ideal_only][..],
        ),
        (
            &["contact", "--discs", "elastic", "--method", "closed-form"],
            &["the closed form does not support elastic discs", ideal_only],
        ),
        (
            &["wear", "--mode", "tao2024", "--joints", "bearings"],
            &["the study of Tao2024 does not support bearings", ideal_only],
        ),
        (
            &["wear", "--mode", "tao2024", "--discs", "elastic"],
            &["the study of Tao2024 does not support elastic discs", ideal_only],
        ),
        (
            &["contact", "--errors", "drawn"],
            &["ideal joints do not support manufacturing errors", "help: choose --joints bearings"],
        ),
        (
            &["simulate", "--errors", "given"],
            &["ideal joints do not support manufacturing errors", "help: choose --joints bearings"],
        ),
        (
            &["simulate", "--load-file", "load.csv"],
            &["load.csv is not used by these options", "help: add --load table, stepped or duty-cycle"],
        ),
        (
            &["simulate", "--drive-file", "drive.csv"],
            &["drive.csv is not used by these options", "help: add --drive speed-table or torque-table"],
        ),
        (
            &["simulate", "--torque-nm", "412"],
            &["a torque without a load (--torque-nm)", "help: add --load constant or sine"],
        ),
        (&["rig", "--seed", "3"], &["a seed needs drawn errors", "help: add --errors drawn"]),
        (&["rig", "--errors", "given"], &["the design gives no manufacturing errors", "[errors]"]),
        (
            &["simulate", "--joints", "bearings", "--discs", "elastic", "--bores", "common"],
            &["one rigid spider for all bores", "leave --bores common out, or choose --joints ideal"],
        ),
    ] {
        let said = refused(d, &[&arguments[..1], &["d.toml"], &arguments[1..]].concat());
        let said = said.replace("\n  │ ", " ");
        assert!(words.iter().all(|word| said.contains(word)), "{arguments:?}: {said}");
    }
}

/// Names from files must not send control characters to the terminal.
#[test]
fn names_with_control_characters_reach_no_terminal() {
    let directory = with_design();
    let d = directory.path();
    edit(d, "name = \"RV-40E-81 of Tao2024\"", "name = \"\\u001B[2J\\u0007evil<script>\"");
    std::fs::rename(d.join("d.toml"), d.join("\u{1b}[31md.toml")).unwrap();
    let hostile = "\u{1b}[31md.toml";
    let output = arcmin(d, &["contact", hostile, "--positions", "8", "--out", "o"]);
    let (said, complaint) = texts(&output);
    assert!(output.status.success(), "{complaint}");
    assert!(said.contains("evil") && !said.contains(['\u{1b}', '\u{7}']), "{said:?}");
    assert!(!complaint.contains(['\u{1b}', '\u{7}']), "{complaint:?}");
    let page = read(d, "o/report.html");
    assert!(page.contains("evil") && !page.contains("evil<script>"), "a name is no markup");
    // The summary keeps the name unchanged; another design with the same results is still another one.
    assert_eq!(summary(d, "o")["design"]["name"], "\u{1b}[2J\u{7}evil<script>");
    write(d, "x.toml", &read(d, hostile).replace("evil", "worse"));
    let said = refused(d, &["contact", "x.toml", "--out", "o"]);
    assert!(
        said.contains("holds results of another design") && !said.contains(['\u{1b}', '\u{7}']),
        "{said:?}"
    );
    let said = refused(d, &["check", "\u{1b}[31mnowhere.toml"]);
    assert!(said.contains("nowhere.toml") && !said.contains('\u{1b}'), "{said:?}");
    write(d, "\u{1b}[31mt.toml", "pin_radius = \"\u{1b}\"\n[rong]\n");
    assert!(!refused(d, &["check", "\u{1b}[31mt.toml"]).contains('\u{1b}'));
    write(d, "\u{1b}[31m.csv", "hours,depth_um\n1,\u{1b}[0m\n");
    let said = refused(d, &["calibrate", "x.toml", "\u{1b}[31m.csv", "--out", "p"]);
    assert!(!said.contains('\u{1b}'), "{said:?}");
}

/// A device without end is neither a design nor a table, and needs no more memory than the size limit.
#[cfg(target_os = "linux")]
#[test]
fn files_without_end_are_refused() {
    let directory = with_design();
    let said = refused(directory.path(), &["check", "/dev/zero"]);
    assert!(said.contains("cannot read /dev/zero: it is longer than 16 MB"), "{said}");
}
