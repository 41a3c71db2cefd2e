use rand::Rng;
use rand_pcg::Pcg64Mcg;

/// Uses of streams of random numbers. Each use has separate streams, so that a new use does not change the numbers
/// of the others. The values are part of the format of a study and must not change.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Purpose {
    Points = 1,
    Strata = 2,
    Scramble = 3,
    Trajectories = 4,
    Resamples = 5,
    Generations = 6,
    Machines = 7,
    Batches = 8,
    Reducers = 9,
}

/// Random numbers that depend only on (seed, purpose, index): the `index`-th stream of a purpose can be drawn alone,
/// in any order and anywhere. The generator is PCG-64-MCG (O'Neill 2014, XSL-RR 128/64) with its state set by
/// SplitMix64 (Steele, Lea & Flood 2014); doubles are computed here, so that they do not depend on the release of a
/// library of random numbers.
#[derive(Debug, Clone)]
pub struct Stream(Pcg64Mcg);

/// SplitMix64's output function: a bijection of 64 bits in which every bit depends on every other.
pub fn mix(word: u64) -> u64 {
    let word = (word ^ (word >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let word = (word ^ (word >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    word ^ (word >> 31)
}

/// One word of several, in which their order matters.
pub(crate) fn hash(words: &[u64]) -> u64 {
    words.iter().fold(0x243f_6a88_85a3_08d3, |hash, word| {
        mix(hash.rotate_left(23).wrapping_add(0x9e37_79b9_7f4a_7c15) ^ mix(*word))
    })
}

impl Stream {
    pub fn new(seed: u64, purpose: Purpose, index: u64) -> Stream {
        let (high, low) = (hash(&[seed, purpose as u64, index, 0]), hash(&[seed, purpose as u64, index, 1]));
        Stream(Pcg64Mcg::new(u128::from(high) << 64 | u128::from(low)))
    }

    pub fn next_u64(&mut self) -> u64 {
        self.0.next_u64()
    }

    /// Even over (0, 1), both ends excluded: the middles of 2⁵² cells.
    pub fn unit(&mut self) -> f64 {
        ((self.next_u64() >> 12) as f64 + 0.5) / (1_u64 << 52) as f64
    }

    /// Even over 0 … `count` − 1, to one part in 2⁶⁴/count (Lemire 2019 without rejection); 0 for a count of
    /// 0.
    pub fn below(&mut self, count: usize) -> usize {
        ((u128::from(self.next_u64()) * count as u128) >> 64) as usize
    }

    /// Standard normal, by inversion: one number drawn for one used.
    pub fn normal(&mut self) -> f64 {
        super::distribution::standard_normal(self.unit())
    }

    /// Fisher–Yates.
    pub fn shuffle<T>(&mut self, items: &mut [T]) {
        for last in (1..items.len()).rev() {
            items.swap(last, self.below(last + 1));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Pins the generator: if this moves, every study ever drawn moves.
    #[test]
    fn regress_streams_are_pinned() {
        let mut stream = Stream::new(7, Purpose::Points, 3);
        let words = [stream.next_u64(), stream.next_u64()];
        assert_eq!(words, PINNED, "{words:#x?}");
    }
    const PINNED: [u64; 2] = [0x9c3c_f1a0_11e8_9db8, 0x451d_aa05_2eb4_32c4];

    #[test]
    fn splitmix_is_the_published_one() {
        // First outputs of SplitMix64 from state 1234567 (Vigna's C code, the reference of many ports).
        let golden = 0x9e37_79b9_7f4a_7c15_u64;
        let outputs: Vec<u64> =
            (1..=3).map(|k| mix(1_234_567_u64.wrapping_add(golden.wrapping_mul(k)))).collect();
        assert_eq!(
            outputs,
            [6_457_827_717_110_365_317, 3_203_168_211_198_807_973, 9_817_491_932_198_370_423]
        );
    }

    #[test]
    fn streams_are_even_and_independent_of_each_other() {
        // First numbers of 20 000 neighbouring streams: mean and variance of the uniform distribution within
        // five standard errors, neighbours uncorrelated.
        let firsts: Vec<f64> =
            (0..20_000).map(|index| Stream::new(1, Purpose::Points, index).unit()).collect();
        let n = firsts.len() as f64;
        let mean = firsts.iter().sum::<f64>() / n;
        assert!((mean - 0.5).abs() < 5.0 / (12.0 * n).sqrt(), "{mean}");
        let covariance = firsts.windows(2).map(|w| (w[0] - 0.5) * (w[1] - 0.5)).sum::<f64>() / n;
        assert!(covariance.abs() < 5.0 / 12.0 / n.sqrt(), "{covariance}");
        assert!(firsts.iter().all(|u| *u > 0.0 && *u < 1.0));
        assert_ne!(Stream::new(1, Purpose::Points, 0).unit(), Stream::new(1, Purpose::Strata, 0).unit());
        assert_ne!(Stream::new(1, Purpose::Points, 0).unit(), Stream::new(2, Purpose::Points, 0).unit());
    }

    #[test]
    fn shuffles_are_even() {
        // Each of the six orders of three items 1000 ± 5·29 times in 6000.
        let mut counts = std::collections::BTreeMap::new();
        for index in 0..6000 {
            let mut items = [0, 1, 2];
            Stream::new(3, Purpose::Strata, index).shuffle(&mut items);
            *counts.entry(items).or_insert(0_i32) += 1;
        }
        assert_eq!(counts.len(), 6);
        assert!(counts.values().all(|count| (count - 1000).abs() < 145), "{counts:?}");
    }
}
