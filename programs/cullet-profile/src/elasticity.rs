//! From times of frames to the link that they wait for. Pure computation.

use serde::Serialize;

use super::link::Link;

/// Relative increase of a frame's time when the work of one link is doubled.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Elasticity {
    /// The median of all rounds.
    pub value: f64,
    /// Where the median lies in 95 of 100 draws of the rounds with replacement (B. Efron,
    /// *Bootstrap Methods*, 1979).
    pub interval: [f64; 2],
}

/// An elasticity of at least so much names a link.
pub const NAMED: f64 = 0.4;

impl Elasticity {
    /// Computes the elasticity from rounds in which a frame took `base`, and one with a link
    /// doubled took `doubled`, in any unit. Rounds without a positive time are left out; if none is
    /// left it is 0, and may be anything.
    #[must_use]
    pub fn of(rounds: &[[f64; 2]]) -> Self {
        let share = |[base, doubled]: &[f64; 2]| (doubled - base) / base;
        let is_time = |[base, doubled]: &&[f64; 2]| *base > 0.0 && *doubled > 0.0;
        let shares: Vec<f64> =
            rounds.iter().filter(is_time).map(share).filter(|s| s.is_finite()).collect();
        if shares.is_empty() {
            return Self { value: 0.0, interval: [f64::NEG_INFINITY, f64::INFINITY] };
        }
        const DRAWS: usize = 1000;
        let mut state = 0x9E37_79B9_7F4A_7C15_u64;
        let mut below = |n: usize| {
            // xorshift64*, S. Vigna 2016.
            state ^= state >> 12;
            state ^= state << 25;
            state ^= state >> 27;
            ((state.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 33) as usize) % n
        };
        let mut medians: Vec<f64> = (0..DRAWS)
            .map(|_| median((0..shares.len()).map(|_| shares[below(shares.len())]).collect()))
            .collect();
        medians.sort_by(f64::total_cmp);
        let interval = [medians[DRAWS / 40], medians[DRAWS - 1 - DRAWS / 40]];
        Self { value: median(shares), interval }
    }
}

/// The middle of some numbers, of two of them their mean; of none 0.
pub(crate) fn median(mut all: Vec<f64>) -> f64 {
    if all.is_empty() {
        return 0.0;
    }
    all.sort_by(f64::total_cmp);
    let (low, high) = (all[(all.len() - 1) / 2], all[all.len() / 2]);
    low + (high - low) / 2.0
}

/// The link that a frame waits for: the one whose elasticity is [large enough](NAMED), with an
/// interval above those of all others; `None` where there is no such.
#[must_use]
pub fn limit(all: &[Elasticity; 4]) -> Option<Link> {
    let (at, most) = (0..4).zip(all).max_by(|a, b| a.1.value.total_cmp(&b.1.value))?;
    let others = (0..4).zip(all).filter(|(other, _)| *other != at);
    let above = others.into_iter().all(|(_, other)| other.interval[1] < most.interval[0]);
    (above && most.value >= NAMED).then_some(Link::ALL[at])
}

#[cfg(test)]
mod tests {
    use cullet_testkit::Rng;

    use super::*;

    fn noisy(rng: &mut Rng, share: f64, rounds: usize) -> Elasticity {
        let round = |_| {
            // The machine is slow at times, for both.
            let base = rng.range(1.0, 1.1) * if rng.chance(0.1) { 3.0 } else { 1.0 };
            [base, base * (1.0 + share) * rng.range(0.97, 1.03)]
        };
        Elasticity::of(&(0..rounds).map(round).collect::<Vec<_>>())
    }

    #[test]
    fn what_was_put_in_is_found_within_the_interval() {
        let mut rng = Rng(1);
        let mut within = 0;
        for _ in 0..200 {
            let share = rng.range(-0.1, 1.2);
            let found = noisy(&mut rng, share, 30);
            assert!((found.value - share).abs() < 0.05, "{share} {found:?}");
            assert!(found.interval[0] <= found.value && found.value <= found.interval[1]);
            within += u32::from(found.interval[0] <= share && share <= found.interval[1]);
        }
        assert!(within > 170, "{within} of 200");
    }

    #[test]
    fn the_largest_is_named_where_it_is_large_and_apart() {
        let mut rng = Rng(2);
        let mut of = |shares: [f64; 4]| limit(&shares.map(|share| noisy(&mut rng, share, 30)));
        for at in 0..4 {
            let mut shares = [0.05; 4];
            shares[at] = 0.9;
            assert_eq!(of(shares), Some(Link::ALL[at]));
        }
        assert_eq!(of([0.5, 0.5, 0.0, 0.0]), None);
        assert_eq!(of([0.3, 0.1, 0.1, 0.1]), None);
    }

    #[test]
    fn no_times_and_broken_ones_name_nothing() {
        let none = Elasticity::of(&[]);
        assert_eq!(limit(&[none; 4]), None);
        let broken = [[0.0, 1.0], [f64::NAN, 1.0], [1.0, f64::INFINITY], [-1.0, 2.0]];
        assert_eq!(Elasticity::of(&broken).interval, none.interval);
        assert_eq!(Elasticity::of(&[[2.0, 3.0]]).value, 0.5);
    }
}
