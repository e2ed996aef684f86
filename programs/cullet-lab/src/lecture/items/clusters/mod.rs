//! Clusters that face away as a whole.

mod body;
mod bound;
mod cost;
mod joint;

use crate::lecture::item::{BLANK, Item, Live, zachmann};

/// Where the book derives the bound.
const CHAPTER: &str = "backface-clusters.md#johannsen-and-carter-step-by-step";
/// Where the book has what the texts get wrong.
const TRAPS: &str = "backface-clusters.md#traps-in-the-published-formulas";
/// The bound that is derived, on a built-in body.
const BOXES: Option<Live> =
    Some(Live { scene: "knobs", state: "study.by=boxes&look.colour=clusters" });
/// The region of a cluster that is clicked.
const VOLUME: Option<Live> =
    Some(Live { scene: "knobs", state: "structure.volume=true&look.colour=clusters" });

pub(super) const ITEMS: &[Item] = &[
    Item {
        number: 47,
        title: "Rules of minimum and maximum",
        places: &[zachmann("slide 20")],
        claim: "The maximum of sums is at most the sum of the maxima, that of differences at most the maximum less the minimum. A factor moves \
                out of a maximum, and turns it into a minimum where it is negative.",
        command: "cullet reproduce johannsen-carter",
        chapter: CHAPTER,
        check: bound::rules,
        ..BLANK
    },
    Item {
        number: 48,
        title: "Back-facing, the other way round",
        places: &[zachmann("slide 20")],
        claim: "For clusters the rule is written with the vector from the polygon to the eye: it faces away if n·(e − p) ≤ 0. That is the first \
                rule's set, and what is seen edge-on besides.",
        command: "cullet verify solids --views 4",
        live: Some(Live { scene: "solids", state: "look.colour=sides" }),
        chapter: "backface-clusters.md#johannsen-and-carter-step-by-step",
        check: bound::inverted,
        ..BLANK
    },
    Item {
        number: 49,
        title: "From every polygon to three axes",
        places: &[zachmann("slide 21")],
        claim: "All polygons of a cluster face away if and only if the largest n·(e − p) is not positive. Two upper bounds of it are quicker: \
                the largest n·e less d, the smallest n·p; and for the first the sum of the largest on each axis.",
        command: "cullet reproduce johannsen-carter",
        live: BOXES,
        chapter: CHAPTER,
        check: bound::steps,
        ..BLANK
    },
    Item {
        number: 50,
        title: "Eight octants, 28 bytes",
        places: &[zachmann("slide 22"), zachmann("slide 23")],
        claim: "With m the largest and m′ the smallest component of the normals on each axis, the bound at the eye e takes m where e is positive \
                and m′ elsewhere, and the cluster is culled if that vector times e is at most d. Two vectors and d are 28 bytes a cluster.",
        said: Some("28 bytes"),
        command: "cullet reproduce johannsen-carter",
        live: BOXES,
        chapter: CHAPTER,
        check: bound::octants,
        ..BLANK
    },
    Item {
        number: 51,
        title: "The culling volume",
        places: &[zachmann("slide 24")],
        claim: "The test is one plane in each octant, eight in all. The four that meet across a half-axis meet on it, at (d/m, 0, 0), and an eye \
                within all planes sees the cluster from behind.",
        said: Some("8 planes; (d/mₓ, 0, 0)"),
        fault: Some(
            "It is called a closed volume. It is closed only where the normals lie around 0 on every axis, as those of a whole solid do, seen \
             from within; that of a cluster goes on behind it for ever. The corner (d/m, 0, 0) is there only for d and m above 0.",
        ),
        command: "cullet picture culling-volume knobs",
        live: VOLUME,
        chapter: CHAPTER,
        check: bound::volume,
    },
    Item {
        number: 52,
        title: "An origin for each cluster",
        places: &[zachmann("slide 25")],
        claim: "Far from the origin d becomes so negative that the test never culls. So each cluster gets an origin c of its own, with which d is \
                large; in practice the best of the middle and the corners of its box.",
        fault: Some(
            "The slides of 2014 take the octant from the eye's position e. It must be that of e − c, as in 2013: with the other, front faces \
             are culled. And c makes 40 bytes of 28.",
        ),
        command: "cullet reproduce johannsen-carter",
        live: BOXES,
        chapter: TRAPS,
        check: bound::local_origin,
        ..BLANK
    },
    Item {
        number: 53,
        title: "Does a rotation help?",
        places: &[zachmann("slide 25")],
        claim: "Would axes of a cluster's own, in place of those of the mesh, achieve something?",
        command: "cullet reproduce johannsen-carter",
        live: BOXES,
        chapter: CHAPTER,
        check: bound::rotation,
        ..BLANK
    },
    Item {
        number: 54,
        title: "Joint clusters",
        places: &[zachmann("slide 26")],
        claim: "Two clusters make a joint one: on each axis the larger m and the smaller m′, and the smaller d. Where the joint cluster is culled, \
                both are.",
        fault: Some(
            "The smaller d is only right if both are measured from the same origin, and the slide before has just given each cluster its own. d \
             must first be moved: n·(p − c′) is at least d less the largest n·(c′ − c) of the box of normals.",
        ),
        command: "cullet reproduce johannsen-carter",
        chapter: TRAPS,
        check: joint::joint,
        ..BLANK
    },
    Item {
        number: 55,
        title: "A hierarchy of clusters",
        places: &[zachmann("slide 26")],
        claim: "In a tree of joint clusters with a test for fronts beside that for backs, testing stops where a joint cluster faces one way as a \
                whole.",
        fault: Some(
            "The test for fronts is called analogous. With the same d it is wrong: it needs the largest n·p where the test for backs needs the \
             smallest, a second number for each cluster.",
        ),
        command: "cullet reproduce johannsen-carter",
        live: Some(Live { scene: "knobs", state: "look.colour=clusters" }),
        chapter: "backface-clusters.md#trees-and-the-frame-before",
        check: joint::hierarchy,
        ..BLANK
    },
    Item {
        number: 56,
        title: "How likely a cluster is culled",
        places: &[zachmann("slide 27")],
        claim: "The probability P that a cluster is culled is the volume of its culling volume over the volume where eyes may be. The first can be \
                computed exactly.",
        fault: Some(
            "The culling volume of a cluster has no end, so that its volume is infinite. It must be cut to where eyes may be; then P is exact, and \
             depends on that box.",
        ),
        command: "cullet picture culling-volume knobs",
        live: VOLUME,
        chapter: "backface-clusters.md#making-clusters",
        check: cost::probability,
        ..BLANK
    },
    Item {
        number: 57,
        title: "Where eyes may be",
        places: &[zachmann("slide 27")],
        claim: "Eyes may be in the box of the whole scene; or, with local origins, in the cluster's own box made larger. Both tell well enough \
                which clusters are good.",
        command: "cullet reproduce johannsen-carter",
        live: Some(Live { scene: "knobs", state: "look.colour=clusters" }),
        chapter: "backface-clusters.md#making-clusters",
        check: cost::boxes,
        ..BLANK
    },
    Item {
        number: 58,
        title: "What a cluster is expected to cost",
        places: &[zachmann("slide 28")],
        claim: "A cluster costs its test, and its triangles where it is not culled: T = t + (1 − P) R.",
        command: "cullet reproduce johannsen-carter",
        live: Some(Live { scene: "knobs", state: "look.colour=clusters" }),
        chapter: "backface-clusters.md#making-clusters",
        check: cost::expected,
        ..BLANK
    },
    Item {
        number: 59,
        title: "When to merge two clusters",
        places: &[zachmann("slide 29")],
        claim: "With R = n r, merging A and B into C pays if and only if P(C) > (P(A) n(A) + P(B) n(B) − t/r) / (n(A) + n(B)).",
        command: "cullet picture clusters knobs --test-cost 4",
        live: Some(Live { scene: "knobs", state: "look.colour=clusters" }),
        chapter: "backface-clusters.md#making-clusters",
        check: cost::merging,
        ..BLANK
    },
    Item {
        number: 60,
        title: "t/r, measured beforehand",
        places: &[zachmann("slide 29")],
        claim: "The ratio of a cluster's test to a triangle drawn depends on the machine, its graphics, lights and textures; a program can measure \
                it by itself, beforehand.",
        command: "cullet calibrate --dry-run",
        chapter: "costs.md#what-is-measured",
        check: cost::calibrated,
        ..BLANK
    },
];
