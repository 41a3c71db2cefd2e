//! The drawings of every family.

use std::f64::consts::{PI, TAU};

use super::{Dimension, Shape, Stroke, View, sheet};
use crate::design::{Design, StageDesign, TwoRingDesign, TwoStageDesign, Value};
use crate::geometry::{Profile, Vec2, unit};
use crate::machine::{Bore, OutputPins, PinBeam, RingProfile, RollerBearing, SingleStage};
use crate::units::MM;

/// Largest number of characters of a section with a note in a column of labels.
const LONGEST: usize = 38;
/// Number of corners of a flank's outline per lobe.
const CORNERS_PER_LOBE: usize = 60;

/// A design that can be drawn with its keys as dimensions.
pub trait DimensionedDesign {
    /// Drawing in SVG: views along the axis and perpendicular to it; every dimension line has the path of its
    /// key and its value.
    fn dimension_drawing(&self) -> String;
}

/// Values of keys as in the file.
struct Keys<'a> {
    /// Prefix of all keys: the section of a stage.
    prefix: &'static str,
    of: &'a dyn Fn(&str) -> Option<Value>,
}

impl Keys<'_> {
    /// A dimension between two points; `size` (m) is the value if the file does not contain the key.
    fn dimension(&self, key: &str, ends: [Vec2; 2], size: Option<f64>, note: &str) -> Dimension {
        let path = format!("{}{key}", self.prefix);
        let value = match ((self.of)(&path), size) {
            (Some(Value::LeftOut) | None, Some(size)) => format!("left out: {}", rounded(size / MM)),
            (Some(Value::LeftOut) | None, None) => "left out".to_owned(),
            (Some(Value::Text(word)), _) => format!("= {word}"),
            (Some(value), _) => format!("= {value}"),
        };
        // Only if there is space after the section.
        let section = path.rsplit_once('.').map_or(0, |(section, _)| section.len());
        let is_told = !note.is_empty() && section + note.len() < LONGEST;
        let note = if is_told { format!(" ({note})") } else { String::new() };
        Dimension { key: path, value, note, ends, is_left: ends[1].x < 0.0 }
    }

    /// A dimension at a point.
    fn at(&self, key: &str, place: Vec2, note: &str) -> Dimension {
        self.dimension(key, [place; 2], None, note)
    }
}

/// Up to four decimals.
fn rounded(value: f64) -> String {
    let text = format!("{value:.4}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

fn outline(profile: &Profile, centre: Vec2) -> Shape {
    let (lobes, places) = (profile.lobe_count(), profile.around_lobe(CORNERS_PER_LOBE));
    let corner = |lobe: usize, tau: f64| centre + profile.flank_point(TAU * lobe as f64 / lobes as f64 + tau);
    let corners = (0..lobes).flat_map(|lobe| places.iter().map(move |tau| corner(lobe, *tau)));
    Shape::Polygon(corners.collect(), Stroke::Disc)
}

fn rectangle(low: Vec2, high: Vec2, stroke: Stroke) -> Shape {
    Shape::Polygon(vec![low, Vec2::new(high.x, low.y), high, Vec2::new(low.x, high.y)], stroke)
}

/// Angle of the one of `count` positions on a circle that is nearest to an angle in degrees.
fn nearest(count: usize, degrees: f64) -> f64 {
    let step = TAU / count as f64;
    (degrees.to_radians() / step).round() * step
}

/// A disc in its ring, viewed along the axis, with its eccentric to the right.
struct Front<'a> {
    keys: Keys<'a>,
    /// Section of the ring, of the disc and of the eccentricity.
    sections: [&'static str; 3],
    title: String,
    profile: &'a Profile,
    /// Circle and radius of the ring pins, m.
    ring: [f64; 2],
    /// Contour of a ring of one piece, instead of pins.
    contour: Option<RingProfile>,
    openings: &'a [Bore],
    eccentric: Option<&'a RollerBearing>,
    output: Option<(&'a OutputPins, &'a PinBeam)>,
}

impl Front<'_> {
    fn view(self) -> View {
        let Front { keys, sections: [ring, disc, eccentric], profile, ring: [circle, pin], .. } = self;
        let (pins, e) = (profile.pin_count, profile.eccentricity);
        let outside = self.contour.as_ref().map_or(circle + pin, |ring| ring.outer_radius);
        let reach = 1.04 * outside;
        let (origin, centre) = (Vec2::zeros(), Vec2::new(e, 0.0));
        let mut shapes = vec![outline(profile, centre), Shape::Circle(origin, circle, Stroke::Axis)];
        let place = |k: usize| circle * unit(TAU * k as f64 / pins as f64);
        match &self.contour {
            Some(ring) => {
                let points = ring.opening.sample(0.1 * pin).into_iter().map(|t| ring.opening.point(t));
                shapes.push(Shape::Polygon(points.collect(), Stroke::Pin));
                shapes.push(Shape::Circle(origin, outside, Stroke::Pin));
            }
            None => shapes.extend((0..pins).map(|k| Shape::Circle(place(k), pin, Stroke::Pin))),
        }
        let round = |bore: &Bore| {
            Shape::Circle(centre + bore.centre_radius * unit(bore.centre_angle), bore.radius, Stroke::Opening)
        };
        shapes.extend(self.openings.iter().map(round));
        shapes.extend([Shape::Cross(origin, 0.12 * circle), Shape::Cross(centre, 0.06 * circle)]);
        let key = |section: &str, name: &str| format!("{section}.{name}");
        let [upper, side, lower] = [55.0, 20.0, -14.0].map(|degrees| circle * unit(nearest(pins, degrees)));
        let flank = |degrees: f64| centre + profile.flank_point(f64::to_radians(degrees));
        let mut dimensions = vec![
            keys.dimension(&key(ring, "pin_circle_radius_mm"), [origin, upper], None, ""),
            keys.dimension(&key(ring, "pin_radius_mm"), [side, side + pin * unit(0.0)], None, ""),
            keys.at(&key(ring, "pin_count"), lower, ""),
            keys.at(&key(disc, "lobe_count"), flank(-40.0), &format!("{} lobes", profile.lobe_count())),
            keys.at(&key(disc, "modification.equidistant_offset_um"), flank(-58.0), "gap of the flank"),
            keys.at(&key(disc, "modification.radial_offset_um"), flank(-75.0), "circle of the cut"),
        ];
        if profile.tooth_difference > 1 {
            let note = format!("tooth difference {}", profile.tooth_difference);
            dimensions.push(keys.at(&key(ring, "tooth_difference"), lower, &note));
        }
        if let Some(tip) = profile.tip() {
            let out =
                tip.radius * unit(nearest(profile.lobe_count(), -25.0) + PI / profile.lobe_count() as f64);
            let ends = [centre - out, centre + out];
            dimensions.push(keys.dimension(&key(disc, "tip_diameter_mm"), ends, Some(2.0 * tip.radius), ""));
        }
        let shift = keys.dimension(&key(eccentric, "eccentricity_mm"), [origin, centre], None, "");
        dimensions.push(Dimension { is_left: true, ..shift });
        if let (Some(bearing), Some(bore)) = (self.eccentric, self.openings.first()) {
            let across = |radius: f64, degrees: f64| {
                let arm = radius * unit(f64::to_radians(degrees));
                [centre - arm, centre + arm]
            };
            let [low, high] =
                [0.5, -0.5].map(|sign| 0.5 * bearing.pitch_diameter - sign * bearing.roller_diameter);
            shapes.push(Shape::Circle(centre, 0.5 * bearing.pitch_diameter, Stroke::Axis));
            shapes.extend([low, high].map(|radius| Shape::Circle(centre, radius, Stroke::Pin)));
            let bore_ends = across(bore.radius, 248.0);
            dimensions.push(keys.dimension(
                "disc.crank_bore_diameter_mm",
                bore_ends,
                Some(2.0 * bore.radius),
                "",
            ));
            let pitch = across(0.5 * bearing.pitch_diameter, 215.0);
            dimensions.push(keys.dimension("bearings.eccentric.pitch_diameter_mm", pitch, None, ""));
        }
        if let Some((pins, beam)) = self.output {
            let angle = |degrees: f64| nearest(pins.count, degrees);
            shapes.push(Shape::Circle(origin, pins.circle_radius, Stroke::Axis));
            for k in 0..pins.count {
                let place = pins.circle_radius * unit(TAU * k as f64 / pins.count as f64);
                shapes.push(Shape::Circle(place, pins.radius, Stroke::Pin));
                if beam.radius < pins.radius {
                    shapes.push(Shape::Circle(place, beam.radius, Stroke::Pin));
                }
            }
            let pin = |degrees: f64| pins.circle_radius * unit(angle(degrees));
            let (top, left) = (pin(120.0), pin(180.0));
            let hole = pins.hole_radius(e);
            dimensions.extend([
                keys.dimension("output_pins.circle_radius_mm", [origin, top], None, ""),
                keys.dimension(
                    "output_pins.roller_radius_mm",
                    [left, left + pins.radius * unit(2.4)],
                    None,
                    "",
                ),
                keys.dimension("output_pins.pin_radius_mm", [left, left + beam.radius * unit(3.4)], None, ""),
                keys.at("output_pins.count", pin(150.0) - Vec2::new(0.5 * pins.radius, 0.0), ""),
            ]);
            let hole_centre = centre + pins.circle_radius * unit(angle(240.0));
            dimensions.push(keys.at(
                "output_pins.hole_clearance_um",
                hole_centre + hole * unit(f64::to_radians(200.0)),
                &format!("hole radius {} mm", rounded(hole / MM)),
            ));
        }
        View { title: self.title, half: [reach; 2], shapes, dimensions }
    }
}

/// Discs side by side, viewed perpendicular to the axis.
struct Across<'a> {
    keys: Keys<'a>,
    title: String,
    /// Position of the middle along the axis, width, shift and half height of every disc, m.
    discs: Vec<[f64; 4]>,
    /// Keys of widths with the indices of their discs.
    widths: Vec<(String, usize)>,
    /// Circle, radius and length of an output pin on both sides, and the plates that hold it, m.
    pins: Option<([f64; 3], Vec<[f64; 2]>)>,
    dimensions: Vec<Dimension>,
}

impl Across<'_> {
    fn view(self) -> View {
        let Across { keys, title, discs, widths, pins, mut dimensions } = self;
        let ends = discs.iter().map(|[middle, width, ..]| middle.abs() + 0.5 * width).fold(0.0, f64::max);
        let height = discs.iter().map(|[_, _, shift, half]| shift.abs() + half).fold(0.0, f64::max);
        let mut shapes = Vec::new();
        let mut reach = ends;
        for [middle, width, shift, half] in &discs {
            let low = Vec2::new(middle - 0.5 * width, shift - half);
            shapes.push(rectangle(low, low + Vec2::new(*width, 2.0 * half), Stroke::Disc));
        }
        if let Some(([circle, radius, low], plates)) = &pins {
            let high = plates.iter().map(|[_, high]| *high).fold(ends, f64::max);
            for side in [-1.0, 1.0] {
                let [bottom, top] = [side * circle - radius, side * circle + radius];
                shapes.push(rectangle(Vec2::new(*low, bottom), Vec2::new(high, top), Stroke::Pin));
            }
            for [low, high] in plates {
                let half = circle + 2.0 * radius;
                shapes.push(rectangle(Vec2::new(*low, -half), Vec2::new(*high, half), Stroke::Pin));
            }
            reach = plates.iter().flatten().map(|end| end.abs()).fold(reach, f64::max);
        }
        let reach = 1.1 * reach;
        shapes.push(Shape::Polygon(vec![Vec2::new(-reach, 0.0), Vec2::new(reach, 0.0)], Stroke::Axis));
        for (key, disc) in widths {
            let [middle, width, shift, half] = discs[disc];
            let level = shift - half - 0.06 * height;
            let [low, high] = [-0.5, 0.5].map(|side| Vec2::new(middle + side * width, level));
            dimensions.push(keys.dimension(
                &key,
                if middle > 0.0 { [low, high] } else { [high, low] },
                None,
                "",
            ));
        }
        let half = [reach.max(1.4 * height), 1.12 * height];
        View { title, half, shapes, dimensions }
    }
}

/// Both views of a single stage; `[ring, disc, eccentric]` are its sections.
fn stage_views<'a>(stage: &'a SingleStage, keys: impl Fn() -> Keys<'a>, name: &str) -> [View; 2] {
    let width = stage.mesh.contact.width;
    let discs = stage.phases.len();
    let front = Front {
        keys: keys(),
        sections: ["ring", "disc", "eccentric"],
        title: titled(name, "along the axis"),
        profile: &stage.mesh.profile,
        ring: [stage.mesh.ring_circle_radius, stage.mesh.ring_pin_radius],
        contour: stage.mesh.ring_profile(),
        openings: &stage.openings,
        eccentric: Some(&stage.eccentric),
        output: Some((&stage.output_pins, &stage.pin_beam)),
    };
    let beam = &stage.pin_beam;
    // The plate that holds the pins is on the left.
    let begin = -0.5 * discs as f64 * width + 0.5 * width - beam.places[0];
    let thickness = 0.6 * width;
    let mut plates = vec![[begin - thickness, begin]];
    plates.extend(beam.span.map(|span| [begin + span, begin + span + thickness]));
    let profile = &stage.mesh.profile;
    let tip = profile.root_radius() + 2.0 * profile.eccentricity;
    let disc = |j: usize| [begin + beam.places[j], width, profile.eccentricity * stage.phases[j].cos(), tip];
    let circle = stage.output_pins.circle_radius;
    let level = circle + 2.6 * beam.radius;
    let first = [Vec2::new(begin + beam.places[0], level), Vec2::new(begin, level)];
    let keys_across = keys();
    let dimensions = vec![
        keys_across.dimension("output_pins.plate_distance_mm", first, Some(beam.places[0]), ""),
        keys_across.at("output_pins.support", Vec2::new(begin - 0.5 * thickness, -circle), ""),
        keys_across.at("disc.count", Vec2::new(begin + beam.places[discs - 1], 0.7 * tip).abs_x(), ""),
    ];
    let across = Across {
        keys: keys_across,
        title: titled(name, "across the axis"),
        discs: (0..discs).map(disc).collect(),
        widths: vec![("disc.width_mm".to_owned(), discs - 1)],
        pins: Some(([circle, beam.radius, begin - thickness], plates)),
        dimensions,
    };
    [front.view(), across.view()]
}

/// Stage and view, capitalised.
fn titled(stage: &str, view: &str) -> String {
    match stage {
        "" => view.replacen('a', "A", 1),
        stage => format!("{stage}, {view}"),
    }
}

/// A point on the right half.
trait OnTheRight {
    fn abs_x(self) -> Vec2;
}

impl OnTheRight for Vec2 {
    fn abs_x(self) -> Vec2 {
        Vec2::new(self.x.abs().max(1e-9), self.y)
    }
}

fn stamp(hash: &str) -> String {
    format!("arcmin {}, design {}", env!("CARGO_PKG_VERSION"), &hash[..12])
}

impl DimensionedDesign for StageDesign {
    fn dimension_drawing(&self) -> String {
        let of = |key: &str| self.get(key).ok();
        let views = stage_views(self.drive(), || Keys { prefix: "", of: &of }, "");
        sheet(&self.name, &stamp(&self.hash()), &views)
    }
}

impl DimensionedDesign for TwoStageDesign {
    fn dimension_drawing(&self) -> String {
        let of = |key: &str| self.get(key).ok();
        let drive = self.drive();
        let first =
            stage_views(&drive.first, || Keys { prefix: "first_stage.", of: &of }, "Stage at the input");
        let second = stage_views(&drive.second, || Keys { prefix: "", of: &of }, "Stage at the output");
        sheet(&self.name, &stamp(&self.hash()), &[first, second].concat())
    }
}

impl DimensionedDesign for TwoRingDesign {
    fn dimension_drawing(&self) -> String {
        let of = |key: &str| self.get(key).ok();
        let (drive, keys) = (self.drive(), || Keys { prefix: "", of: &of });
        let front = |k: usize| {
            let (ring, disc, title) = [
                ("ring", "disc", "Ring at rest, along the axis"),
                ("second_ring", "second_disc", "Ring of the output, along the axis"),
            ][k];
            let mesh = &drive.meshes[k];
            Front {
                keys: keys(),
                sections: [ring, disc, "eccentric"],
                title: title.to_owned(),
                profile: &mesh.profile,
                ring: [mesh.ring_circle_radius, mesh.ring_pin_radius],
                contour: mesh.ring_profile(),
                openings: &drive.openings,
                eccentric: (k == 0).then_some(&drive.eccentric),
                output: None,
            }
            .view()
        };
        let tips =
            drive.meshes.each_ref().map(|mesh| mesh.profile.root_radius() + 2.0 * mesh.profile.eccentricity);
        let [first, second] = drive.widths;
        let e = drive.meshes[0].profile.eccentricity;
        let across = Across {
            keys: keys(),
            title: "One stepped disc across the axis".to_owned(),
            discs: vec![[-0.5 * second, first, e, tips[0]], [0.5 * first, second, e, tips[1]]],
            widths: vec![("disc.width_mm".to_owned(), 0), ("second_disc.width_mm".to_owned(), 1)],
            pins: None,
            dimensions: vec![keys().at("disc.count", Vec2::new(0.5 * first, 0.5 * tips[1]), "")],
        };
        sheet(&self.name, &stamp(&self.hash()), &[front(0), front(1), across.view()])
    }
}

impl DimensionedDesign for Design {
    fn dimension_drawing(&self) -> String {
        let of = |key: &str| self.get(key).ok();
        let keys = || Keys { prefix: "", of: &of };
        let machine = self.machine();
        let (profile, disc, cranks) = (machine.profile(), &machine.disc, &machine.crankshafts);
        let circle = machine.gear_stage.centre_distance();
        let bore = |k: usize| Bore {
            radius: disc.crank_bore_radius,
            centre_radius: circle,
            centre_angle: crate::machine::Kinematics::crankshaft_angle(cranks.first_angle, k, cranks.count),
        };
        let openings: Vec<Bore> = (0..cranks.count).map(bore).chain(disc.holes.iter().copied()).collect();
        let ring = [machine.ring.pin_circle_radius, machine.ring.pin_radius];
        let mut front = Front {
            keys: keys(),
            sections: ["ring", "disc", "crankshafts"],
            title: "Along the axis".to_owned(),
            profile: &profile,
            ring,
            contour: None,
            openings: &openings,
            eccentric: None,
            output: None,
        }
        .view();
        let centre = Vec2::new(profile.eccentricity, 0.0);
        let crank = |k: usize| centre + circle * unit(openings[k].centre_angle);
        let left = (0..cranks.count).min_by(|a, b| crank(*a).x.total_cmp(&crank(*b).x)).unwrap_or(0);
        let arm = disc.crank_bore_radius * unit(0.8 * std::f64::consts::PI);
        let hang = |dimension: Dimension| Dimension { is_left: true, ..dimension };
        front.shapes.push(Shape::Circle(centre, circle, Stroke::Axis));
        front.dimensions.extend([
            hang(keys().dimension("crankshafts.circle_radius_mm", [centre, crank(left)], Some(circle), "")),
            hang(keys().dimension(
                "disc.crank_bore_diameter_mm",
                [crank(left) - arm, crank(left) + arm],
                Some(2.0 * disc.crank_bore_radius),
                "",
            )),
            hang(keys().at("crankshafts.count", crank(left) - 0.5 * arm, "")),
        ]);
        if disc.centre_hole_radius > 0.0 {
            let arm = disc.centre_hole_radius * unit(f64::to_radians(250.0));
            front.shapes.push(Shape::Circle(centre, disc.centre_hole_radius, Stroke::Opening));
            front.dimensions.push(hang(keys().dimension(
                "disc.centre_hole_diameter_mm",
                [centre - arm, centre + arm],
                None,
                "",
            )));
        }
        for window in &disc.windows {
            let outline = window.outline();
            let corners = (0..240).map(|k| centre + outline.point(k as f64 / 240.0)).collect();
            front.shapes.push(Shape::Polygon(corners, Stroke::Opening));
        }
        let count = machine.disc_count;
        let tip = profile.root_radius() + 2.0 * profile.eccentricity;
        let along = |j: usize| {
            let middle = (j as f64 - 0.5 * (count as f64 - 1.0)) * disc.width;
            let turn = TAU * j as f64 / count as f64;
            [middle, disc.width, profile.eccentricity * turn.cos(), tip]
        };
        let last = (count as f64 - 1.0) * 0.5 * disc.width;
        let across = Across {
            keys: keys(),
            title: "Discs across the axis".to_owned(),
            discs: (0..count).map(along).collect(),
            widths: vec![("disc.width_mm".to_owned(), count - 1)],
            pins: None,
            dimensions: vec![keys().at("disc.count", Vec2::new(last, 0.5 * tip).abs_x(), "")],
        };
        sheet(&self.name, &stamp(&self.hash()), &[front, across.view()])
    }
}
