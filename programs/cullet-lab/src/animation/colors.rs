//! Few colours for many pictures: a median cut of their histogram.

use cullet_draw::Picture;

/// Bits of a channel that tell colours apart: the histogram has 2 to the power of three times that.
const BITS: u32 = 5;

/// A palette, and the way to it from every colour.
pub(super) struct Colors {
    palette: Vec<[u8; 3]>,
    /// For each bin of the histogram an index of the palette.
    of_bins: Vec<u8>,
}

/// The colours of a bin: how many, their sum, and one that stands for a bin of one colour.
#[derive(Clone, Copy, Default)]
struct Bin {
    count: u64,
    sum: [u64; 3],
}

impl Bin {
    fn mean(&self) -> [f64; 3] {
        self.sum.map(|v| v as f64 / self.count.max(1) as f64)
    }
}

fn bin_of(color: [u8; 3]) -> usize {
    let [r, g, b] = color.map(|v| usize::from(v >> (8 - BITS)));
    (r << (2 * BITS)) | (g << BITS) | b
}

impl Colors {
    /// At most `most` colours for these pictures (Heckbert, *Color Image Quantization for Frame
    /// Buffer Display*, 1982): the set of colours whose spread weighs the most is cut in two, again
    /// and again, along the channel that spreads the most.
    pub(super) fn of(pictures: &[Picture], most: usize) -> Self {
        let mut bins = vec![Bin::default(); 1 << (3 * BITS)];
        for p in pictures {
            for color in p.rgb.as_chunks::<3>().0 {
                let bin = &mut bins[bin_of(*color)];
                bin.count += 1;
                (0..3).for_each(|k| bin.sum[k] += u64::from(color[k]));
            }
        }
        let taken: Vec<usize> = (0..bins.len()).filter(|&i| bins[i].count > 0).collect();
        let mut sets = vec![taken];
        while sets.len() < most {
            let spread = |set: &Vec<usize>| spread_of(set, &bins);
            let widest = (0..sets.len())
                .map(|i| (i, spread(&sets[i])))
                .max_by(|a, b| a.1.1.total_cmp(&b.1.1).then(b.0.cmp(&a.0)));
            let Some((at, (channel, weight))) = widest else { break };
            if weight <= 0.0 {
                break;
            }
            let mut set = std::mem::take(&mut sets[at]);
            set.sort_by(|a, b| {
                bins[*a].mean()[channel].total_cmp(&bins[*b].mean()[channel]).then(a.cmp(b))
            });
            let high = set.split_off(cut_of(&set, &bins, channel));
            sets[at] = set;
            sets.push(high);
        }
        let mut of_bins = vec![0; bins.len()];
        let mut palette = Vec::with_capacity(sets.len());
        for (number, set) in (0..).zip(&sets) {
            let mut all = Bin::default();
            for &i in set {
                of_bins[i] = number;
                all.count += bins[i].count;
                (0..3).for_each(|k| all.sum[k] += bins[i].sum[k]);
            }
            palette.push(all.mean().map(|v| v.round() as u8));
        }
        Self { palette, of_bins }
    }

    pub(super) fn palette(&self) -> Vec<[u8; 3]> {
        self.palette.clone()
    }

    /// The index of each pixel.
    pub(super) fn indices(&self, picture: &Picture) -> Vec<u8> {
        picture.rgb.as_chunks::<3>().0.iter().map(|c| self.of_bins[bin_of(*c)]).collect()
    }
}

/// The channel in which a set spreads the most, and its sum of squares there. Eyes tell shades of
/// flat areas apart however small those are, so the weight of a bin is the square root of its
/// count.
fn spread_of(set: &[usize], bins: &[Bin]) -> (usize, f64) {
    if set.len() < 2 {
        return (0, 0.0);
    }
    let of = |channel: usize| {
        let (mut weight, mut sum, mut squares) = (0.0, 0.0, 0.0);
        for &i in set {
            let (w, v) = ((bins[i].count as f64).sqrt(), bins[i].mean()[channel]);
            weight += w;
            sum += w * v;
            squares += w * v * v;
        }
        squares - sum * sum / weight
    };
    let all = [0, 1, 2].map(|channel| (channel, of(channel)));
    all.into_iter().max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((0, 0.0))
}

/// Where to cut a sorted set, so that both halves have some: above the mean.
fn cut_of(set: &[usize], bins: &[Bin], channel: usize) -> usize {
    let weight = |i: usize| (bins[i].count as f64).sqrt();
    let value = |i: usize| bins[i].mean()[channel];
    let all: f64 = set.iter().map(|&i| weight(i)).sum();
    let mean = set.iter().map(|&i| weight(i) * value(i)).sum::<f64>() / all;
    set.partition_point(|&i| value(i) <= mean).clamp(1, set.len() - 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_widest_sets_are_cut_first() {
        let mut p = Picture::new(8, 1, [0; 3]);
        p.rgb[..12].copy_from_slice(&[250, 0, 0, 251, 0, 0, 0, 0, 250, 0, 0, 251]);
        let colors = Colors::of(std::slice::from_ref(&p), 3);
        let mut palette = colors.palette();
        palette.sort_unstable();
        assert_eq!(palette, [[0, 0, 0], [0, 0, 251], [251, 0, 0]]);
        let shown: Vec<_> =
            colors.indices(&p).iter().map(|&i| colors.palette[usize::from(i)]).collect();
        assert_eq!(shown[..4], [[251, 0, 0], [251, 0, 0], [0, 0, 251], [0, 0, 251]]);
    }

    #[test]
    fn one_colour_is_one_colour() {
        let p = Picture::new(3, 3, [1, 2, 3]);
        assert_eq!(Colors::of(&[p], 9).palette(), [[1, 2, 3]]);
    }
}
