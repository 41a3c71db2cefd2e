use super::*;
use proptest::prelude::*;

fn form() -> Form {
    Form::new(&[
        Column::number("hours").not_falling(),
        Column::number("depth_um").also(&["wear_depth"]).within(-500.0, 500.0),
        Column::words("note").optional(),
    ])
}

fn read(text: &str) -> Result<Table, TableError> {
    form().read(text.as_bytes(), "t.csv")
}

fn depths(text: &str) -> Vec<f64> {
    read(text).unwrap().numbers("depth_um").unwrap().to_vec()
}

fn refused(text: &str) -> (Option<usize>, TableErrorKind) {
    let error = read(text).unwrap_err();
    assert!(!error.remedy().is_empty());
    (error.line, error.kind)
}

#[test]
fn the_same_table_in_every_dialect() {
    for text in [
        "hours,depth_um\n0,1.5\n10,2\n",
        "depth_um,hours\r\n1.5,0\r\n2,10",
        "\u{feff}hours;depth_um\n0;1,5\n10;2,0\n",
        "# of the shop\n\nhours\tdepth_um\n0\t1,5\n  # half way\n10\t2\n\n",
        "sep=;\nHours;Depth [µm]\r0;1.5\r10;2\r",
        "hours,\"depth (mm)\"\n0,0.0015\n10,2e-3\n",
        "hours,depth_um,\n0,1.5,\n10,2,\n,,\n",
        "hours,depth_um\n\"0\",\"1,5\"\n\"10\",\"2,0\"\n",
        "Hours;wear depth (um);NOTE\n0;1,5;\"x;y\"\n10;2;\n",
    ] {
        let table = read(text).unwrap_or_else(|e| panic!("{text:?}: {e}"));
        assert_eq!(table.numbers("hours").unwrap(), [0.0, 10.0], "{text:?}");
        let depths = table.numbers("depth_um").unwrap();
        assert!((depths[0] - 1.5).abs() < 1e-15 && depths[1] == 2.0, "{text:?}: {depths:?}");
    }
}

#[test]
fn encodings() {
    let text = "hours;depth [µm]\n0;−1,25\n";
    let sixteen: Vec<u8> =
        [0xff, 0xfe].into_iter().chain(text.encode_utf16().flat_map(u16::to_le_bytes)).collect();
    assert_eq!(form().read(&sixteen, "t").unwrap().numbers("depth_um").unwrap(), [-1.25]);
    let big: Vec<u8> =
        [0xfe, 0xff].into_iter().chain(text.encode_utf16().flat_map(u16::to_be_bytes)).collect();
    assert_eq!(form().read(&big, "t").unwrap().numbers("depth_um").unwrap(), [-1.25]);
    let latin = b"hours;depth [\xb5m]\n0;1,25\n";
    assert_eq!(form().read(latin, "t").unwrap().numbers("depth_um").unwrap(), [1.25]);
    assert_eq!(form().read(b"hours;depth_um\n0;\x93\n", "t").unwrap_err().kind, TableErrorKind::NotText);
    assert_eq!(form().read(b"PK\x03\x04", "t").unwrap_err().kind, TableErrorKind::ControlCharacter(3));
}

/// The two files that were once read as (1, 0) and as 1 µm, and similar ones.
#[test]
fn trap_decimal_commas_between_commas() {
    let counts = |text: &str| matches!(refused(text), (Some(2), TableErrorKind::FieldCount { .. }));
    assert!(counts("hours,depth_um\n1,0,078\n"));
    assert!(counts("hours,depth_um\n37,1,54\n"));
    // The number of fields is right only because a name is left out.
    assert!(matches!(
        refused("hours,depth_um,note\n1,0,078\n1,2\n").1,
        TableErrorKind::FieldCount { header: 3, found: 2, .. }
    ));
    let three = Form::new(&[Column::number("a"), Column::number("b"), Column::number("c")]);
    let error = three.read(b"a,b,c\n1,0,078\n", "t").unwrap_err();
    assert!(matches!(error.kind, TableErrorKind::LeadingZero { .. }), "{error}");
    // One column: a comma may be decimal or a separator.
    let one = Form::new(&[Column::number("a")]);
    assert!(matches!(
        one.read(b"a\n0,078\n", "t").unwrap_err().kind,
        TableErrorKind::FieldCount { header: 1, .. }
    ));
    assert_eq!(one.read(b"a\n0.078\n", "t").unwrap().numbers("a").unwrap(), [0.078]);
}

#[test]
fn thousands_are_not_decimals() {
    assert!(matches!(
        refused("hours;depth_um\n0;1,5\n1;2.5\n"),
        (Some(2), TableErrorKind::MixedMarks { point: 3 })
    ));
    for field in ["1.234,5", "1,234.5", "1'234", "1 234", "1,234,567", "1\u{a0}234"] {
        let (line, kind) = refused(&format!("hours;depth_um\n0;{field}\n"));
        assert!(line == Some(2) && matches!(kind, TableErrorKind::Grouped { .. }), "{field} {kind}");
    }
    let tab = |rest: &str| format!("hours\tdepth_um\n0\t1,234\n{rest}");
    assert!(matches!(refused(&tab("")), (Some(2), TableErrorKind::AmbiguousComma { .. })));
    assert!(matches!(refused("hours,depth_um\n0,\"1,234\"\n").1, TableErrorKind::AmbiguousComma { .. }));
    assert_eq!(depths(&tab("1\t0,5\n")), [1.234, 0.5]);
    assert_eq!(depths("hours;depth_um\n0;1,234\n"), [1.234]);
}

#[test]
fn faults_are_reported_with_their_line() {
    use TableErrorKind::*;
    let cases: &[(&str, Option<usize>, fn(&TableErrorKind) -> bool)] = &[
        ("", None, |k| *k == Empty),
        ("# only words\n", None, |k| *k == Empty),
        ("hours,depth_um\n", Some(1), |k| *k == NoRows),
        ("0,1.5\n10,2\n", Some(1), |k| matches!(k, NoHeader { .. })),
        ("0;1,5\n10;2\n", Some(1), |k| matches!(k, NoHeader { .. })),
        ("#x\nhours,depth_um,colour\n0,1,2\n", Some(2), |k| matches!(k, Unknown { .. })),
        ("hours,depth\n0,1\n", Some(1), |k| matches!(k, NoUnit { .. })),
        ("hours,depth_deg\n0,1\n", Some(1), |k| matches!(k, WrongUnit { .. })),
        ("hours,depth [in]\n0,1\n", Some(1), |k| matches!(k, WrongUnit { .. })),
        ("hours,depth_um,depth_mm\n0,1,1\n", Some(1), |k| matches!(k, Twice { .. })),
        ("depth_um\n0\n", Some(1), |k| matches!(k, Missing { .. })),
        ("hours;depth_um,note\n0;1\n", Some(1), |k| matches!(k, MixedSeparators { .. })),
        ("hours,depth_um\n0,1\n\n# c\n5,\n", Some(5), |k| matches!(k, Blank { .. })),
        ("hours,depth_um\n0,1\n5,NaN\n", Some(3), |k| matches!(k, NotANumber { .. })),
        ("hours,depth_um\n0,inf\n", Some(2), |k| matches!(k, NotANumber { .. })),
        ("hours,depth_um\n0,1e999\n", Some(2), |k| matches!(k, NotANumber { .. })),
        ("hours,depth_um\n0,0x1f\n", Some(2), |k| matches!(k, NotANumber { .. })),
        ("hours,depth_um\n0;1\n", Some(2), |k| matches!(k, FieldCount { .. })),
        ("hours,depth_um,\n0,1,2\n", Some(2), |k| *k == Unnamed(3)),
        ("hours,depth_um\n5,1\n0,1\n", Some(3), |k| matches!(k, Order { .. })),
        ("hours,depth_um\n5,1e4\n", Some(2), |k| matches!(k, OutOfRange { .. })),
        ("hours,depth_um\n5,\"1\n6,2\n", Some(2), |k| *k == OpenQuote),
        ("hours,depth_um\n5,1\u{1b}[2J\n", Some(2), |k| *k == ControlCharacter(27)),
    ];
    for (text, line, is) in cases {
        let (found, kind) = refused(text);
        assert!(found == *line && is(&kind), "{text:?}: {found:?} {kind:?}");
    }
}

#[test]
fn limits_gaps_and_strangers() {
    let small = form().with_limits(Limits { bytes: 60, rows: 2, columns: 3 });
    assert!(matches!(
        small.read(b"hours,depth_um\n0,1\n1,1\n2,1\n", "t").unwrap_err(),
        TableError { line: Some(4), kind: TableErrorKind::TooLarge { .. }, .. }
    ));
    assert!(matches!(small.read(&[b'x'; 61], "t").unwrap_err().kind, TableErrorKind::TooLarge { .. }));
    let log = Form::new(&[Column::number("torque_n_m").with_gaps()]).with_others();
    let table = log.read(b"state,Torque (Nm),torque_limit_n_m\n7a,,3\nok,2.5,3\n", "t").unwrap();
    assert_eq!(table.gaps("torque_n_m").unwrap(), [None, Some(2.5)]);
    assert_eq!(table.numbers("torque_n_m").unwrap_err().line, Some(2));
    assert_eq!(table.wrong(1, "a", "b").line, Some(3));
    assert!(table.numbers("x").is_err() && table.words("torque_n_m").is_err() && !table.has("x"));
}

#[test]
fn messages_verbatim() {
    let error = read("hours,depth_um\n37,1,54\n").unwrap_err();
    assert_eq!(error.to_string(), "t.csv, line 2: the header names 2 columns, but here are 3 fields");
    assert_eq!(
        error.remedy(),
        "if these are decimal commas, separate the fields by semicolons or write decimal points"
    );
    let error = read("hours,depth\n0,1\n").unwrap_err();
    assert_eq!(error.to_string(), "t.csv, line 1: the column \"depth\" has no unit");
    assert_eq!(error.remedy(), "name it depth with one of the endings _m, _mm, _um");
}

fn log() -> Form {
    Form::new(&[
        Column::stamps("time_s").also(&["t", "timestamp"]).not_falling(),
        Column::number("torque_n_m").also(&["joint_torque"]).optional().with_gaps(),
        Column::number("angle_rad").also(&["position", "joint_angle"]).optional(),
    ])
    .with_others()
    .naming(&Naming::default())
}

/// A trace of TwinCAT: a head, names of the user, units and other lines between names and rows.
const TRACE: &str = "Name;JointTrace\nFile;C:\\Scope\\JointTrace.csv\n\n\nName;J3_ActTorque;J3_Pos\n\
    SymbolComment;Actual torque;Angle\nSampleTime[ms];8;8\nUnit;Nm (Torque);° (Angle)\nUnit ScaleFactor;1;1\n\n\
    132907764534190000;-64.7029;180\n132907764534270000;-52.5895;90\n";

#[test]
fn heads_of_instruments() {
    let table = log().read(TRACE.as_bytes(), "t").unwrap();
    // Times are recognised; the other columns are proposed.
    assert_eq!((table.header_line(), table.line(0)), (5, 11));
    assert_eq!(table.proposal(), "J3_ActTorque=torque_n_m,J3_Pos=angle_deg");
    let times = table.numbers("time_s").unwrap();
    assert!((times[1] - times[0] - 0.008).abs() < 1e-5);
    let naming = Naming::parse("J3_ActTorque=joint_torque, J3_Pos=angle_rad").unwrap();
    let error = log().naming(&naming).read(TRACE.as_bytes(), "t").unwrap_err();
    assert!(matches!(error.kind, TableErrorKind::TwoUnits { .. }), "{error}");
    let naming = Naming::parse("J3_ActTorque=joint_torque,J3_Pos=angle").unwrap();
    let table = log().naming(&naming).read(TRACE.as_bytes(), "t").unwrap();
    assert_eq!(table.numbers("torque_n_m").unwrap(), [-64.7029, -52.5895]);
    assert!((table.numbers("angle_rad").unwrap()[1] - 0.5 * std::f64::consts::PI).abs() < 1e-12);
    assert_eq!((table.meant("torque_n_m"), table.written("torque_n_m")), ("joint_torque", "J3_ActTorque"));
    // Skipped lines are counted.
    let table = log().naming(&naming.skipping(4)).read(TRACE.as_bytes(), "t").unwrap();
    assert_eq!((table.header_line(), table.len()), (5, 2));
    // If no line contains the mandatory names, the message gives the nearest line and the rows.
    let text = "Rig 7\nMessung;A\n\nZeitpunkt;Kraft [N];M [Nm]\n0;1;2\n1;1;2\n";
    let error = log().read(text.as_bytes(), "t").unwrap_err();
    assert_eq!(
        error.to_string(),
        "t, line 4: there is no column time_s above the rows, which begin in line 5"
    );
    assert_eq!(
        error.remedy(),
        "add or rename it; the file has Zeitpunkt, Kraft [N], M [Nm]: assign the columns, such as --columns \"M \
         [Nm]=torque_n_m\""
    );
    // A strict form also accepts a head and units.
    let text = "Prüfstand 4\nhours;depth;note\n;mm;\n0;0,001;a\n5;0,002;b\n";
    assert_eq!(depths(text), [1.0, 2.0]);
    // Another line than units between names and rows remains an error.
    assert_eq!(refused("hours,depth_um\nabc,def\n0,1\n1,2\n").0, Some(2));
    assert!(matches!(refused("hours,depth_um\nmm,mm\n0,1\n1,2\n").1, TableErrorKind::TwoUnits { .. }));
}

#[test]
fn names_by_convention_and_by_the_user() {
    let ros = "%time,field.header.seq,field.position0,field.effort0\n1772536853000000000,1,0.5,3\n\
               1772536853010000000,2,0.6,4\n";
    let table = log().read(ros.as_bytes(), "t").unwrap();
    assert_eq!(table.numbers("angle_rad").unwrap(), [0.5, 0.6]);
    assert_eq!(table.numbers("torque_n_m").unwrap(), [3.0, 4.0]);
    // Brackets of an index precede those of the unit.
    let drive = "Time [ms],r80[0] Torque [Nm],r81\n0,5,1\n1,6,1\n";
    let table = log().read(drive.as_bytes(), "t").unwrap();
    assert_eq!(
        (table.proposal(), table.names()),
        ("r80[0] Torque [Nm]=torque_n_m", "Time [ms], r80[0] Torque [Nm], r81")
    );
    // With two joints the user has to choose.
    let two = "__time,/joint_states/a/position,/joint_states/b/position\n0,1,2\n1,1,2\n";
    let table = log().read(two.as_bytes(), "t").unwrap();
    assert!(!table.has("angle_rad"));
    assert_eq!(table.proposal(), "/joint_states/a/position=joint_angle_rad");
    let naming = Naming::parse("/joint_states/b/position=joint_angle_rad").unwrap();
    assert_eq!(
        log().naming(&naming).read(two.as_bytes(), "t").unwrap().numbers("angle_rad").unwrap(),
        [2.0, 2.0]
    );
    // By number, without a line of names; one column is skipped.
    let naming = Naming::parse("1=time_ms,3=torque_n_m").unwrap();
    let table = log().naming(&naming).read(b"0 7 1.5\n10 8 2.5\n", "t").unwrap();
    assert_eq!(table.numbers("time_s").unwrap(), [0.0, 0.01]);
    assert_eq!(table.numbers("torque_n_m").unwrap(), [1.5, 2.5]);
    let naming = Naming::parse("joint_torque_n_m=-").unwrap();
    let twice = b"t [s],torque [Nm],joint_torque_n_m\n0,1,9\n1,2,9\n";
    assert_eq!(log().naming(&naming).read(twice, "t").unwrap().numbers("torque_n_m").unwrap(), [1.0, 2.0]);
    assert!(matches!(log().read(twice, "t").unwrap_err().kind, TableErrorKind::Twice { .. }));
    for (text, told) in [("x", "name=column"), ("=a", "lacks a name"), ("a=", "lacks a name")] {
        assert!(Naming::parse(text).unwrap_err().contains(told), "{text}");
    }
    let naming = Naming::parse("t=colour").unwrap();
    let error = log().naming(&naming).read(b"t,torque [Nm]\n0,1\n", "t").unwrap_err();
    assert!(matches!(error.kind, TableErrorKind::NotAsked { .. }), "{error}");
}

#[test]
fn ends_indexes_and_stamps() {
    let times = |text: &str| log().read(text.as_bytes(), "t").unwrap().numbers("time_s").unwrap().to_vec();
    // An incomplete last line is skipped with a message; with a line end it is an error.
    let table = log().read(b"time_s,torque_n_m\n0,1.25\n1,1.50\n2", "t").unwrap();
    assert_eq!(
        (table.len(), table.notes()),
        (2, &["the last line, 4, is incomplete and left out".to_owned()][..])
    );
    assert!(log().read(b"time_s,torque_n_m\n0,1.25\n1,1.50\n2\n", "t").is_err());
    assert_eq!(times("time_s,torque_n_m\n0,1\n1,2").len(), 2);
    // Twenty rows with two decimals, then one with one.
    let rows: String = (0..20).map(|i| format!("{i},1.25\n")).collect();
    assert_eq!(times(&format!("time_s,torque_n_m\n{rows}20,1.2")).len(), 20);
    assert_eq!(times(&format!("time_s,torque_n_m\n{rows}20,1.2\n")).len(), 21);
    // Index columns.
    assert_eq!(depths(",hours,depth_um\n0,0,1\n1,5,2\n"), [1.0, 2.0]);
    assert!(matches!(refused(",hours,depth_um\n1,0,1\n0,5,2\n").1, TableErrorKind::Unnamed(1)));
    assert!(matches!(refused("hours,,depth_um\n1,0,1\n5,1,2\n").1, TableErrorKind::Unnamed(2)));
    // Times by date, by size, and a number of unknown unit.
    let dates = times("timestamp,torque_n_m\n2026-03-03 11:20:53.5,1\n2026-03-03 11:20:54.25,1\n");
    assert!((dates[1] - dates[0] - 0.75).abs() < 1e-6);
    let stamps = times("timestamp,torque_n_m\n1772536853500,1\n1772536854250,1\n");
    assert!((stamps[1] - stamps[0] - 0.75).abs() < 1e-6 && (stamps[0] - dates[0]).abs() < 1e-3);
    let error = log().read(b"timestamp,torque_n_m\n0,1\n1,1\n", "t").unwrap_err();
    assert!(matches!(error.kind, TableErrorKind::NoUnit { .. }), "{error}");
    assert!(log().read(b"timestamp,torque_n_m\n2026-13-03 11:20:53,1\n", "t").is_err());
    // UTF-16 without byte-order mark, and cut within a letter.
    let bytes: Vec<u8> =
        "time_s;torque_n_m\n0;1\n1;2\n3;".encode_utf16().flat_map(u16::to_le_bytes).collect();
    assert_eq!(log().read(&bytes[..bytes.len() - 1], "t").unwrap().len(), 2);
    let turns = log().read("t [s],Position [U]\n0,0.5\n".as_bytes(), "t").unwrap();
    assert!((turns.numbers("angle_rad").unwrap()[0] - std::f64::consts::PI).abs() < 1e-12);
}

/// A table as a spreadsheet writes it.
fn written(numbers: &[(f64, f64)], separator: char, mark: char, end: &str) -> String {
    let number = |x: f64| x.to_string().replace('.', &mark.to_string());
    let mut text = format!("a{separator}b{end}");
    for (a, b) in numbers {
        text += &format!("{}{separator}{}{end}", number(*a), number(*b));
    }
    text
}

/// A thousand of each kind, or the number in HOSTILE_CASES.
fn cases() -> u32 {
    std::env::var("HOSTILE_CASES").ok().and_then(|cases| cases.parse().ok()).unwrap_or(1000)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(cases()))]

    /// Tables written with `;` and `,` and with any other dialect are read back with identical bits.
    #[test]
    fn round_trip(numbers in prop::collection::vec((-1e6..1e6_f64, prop::num::f64::NORMAL), 1..20), crlf: bool) {
        let form = Form::new(&[Column::number("a"), Column::number("b")]);
        let end = if crlf { "\r\n" } else { "\n" };
        for (separator, mark) in [(';', ','), (';', '.'), (',', '.'), ('\t', '.')] {
            let table = form.read(written(&numbers, separator, mark, end).as_bytes(), "t").unwrap();
            let back: Vec<(f64, f64)> =
                table.numbers("a").unwrap().iter().copied().zip(table.numbers("b").unwrap().iter().copied()).collect();
            prop_assert_eq!(&back, &numbers);
        }
        // With the comma in both roles the table is either rejected or read as written.
        if let Ok(table) = form.read(written(&numbers, ',', ',', end).as_bytes(), "t") {
            prop_assert_eq!(table.numbers("a").unwrap(), numbers.iter().map(|n| n.0).collect::<Vec<_>>());
        }
    }

    /// Hostile tables: random bytes, and tables that were cut, doubled and modified at random.
    #[test]
    fn hostile_bytes(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        let _ = form().read(&bytes, "t");
        let _ = form().with_others().read(&bytes, "t");
    }

    #[test]
    fn hostile_tables(
        text in "(hours|depth_um|depth|note|sep=|[;,\t\"#]|\n|\r\n|[0-9]{1,3}|[.,]|-|e9|nan|\\[|µ|\u{feff}| ){0,60}",
        at in 0usize..60,
        odd in any::<u8>(),
    ) {
        for form in [form(), form().with_others()] {
            if let Ok(table) = form.read(text.as_bytes(), "t") {
                prop_assert!(table.numbers("depth_um").unwrap().iter().all(|x| x.is_finite()));
                prop_assert_eq!(table.numbers("hours").unwrap().len(), table.len());
            }
            let mut bytes = format!("hours;depth_um;note\n0;1,5;a\n{text}\n").into_bytes();
            let at = at % bytes.len();
            bytes[at] = odd;
            if let Err(error) = form.read(&bytes, "t") {
                let harmless = error.to_string().chars().all(|c| !c.is_control());
                prop_assert!(harmless && !error.remedy().is_empty());
            }
        }
    }
}

/// A million rows are read in one pass; the line numbers of the last rows are right.
#[test]
fn long_tables_keep_their_lines() {
    let mut text = String::from("time_s,torque_n_m\n");
    for i in 0..200_000 {
        text += if i % 1000 == 0 { "# mark\n\n" } else { "" };
        text += &format!("{}e-3,{}\n", i, f64::from(i % 777) * 0.37);
    }
    let form = Form::new(&[Column::number("time_s").rising(), Column::number("torque_n_m")]);
    let table = form.read(text.as_bytes(), "t").unwrap();
    assert_eq!((table.len(), table.line(0), table.line(199_999)), (200_000, 4, 200_401));
}
