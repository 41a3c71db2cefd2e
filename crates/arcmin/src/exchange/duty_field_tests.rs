//! Logs as recorded in the field: a known duty, distorted as loggers do, and read back.

use super::*;
use crate::machine::Machine;
use crate::tables::Naming;
use crate::templates::tao2024;
use crate::units::RPM;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use std::f64::consts::TAU;

/// The original duty, in small steps.
struct Truth {
    step: f64,
    torque: Vec<f64>,
    speed: Vec<f64>,
    angle: Vec<f64>,
    /// Time at rest, s.
    rest: f64,
    starts: usize,
    reversals: usize,
}

/// Motions with ramps, between which the joint rests or reverses immediately; torques of a weight, of inertia
/// and of friction.
fn truth(seed: u64, step: f64) -> Truth {
    let mut random = Pcg64::seed_from_u64(seed);
    let mut truth =
        Truth { step, torque: vec![], speed: vec![], angle: vec![], rest: 0.0, starts: 0, reversals: 0 };
    let (mut angle, mut way, mut rested) = (random.random_range(-1.0..1.0), 1.0, 0.0);
    let weight = random.random_range(80.0..250.0);
    let inertia = random.random_range(5.0..40.0);
    let mut go = |truth: &mut Truth, seconds: f64, speed: &dyn Fn(f64) -> f64, acceleration: f64| {
        for i in 0..(seconds / step).round() as usize {
            let speed = speed((i as f64 + 0.5) * step);
            truth.angle.push(angle);
            truth.speed.push(speed);
            truth.torque.push(
                weight * (angle).sin()
                    + inertia * acceleration
                    + 15.0 * speed.signum() * f64::from(speed != 0.0),
            );
            angle += speed * step;
        }
    };
    for moves in 0..14 {
        // Times are whole numbers of steps, which keeps the sums exact.
        let whole = |seconds: f64| (seconds / step).round() * step;
        if moves == 0 || rested > 0.0 {
            rested = whole(random.random_range(0.4..2.0));
            go(&mut truth, rested, &|_| 0.0, 0.0);
            truth.rest += rested;
            truth.starts += 1;
        }
        let top = way * random.random_range(4.0..25.0) * RPM;
        let (ramp, plateau) = (whole(random.random_range(0.15..0.5)), whole(random.random_range(0.2..1.5)));
        let rise = top / ramp;
        go(&mut truth, ramp, &|t| rise * t, rise);
        go(&mut truth, plateau, &|_| top, 0.0);
        go(&mut truth, ramp, &|t| top - rise * t, -rise);
        rested = f64::from(u8::from(random.random_bool(0.7)));
        let turns_round = rested == 0.0 || random.random_bool(0.6);
        if turns_round && moves < 13 {
            way = -way;
            truth.reversals += 1;
        }
    }
    let rested = whole_rest(step);
    go(&mut truth, rested, &|_| 0.0, 0.0);
    truth.rest += rested;
    truth
}

fn whole_rest(step: f64) -> f64 {
    (0.6 / step).round() * step
}

impl Truth {
    fn sum(&self, power: f64) -> f64 {
        self.torque.iter().zip(&self.speed).map(|(t, w)| t.abs().powf(power) * w.abs() * self.step).sum()
    }

    fn time(&self, i: usize) -> f64 {
        i as f64 * self.step
    }

    fn peak_speed(&self) -> f64 {
        self.speed.iter().fold(0.0, |most: f64, speed| most.max(speed.abs()))
    }

    /// Rows of the log: time, torque, motion.
    fn log(&self, head: &str, motion: &[f64], factor: f64) -> String {
        let mut text = format!("{head}\n");
        for i in 0..self.torque.len() {
            text += &format!("{:.4},{:.3},{:.6}\n", self.time(i), self.torque[i], motion[i] * factor);
        }
        text
    }

    /// Angles of an encoder that restarts at `low`, with quantisation and noise, in rad of its own shaft.
    fn angle_log(&self, name: &str, encoder: &Encoder, grid: f64, noise: f64) -> String {
        let mut random = Pcg64::seed_from_u64(self.angle.len() as u64);
        let mut size = || noise * (random.random_range(-1.0..1.0) + random.random_range(-1.0..1.0));
        let read = |angle: &f64| {
            let noisy = angle * encoder.ratio + size();
            let turned = noisy - TAU * ((noisy - encoder.low) / TAU).floor();
            if grid > 0.0 { (turned / grid).floor() * grid } else { turned }
        };
        let read: Vec<f64> = self.angle.iter().map(read).collect();
        self.log(&format!("time_s,torque_n_m,{name}"), &read, 1.0 / encoder.unit)
    }

    /// Checks the deviation of the result: sums of wear and life relative, time at rest as a fraction of the
    /// log.
    fn hold(&self, import: &DutyImport, what: &str, sums: f64, rest: f64) {
        let ratio = tao2024().kinematics().ratio();
        let moving = import.duration - import.at_rest;
        let of_rows = |power: f64| -> f64 {
            let of_row =
                |row: &DutyRow| row.torque.abs().powf(power) * (row.input_speed / ratio).abs() * row.share;
            import.rows.iter().map(of_row).sum::<f64>() * moving
        };
        for (power, name) in [(0.0, "turns"), (1.0, "wear"), (10.0 / 3.0, "life")] {
            let off = of_rows(power) / self.sum(power) - 1.0;
            assert!(off.abs() < sums, "{what}: {name} off by {off:.4}");
        }
        let whole = self.time(self.torque.len());
        let off = (import.at_rest - self.rest) / whole;
        assert!(
            off.abs() < rest,
            "{what}: rest {:.3} s for {:.3} s of {whole:.1}",
            import.at_rest,
            self.rest
        );
        assert_eq!((import.starts, import.reversals), (self.starts, self.reversals), "{what}");
    }
}

/// An encoder at the output or the motor.
struct Encoder {
    /// Turns of its shaft per turn of the output.
    ratio: f64,
    /// Angle in rad at which it restarts.
    low: f64,
    /// Unit of the log in rad.
    unit: f64,
}

fn read(machine: &Machine, text: &str, options: &DutyImportOptions) -> DutyImport {
    import_duty(machine, text.as_bytes(), "log.csv", options)
        .unwrap_or_else(|error| panic!("{error}: {} in {}", error.remedy(), &text[..200.min(text.len())]))
}

const STEPS: [f64; 4] = [0.002, 0.004, 0.008, 0.012];

#[test]
fn angles_that_restart_are_unwrapped() {
    let machine = tao2024();
    let ratio = machine.kinematics().ratio();
    let deg = TAU / 360.0;
    for seed in 0..24 {
        let truth = truth(seed, STEPS[seed as usize % 4]);
        let (name, unit, low, on_motor) = [
            ("angle_deg", deg, 0.0, false),
            ("output_angle_deg", deg, -0.5 * TAU, false),
            ("Winkel [rad]", 1.0, -0.5 * TAU, false),
            ("joint_angle_turns", TAU, 0.0, false),
            ("motor_angle_deg", deg, 0.0, true),
            ("motor_position (rad)", 1.0, -0.5 * TAU, true),
        ][seed as usize % 6];
        // For more than 0.4 of a turn between readings the sense of rotation is ambiguous.
        let turned = truth.peak_speed() * ratio * truth.step / TAU;
        let encoder = Encoder { ratio: if on_motor { ratio } else { 1.0 }, low, unit };
        if on_motor && turned > 0.38 {
            let log = truth.angle_log(name, &encoder, 0.0, 0.0);
            let found = import_duty(&machine, log.as_bytes(), "l", &DutyImportOptions::default());
            let lost = found.is_err_and(|error| error.to_string().contains("which way it went"));
            assert!(lost || turned < 0.4, "{turned}");
            continue;
        }
        // The actual case: an encoder of 16 bits, noise of a hundredth of a degree.
        let noise = 0.01 * deg * encoder.ratio;
        for (grid, noise, sums, rest) in
            [(0.0, 0.0, 0.01, 0.01), (TAU / 65536.0, 0.0, 0.02, 0.02), (0.0, noise, 0.02, 0.03)]
        {
            let log = truth.angle_log(name, &encoder, grid, noise);
            let import = read(&machine, &log, &DutyImportOptions::default());
            truth.hold(&import, &format!("{seed} {name} {grid} {noise}"), sums, rest);
        }
    }
}

#[test]
fn rest_under_noise() {
    let machine = tao2024();
    for seed in 0..24 {
        let truth = truth(100 + seed, STEPS[seed as usize % 4]);
        let mut random = Pcg64::seed_from_u64(seed);
        let size = random.random_range(0.002..0.02) * truth.peak_speed();
        let normal = |random: &mut Pcg64| (0..12).map(|_| random.random_range(-0.5..0.5)).sum::<f64>();
        let distorted: Vec<f64> = truth
            .speed
            .iter()
            .map(|speed| match seed % 3 {
                0 => speed + size * normal(&mut random),
                // Counts, one of which flickers at rest.
                1 => ((speed + size * random.random_range(-1.0..1.0)) / (2.0 * size)).round() * 2.0 * size,
                // The speed from counts of an angle.
                _ => (speed / size + random.random_range(0.0..1.0)).floor() * size,
            })
            .collect();
        let log = truth.log("time_s,torque_n_m,speed_rad_s", &distorted, 1.0);
        let import = read(&machine, &log, &DutyImportOptions::default());
        truth.hold(
            &import,
            &format!("{seed} noise of {:.2} %", 100.0 * size / truth.peak_speed()),
            0.02,
            0.03,
        );
        let given = DutyImportOptions { rest_speed: Some(0.3), ..DutyImportOptions::default() };
        assert_eq!(read(&machine, &log, &given).rest_speed, 0.3);
    }
}

#[test]
fn values_recorded_on_change_remain_valid() {
    let machine = tao2024();
    for seed in 0..12 {
        let mut truth = truth(200 + seed, 0.01);
        // A load that is constant between moves, so that there are no readings for long times.
        let moving = |i: usize| truth.speed[i] != 0.0;
        let held: Vec<f64> = (0..truth.torque.len()).map(|i| if moving(i) { 150.0 } else { 90.0 }).collect();
        truth.torque = held;
        let mut log = String::from("time_s,torque_n_m,speed_rad_s\n");
        let slow = 400.0;
        let mut last = String::new();
        let mut now = 0.0;
        for i in 0..truth.torque.len() {
            let values = format!("{:.3},{:.6}", truth.torque[i], truth.speed[i]);
            if values != last {
                log += &format!("{now:.4},{values}\n");
            }
            // Holding takes much longer than ramps.
            now += if values == last { slow * truth.step } else { truth.step };
            last = values;
        }
        log += &format!("{now:.4},{last}\n");
        let import = read(&machine, &log, &DutyImportOptions::default());
        assert_eq!(
            (import.gaps, import.starts, import.reversals),
            (0.0, truth.starts, truth.reversals),
            "{seed}"
        );
        assert!((import.duration - now).abs() < 1e-3);
        let mut seconds = (0.0, 0.0);
        for i in 1..truth.speed.len() {
            let same = truth.speed[i] == truth.speed[i - 1];
            let time = if same { slow * truth.step } else { truth.step };
            seconds.0 += time * f64::from(u8::from(truth.speed[i] == 0.0));
            seconds.1 += time * truth.speed[i].abs();
        }
        assert!((import.at_rest / seconds.0 - 1.0).abs() < 0.01, "{seed}: {} {}", import.at_rest, seconds.0);
        assert!((import.output_turns * TAU / seconds.1 - 1.0).abs() < 0.01, "{seed}");
        assert!(
            import.notes.iter().any(|note| note.contains("is valid until the next")),
            "{:?}",
            import.notes
        );
        // With a largest gap these steps are excluded from the duty, and a note is added.
        let short = DutyImportOptions { largest_gap: Some(10.0), ..DutyImportOptions::default() };
        let short = read(&machine, &log, &short);
        assert!(short.gaps > 0.9 * now && short.notes.iter().any(|note| note.contains("are gaps")));
    }
}

#[test]
fn clocks_that_are_coarse_or_repeat() {
    let machine = tao2024();
    for seed in 0..12 {
        let truth = truth(300 + seed, 0.008);
        let mut log = String::from("time_s,torque_n_m,speed_rad_s\n");
        for i in 0..truth.torque.len() {
            let tick = [0.01, 0.1, 1.0][seed as usize % 3];
            let row = format!("{:.3},{:.6}", truth.torque[i], truth.speed[i]);
            match seed % 4 {
                // Some readings occur twice.
                3 => {
                    let twice = if i % 37 == 0 { 2 } else { 1 };
                    (0..twice).for_each(|_| log += &format!("{:.4},{row}\n", truth.time(i)));
                }
                _ => log += &format!("{:.3},{row}\n", (truth.time(i) / tick + 1e-9).floor() * tick),
            }
        }
        let import = read(&machine, &log, &DutyImportOptions::default());
        truth.hold(&import, &format!("{seed} clock"), 0.02, 0.02);
        assert!(!import.notes.is_empty(), "{seed}");
    }
}

#[test]
fn torques_of_the_motor_both_ways() {
    let machine = tao2024();
    let ratio = machine.kinematics().ratio();
    let (efficiency, inertia, constant) = (0.82, 6e-4, 0.7);
    for seed in 0..12 {
        let truth = truth(400 + seed, STEPS[seed as usize % 3]);
        let mut log = String::from(
            ["time_s,motor_torque_n_m,motor_speed_rpm\n", "t [s];Motorstrom [A];joint_speed [°/s]\n"]
                [seed as usize % 2],
        );
        let count = truth.torque.len();
        for i in 0..count {
            let drives = truth.torque[i] * truth.speed[i] >= 0.0;
            let through = if drives { 1.0 / efficiency } else { efficiency };
            let through = if truth.speed[i] == 0.0 { 1.0 } else { through };
            let (a, b) = (i.saturating_sub(1), (i + 1).min(count - 1));
            let speeding = (truth.speed[b] - truth.speed[a]) / (truth.time(b) - truth.time(a));
            let motor = truth.torque[i] / ratio * through + inertia * ratio * speeding;
            log += &match seed % 2 {
                0 => format!("{:.4},{motor:.6},{:.4}\n", truth.time(i), truth.speed[i] * ratio / RPM),
                _ => format!(
                    "{:.4};{:.6};{:.5}\n",
                    truth.time(i),
                    motor / constant,
                    truth.speed[i].to_degrees()
                ),
            };
        }
        let options = DutyImportOptions {
            torque_constant: Some(constant),
            gear_efficiency: efficiency,
            rotor_inertia: inertia,
            ..DutyImportOptions::default()
        };
        truth.hold(&read(&machine, &log, &options), &format!("{seed} motor"), 0.02, 0.01);
    }
}

/// Files of measuring instruments give the same result as a plain table.
#[test]
fn headers_units_and_encodings_do_not_change_the_result() {
    let machine = tao2024();
    let truth = truth(500, 0.008);
    let rows = |separator: &str, mark: char, index: bool| -> String {
        let row = |i: usize| {
            let row = format!("{:.4}\t{:.3}\t{:.6}\n", truth.time(i), truth.torque[i], truth.speed[i] / RPM);
            let row = row.replace('.', &mark.to_string()).replace('\t', separator);
            if index { format!("{i}{separator}{row}") } else { row }
        };
        (0..truth.torque.len()).map(row).collect()
    };
    let sixteen = |text: &str| -> Vec<u8> {
        [0xff, 0xfe].into_iter().chain(text.encode_utf16().flat_map(u16::to_le_bytes)).collect()
    };
    let latin = |text: &str| -> Vec<u8> { text.chars().map(|c| c as u8).collect() };
    let plain = rows(",", '.', false);
    let lvm = "LabVIEW Measurement\t\nWriter_Version\t2\nSeparator\tTab\nDate\t2026/03/03\nTime\t11:20:53.4\n\
               ***End_of_Header***\t\n\t\nChannels\t2\t\t\nSamples\t9\t9\t\nY_Unit_Label\tNm\trpm\t\nX0\t0.0E+0\t0.0E+0\t\n\
               Delta_X\t0.008\t0.008\t\n***End_of_Header***\t\t\t\nX_Value\tJoint Torque\tJoint Speed\tComment\n";
    let nanoseconds = |i: usize| 1_772_536_853_000_000_000 + (truth.time(i) * 1e9).round() as i64;
    let ros: String = (0..truth.torque.len())
        .map(|i| {
            format!(
                "{},7,{},base,{:.6},{:.3}\n",
                nanoseconds(i),
                nanoseconds(i),
                truth.speed[i],
                truth.torque[i]
            )
        })
        .collect();
    let dates: String = (0..truth.torque.len())
        .map(|i| {
            let (t, torque, speed) = (truth.time(i), truth.torque[i], truth.speed[i] / RPM);
            format!("2026-03-03T11:{:02}:{:07.4},{torque:.3},{speed:.6}\n", 20 + t as usize / 60, t % 60.0)
        })
        .collect();
    let files: Vec<(&str, Vec<u8>)> = vec![
        ("plain", format!("time_s,torque_n_m,speed_rpm\n{plain}").into_bytes()),
        ("cut", {
            let text = format!("time_s,torque_n_m,speed_rpm\n{plain}");
            text.as_bytes()[..text.len() - 9].to_vec()
        }),
        ("index", format!(",time_s,torque_n_m,speed_rpm\n{}", rows(",", '.', true)).into_bytes()),
        ("units", format!("Zeit;Drehmoment;Drehzahl\n[s];[Nm];[U/min]\n{}", rows(";", ',', false)).into_bytes()),
        ("head", format!("Joint 3\nOperator;A. N.\n\nt;torque;speed\ns;Nm;rpm\n{}", rows(";", ',', false)).into_bytes()),
        ("sixteen", sixteen(&format!("time [s]\ttorque [N·m]\tspeed [1/min]\n{}", rows("\t", '.', false)))),
        ("latin", latin(&format!("Zeit [s];Drehmoment [N·m];Drehzahl [U/min];Öl\n{}", rows(";", ',', false).replace('\n', ";x\n")))),
        ("labview", format!("{lvm}{}", rows("\t", '.', false)).into_bytes()),
        ("blanks", format!("# rig 2\n# time_s torque_n_m speed_rpm\n{}", rows("  ", '.', false)).into_bytes()),
        ("ros", format!("%time,field.header.seq,field.header.stamp,field.header.frame_id,field.velocity0,field.effort0\n{ros}").into_bytes()),
        ("dates", format!("timestamp,torque_n_m,speed_rpm\n{dates}").into_bytes()),
        ("restarted", {
            let (first, second) = plain.split_at(plain[..plain.len() / 2].rfind('\n').unwrap() + 1);
            format!("time_s,torque_n_m,speed_rpm\n{first}time_s,torque_n_m,speed_rpm\n{second}").into_bytes()
        }),
    ];
    for (name, bytes) in files {
        let import = import_duty(&machine, &bytes, name, &DutyImportOptions::default())
            .unwrap_or_else(|error| panic!("{name}: {error}: {}", error.remedy()));
        truth.hold(&import, name, 0.01, 0.01);
    }
    // Columns with other names can be assigned by the user.
    let naming = |text: &str| DutyImportOptions {
        naming: Naming::parse(text).unwrap(),
        ..DutyImportOptions::default()
    };
    let by_number = naming("1=time_s,2=joint_torque_n_m,3=speed_rpm");
    truth.hold(&read(&machine, &plain, &by_number), "by number", 0.01, 0.01);
    let strange = format!("rubbish,1,2\nA,B [Nm],C,torque_n_m\n{}", plain.replace('\n', ",7\n"));
    let named = naming("A=time_s,B [Nm]=torque,C=speed_rpm");
    truth.hold(&read(&machine, &strange, &named), "named", 0.01, 0.01);
    let error = import_duty(&machine, strange.as_bytes(), "l", &naming("A=time_s,C=speed_rpm,D=torque_n_m"))
        .unwrap_err();
    assert!(error.to_string().contains("\"D\"") && error.remedy().contains("B [Nm]"), "{error}");
}

/// Signals recorded at different rates leave fields empty.
#[test]
fn empty_fields_repeat_values_and_interpolate_angles() {
    let machine = tao2024();
    let truth = truth(550, 0.004);
    let row = |i: usize| {
        let degrees = truth.angle[i].to_degrees().rem_euclid(360.0);
        match i % 4 {
            0 => format!("{:.4},,{degrees:.5}\n", truth.time(i)),
            _ => format!("{:.4},{:.3},\n", truth.time(i), truth.torque[i]),
        }
    };
    let rows: String = (0..truth.torque.len()).map(row).collect();
    let import =
        read(&machine, &format!("time_s,torque_n_m,angle_deg\n{rows}"), &DutyImportOptions::default());
    truth.hold(&import, "empty fields", 0.01, 0.01);
}

/// Steady speeds in whole numbers, the slowest of which is one count: sustained slow motion is not flickering.
#[test]
fn slow_motion_that_lasts_is_motion() {
    let machine = tao2024();
    let levels = [0, 1, 0, 5, 0, 20, 0, -1];
    let rows: String = (0..levels.len() * 200)
        .map(|i| format!("{:.3},100,{}\n", i as f64 * 0.02, levels[i / 50 % levels.len()]))
        .collect();
    let import =
        read(&machine, &format!("time_s,torque_n_m,speed_rpm\n{rows}"), &DutyImportOptions::default());
    assert_eq!((import.starts, import.reversals), (16, 7));
    assert!((import.at_rest - 16.0).abs() < 0.1, "{}", import.at_rest);
}

/// Columns without a side in their names are not taken as those of the output if their magnitudes exclude this.
#[test]
fn trap_motor_columns_without_a_side() {
    let machine = tao2024();
    let ratio = machine.kinematics().ratio();
    let truth = truth(600, 0.008);
    let rows: String = (0..truth.torque.len())
        .map(|i| {
            format!(
                "{:.4},{:.4},{:.3}\n",
                truth.time(i),
                truth.torque[i] / ratio,
                truth.speed[i] * ratio / RPM
            )
        })
        .collect();
    let error = |head: &str| {
        import_duty(&machine, format!("{head}\n{rows}").as_bytes(), "l", &DutyImportOptions::default())
            .unwrap_err()
    };
    let speed = error("time_s,torque_n_m,speed_rpm");
    assert!(speed.to_string().contains("times the rated"), "{speed}");
    assert!(speed.remedy().contains("speed_rpm=motor_speed_rpm"), "{}", speed.remedy());
    let torque = error("time_s,torque_n_m,motor_speed_rpm");
    assert!(torque.to_string().contains("as the motor's"), "{torque}");
    assert!(torque.remedy().contains("torque_n_m=motor_torque_n_m"), "{}", torque.remedy());
    let naming = Naming::parse("torque_n_m=motor_torque_n_m,speed_rpm=motor_speed_rpm").unwrap();
    let options = DutyImportOptions { naming, ..DutyImportOptions::default() };
    let import = read(&machine, &format!("time_s,torque_n_m,speed_rpm\n{rows}"), &options);
    truth.hold(&import, "motor by name", 0.01, 0.01);
    assert!(import.notes.iter().any(|note| note.contains("--efficiency")));
}
