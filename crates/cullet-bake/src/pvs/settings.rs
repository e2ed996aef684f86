//! Settings of a bake.

/// How far a bake goes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PvsPreset {
    /// Floods through whole portals, and some lines: several times too much is kept, in a hundredth
    /// of the time.
    Fast,
    /// Every pair of cells is decided, as far as the budget of each goes.
    #[default]
    Full,
}

/// Settings of a bake. Results are a function of these and the graph, and of nothing else.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct PvsSettings {
    /// How far to go. Default: full.
    pub preset: PvsPreset,
    /// Seed of the sampled lines. Default: 1.
    pub seed: u64,
    /// Openings through which a line can only just pass count as none: those at most so wide, as a
    /// share of the graph's diagonal, of 1e-7 to 1e-3. Less keeps more pairs that only touch.
    /// Default: 1e-6, 8 mm in a map of 8 km, or 0.008 units in a map of Quake.
    pub tolerance: f64,
    /// Lines through each pair of a cell's portals, to begin with. More find more pairs cheaply and
    /// take longer. Default: 4.
    pub local_lines: u32,
    /// Lines aimed at each undecided cell next to those that are seen. Default: 8.
    pub aimed_lines: u32,
    /// Lines through what a chain of portals leaves open, before it is searched. Default: 8.
    pub chain_lines: u32,
    /// How often such a chain is split in the search for a line through it, or for the proof that
    /// there is none. More leaves less undecided. Default: 32.
    pub splits: u32,
}

impl Default for PvsSettings {
    fn default() -> Self {
        Self {
            preset: PvsPreset::Full,
            seed: 1,
            tolerance: 1e-6,
            local_lines: 4,
            aimed_lines: 8,
            chain_lines: 8,
            splits: 32,
        }
    }
}

impl PvsSettings {
    /// Returns a copy with `seed`.
    #[must_use]
    pub fn with_seed(self, seed: u64) -> Self {
        Self { seed, ..self }
    }

    /// Returns a copy with `preset`.
    #[must_use]
    pub fn with_preset(self, preset: PvsPreset) -> Self {
        Self { preset, ..self }
    }

    /// The tolerance within its limits; the default where it is no number.
    pub(super) fn sound_tolerance(&self) -> f64 {
        if self.tolerance.is_nan() {
            Self::default().tolerance
        } else {
            self.tolerance.clamp(1e-7, 1e-3)
        }
    }

    /// All that results depend on, for hashes.
    pub(super) fn bytes(&self) -> Vec<u8> {
        let Self { preset, seed, tolerance: _, local_lines, aimed_lines, chain_lines, splits } =
            *self;
        let mut bytes = vec![preset as u8];
        bytes.extend(seed.to_le_bytes());
        bytes.extend(self.sound_tolerance().to_le_bytes());
        for n in [local_lines, aimed_lines, chain_lines, splits] {
            bytes.extend(n.to_le_bytes());
        }
        bytes
    }
}
