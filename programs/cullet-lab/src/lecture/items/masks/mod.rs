//! Normal masks: two bytes a triangle, one AND to cull it.

mod classes;
mod paper;

pub(super) use classes::{N, grid};

use crate::lecture::item::{BLANK, Item, Live, zachmann, zhang_hoff};

/// Where the book goes through the method.
const CHAPTER: &str = "backface-masks.md#step-by-step";

pub(super) const ITEMS: &[Item] = &[
    Item {
        number: 29,
        title: "Classes of normals",
        places: &[zachmann("slide 13"), zhang_hoff("section 2.1")],
        claim: "A cube around the sphere of normals, with N × N cells on each side, cuts all directions into 6 N² classes. The class of a \
                normal is easy to find: it is the cell that the normal's line passes through.",
        said: Some("6 N² classes"),
        command: "cullet picture normal-mask --eye 3,2,5 --target 0,0,0 --fov 20",
        live: Some(Live {
            scene: "knobs",
            state: "study.cube=true&study.cells=8&look.colour=sides",
        }),
        chapter: CHAPTER,
        check: classes::classes,
        ..BLANK
    },
    Item {
        number: 30,
        title: "The circle of normals",
        places: &[zhang_hoff("Figure 1")],
        claim: "In the plane, the equal pieces of the sides of a square cut the circle of normals into arcs, each a class. The classes are not \
                equally large, which is the price of finding them easily.",
        command: "cullet picture normal-partition --fov 40",
        chapter: CHAPTER,
        check: classes::circle,
        ..BLANK
    },
    Item {
        number: 31,
        title: "A normal in two bytes",
        places: &[zachmann("slide 14"), zhang_hoff("section 2.2")],
        claim: "Of a string with a bit for each class a normal sets one, so the number of a byte and that byte are enough to keep: two bytes a \
                polygon. One byte for the number allows 2,048 classes, and N = 16 needs 1,536.",
        said: Some("2 bytes; 2,048 bits; 1,536 classes"),
        command: "cullet reproduce zhang-hoff",
        live: Some(Live { scene: "knobs", state: "study.by=masks&study.cube=true&study.cells=16" }),
        chapter: CHAPTER,
        check: classes::two_bytes,
        ..BLANK
    },
    Item {
        number: 32,
        title: "Classes that face away, in a parallel view",
        places: &[zachmann("slide 15"), zhang_hoff("section 3.1")],
        claim: "With parallel lines of sight the normal alone decides. A class may go if all of its normals face away, and those are nearly half \
                of all classes.",
        command: "cullet picture normal-partition",
        live: Some(Live { scene: "knobs", state: "study.by=masks&study.cube=true&study.cells=16" }),
        chapter: CHAPTER,
        check: classes::orthographic,
        ..BLANK
    },
    Item {
        number: 33,
        title: "180 degrees less the field of view",
        places: &[zachmann("slides 15 and 16"), zhang_hoff("section 3.1"), zhang_hoff("Figure 2")],
        claim: "In perspective a class is only culled if its normals face away wherever the polygon is: if they do for every line of sight of \
                the view. That leaves the normals within an arc of 180 degrees less the field of view.",
        said: Some("180° − FOV"),
        fault: Some(
            "The arc is derived in the plane, and the call of the paper takes a direction and a field of view without saying which angle of a \
             window that is. With the vertical one front faces in the window's corners are culled; it must be the angle between opposite \
             corners of the frustum.",
        ),
        command: "cullet picture conservative-set",
        live: Some(Live {
            scene: "knobs",
            state: "study.by=masks&study.groups=1&study.cube=true&study.cells=16",
        }),
        chapter: CHAPTER,
        check: classes::field_of_view,
    },
    Item {
        number: 34,
        title: "Four corners of a cell, four of the frustum",
        places: &[zachmann("slide 16"), zhang_hoff("section 3")],
        claim: "A class is tested by the four normals that point to the corners of its cell, for the lines of sight at the four corners of the \
                frustum. If all of them face away, all of the class does in all of the view.",
        fault: Some(
            "The paper calls the corners an approximation of all normals of the class. They are exact: a cell is all that lies between its \
             corners, and the normals that face away for a line of sight, or a cone of them, form a convex set.",
        ),
        command: "cullet picture normal-mask --eye 3,2,5 --target 0,0,0 --fov 40",
        chapter: CHAPTER,
        check: classes::four_corners,
        ..BLANK
    },
    Item {
        number: 35,
        title: "One AND a polygon",
        places: &[zachmann("slide 17"), zhang_hoff("section 3")],
        claim: "The classes that face away are the set bits of 256 bytes. A polygon is drawn if the AND of its byte and the mask's is 0.",
        said: Some("256 bytes; == 0"),
        fault: Some(
            "The slides of 2013 draw a polygon where the AND is 1; those of 2014 where it is 0. The first is wrong twice: a set bit means \
             that the class faces away, and the AND gives the bit, which is 1 for one class in eight.",
        ),
        command: "cullet reproduce zhang-hoff",
        live: Some(Live { scene: "knobs", state: "study.by=masks&look.colour=sides" }),
        chapter: "backface-masks.md#what-goes-wrong",
        check: paper::runtime_test,
    },
    Item {
        number: 36,
        title: "Sectors of the frustum",
        places: &[zachmann("slide 17")],
        claim: "If the view is divided into sectors with a mask each, the lines of sight of each differ less, so that more is culled.",
        command: "cullet picture conservative-set",
        chapter: CHAPTER,
        check: paper::sectors,
        ..BLANK
    },
    Item {
        number: 37,
        title: "A viewing cone for each group",
        places: &[zhang_hoff("section 3.2")],
        claim: "Groups of polygons with a viewing cone and a mask each make what is culled independent of the view's own angle: the smaller \
                the groups, the more goes. Each mask costs something, so that there is a number of groups beyond which it does not pay.",
        command: "cullet reproduce zhang-hoff",
        live: Some(Live { scene: "knobs", state: "study.by=masks&study.groups=64&study.cells=16" }),
        chapter: CHAPTER,
        check: paper::groups,
        ..BLANK
    },
    Item {
        number: 38,
        title: "216 and 1,536 classes, in a picture",
        places: &[zachmann("slide 18")],
        claim: "For one point of view, the classes that face away are marked on the cube with 216 classes and on that with 1,536. The finer \
                ones follow the limit more closely.",
        command: "cullet picture normal-mask --eye 3,2,5 --target 0,0,0 --fov 20",
        live: Some(Live { scene: "knobs", state: "study.cube=true&study.cells=16" }),
        chapter: CHAPTER,
        check: classes::picture,
        ..BLANK
    },
    Item {
        number: 39,
        title: "What nine grids cull of two bunnies",
        places: &[zhang_hoff("Table 1"), zachmann("slide 19")],
        claim: "Of two copies of the bunny, masks of 24 to 1,944 classes cull a growing share. Beyond some hundred classes little is gained.",
        said: Some("27.5 % for N = 2, 42.6 % for 16, 43.0 % for 18"),
        command: "cullet reproduce zhang-hoff",
        live: Some(Live {
            scene: "knobs",
            state: "study.by=masks&study.groups=1&study.cells=18&study.cube=true",
        }),
        chapter: CHAPTER,
        check: paper::table,
        ..BLANK
    },
    Item {
        number: 40,
        title: "How much faster frames become",
        places: &[zhang_hoff("Table 1"), zhang_hoff("section 4"), zachmann("slide 19")],
        claim: "Culling by masks before the hardware's own back-face culling makes frames 60 to 80 % faster, in the lecture 1.5 times as fast.",
        said: Some("60 to 80 %; 1.5 times"),
        fault: Some(
            "The paper culls 43.0 % at the most. Were triangles all that a frame costs, and a triangle that the hardware rejects as costly as \
             one that it draws, that would be 1 / (1 − 0.43) = 1.75 times, which is 75 %; the times in its own table fall as its triangles \
             do and give no more. A frame without masks is not in the table.",
        ),
        command: "cullet reproduce zhang-hoff",
        chapter: "gpu.md#triangles-one-by-one",
        check: paper::speed,
        ..BLANK
    },
    Item {
        number: 41,
        title: "Two functions and a macro",
        places: &[zhang_hoff("section 4")],
        claim: "Three calls are all that a renderer needs: one encodes a normal, one makes the mask of a direction of sight and a field of view, \
                and one tests a polygon.",
        said: Some("80 lines of C"),
        command: "cullet bench backface",
        chapter: "backface-masks.md",
        check: paper::interface,
        ..BLANK
    },
];
