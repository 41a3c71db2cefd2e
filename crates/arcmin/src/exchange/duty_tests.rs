use super::*;
use crate::templates::tao2024;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

/// A pick-and-place cycle with random payloads: trapezoidal speed, inertia, weight, friction, pauses.
fn log(seconds: usize, rate: usize) -> (Vec<f64>, Vec<f64>, Vec<f64>) {
    let mut random = Pcg64::seed_from_u64(5);
    let (mut time, mut torque, mut speed) = (Vec::new(), Vec::new(), Vec::new());
    let (mut load, mut way) = (100.0, 1.0);
    for i in 0..seconds * rate {
        let t = i as f64 / rate as f64;
        let phase = t % 2.0;
        if i % (2 * rate) == 0 {
            load = random.random_range(20.0..250.0);
            way = -way;
        }
        let (w, a) = match phase {
            p if p < 0.4 => (p / 0.4, 1.0),
            p if p < 1.0 => (1.0, 0.0),
            p if p < 1.4 => ((1.4 - p) / 0.4, -1.0),
            _ => (0.0, 0.0),
        };
        time.push(t);
        speed.push(way * 1.8 * w);
        torque.push(
            way * (a * 300.0 + 20.0 * f64::from(w > 0.0))
                + load * (0.3 * t).sin()
                + random.random_range(-3.0..3.0),
        );
    }
    (time, torque, speed)
}

fn text(head: &str, columns: &[&[f64]]) -> String {
    let mut text = head.to_owned() + "\n";
    for i in 0..columns[0].len() {
        let fields: Vec<String> = columns.iter().map(|column| format!("{:.9}", column[i])).collect();
        text += &fields.join(",");
        text.push('\n');
    }
    text
}

/// Sums over the rows of the written TOML compared with sums over all readings, both computed here.
#[test]
fn fifty_rows_represent_the_whole_log() {
    let machine = tao2024();
    let (time, torque, speed) = log(600, 200);
    let file = text("time_s,torque_n_m,speed_rad_s,state", &[&time, &torque, &speed, &time]);
    let import = import_duty(&machine, file.as_bytes(), "log.csv", &DutyImportOptions::default()).unwrap();
    assert!(import.rows.len() <= 50);
    let body: toml::Table = import.toml.parse().unwrap();
    let rows: Vec<[f64; 3]> = body["duty"]
        .as_array()
        .unwrap()
        .iter()
        .map(|row| {
            ["torque_n_m", "input_speed_rpm", "share"]
                .map(|key| row[key].as_float().unwrap_or_else(|| row[key].as_integer().unwrap() as f64))
        })
        .collect();
    assert!((rows.iter().map(|row| row[2]).sum::<f64>() - 1.0).abs() < 1e-11);
    let moving: Vec<usize> = (0..time.len()).filter(|i| speed[*i].abs() > 1.8e-3).collect();
    // Totals of the joint; the hours in motion, to which the shares refer, are part of the result.
    let in_motion = import.duration - import.at_rest;
    let log_sum = |power: f64| {
        moving.iter().map(|i| torque[*i].abs().powf(power) * speed[*i].abs() / 200.0).sum::<f64>()
    };
    let ratio = machine.kinematics().ratio();
    let row_sum = |power: f64| {
        rows.iter()
            .map(|row| row[0].abs().powf(power) * (row[1] * crate::units::RPM / ratio).abs() * row[2])
            .sum::<f64>()
            * in_motion
    };
    // Number of turns exactly; wear and bearing load within the stated percent.
    for (power, limit) in [(0.0, 1e-4), (1.0, 0.01), (10.0 / 3.0, 0.01)] {
        let off = row_sum(power) / log_sum(power) - 1.0;
        assert!(off.abs() < limit, "{power}: {off}");
    }
    let r = &import.reduction;
    assert!((r.wear_error - (row_sum(1.0) / log_sum(1.0) - 1.0)).abs() < 1e-5);
    assert!((r.life_error - (log_sum(10.0 / 3.0) / row_sum(10.0 / 3.0) - 1.0)).abs() < 1e-4);
    assert!(r.wear_error.abs() < 0.01 && r.bearing_load_error.abs() < 0.01 && r.life_error.abs() < 0.01);
    // All four combinations of signs occur in such a log.
    for signs in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)] {
        assert!(rows.iter().any(|row| row[0] * signs.0 > 0.0 && row[1] * signs.1 > 0.0));
    }
    // 600 s in cycles of 2 s, of which 0.6 s at rest.
    assert!((import.duration - 599.995).abs() < 1e-6 && (import.at_rest - 180.0).abs() < 4.0);
    assert!((299..=300).contains(&import.starts) && (298..=299).contains(&import.reversals));
    assert!((import.output_turns - 600.0 * 0.5 * 1.8 / std::f64::consts::TAU).abs() < 0.5);
    assert_eq!(
        import.peak_torque.0.abs(),
        torque.iter().fold(0.0_f64, |m, t| m.max(format!("{t:.9}").parse::<f64>().unwrap().abs()))
    );
    let shares: f64 = import.picture.cells.iter().flatten().sum();
    assert!((shares - 100.0).abs() < 1e-9);
    let design = crate::templates::TAO2024.text;
    let (before, after) = design.split_once("[[duty]]").unwrap();
    let rest = after.split_once("[wear]").unwrap().1;
    let design = format!("{before}{}\n[wear]{rest}", import.toml);
    let read = crate::design::Design::parse(&design, "t").unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(read.machine().duty.len(), import.rows.len());
}

/// Current and motor angle give the same result as torque and speed at the output.
#[test]
fn motor_side_logs_agree() {
    let machine = tao2024();
    let ratio = machine.kinematics().ratio();
    let (time, torque, speed) = log(60, 100);
    let file = text("time_s,torque_n_m,speed_rad_s", &[&time, &torque, &speed]);
    let direct = import_duty(&machine, file.as_bytes(), "log.csv", &DutyImportOptions::default()).unwrap();
    let mut angle = vec![0.0];
    for i in 1..time.len() {
        angle.push(angle[i - 1] + 0.5 * (speed[i] + speed[i - 1]) * (time[i] - time[i - 1]));
    }
    // If the load drives, the motor torque is the part of the load torque that is transmitted.
    let through = |t: f64, w: f64| match t * w {
        power if power > 0.0 => 1.0 / 0.9,
        power if power < 0.0 => 0.9,
        _ => 1.0,
    };
    let current: Vec<f64> =
        torque.iter().zip(&speed).map(|(t, w)| t / ratio * through(*t, *w) / 0.5).collect();
    let degrees: Vec<f64> = angle.iter().map(|a| (a * ratio).to_degrees()).collect();
    let milliseconds: Vec<f64> = time.iter().map(|t| t * 1e3).collect();
    let file = text("time_ms,motor_current [A],motor_angle [°]", &[&milliseconds, &current, &degrees]);
    let options = DutyImportOptions {
        torque_constant: Some(0.5),
        gear_efficiency: 0.9,
        ..DutyImportOptions::default()
    };
    let motor = import_duty(&machine, file.as_bytes(), "log.csv", &options).unwrap();
    let (a, b) = (&direct.reduction, &motor.reduction);
    assert!((b.equivalent_torque / a.equivalent_torque - 1.0).abs() < 2e-3);
    // Differences of the angle smooth every start and stop over one reading: four ramps of 10 ms in 1.4 s.
    assert!((b.mean_speed / a.mean_speed - 1.0).abs() < 0.03, "{} {}", b.mean_speed, a.mean_speed);
    assert!((motor.peak_torque.0 / direct.peak_torque.0 - 1.0).abs() < 1e-6);
    assert!(import_duty(&machine, file.as_bytes(), "l", &DutyImportOptions::default()).is_err());
}

#[test]
fn gaps_and_constant_logs() {
    let machine = tao2024();
    let mut file = String::from("time_s,torque_n_m,speed_rpm\n");
    for i in 0..100 {
        let t = f64::from(i) * 0.1 + if i >= 50 { 1000.0 } else { 0.0 };
        file += &format!("{t},100,15\n");
    }
    let import = import_duty(&machine, file.as_bytes(), "l", &DutyImportOptions::default()).unwrap();
    assert_eq!(import.rows.len(), 1);
    let row = import.rows[0];
    assert!((row.torque - 100.0).abs() < 1e-6 && row.share == 1.0);
    assert!((row.input_speed / crate::units::RPM - 15.0 * 81.0).abs() < 1e-5);
    assert!((import.gaps - 1000.1).abs() < 1e-6 && (import.duration - 9.8).abs() < 1e-9);
    assert!(import.reduction.life_error.abs() < 1e-9 && import.at_rest.abs() < 1e-9);
    // The torque of the surroundings has the opposite sign.
    let outer = DutyImportOptions { torque_is_outer: true, ..DutyImportOptions::default() };
    assert!(import_duty(&machine, file.as_bytes(), "l", &outer).unwrap().rows[0].torque < 0.0);
}

#[test]
fn invalid_logs_are_refused_with_a_remedy() {
    let machine = tao2024();
    for file in [
        "",
        "time_s,torque_n_m\n0,1\n1,1\n",
        "time_s,speed_rpm\n0,1\n1,1\n",
        "time_s,torque_n_m,speed_rpm\n0,1,1\n",
        "time_s,torque_n_m,speed_rpm\n0,1,0\n1,1,0\n",
        "time_s,torque_n_m,speed_rpm\n0,0,1\n1,0,1\n",
        "time_s,torque_n_m,speed_rpm\n1,1,1\n0,1,1\n",
        "time_s,torque_n_m,speed_rpm\n0,1,1\n1,NaN,1\n",
        "time_s,torque_n_m,current_a,speed_rpm\n0,1,1,1\n1,1,1,1\n",
        "time_s,torque_n_m,speed\n0,1,1\n1,1,1\n",
        "time_s,torque_n_m,speed_rpm\n0,1e300,1\n1,1,1\n",
    ] {
        let error = import_duty(&machine, file.as_bytes(), "l", &DutyImportOptions::default()).unwrap_err();
        assert!(!error.remedy().is_empty(), "{file}: {error}");
    }
    let rows = DutyImportOptions { rows: 3, ..DutyImportOptions::default() };
    assert!(matches!(import_duty(&machine, b"", "l", &rows), Err(ExchangeError::Option { .. })));
}
