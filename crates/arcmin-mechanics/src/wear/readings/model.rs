//! Prediction of readings from a wear coefficient as a function of time.

use crate::wear::growth::{Grown, Target};
use crate::wear::{Exposure, Growth};

/// One reading of one machine.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reading {
    /// Running time in s.
    pub time: f64,
    /// Quantity of the reading.
    pub measured: Measured,
    /// Value of the reading, m or rad.
    pub value: f64,
    /// Divisor of its residual.
    pub scale: f64,
}

/// Quantity of a reading.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Measured {
    /// Largest wear depth of the flank.
    Depth,
    /// Increase of the lost motion since new.
    Increase,
    /// Lost motion of the machine with this number.
    LostMotion(usize),
}

/// Lost motion of a machine when new, if known in addition to its readings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct New {
    /// Lost motion in rad.
    pub value: f64,
    /// Its standard deviation divided by that of a reading: 1 for one that was read.
    pub error: f64,
}

/// All readings, and the lost motion of their machines when new if known.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Readings {
    /// Readings in the order given; all count in the fit.
    pub all: Vec<Reading>,
    /// By the number of the machine.
    pub new: Vec<Option<New>>,
}

/// A point of the parameter space: a coefficient as a function of time, and the difference (rad) of the lost
/// motion when new of one machine from its best fit with that coefficient.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Truth {
    /// Coefficient over time.
    pub law: Exposure,
    /// Number of the machine and shift of its lost motion when new, rad; `None` for no shift.
    pub shift: Option<(usize, f64)>,
}

impl Truth {
    /// A coefficient as a function of time, with the best fit of every lost motion when new.
    pub fn best(law: Exposure) -> Truth {
        Truth { law, shift: None }
    }
}

impl Readings {
    fn of_machine(&self, machine: usize) -> impl Iterator<Item = &Reading> {
        self.all.iter().filter(move |reading| reading.measured == Measured::LostMotion(machine))
    }

    /// Time of the first reading of a machine and its value, the mean of those at the same time; a known lost
    /// motion when new counts as a reading at time 0.
    pub fn first(&self, machine: usize) -> Option<(f64, f64)> {
        let new = self.new.get(machine).copied().flatten().map(|new| (0.0, new.value));
        let all = || self.of_machine(machine).map(|reading| (reading.time, reading.value)).chain(new);
        let time = all().map(|(time, _)| time).reduce(f64::min)?;
        let at_first: Vec<f64> = all().filter(|(at, _)| *at == time).map(|(_, value)| value).collect();
        Some((time, at_first.iter().sum::<f64>() / at_first.len() as f64))
    }

    /// Growth required by each reading alone; a first reading requires none.
    pub fn targets(&self) -> Vec<Target> {
        let target = |reading: &Reading| {
            let (grown, since, before) = match reading.measured {
                Measured::Depth => (Grown::Depth, 0.0, 0.0),
                Measured::Increase => (Grown::LostMotion, 0.0, 0.0),
                Measured::LostMotion(machine) => {
                    let (time, value) = self.first(machine)?;
                    (Grown::LostMotion, time, value)
                }
            };
            let value = reading.value - before;
            (reading.time > since).then_some(Target { grown, since, time: reading.time, value })
        };
        self.all.iter().filter_map(target).collect()
    }
}

/// Readings with the growth that predicts them.
pub struct Model<'a> {
    /// Depth and lost motion against exposure.
    pub growth: &'a Growth,
    /// Readings for comparison with the growth.
    pub readings: &'a Readings,
    /// Numbers of the readings of each machine.
    of_machine: Vec<Vec<usize>>,
}

impl<'a> Model<'a> {
    /// Groups the readings by machine.
    pub fn new(growth: &'a Growth, readings: &'a Readings) -> Model<'a> {
        let mut of_machine = vec![Vec::new(); readings.new.len()];
        for (index, reading) in readings.all.iter().enumerate() {
            if let Measured::LostMotion(machine) = reading.measured {
                of_machine[machine].push(index);
            }
        }
        Model { growth, readings, of_machine }
    }

    /// Numbers of machines whose lost motion was read.
    pub fn machines(&self) -> impl Iterator<Item = usize> {
        (0..self.of_machine.len()).filter(|machine| !self.of_machine[*machine].is_empty())
    }

    /// Number of known values, and of machines whose lost motion when new is fitted.
    pub fn counted(&self) -> (usize, usize) {
        let machines = self.machines().count();
        let new = self.machines().filter(|machine| self.readings.new[*machine].is_some()).count();
        (self.readings.all.len() + new, machines)
    }

    /// Divisor of the residuals of a machine's readings, the same for all of them.
    pub(super) fn scale(&self, machine: usize) -> f64 {
        self.of_machine[machine].first().map_or(1.0, |index| self.readings.all[*index].scale)
    }

    /// Lost motion of a machine when new in rad: weighted mean of its readings less their growth and of its
    /// known value, by their errors.
    pub fn new_of(&self, machine: usize, truth: &Truth) -> f64 {
        let own = &self.of_machine[machine];
        let left = |index: &usize| {
            let reading = &self.readings.all[*index];
            reading.value - self.growth.increase(truth.law.at(reading.time))
        };
        let (mut sum, mut weight) = (own.iter().map(left).sum::<f64>(), own.len() as f64);
        if let Some(new) = self.readings.new[machine] {
            sum += new.value / (new.error * new.error);
            weight += 1.0 / (new.error * new.error);
        }
        let shift = truth.shift.filter(|(of, _)| *of == machine).map_or(0.0, |(_, shift)| shift);
        sum / weight + shift
    }

    /// Predicted value of a reading.
    pub fn value(&self, reading: &Reading, truth: &Truth) -> f64 {
        let exposure = truth.law.at(reading.time);
        match reading.measured {
            Measured::Depth => self.growth.depth(exposure),
            Measured::Increase => self.growth.increase(exposure),
            Measured::LostMotion(machine) => self.new_of(machine, truth) + self.growth.increase(exposure),
        }
    }

    /// (p − r)/s of all readings, and of the known values of machines when new.
    pub(super) fn residuals(&self, truth: &Truth) -> Vec<f64> {
        let mut residuals = Vec::with_capacity(self.readings.all.len() + self.of_machine.len());
        let since_new = |reading: &&Reading| !matches!(reading.measured, Measured::LostMotion(_));
        for reading in self.readings.all.iter().filter(since_new) {
            residuals.push((self.value(reading, truth) - reading.value) / reading.scale);
        }
        for machine in self.machines() {
            let (new, scale) = (self.new_of(machine, truth), self.scale(machine));
            for index in &self.of_machine[machine] {
                let reading = &self.readings.all[*index];
                let grown = self.growth.increase(truth.law.at(reading.time));
                residuals.push((new + grown - reading.value) / scale);
            }
            if let Some(known) = self.readings.new[machine] {
                residuals.push((new - known.value) / (known.error * scale));
            }
        }
        residuals
    }
}
