//! Lost motion stacked by cause over the hours.

use super::{Axis, Block, Colour, Plot, Series};

/// Negative values up to this size, in arcmin, are still stacked.
const NEGLIGIBLE: f64 = 0.02;

/// Lost motion per cause: (cause, points of (h, arcmin)), all at the same hours.
pub fn lost_motion_causes(causes: &[(String, Vec<(f64, f64)>)]) -> Block {
    let mut plot = Plot::new(
        "Lost motion by cause",
        Axis::new("Running time", "h"),
        Axis::new("Lost motion", "arcmin").from_zero(),
    );
    // Negative causes (manufacturing errors that close gaps) cannot be stacked.
    if causes.iter().flat_map(|(_, points)| points).any(|(_, value)| *value < -NEGLIGIBLE) {
        for (index, (cause, points)) in causes.iter().enumerate() {
            plot.series.push(
                Series::line(cause.clone(), points.iter().copied())
                    .coloured(Colour::Palette((index % 7) as u8)),
            );
        }
        let hours = causes.first().map_or(&[][..], |(_, points)| points).iter().map(|(hours, _)| *hours);
        let sum =
            |at: usize| causes.iter().filter_map(|(_, points)| points.get(at)).map(|(_, value)| value).sum();
        plot.series.push(
            Series::line("sum", hours.enumerate().map(|(at, hours)| (hours, sum(at))))
                .coloured(Colour::Reference)
                .strong(),
        );
        plot.note = "Lost motion at the output in arcmin by cause, over the running time in h. Negative contributions close gaps. If manufacturing errors cause forces without load, their contribution and the elastic one are many times the sum and nearly cancel; both are shown as one.".into();
        return Block::Plot(plot);
    }
    // Every band begins at the top of the previous one.
    let mut below: Vec<(f64, f64)> = Vec::new();
    for (index, (cause, points)) in causes.iter().enumerate() {
        let band: Vec<(f64, f64, f64)> = points
            .iter()
            .enumerate()
            .map(|(at, (hours, value))| {
                let low = below.get(at).map_or(0.0, |base| base.1);
                (*hours, low, low + value)
            })
            .collect();
        below = band.iter().map(|(hours, _, high)| (*hours, *high)).collect();
        plot.series.push(Series::band(cause.clone(), band).coloured(Colour::Palette((index % 7) as u8)));
    }
    plot.series.push(Series::line("sum", below).coloured(Colour::Reference).strong());
    plot.note =
        "Lost motion at the output in arcmin over the running time in h; the contributions of the causes are stacked."
            .into();
    Block::Plot(plot)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bands_of_lost_motion_add_up() {
        let causes = vec![
            ("teeth".to_owned(), vec![(0.0, 0.1), (10.0, 0.4)]),
            ("bearings".to_owned(), vec![(0.0, 0.3), (10.0, 0.3)]),
        ];
        let Block::Plot(plot) = lost_motion_causes(&causes) else { panic!("a plot") };
        assert_eq!(plot.series[1].points.low, vec![Some(0.1), Some(0.4)]);
        assert!((plot.series[2].points.y[1].unwrap_or(0.0) - 0.7).abs() < 1e-12);
    }

    #[test]
    fn causes_that_take_away_are_lines_with_their_sum() {
        let causes = vec![
            ("elastic".to_owned(), vec![(0.0, 0.9), (10.0, 0.8)]),
            ("errors".to_owned(), vec![(0.0, -0.5), (10.0, -0.2)]),
        ];
        let Block::Plot(plot) = lost_motion_causes(&causes) else { panic!("a plot") };
        assert!(plot.series.iter().all(|series| series.points.low.is_empty()));
        assert!((plot.series[2].points.y[1].unwrap_or(0.0) - 0.6).abs() < 1e-12);
    }
}
