#[path = "../tests/support/mod.rs"]
#[allow(dead_code)]
mod support;
use arcmin::contact::*;
use arcmin::geometry::Relief;
fn main() {
    for (name, design) in [
        ("tao", arcmin::templates::design("tao2024").unwrap()),
        ("5003", support::sound_design(5003).0),
        ("5000", support::sound_design(5000).0),
        ("rv40", arcmin::templates::design("rv-40e").unwrap()),
    ] {
        let machine = design.machine();
        for relief in [0.0, -4e-6] {
            let mut ring = PinContacts::new(
                machine.profile(),
                machine.pins(),
                machine.designed_relief().plus(&Relief::uniform(relief)),
                machine.line_contact(),
            );
            for conservative in [false, true] {
                ring.set_conservative(conservative);
                let e = machine.kinematics().eccentricity;
                let q = [e + 1.1e-6, 0.7e-6, -4e-4];
                let pose =
                    |q: [f64; 3]| DiscPose { centre: arcmin::geometry::Vec2::new(q[0], q[1]), angle: q[2] };
                let at = |q: [f64; 3]| ring.react(pose(q), DiscVelocity::REST);
                let here = at(q);
                let h = [1e-9, 1e-9, 3e-8];
                println!("{name} {relief:e} conservative {conservative} force {:?}", here.force);
                for j in 0..3 {
                    let (mut u, mut d) = (q, q);
                    u[j] += h[j];
                    d[j] -= h[j];
                    let (u, d) = (at(u), at(d));
                    for i in 0..3 {
                        let k = (d.force[i] - u.force[i]) / (2.0 * h[j]);
                        let size = (here.stiffness[i][i] * here.stiffness[j][j]).sqrt();
                        print!(" {:.1e}", (here.stiffness[i][j] - k) / size);
                    }
                    let f = (d.stored - u.stored) / (2.0 * h[j]);
                    println!("   energy {:.2e}", (f - here.force[j]) / here.force[0].hypot(here.force[1]));
                }
            }
        }
    }
}
