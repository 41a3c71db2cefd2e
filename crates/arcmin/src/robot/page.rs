//! Terminal and report of a robot.

use super::figures::{Figure, Figures};
use super::run::{Robot, ToolAnswer};
use super::tool::CAUSES;
use crate::analyses::{Outcome, TextBlock};
use crate::report::{
    Axis, Block, Colour, Column, HeatMap, KeyFigure, Page, Plot, Provenance, Section, Series, Shares, Style,
    Table, Tone, Verdict, Width, capitalised, compact, significant,
};
use crate::results::{Summary, Table as Filled};
use crate::units::{ARCMIN, DEG, MM};

impl Outcome for Robot {
    fn summary(&self) -> Summary {
        super::declared::SUMMARY.fill(self)
    }

    fn tables(&self) -> Vec<Filled> {
        Robot::tables(self).to_vec()
    }

    fn text_blocks(&self) -> Vec<TextBlock> {
        text_blocks(self)
    }

    fn page(&self) -> Page {
        page(self)
    }

    fn seeds(&self) -> Vec<u64> {
        self.seeds.clone()
    }

    fn attachments(&self) -> Result<Vec<crate::analyses::Attachment>, crate::analyses::AnalysisError> {
        Robot::attachments(self)
    }

    fn as_any(&self) -> &dyn std::any::Any {
        self
    }
}

fn value(figure: Figure, size: f64) -> String {
    match figure {
        Figure::Orientation => format!("{}°", significant(size / DEG, 3)),
        _ => format!("{} mm", significant(size / MM, 3)),
    }
}

impl Robot {
    /// The main result in one sentence.
    pub fn headline(&self) -> String {
        let Some(last) = self.last() else {
            return "Loads of all joints, without lives.".to_owned();
        };
        match self.end {
            Some(end) => format!(
                "The tool exceeds its {} limit of {} after {:.0} h of {:.0} h planned; the largest contribution is {} of {}.",
                end.limit.figure.word(),
                value(end.limit.figure, end.limit.allowed),
                end.hours,
                self.planned,
                CAUSES[end.cause],
                self.joints[end.axis].axis
            ),
            None if self.limits.is_empty() => format!(
                "After {:.0} h the tool is up to {} off, repeatability {}; no limits are given.",
                self.planned,
                value(Figure::Position, last.position),
                value(Figure::Repeatability, last.repeatability)
            ),
            None => format!(
                "The tool keeps its limits over {:.0} h: {} off at most, repeatability {}.",
                self.planned,
                value(Figure::Position, last.position),
                value(Figure::Repeatability, last.repeatability)
            ),
        }
    }

    fn tone(&self) -> Tone {
        match (self.end, self.limits.is_empty()) {
            (Some(_), _) => Tone::Bad,
            (None, true) => Tone::Neutral,
            (None, false) => Tone::Good,
        }
    }

    /// The plan in one sentence.
    pub fn plan_sentence(&self) -> Option<String> {
        let tool = self.tool.as_ref()?;
        if self.limits.is_empty() {
            return None;
        }
        Some(match &tool.plan {
            None => {
                "No plan of overhauls keeps the limits: new reducers leave them as well, or soon.".to_owned()
            }
            Some((plan, _)) if plan.is_empty() => {
                format!("No overhaul is needed in {:.0} h.", self.planned)
            }
            Some((plan, fewest)) => {
                let steps: Vec<String> = plan
                    .iter()
                    .map(|one| format!("{} at {:.0} h", self.joints[one.axis].axis, one.hours))
                    .collect();
                let word = if plan.len() == 1 { "overhaul keeps" } else { "overhauls keep" };
                let sure = if *fewest { "" } else { " (fewer may exist)" };
                format!(
                    "{} {word} the limits over {:.0} h{sure}: {}.",
                    plan.len(),
                    self.planned,
                    steps.join(", ")
                )
            }
        })
    }
}

fn text_blocks(robot: &Robot) -> Vec<TextBlock> {
    let mark = match robot.tone() {
        Tone::Bad => "✕",
        Tone::Good => "✓",
        _ => "·",
    };
    let mut blocks =
        vec![TextBlock::line(robot.name.clone()), TextBlock::line(format!("{mark} {}", robot.headline()))];
    blocks.extend(robot.plan_sentence().map(TextBlock::line));
    blocks.push(TextBlock::line(""));
    let find = |name: &str| robot.table(name);
    if let Some(table) = find("tool") {
        let keys =
            ["hours", "position_error_mm", "repeatability_mm", "path_error_mm", "orientation_error_deg"];
        blocks.push(TextBlock::columns(table, &keys, 0..table.rows()));
    }
    if let Some(table) = find("joints") {
        let count = robot.joints.len();
        blocks.push(TextBlock::line(format!("joints after {:.0} h:", robot.planned)));
        let keys =
            ["joint", "torque_rms_n_m", "lost_motion_arcmin", "share_at_tool_mm", "repeatability_alone_mm"];
        blocks.push(TextBlock::columns(table, &keys, table.rows() - count..table.rows()));
    }
    if let Some(table) = find("loads") {
        let keys = [
            "joint",
            "design",
            "torque_rms_n_m",
            "torque_peak_n_m",
            "rated_torque_n_m",
            "moving_share",
            "motor_torque_peak_n_m",
        ];
        blocks.push(TextBlock::columns(table, &keys, 0..table.rows()));
    }
    if let Some(table) = find("variants") {
        let keys = ["variant", "position_error_mm", "repeatability_mm", "hours_to_limit", "limited_by"];
        blocks.push(TextBlock::columns(table, &keys, 0..table.rows()));
    }
    if let Some((axis, bearing, hours)) = robot.shortest_bearing() {
        blocks
            .push(TextBlock::line(format!("shortest bearing life: {hours:.0} h, {bearing} of {axis} (L10)")));
    }
    blocks.extend(robot.notes.iter().map(|note| TextBlock::line(format!("note: {note}"))));
    blocks
}

fn page(robot: &Robot) -> Page {
    let mut sections = Vec::new();
    if let Some(tool) = &robot.tool {
        sections.push(Section::new("tool", "Tool over the hours", over_hours(robot, tool)));
        sections.push(Section::new("shares", "Which joint, which cause", shares(robot, tool)));
        sections.push(Section::new("overhaul", "Overhauls", overhaul(robot, tool)));
        sections.push(Section::new(
            "arm",
            "Arm, path and reach",
            super::picture::blocks(robot, tool, reach_map(robot, tool)),
        ));
        sections.push(Section::new("compensation", "Compensation by the controller", remains(robot)));
    }
    sections.push(Section::new("loads", "Loads of the joints", loads(robot)));
    sections.push(Section::new("limits", "Limits of the model", vec![Block::Text(LEFT_OUT.to_owned())]));
    let code = Block::Code { title: "Robot file".to_owned(), text: robot.text.clone() };
    sections.push(Section::new("file", "Robot file", vec![code]));
    Page {
        title: robot.name.clone(),
        subtitle: format!("Tool error over {} h", compact(robot.planned, 5)),
        provenance: Provenance::default(),
        verdict: verdict(robot),
        sections,
    }
}

/// Note in every report.
const LEFT_OUT: &str = "Links are rigid, motors have no position error, and the arm is calibrated: the errors \
    shown are those of reducers and their bearings. Backlash of couplings, encoders, heat, overshoot and the foundation \
    are left out. Between two stops nothing else moves the joints, so that a pose that is reached in the same way \
    twice is the same place; repeatability is therefore that of approaches from all sides.";

fn verdict(robot: &Robot) -> Verdict {
    let mut verdict = Verdict::new(robot.tone(), robot.headline());
    if let (Some(first), Some(last)) = (robot.first(), robot.last()) {
        let tile = |label: &str, figure: Figure, of: fn(&Figures) -> f64| {
            let limit = robot.limits.iter().find(|limit| limit.figure == figure);
            let new = significant(of(&first) / MM, 3);
            let note = match limit {
                Some(limit) => format!("new {new} mm, allowed {} mm", compact(limit.allowed / MM, 4)),
                None => format!("new {new} mm"),
            };
            KeyFigure::new(label, significant(of(&last) / MM, 3), "mm", note)
                .kept(limit.is_none_or(|limit| of(&last) <= limit.allowed))
        };
        verdict.figures = vec![
            match robot.end {
                Some(end) => KeyFigure::new(
                    "Within limits",
                    format!("{:.0}", end.hours),
                    "h",
                    format!("{:.0} h planned", robot.planned),
                )
                .kept(false),
                None => KeyFigure::new("Within limits", format!("> {:.0}", robot.planned), "h", "planned"),
            },
            tile("Pose accuracy", Figure::Position, |f| f.position),
            tile("Repeatability from all sides", Figure::Repeatability, |f| f.repeatability),
            tile("Path accuracy", Figure::Path, |f| f.path),
        ];
    }
    if let Some(end) = robot.end {
        verdict.answers.push((
            "Which joint ends it".to_owned(),
            format!("{}, by its {}.", robot.joints[end.axis].axis, CAUSES[end.cause]),
        ));
    }
    verdict.answers.extend(robot.plan_sentence().map(|plan| ("Plan of overhauls".to_owned(), plan)));
    if let Some(tool) = &robot.tool {
        let best = tool.levers.iter().enumerate().max_by(|a, b| a.1.position.total_cmp(&b.1.position));
        if let Some((axis, lever)) = best {
            verdict.answers.push((
                "Joint for a tighter specification".to_owned(),
                format!(
                    "{}: each arc-minute less is {} mm at the pose that is off most.",
                    robot.joints[axis].axis,
                    significant(lever.position * ARCMIN / MM, 3)
                ),
            ));
        }
    }
    if let Some((axis, bearing, hours)) = robot.shortest_bearing() {
        verdict.answers.push((
            "Which bearing lasts shortest".to_owned(),
            format!("{bearing} of {axis}: L10 {} h of the robot.", significant(hours, 3)),
        ));
    }
    verdict
        .answers
        .push(("Compensated by the controller".to_owned(), format!("{}.", capitalised(compensates(robot)))));
    verdict.summary = format!("{}: {}\n", robot.name, verdict.headline);
    for (question, answer) in &verdict.answers {
        verdict.summary.push_str(&format!("- {question}: {answer}\n"));
    }
    verdict
}

fn compensates(robot: &Robot) -> &'static str {
    use crate::design::Choice;
    let words = super::file::Compensation::WORDS;
    let word = robot.compensates.word();
    words.iter().find(|(known, _)| *known == word).map_or("", |(_, meaning)| meaning)
}

fn over_hours(robot: &Robot, tool: &ToolAnswer) -> Vec<Block> {
    let mut plot = Plot::new(
        "Tool over the hours",
        Axis::new("hours of the robot", "h"),
        Axis::new("error", "mm").from_zero(),
    );
    let lines: [(&str, Figure, fn(&Figures) -> f64); 3] = [
        ("pose accuracy", Figure::Position, |f| f.position),
        ("repeatability", Figure::Repeatability, |f| f.repeatability),
        ("path accuracy", Figure::Path, |f| f.path),
    ];
    for (index, (name, figure, of)) in lines.into_iter().enumerate() {
        let points = tool.figures.iter().map(|(hours, f)| (*hours, of(f) / MM));
        plot.series
            .push(Series::new(name, Style::LineMarkers, points).coloured(Colour::Palette(index as u8)));
        if let Some(limit) = robot.limits.iter().find(|limit| limit.figure == figure) {
            plot.limit_at(limit.allowed / MM, format!("limit of {name}"));
        }
        if let Some(population) = &tool.population {
            let hours = [0.0, robot.planned];
            let band = (0..2).map(|age| {
                (hours[age], population.quantile(age, 0.05, of) / MM, population.quantile(age, 0.95, of) / MM)
            });
            plot.series.push(
                Series::band(format!("{name}, 90 % of drawn robots"), band)
                    .coloured(Colour::Palette(index as u8)),
            );
        }
    }
    let note = "Error of the tool in mm with all reducers of the same age. Pose accuracy: largest error of a test pose as the \
                program reaches it. Repeatability: the same poses approached from thirty sides. Path accuracy: largest \
                distance from the commanded path.";
    vec![
        Block::Plot(plot.noted(note)),
        shown(&robot.tool_table(tool), "Figures by ISO 9283", 0..tool.figures.len()),
    ]
}

/// A filled table as a table of the report.
fn shown(table: &Filled, title: &str, rows: std::ops::Range<usize>) -> Block {
    let columns = table
        .columns
        .iter()
        .map(|column| match column.cells {
            crate::results::Cells::Words(_) => Column::text(capitalised(&column.quantity.label())),
            _ => Column::number(capitalised(&column.quantity.label()), column.quantity.unit()),
        })
        .collect();
    let row = |row: usize| table.columns.iter().map(|c| c.quantity.show(&c.cells.value(row))).collect();
    Block::Table(Table {
        title: title.to_owned(),
        columns,
        rows: rows.map(row).collect(),
        note: format!("Every row is in `{}.csv`.", table.name),
    })
}

fn shares(robot: &Robot, tool: &ToolAnswer) -> Vec<Block> {
    let mapped = tool.mapped();
    let mut plot = Plot::new(
        "Shares of the joints in the pose accuracy",
        Axis::new("hours of the robot", "h"),
        Axis::new("share, stacked", "mm"),
    );
    let of: Vec<(f64, Vec<f64>)> = tool
        .figures
        .iter()
        .map(|(hours, _)| {
            let shares = mapped.shares(&vec![*hours; robot.joints.len()]);
            (*hours, shares.iter().map(|causes| causes.iter().sum::<f64>() / MM).collect())
        })
        .collect();
    for (axis, joint) in robot.joints.iter().enumerate() {
        let band = of.iter().map(|(hours, shares)| {
            let below: f64 = shares[..axis].iter().sum();
            (*hours, below, below + shares[axis])
        });
        plot.series.push(Series::band(joint.axis.clone(), band).coloured(Colour::Palette(axis as u8)));
    }
    let ages = vec![robot.planned; robot.joints.len()];
    let causes = mapped.shares(&ages);
    let each = (0..4).map(|cause| {
        let sum: f64 = causes.iter().map(|causes| causes[cause]).sum();
        (
            CAUSES[cause].to_owned(),
            sum.abs() / MM,
            if sum < 0.0 { "against the others".to_owned() } else { String::new() },
        )
    });
    let table = robot.joint_table(tool);
    let last = table.rows() - robot.joints.len()..table.rows();
    vec![
        Block::Plot(plot.noted(
            "Shares at the test pose with the largest error, at every age: displacement of the tool by each joint along \
             that error. A band below the previous one is a joint that reduces the error.",
        )),
        Block::Shares(Shares {
            title: format!("Causes after {:.0} h", robot.planned),
            unit: "mm".to_owned(),
            rows: each.collect(),
            note: "Of all joints together, along the deviation of the worst test pose.".to_owned(),
        }),
        shown(&table, &format!("Joints after {:.0} h", robot.planned), last),
    ]
}

fn overhaul(robot: &Robot, tool: &ToolAnswer) -> Vec<Block> {
    let mut blocks: Vec<Block> = robot.plan_sentence().map(Block::Text).into_iter().collect();
    let titles = [
        ("plan", "Plan"),
        ("overhauls", "Gain by the overhaul of one reducer"),
        ("levers", "Displacement of the tool by an arc-minute of a joint"),
        ("variants", "Gain by changes of the program"),
    ];
    for (name, title) in titles {
        if let Some(table) = robot.table(name).filter(|table| table.rows() > 0) {
            blocks.push(shown(table, title, 0..table.rows()));
        }
    }
    if !tool.variants.is_empty() {
        blocks.push(Block::Note(
            Tone::Neutral,
            "Variants take the joints of the robot as it is; their hours are scaled by what wears them, Σ |T| |ω| t."
                .to_owned(),
        ));
    }
    blocks
}

fn reach_map(robot: &Robot, tool: &ToolAnswer) -> Option<Block> {
    const CELLS: usize = 20;
    let points = &tool.reach.points;
    if points.is_empty() {
        return None;
    }
    let bounds = |of: fn(&super::reach::ReachPoint) -> f64| {
        points
            .iter()
            .map(of)
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high): (f64, f64), x| (low.min(x), high.max(x)))
    };
    let (r, z) = (bounds(|p| p.radius), bounds(|p| p.height));
    let at = |(low, high): (f64, f64), cell: usize| low + (high - low) * cell as f64 / (CELLS - 1) as f64;
    let cell = |(low, high): (f64, f64), x: f64| {
        if high > low { ((x - low) / (high - low) * (CELLS - 1) as f64).round() as usize } else { 0 }
    };
    let mut cells: Vec<Option<f64>> = vec![None; CELLS * CELLS];
    for point in points {
        let here = &mut cells[cell(z, point.height) * CELLS + cell(r, point.radius)];
        let value = point.repeatability[1] / MM;
        *here = Some(here.map_or(value, |known: f64| known.max(value)));
    }
    Some(Block::HeatMap(HeatMap {
        title: format!("Repeatability over the reach after {:.0} h", robot.planned),
        x: Axis::new("distance from the first axis", "mm"),
        y: Axis::new("height", "mm"),
        value: Axis::new("repeatability", "mm"),
        x_values: (0..CELLS).map(|i| at(r, i) / MM).collect(),
        y_values: (0..CELLS).map(|i| at(z, i) / MM).collect(),
        cells,
        note: "Repeatability in mm, approached from all sides. The second and third axis move over their ranges; the other \
               axes have their mean angle in the programs. A cell shows its worst posture."
            .to_owned(),
        width: Width::Full,
    }))
}

fn remains(robot: &Robot) -> Vec<Block> {
    let mut blocks = vec![Block::Text(
        "Tables for the controller: `compensation.csv` contains the mean error of every joint over load and direction at \
         every age, `compensation_waves.csv` its transmission error over the angle. The table below compares the \
         remaining errors without compensation, with compensation of the stiffness, and with the whole table of the \
         new joints."
            .to_owned(),
    )];
    blocks.extend(robot.table("remains").map(|table| shown(table, "Remaining errors", 0..table.rows())));
    blocks
}

fn loads(robot: &Robot) -> Vec<Block> {
    let mut blocks = Vec::new();
    if let Some(table) = robot.table("loads") {
        blocks.push(shown(table, "Joints", 0..table.rows()));
    }
    for (program, course) in robot.programs.iter().zip(&robot.courses) {
        let mut plot = Plot::new(
            format!("Torques of the program {}", program.name),
            Axis::new("time", "s"),
            Axis::new("share of the rated torque", "%"),
        );
        let stride = program.motion.len().div_ceil(1500).max(1);
        for (axis, joint) in robot.joints.iter().enumerate() {
            let points = (0..program.motion.len()).step_by(stride).map(|sample| {
                (program.motion.time[sample], 100.0 * course.loads[sample][axis].torque / joint.rated)
            });
            plot.series.push(Series::line(joint.axis.clone(), points).coloured(Colour::Palette(axis as u8)));
        }
        blocks.push(Block::Plot(plot.noted(
            "Torque on every link in % of the rated torque of its reducer, by inverse dynamics along the program. \
             Positive torque drives positive motion.",
        )));
    }
    blocks.push(Block::Text(format!(
        "Programs run {:.0} % of the time. Designs with the duty of each joint are `joint-1.toml`, …: `arcmin life` of \
         one computes further results.",
        100.0 * robot.busy()
    )));
    if !robot.notes.is_empty() {
        blocks.push(Block::Note(Tone::Caution, robot.notes.join(" ")));
    }
    blocks
}
