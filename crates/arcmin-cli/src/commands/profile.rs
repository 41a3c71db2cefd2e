use std::f64::consts::TAU;

use arcmin::geometry::{Profile, Relief};
use arcmin::units::{DEG, MM, UM, wrap_angle};
use serde_json::json;

use crate::failure::Failure;
use crate::run::{Common, Run, Table, Verdict};

#[derive(Debug, clap::Args)]
#[command(
    long_about = "Computes the flank of the cycloid disc over one full turn, as cut: with its modifications, and less the wear.\n\n\
                  profile.csv: tau_deg (parameter around the disc), meshing_angle_deg, x_mm and y_mm (worn flank), normal_x and normal_y \
                  (unit, into the metal), curvature_radius_mm (concave positive, empty where straight), unworn_x_mm, unworn_y_mm.",
    after_help = "Examples:\n  arcmin profile my-reducer.toml --points 400\n  arcmin profile my-reducer.toml --wear-um 60 --out flank60"
)]
pub struct Options {
    #[command(flatten)]
    common: Common,
    /// Points per lobe.
    #[arg(long, value_name = "N", default_value_t = 200, value_parser = clap::value_parser!(u32).range(4..=100_000))]
    points: u32,
    /// Depth removed from the whole flank in µm.
    #[arg(long, value_name = "X", default_value_t = 0.0, value_parser = crate::run::depth_um)]
    wear_um: f64,
}

pub fn run(options: Options) -> Result<Verdict, Failure> {
    let mut run = Run::start("profile", &options.common)?;
    let machine = run.design.machine();
    let profile = machine.profile();
    let relief = machine.designed_relief();
    let worn = relief.plus(&Relief::uniform(options.wear_um * UM));
    let mut table = Table::new(&[
        "tau_deg",
        "meshing_angle_deg",
        "x_mm",
        "y_mm",
        "normal_x",
        "normal_y",
        "curvature_radius_mm",
        "unworn_x_mm",
        "unworn_y_mm",
    ]);
    let (lobes, per_lobe) = (profile.lobe_count(), options.points as usize);
    for index in 0..lobes * per_lobe {
        let tau = TAU * index as f64 / (lobes * per_lobe) as f64;
        // From the whole number of steps within the lobe: exact at root and tip, equal on every lobe.
        let meshing_angle = wrap_angle(-TAU * (index % per_lobe) as f64 / per_lobe as f64);
        let outward = profile.outward_normal(tau);
        let (unworn, here) = (relief.at(meshing_angle).depth, worn.at(meshing_angle).depth);
        let point = |depth: f64| (profile.flank_point(tau) - depth * outward) / MM;
        table.row(&[
            (tau / DEG).into(),
            (meshing_angle / DEG).into(),
            point(here).x.into(),
            point(here).y.into(),
            (-outward.x).into(),
            (-outward.y).into(),
            (worn_curvature_radius(&profile, &worn, meshing_angle) / MM).into(),
            point(unworn).x.into(),
            point(unworn).y.into(),
        ]);
    }
    run.table("profile.csv", table)?;
    let (sharpest, at) = profile.sharpest_convex_trace();
    let summary = json!({
        "ratio": machine.kinematics().ratio(),
        "short_width_coefficient": profile.short_width_coefficient(),
        "inflection_deg": profile.inflection().map(|angle| angle / DEG),
        "min_convex_flank_radius_mm": (sharpest - profile.pin_radius) / MM - options.wear_um * UM / MM,
        "min_convex_flank_radius_at_deg": at / DEG,
        "wear_um": options.wear_um,
        "points_per_lobe": options.points,
    });
    run.say(&format!(
        "K1 {:.4}   inflection {}   sharpest convex flank radius {:.3} mm at {:.2}°",
        profile.short_width_coefficient(),
        profile.inflection().map_or("none".to_owned(), |angle| format!("{:.3}°", angle / DEG)),
        (sharpest - profile.pin_radius) / MM - options.wear_um * UM / MM,
        at / DEG
    ));
    run.finish(summary)?;
    Ok(Verdict::Fine)
}

/// Curvature radius in m of the flank less the depth w: 1/ρ of the parallel curve, less w″ along the flank.
fn worn_curvature_radius(profile: &Profile, worn: &Relief, meshing_angle: f64) -> f64 {
    let cos = meshing_angle.cos();
    let curvature = profile.flank_curvature(cos);
    let sample = worn.at(meshing_angle);
    let length = profile.flank_length_per_meshing_angle(cos);
    1.0 / (curvature / (1.0 + sample.depth * curvature) - sample.bend / (length * length))
}
