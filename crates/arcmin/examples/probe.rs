use arcmin::contact::ContactLaw;
use arcmin::dynamics::*;
use arcmin::geometry::Relief;
use arcmin::units::{ARCMIN, RPM, UM};
fn main() {
    let arg = |i: usize, d: f64| std::env::args().nth(i).map_or(d, |x| x.parse().unwrap());
    let (wear, torque, period, drag, tol, law, rho, vt) =
        (arg(1, 10.0), arg(2, 412.0), arg(3, 0.0), arg(4, 0.0), arg(5, 1e-5), arg(6, 2.85e8), arg(7, 0.9), arg(8, 2e-5));
    let end = arg(9, 0.8);
    let mut machine = arcmin::templates::rv_40e_81();
    if law > 0.0 {
        machine.contact_law = ContactLaw::Linear { stiffness: law }
    }
    let load = if torque == 0.0 {
        OutputLoad::None
    } else if period > 0.0 {
        OutputLoad::Sine { amplitude: torque, period }
    } else {
        OutputLoad::Constant { torque }
    };
    let model = IdealJoints::new(&machine, &Relief::uniform(wear * UM), Drive::SpeedLaw { speed: 1500.0 * RPM, rise_time: 0.1 }, load, drag).unwrap();
    let plan = RunPlan {
        end,
        control: StepControl { tolerance: tol, spectral_radius: rho, velocity_time: vt, ..StepControl::default() },
        ..RunPlan::default()
    };
    let start = std::time::Instant::now();
    let mut run = Run::new(&model, plan).unwrap();
    if let Err(e) = run.finish() {
        println!("{e}");
    }
    let wall = start.elapsed().as_secs_f64();
    let r = run.result();
    if let Some(s) = r.statistics {
        println!(
            "mean {:.6} abs {:.6} max {:.6} pp {:.6} rms {:.6} [{:.6} {:.6}]",
            s.mean / ARCMIN,
            s.mean_abs / ARCMIN,
            s.max_abs / ARCMIN,
            s.peak_to_peak / ARCMIN,
            s.rms / ARCMIN,
            s.lowest / ARCMIN,
            s.highest / ARCMIN
        );
    }
    println!(
        "wall {wall:.3} s  {:?}  energy {:?} res {:.2e} ratio-81 {:.2e}",
        r.counts,
        r.energy,
        r.energy.residual(),
        r.mean_ratio.unwrap_or(0.0) - 81.0
    );
    println!("ns/eval {:.0}", wall * 1e9 / r.counts.evaluations as f64);
}
