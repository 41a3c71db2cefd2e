use std::cmp::Ordering;

use serde::{Deserialize, Serialize};

use super::Outcome;
use crate::study::StudyError;
use crate::study::stream::{Purpose, Stream};

/// Non-dominated sorting genetic algorithm II (Deb, Pratap, Agarwal & Meyarivan 2002) in the unit cube, with
/// simulated binary crossover (η = 15, nine couples in ten), polynomial mutation (η = 20, one gene in n) and
/// constrained dominance. Elitist: the population after each generation is the best of parents and children
/// together.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Nsga2 {
    seed: u64,
    generation: u64,
    dimensions: usize,
    population: usize,
    /// Empty before the first generation is evaluated.
    members: Vec<Member>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Member {
    place: Vec<f64>,
    outcome: Outcome,
    rank: usize,
    crowding: Crowding,
}

/// Distance to the neighbours on the front; the ends of a front count as far.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
enum Crowding {
    End,
    Distance(f64),
}

impl Crowding {
    fn value(self) -> f64 {
        match self {
            Crowding::End => f64::INFINITY,
            Crowding::Distance(distance) => distance,
        }
    }
}

const CROSSOVER_SHARE: f64 = 0.9;
const CROSSOVER_INDEX: f64 = 15.0;
const MUTATION_INDEX: f64 = 20.0;

impl Nsga2 {
    /// # Errors
    /// [`StudyError::Search`] without dimensions or with an odd population or one below four.
    pub fn new(dimensions: usize, population: usize, seed: u64) -> Result<Nsga2, StudyError> {
        if dimensions == 0 || population < 4 || population % 2 == 1 {
            let reason = "the search needs something to vary and an even population of four or more".into();
            return Err(StudyError::Search { reason });
        }
        Ok(Nsga2 { seed, generation: 0, dimensions, population, members: Vec::new() })
    }

    /// Number of generations evaluated.
    pub fn generation(&self) -> u64 {
        self.generation
    }

    /// Designs of one generation.
    pub fn population(&self) -> usize {
        self.population
    }

    /// The Pareto front of designs that keep their constraints.
    pub fn front(&self) -> Vec<(&[f64], &Outcome)> {
        self.members
            .iter()
            .filter(|member| member.rank == 0 && member.outcome.is_feasible())
            .map(|member| (member.place.as_slice(), &member.outcome))
            .collect()
    }

    fn stream(&self, index: usize) -> Stream {
        let number = self.generation.wrapping_mul(self.population as u64).wrapping_add(index as u64);
        Stream::new(self.seed, Purpose::Generations, number)
    }

    /// Points of the present generation in the unit cube; repeated calls give the same.
    pub fn ask(&self) -> Vec<Vec<f64>> {
        if self.members.is_empty() {
            return (0..self.population)
                .map(|index| {
                    let mut stream = self.stream(index);
                    (0..self.dimensions).map(|_| stream.unit()).collect()
                })
                .collect();
        }
        (0..self.population / 2).flat_map(|couple| self.children(&mut self.stream(couple))).collect()
    }

    fn children(&self, stream: &mut Stream) -> [Vec<f64>; 2] {
        let mut parent = || {
            let (a, b) = (
                &self.members[stream.below(self.members.len())],
                &self.members[stream.below(self.members.len())],
            );
            if crowded_order(b, a) == Ordering::Less { &b.place } else { &a.place }
        };
        let (mut one, mut other) = (parent().clone(), parent().clone());
        if stream.unit() < CROSSOVER_SHARE {
            for (a, b) in one.iter_mut().zip(&mut other) {
                let (cross, u, exchange) = (stream.unit(), stream.unit(), stream.unit());
                if cross < 0.5 && (*a - *b).abs() > 1e-14 {
                    let (low, high) = crossed(a.min(*b), a.max(*b), u);
                    (*a, *b) = if exchange < 0.5 { (low, high) } else { (high, low) };
                }
            }
        }
        for place in [&mut one, &mut other] {
            for gene in place.iter_mut() {
                let (mutate, u) = (stream.unit(), stream.unit());
                if mutate < 1.0 / self.dimensions as f64 {
                    *gene = mutated(*gene, u);
                }
            }
        }
        [one, other]
    }

    /// Receives the outcomes of the generation in its order, and advances to the next.
    ///
    /// # Errors
    /// [`StudyError::Search`] if there are not as many outcomes as members, or they differ in their number of
    /// goals.
    pub fn tell(&mut self, outcomes: &[Outcome]) -> Result<(), StudyError> {
        let no = |reason: &str| Err(StudyError::Search { reason: reason.into() });
        if outcomes.len() != self.population {
            return no("the number of outcomes must equal that of the designs of a generation");
        }
        let known = self.members.iter().map(|member| &member.outcome);
        let mut goals =
            known.chain(outcomes).filter(|outcome| !outcome.goals.is_empty()).map(|o| o.goals.len());
        if let Some(first) = goals.next()
            && goals.any(|count| count != first)
        {
            return no("designs differ in their number of goals");
        }
        let children = self.ask().into_iter().zip(outcomes).map(|(place, outcome)| Member {
            place,
            outcome: outcome.clone(),
            rank: 0,
            crowding: Crowding::Distance(0.0),
        });
        let mut all = std::mem::take(&mut self.members);
        all.extend(children);
        sort_into_fronts(&mut all);
        all.sort_by(crowded_order);
        all.truncate(self.population);
        self.members = all;
        self.generation += 1;
        Ok(())
    }
}

/// Lower front first, then the less crowded; a stable sort leaves ties in their order.
fn crowded_order(a: &Member, b: &Member) -> Ordering {
    a.rank.cmp(&b.rank).then(b.crowding.value().total_cmp(&a.crowding.value()))
}

fn dominates(a: &Outcome, b: &Outcome) -> bool {
    match a.violation().total_cmp(&b.violation()) {
        Ordering::Less => true,
        Ordering::Greater => false,
        Ordering::Equal if a.is_feasible() => {
            a.goals.iter().zip(&b.goals).all(|(a, b)| a <= b)
                && a.goals.iter().zip(&b.goals).any(|(a, b)| a < b)
        }
        Ordering::Equal => false,
    }
}

/// Ranks by non-domination and crowding distances within each front.
fn sort_into_fronts(members: &mut [Member]) {
    let mut better_than: Vec<Vec<usize>> = vec![Vec::new(); members.len()];
    let mut bettered_by = vec![0; members.len()];
    for i in 0..members.len() {
        for j in 0..members.len() {
            if dominates(&members[i].outcome, &members[j].outcome) {
                better_than[i].push(j);
                bettered_by[j] += 1;
            }
        }
    }
    let mut front: Vec<usize> = (0..members.len()).filter(|k| bettered_by[*k] == 0).collect();
    let mut rank = 0;
    while !front.is_empty() {
        let mut next = Vec::new();
        for i in &front {
            members[*i].rank = rank;
            for j in &better_than[*i] {
                bettered_by[*j] -= 1;
                if bettered_by[*j] == 0 {
                    next.push(*j);
                }
            }
        }
        set_crowding(members, &front);
        next.sort_unstable();
        front = next;
        rank += 1;
    }
}

fn set_crowding(members: &mut [Member], front: &[usize]) {
    let goals = members[front[0]].outcome.goals.len();
    for k in front {
        members[*k].crowding = Crowding::Distance(0.0);
    }
    for goal in 0..goals {
        let value = |k: usize| members[k].outcome.goals[goal];
        let mut sorted = front.to_vec();
        sorted.sort_by(|a, b| value(*a).total_cmp(&value(*b)));
        let (first, last) = (sorted[0], sorted[sorted.len() - 1]);
        let range = value(last) - value(first);
        let distances: Vec<(usize, f64)> = sorted
            .windows(3)
            .map(|w| (w[1], if range > 0.0 { (value(w[2]) - value(w[0])) / range } else { 0.0 }))
            .collect();
        for (k, distance) in distances {
            if let Crowding::Distance(sum) = &mut members[k].crowding {
                *sum += distance;
            }
        }
        members[first].crowding = Crowding::End;
        members[last].crowding = Crowding::End;
    }
}

/// Simulated binary crossover of two places within the unit interval (Deb & Agrawal 1995; bounded form of
/// NSGA-II's code).
fn crossed(low: f64, high: f64, u: f64) -> (f64, f64) {
    let spread = |room: f64| {
        let beta = 1.0 + 2.0 * room / (high - low);
        let alpha = 2.0 - beta.powf(-(CROSSOVER_INDEX + 1.0));
        let power = 1.0 / (CROSSOVER_INDEX + 1.0);
        if u <= 1.0 / alpha { (u * alpha).powf(power) } else { (1.0 / (2.0 - u * alpha)).powf(power) }
    };
    let (sum, difference) = (low + high, high - low);
    let one = 0.5 * (sum - spread(low) * difference);
    let other = 0.5 * (sum + spread(1.0 - high) * difference);
    (one.clamp(0.0, 1.0), other.clamp(0.0, 1.0))
}

/// Polynomial mutation within the unit interval (Deb & Goyal 1996).
fn mutated(x: f64, u: f64) -> f64 {
    let power = 1.0 / (MUTATION_INDEX + 1.0);
    let delta = if u < 0.5 {
        (2.0 * u + (1.0 - 2.0 * u) * (1.0 - x).powf(MUTATION_INDEX + 1.0)).powf(power) - 1.0
    } else {
        1.0 - (2.0 * (1.0 - u) + (2.0 * u - 1.0) * x.powf(MUTATION_INDEX + 1.0)).powf(power)
    };
    (x + delta).clamp(0.0, 1.0)
}
