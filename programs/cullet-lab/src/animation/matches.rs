//! Copies of what came before, in a row of indices: what a lossless stream writes in place of
//! pixels.

/// How long a copy is at the most.
pub(super) const LONGEST: usize = 4096;
/// Shorter ones cost more than their pixels.
const SHORTEST: usize = 3;
/// So many earlier places are looked at for a longer copy.
const CHAIN: usize = 96;
/// A copy of this length is good enough.
const ENOUGH: usize = 512;
/// How far back a copy may begin: what the stream can say, less the distances that have short
/// codes.
const REACH: usize = (1 << 20) - 121;

/// A part of a row of indices.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Token {
    /// One index.
    Literal(u8),
    /// So many indices, as they stand so far back.
    Copy { length: usize, distance: usize },
}

/// Splits indices into literals and copies; `width` is that of the picture. By hash chains, as most
/// such programs do: at each place the longest copy, unless the next place has a longer one.
pub(super) fn split(indices: &[u8], width: usize) -> Vec<Token> {
    let mut finder = Finder::new(indices, width);
    let (mut tokens, mut at) = (Vec::new(), 0);
    let mut found = finder.longest(0);
    while at < indices.len() {
        finder.add(at);
        let next = if at + 1 < indices.len() { finder.longest(at + 1) } else { None };
        let is_better = |a: Option<(usize, usize)>, b: usize| a.is_some_and(|a| a.0 > b);
        match found {
            Some((length, distance)) if !is_better(next, length) => {
                tokens.push(Token::Copy { length, distance });
                (at + 1..at + length).for_each(|i| finder.add(i));
                at += length;
                found = if at < indices.len() { finder.longest(at) } else { None };
            }
            _ => {
                tokens.push(Token::Literal(indices[at]));
                at += 1;
                found = next;
            }
        }
    }
    tokens
}

struct Finder<'a> {
    indices: &'a [u8],
    width: usize,
    /// The last place of each hash, and for each place the one before with the same; one more than
    /// the place, 0 for none.
    last: Vec<u32>,
    before: Vec<u32>,
}

const HASH_BITS: u32 = 15;

impl<'a> Finder<'a> {
    fn new(indices: &'a [u8], width: usize) -> Self {
        let (last, before) = (vec![0; 1 << HASH_BITS], vec![0; indices.len()]);
        Self { indices, width, last, before }
    }

    /// Returns the hash of the three indices from a place on.
    fn hash(&self, at: usize) -> Option<usize> {
        let [a, b, c] = *self.indices.get(at..)?.first_chunk::<SHORTEST>()?;
        let key = u32::from_le_bytes([a, b, c, 0]);
        Some((key.wrapping_mul(0x9E37_79B1) >> (32 - HASH_BITS)) as usize)
    }

    fn add(&mut self, at: usize) {
        if let Some(hash) = self.hash(at) {
            self.before[at] = self.last[hash];
            self.last[hash] = at as u32 + 1;
        }
    }

    /// The longest copy for a place, and from how far back; the row above and the pixel before are
    /// tried first, for they have short codes.
    fn longest(&self, at: usize) -> Option<(usize, usize)> {
        let mut best: Option<(usize, usize)> = None;
        let mut consider = |distance: usize, least: usize| {
            if distance == 0 || distance > at.min(REACH) {
                return 0;
            }
            let length = self.common(at, at - distance);
            if length >= least && best.is_none_or(|(longest, _)| length > longest) {
                best = Some((length, distance));
            }
            length
        };
        for distance in [self.width, 1, self.width + 1, self.width - 1] {
            consider(distance, SHORTEST);
        }
        let mut place = self.hash(at).map_or(0, |hash| self.last[hash]);
        for _ in 0..CHAIN {
            let Some(from) = place.checked_sub(1) else { break };
            // A far copy must be longer to pay for its distance.
            if consider(at - from as usize, SHORTEST + 2) >= ENOUGH {
                break;
            }
            place = self.before[from as usize];
        }
        best
    }

    /// How many indices are alike from two places on.
    fn common(&self, at: usize, from: usize) -> usize {
        let most = (self.indices.len() - at).min(LONGEST);
        let [now, then] = [at, from].map(|i| &self.indices[i..i + most]);
        now.iter().zip(then).take_while(|(a, b)| a == b).count()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the text that tokens stand for.
    fn joined(tokens: &[Token]) -> Vec<u8> {
        let mut all: Vec<u8> = Vec::new();
        for token in tokens {
            match *token {
                Token::Literal(index) => all.push(index),
                Token::Copy { length, distance } => {
                    (0..length).for_each(|_| all.push(all[all.len() - distance]));
                }
            }
        }
        all
    }

    #[test]
    fn tokens_say_what_was_split() {
        let mut rng = cullet_testkit::Rng(3);
        for width in [1, 2, 7, 64] {
            for colors in [1, 2, 5, 200] {
                let mut indices: Vec<u8> = (0..2000).map(|_| rng.below(colors) as u8).collect();
                // Some of it again, and a long stretch of one colour.
                let again = indices[100..700].to_vec();
                indices.extend(again);
                indices.extend([3; 6000]);
                let tokens = split(&indices, width);
                assert!(joined(&tokens) == indices, "{width} {colors}");
                assert!(tokens.len() < 2010, "{width} {colors}: {}", tokens.len());
            }
        }
        assert!(split(&[], 4).is_empty());
        assert_eq!(split(&[7], 4), [Token::Literal(7)]);
    }
}
