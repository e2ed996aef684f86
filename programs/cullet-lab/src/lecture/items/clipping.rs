//! Clipping lines, polygons and triangles.

mod cut_away;
mod lines;
mod outcodes;
mod pipeline;
mod polygons;

use crate::lecture::item::{BLANK, Item, Live, kaist};

/// A polygon, a window, and its corners' codes.
const PLAYGROUND: Live =
    Live { scene: "solids:n=9", state: "clipping.open=true&clipping.step=1&map=false" };

pub(super) const ITEMS: &[Item] = &[
    Item {
        number: 92,
        title: "A segment against a line",
        places: &[kaist("Clipping a Line Segment against a Line")],
        claim: "If both ends of a segment lie on one side, there is nothing to cut. Else it crosses the line T at \
                t = −T·p₀ / T·(p₁ − p₀), and whatever the ends carry is interpolated by the same t.",
        command: "cullet picture outcodes solids",
        live: Some(PLAYGROUND),
        chapter: "clipping.md#lines",
        check: lines::segment,
        ..BLANK
    },
    Item {
        number: 93,
        title: "A polygon against a line",
        places: &[kaist("Clipping a Polygon against a Line")],
        claim: "Along the edges of a polygon there are four cases: one inside stays, one outside goes, one that leaves ends in a new \
                point, and one that enters begins in one, joined to the last by a new edge.",
        command: "cullet picture clip-polygon solids",
        live: Some(PLAYGROUND),
        chapter: "clipping.md#polygons-one-side-after-another",
        check: polygons::four_cases,
        ..BLANK
    },
    Item {
        number: 94,
        title: "Sutherland and Hodgman",
        places: &[kaist("Clipping against a Convex Region")],
        claim: "Against a convex region a polygon is clipped by one edge of it after another.",
        command: "cullet picture clip-polygon solids",
        live: Some(PLAYGROUND),
        chapter: "clipping.md#polygons-one-side-after-another",
        check: polygons::one_after_another,
        ..BLANK
    },
    Item {
        number: 95,
        title: "Outcodes",
        places: &[kaist("Outcodes"), kaist("Outcode for Lines"), kaist("Outcodes for Triangles")],
        claim: "A vertex has a bit for each plane of a convex region that it is outside of. If the OR of the codes of a line or a \
                triangle is 0, it is inside; if their AND is not 0, it is outside; else it may cross the region, a line at planes \
                where its codes differ (XOR), and some that seem to cross do not.",
        fault: Some(
            "The third case is given as AND = 0 alone, which holds for everything that is inside as well. To be tested further is \
             what has AND = 0 and OR ≠ 0.",
        ),
        command: "cullet picture outcodes solids",
        live: Some(Live {
            scene: "solids",
            state: "structure.outcodes=true&layout=split&map=false",
        }),
        chapter: "clipping.md#outcodes",
        check: outcodes::rules,
        ..BLANK
    },
    Item {
        number: 96,
        title: "Cohen and Sutherland",
        places: &[kaist("Outcodes")],
        claim: "Cohen and Sutherland's way to clip a line decides by outcodes at once what it can, and cuts only what is left.",
        command: "cullet bench clip/lines",
        live: Some(PLAYGROUND),
        chapter: "clipping.md#lines",
        check: lines::cohen_sutherland,
        ..BLANK
    },
    Item {
        number: 97,
        title: "The best place to clip",
        places: &[kaist("Clipping in the Pipeline")],
        claim: "Triangles can be clipped before they are projected, in the world, or after, in clip space. The best place is clip space.",
        command: "cullet bench clip/place",
        live: Some(PLAYGROUND),
        chapter: "clipping.md#before-projection-or-after-it",
        fault: Some(
            "Neither place is best for every scene. In clip space a corner takes fewer products, but what is rejected was projected \
             first. Of the triangles of cullet bench clip/place most lie outside, and there the world takes less time.",
        ),
        check: pipeline::best_place,
        ..BLANK
    },
    Item {
        number: 98,
        title: "Points behind the eye flip",
        places: &[kaist("View Frustum Clipping")],
        claim: "What straddles the plane of the eye flips around infinity when it is projected, so points must be clipped while they \
                are still in projective space.",
        command: "cullet picture clip-w solids",
        chapter: "clipping.md#the-trap-of-w--0",
        check: pipeline::flip,
        ..BLANK
    },
    Item {
        number: 99,
        title: "The test in clip space",
        places: &[kaist("Clipping in the Clip Space")],
        claim: "After the projection and before the divide, the right side of the view is x = w: the row [1 −1 0] for [x w 1]. The test \
                is a comparison, and a line crosses at t = (w₀ − x₀) / ((w₀ − x₀) − (w₁ − x₁)).",
        command: "cullet bench clip",
        chapter: "clipping.md#the-trap-of-w--0",
        check: pipeline::clip_space,
        ..BLANK
    },
    Item {
        number: 100,
        title: "Culling and clipping in the pipeline",
        places: &[kaist("Culling and Clipping in the Rendering Pipeline")],
        claim: "Both have their places along the pipeline: whole instances first, then what they are made of, then triangles by their \
                sides, and clipping after the projection and before the divide.",
        command: "cullet picture pipeline solids",
        live: Some(Live {
            scene: "solids",
            state: "layout=split&stages.depth=triangles&look.colour=reason&map=false",
        }),
        chapter: "architecture.md#data-flow",
        check: pipeline::all_stages,
        ..BLANK
    },
    Item {
        number: 101,
        title: "Cut-away views",
        places: &[kaist("Culling and Clipping")],
        claim: "Clipping a model at a plane opens it, so that what is inside is seen.",
        command: "cullet cut solids --plane 0,1,0,1 --cap -o half.glb",
        live: Some(Live { scene: "office", state: "cut.on=true&cut.normal=[0,1,0]&cut.at=0.2" }),
        chapter: "cutting.md",
        check: cut_away::open,
        ..BLANK
    },
];
