//! Prefix codes: made, limited in length, and written as WebP's lossless stream has them (RFC 9649,
//! section 3.7.2).

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::bits::BitWriter;

/// The longest code of a symbol, and of the length of one.
const LONGEST: u32 = 15;
const LONGEST_OF_LENGTHS: u32 = 7;
/// The order in which the lengths of the codes of lengths are written.
const ORDER: [usize; 19] = [17, 18, 0, 1, 2, 3, 4, 5, 16, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15];

/// A prefix code of an alphabet.
#[derive(Debug)]
pub(super) struct PrefixCode {
    /// Bits of each symbol's code; 0 for one that does not occur.
    lengths: Vec<u32>,
    /// The codes, their first bit the lowest.
    codes: Vec<u32>,
    /// The one symbol that occurs, where no other does: it takes no bit.
    alone: Option<usize>,
}

impl PrefixCode {
    /// The shortest code of at most 15 bits for symbols that occur so often.
    pub(super) fn new(counts: &[u64]) -> Self {
        Self::limited(counts, LONGEST)
    }

    fn limited(counts: &[u64], longest: u32) -> Self {
        let mut used = (0..counts.len()).filter(|&symbol| counts[symbol] > 0);
        let (first, second) = (used.next().unwrap_or(0), used.next());
        if second.is_none() {
            let none = vec![0; counts.len()];
            return Self { lengths: none.clone(), codes: none, alone: Some(first) };
        }
        let mut counts = counts.to_vec();
        // Where a code is too long, counts are made more alike until none is.
        let lengths = loop {
            let lengths = lengths_of(&counts);
            if lengths.iter().all(|&length| length <= longest) {
                break lengths;
            }
            counts.iter_mut().filter(|n| **n > 0).for_each(|n| *n = n.div_ceil(2));
        };
        Self { codes: canonical(&lengths), lengths, alone: None }
    }

    /// How many bits a symbol takes.
    fn length(&self, symbol: usize) -> u32 {
        self.lengths[symbol]
    }

    /// Writes a symbol, which must occur.
    pub(super) fn put(&self, symbol: usize, out: &mut BitWriter) {
        out.put(self.codes[symbol], self.lengths[symbol]);
    }

    /// Writes the code itself.
    pub(super) fn write(&self, out: &mut BitWriter) {
        if let Some(symbol) = self.alone {
            // The short form: one symbol, in one bit or in eight.
            debug_assert!(symbol < 256, "lengths of copies follow a literal");
            out.put(0b01, 2);
            let is_wide = symbol > 1;
            out.put(u32::from(is_wide), 1);
            out.put(symbol as u32, if is_wide { 8 } else { 1 });
            return;
        }
        let runs = runs_of(&self.lengths);
        let mut counts = [0; ORDER.len()];
        runs.iter().for_each(|run| counts[run.symbol] += 1);
        let of_lengths = Self::limited(&counts, LONGEST_OF_LENGTHS);
        out.put(0, 1);
        out.put(ORDER.len() as u32 - 4, 4);
        for symbol in ORDER {
            // One that is alone has a length, and takes no bit all the same.
            let is_alone = of_lengths.alone == Some(symbol);
            out.put(if is_alone { 1 } else { of_lengths.length(symbol) }, 3);
        }
        // The lengths of all symbols follow.
        out.put(0, 1);
        for run in runs {
            of_lengths.put(run.symbol, out);
            out.put(run.extra, run.bits);
        }
    }
}

/// The length of each symbol's code, of two or more that occur (Huffman, *A Method for the
/// Construction of Minimum-Redundancy Codes*, 1952).
fn lengths_of(counts: &[u64]) -> Vec<u32> {
    let mut lengths = vec![0; counts.len()];
    // The children of the nodes that are no symbols, whose numbers follow those of the symbols. Of
    // equal counts the lower number goes first, so that the code is always the same.
    let mut inner: Vec<[usize; 2]> = Vec::new();
    let mut heap: BinaryHeap<Reverse<(u64, usize)>> = (0..counts.len())
        .filter(|&symbol| counts[symbol] > 0)
        .map(|symbol| Reverse((counts[symbol], symbol)))
        .collect();
    while heap.len() > 1 {
        if let (Some(Reverse((a, left))), Some(Reverse((b, right)))) = (heap.pop(), heap.pop()) {
            inner.push([left, right]);
            heap.push(Reverse((a + b, counts.len() + inner.len() - 1)));
        }
    }
    let mut stack: Vec<(usize, u32)> =
        heap.pop().map(|Reverse((_, root))| (root, 0)).into_iter().collect();
    while let Some((node, depth)) = stack.pop() {
        match node.checked_sub(counts.len()) {
            Some(number) => stack.extend(inner[number].map(|child| (child, depth + 1))),
            None => lengths[node] = depth,
        }
    }
    lengths
}

/// The canonical code of these lengths: shorter ones first, then by symbol; the first bit the
/// lowest.
fn canonical(lengths: &[u32]) -> Vec<u32> {
    let mut codes = vec![0; lengths.len()];
    let mut next = 0u32;
    for length in 1..=LONGEST {
        for (code, _) in codes.iter_mut().zip(lengths).filter(|(_, of)| **of == length) {
            *code = next.reverse_bits() >> (32 - length);
            next += 1;
        }
        next <<= 1;
    }
    codes
}

/// Some lengths as they are written: a symbol, and the bits that follow it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Run {
    symbol: usize,
    extra: u32,
    bits: u32,
}

/// Lengths with runs of zeros taken together, 3 to 10 by symbol 17, and up to 138 by symbol 18.
fn runs_of(lengths: &[u32]) -> Vec<Run> {
    let mut runs = Vec::new();
    for run in lengths.chunk_by(|a, b| *a == 0 && *b == 0) {
        let mut left = run.len() as u32;
        if run[0] != 0 {
            runs.push(Run { symbol: run[0] as usize, extra: 0, bits: 0 });
            continue;
        }
        while left > 0 {
            let (taken, run) = match left {
                0..3 => (1, Run { symbol: 0, extra: 0, bits: 0 }),
                3..11 => (left, Run { symbol: 17, extra: left - 3, bits: 3 }),
                _ => {
                    let taken = left.min(138);
                    (taken, Run { symbol: 18, extra: taken - 11, bits: 7 })
                }
            };
            runs.push(run);
            left -= taken;
        }
    }
    runs
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rare_symbols_have_longer_codes_and_no_code_begins_another() {
        // Counts of Fibonacci make the longest codes that there are.
        let mut counts = vec![1u64, 1];
        for i in 2..30 {
            counts.push(counts[i - 1] + counts[i - 2]);
        }
        for longest in [LONGEST, LONGEST_OF_LENGTHS] {
            let code = PrefixCode::limited(&counts, longest);
            assert!(code.lengths.iter().all(|l| (1..=longest).contains(l)));
            assert!(code.lengths.windows(2).all(|w| w[0] >= w[1]));
            for (a, b) in (0..30).flat_map(|a| (0..30).map(move |b| (a, b))).filter(|(a, b)| a != b)
            {
                let mask = (1u32 << code.lengths[a]) - 1;
                let begins =
                    code.lengths[a] <= code.lengths[b] && code.codes[b] & mask == code.codes[a];
                assert!(!begins, "{a} begins {b}");
            }
            // Complete: Kraft's sum is 1.
            let sum: u32 = code.lengths.iter().map(|l| 1 << (longest - l)).sum();
            assert_eq!(sum, 1 << longest);
        }
    }

    #[test]
    fn a_symbol_that_is_alone_takes_no_bit() {
        let mut out = BitWriter::default();
        PrefixCode::new(&[0, 0, 5, 0]).put(2, &mut out);
        assert!(out.finish().is_empty());
    }

    #[test]
    fn runs_of_zeros_are_taken_together() {
        let lengths = [vec![3], vec![0; 200], vec![2, 2], vec![0; 4], vec![1, 0, 0]].concat();
        let runs: Vec<_> = runs_of(&lengths).iter().map(|r| (r.symbol, r.extra)).collect();
        let expected =
            [(3, 0), (18, 127), (18, 51), (2, 0), (2, 0), (17, 1), (1, 0), (0, 0), (0, 0)];
        assert_eq!(runs, expected);
    }
}
