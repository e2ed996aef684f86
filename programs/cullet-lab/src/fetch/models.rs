//! The models that are fetched: where each comes from, on which terms, and how to know it.

/// Bytes of a megabyte.
const MEGABYTE: u64 = 1_000_000;

/// A model that many papers and lectures use.
#[derive(Debug)]
pub(super) struct Known {
    /// Name by which it is asked for.
    pub(super) name: &'static str,
    /// Other names of it.
    pub(super) also: &'static [&'static str],
    /// Title of the model.
    pub(super) title: &'static str,
    /// The file that is kept.
    pub(super) file: &'static str,
    /// Where it is fetched from.
    pub(super) address: &'static str,
    /// Its path in the archive there, where that is a tar.
    pub(super) member: Option<&'static str>,
    /// How many triangles the reader of this program finds in it.
    pub(super) triangles: u64,
    /// The most megabytes that are fetched; it has fewer.
    most_megabytes: u64,
    /// On which terms.
    pub(super) terms: &'static Terms,
}

/// On which terms something may be used.
#[derive(Debug)]
pub(super) struct Terms {
    /// In a word, for a list.
    pub(super) word: &'static str,
    /// Whether whoever fetches it has to accept them: whether they bind.
    pub(super) bind: bool,
    /// Text of the terms, line by line. They do not replace the terms themselves, which are at
    /// `address`.
    pub(super) lines: &'static [&'static str],
    /// Where they stand in full.
    pub(super) address: &'static str,
}

impl Known {
    /// The model of a name.
    pub(super) fn find(name: &str) -> Option<&'static Self> {
        let is = |known: &&Self| known.name == name || known.also.contains(&name);
        MODELS.iter().find(is)
    }

    /// The most bytes that are fetched.
    pub(super) const fn most_bytes(&self) -> u64 {
        self.most_megabytes * MEGABYTE
    }

    /// The most bytes that may come out of them.
    pub(super) const fn most_unpacked(&self) -> u64 {
        16 * self.most_bytes()
    }
}

const STANFORD: Terms = Terms {
    word: "Stanford's: research and teaching",
    bind: true,
    lines: &[
        "Of the Stanford 3D Scanning Repository, Stanford University Computer Graphics Laboratory.",
        "Free for research, teaching and tests. Say whose it is where you publish a picture of it.",
        "Copies may be passed on free of charge, with that credit. Commercial use needs Stanford's permission.",
    ],
    address: "https://graphics.stanford.edu/data/3Dscanrep/",
};

const STANFORD_SYMBOL: Terms = Terms {
    lines: &[
        STANFORD.lines[0],
        STANFORD.lines[1],
        STANFORD.lines[2],
        "It is a symbol of a culture and a faith: the laboratory asks not to animate, morph or break it.",
    ],
    ..STANFORD
};

const TEAPOT: Terms = Terms {
    word: "none in writing",
    bind: true,
    lines: &[
        "Made by Martin Newell at the University of Utah in 1975 and used by everybody since.",
        "No licence is written anywhere; it is commonly taken for free of rights. Whether you may ship it is yours to judge.",
        "This copy is that of the list of common 3D test models of Alec Jacobson.",
    ],
    address: "https://github.com/alecjacobson/common-3d-test-models",
};

const SPOT: Terms = Terms {
    word: "CC0, free of rights",
    bind: false,
    lines: &["Made by Keenan Crane and given to everybody: CC0 1.0, no rights reserved."],
    address: "https://www.cs.cmu.edu/~kmcrane/Projects/ModelRepository/",
};

/// All of them, the small ones of each source first.
pub(super) const MODELS: &[Known] = &[
    Known {
        name: "bunny",
        also: &["stanford-bunny"],
        title: "the Stanford bunny, with holes in its base",
        file: "bunny.ply",
        address: "https://graphics.stanford.edu/pub/3Dscanrep/bunny.tar.gz",
        member: Some("bunny/reconstruction/bun_zipper.ply"),
        triangles: 69_451,
        most_megabytes: 32,
        terms: &STANFORD,
    },
    Known {
        name: "armadillo",
        also: &[],
        title: "the Stanford armadillo, a closed solid",
        file: "armadillo.ply",
        address: "https://graphics.stanford.edu/pub/3Dscanrep/armadillo/Armadillo.ply.gz",
        member: None,
        triangles: 345_944,
        most_megabytes: 32,
        terms: &STANFORD,
    },
    Known {
        name: "dragon",
        also: &["stanford-dragon"],
        title: "the Stanford dragon",
        file: "dragon.ply",
        address: "https://graphics.stanford.edu/pub/3Dscanrep/dragon/dragon_recon.tar.gz",
        member: Some("dragon_recon/dragon_vrip.ply"),
        triangles: 871_414,
        most_megabytes: 128,
        terms: &STANFORD_SYMBOL,
    },
    Known {
        name: "buddha",
        also: &["happy", "happy-buddha"],
        title: "the happy Buddha of Stanford, with tunnels through it",
        file: "buddha.ply",
        address: "https://graphics.stanford.edu/pub/3Dscanrep/happy/happy_recon.tar.gz",
        member: Some("happy_recon/happy_vrip.ply"),
        triangles: 1_087_716,
        most_megabytes: 128,
        terms: &STANFORD_SYMBOL,
    },
    Known {
        name: "teapot",
        also: &["utah-teapot"],
        title: "the Utah teapot, of four open parts",
        file: "teapot.obj",
        address: "https://raw.githubusercontent.com/alecjacobson/common-3d-test-models/master/data/teapot.obj",
        member: None,
        triangles: 6_320,
        most_megabytes: 4,
        terms: &TEAPOT,
    },
    Known {
        name: "spot",
        also: &[],
        title: "Spot the cow, a closed solid",
        file: "spot.obj",
        address: "https://raw.githubusercontent.com/alecjacobson/common-3d-test-models/master/data/spot.obj",
        member: None,
        triangles: 5_856,
        most_megabytes: 4,
        terms: &SPOT,
    },
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_name_and_each_file_is_of_one_model() {
        let mut names: Vec<&str> =
            MODELS.iter().flat_map(|m| m.also.iter().copied().chain([m.name])).collect();
        let mut files: Vec<&str> = MODELS.iter().map(|m| m.file).collect();
        for list in [&mut names, &mut files] {
            let all = list.len();
            list.sort_unstable();
            list.dedup();
            assert_eq!(list.len(), all);
        }
        assert!(names.iter().all(|name| Known::find(name).is_some()));
        assert!(Known::find("").is_none());
    }

    #[test]
    fn each_has_an_address_and_terms() {
        for model in MODELS {
            assert!(model.address.starts_with("https://"), "{}", model.name);
            assert!(!model.terms.lines.is_empty() && model.terms.address.starts_with("https://"));
            assert_eq!(model.member.is_some(), model.address.contains(".tar"), "{}", model.name);
            // What stands on the standard output must not be wider than a page.
            assert!(model.terms.lines.iter().all(|line| line.len() < 120), "{}", model.name);
        }
    }
}
