//! Culling by planes, boxes and trees, as the third lecture has it.

mod faces;
mod regions;
mod scenes;
mod trees;

use crate::lecture::item::{BLANK, Item, Live, kaist};

pub(super) const ITEMS: &[Item] = &[
    Item {
        number: 83,
        title: "Culling against clipping",
        places: &[kaist("Culling and Clipping")],
        claim: "Culling throws away whole instances and primitives that cannot be seen, to draw faster. Clipping cuts off what of a \
                primitive is out of view, which makes rasterising simpler; cut-away views of a model are made by it too.",
        command: "cullet picture clip-polygon solids",
        live: Some(Live {
            scene: "solids:n=9",
            state: "clipping.open=true&clipping.step=1&map=false",
        }),
        chapter: "clipping.md",
        check: scenes::culled_and_clipped,
        ..BLANK
    },
    Item {
        number: 84,
        title: "A power plant, twelve million triangles",
        places: &[kaist("Culling Example")],
        claim: "Of a power plant's twelve million triangles the frustum leaves ten, and occlusion culling one.",
        said: Some("12, 10 and 1 million triangles"),
        command: "cullet verify plant --path camera:floor --views 1 --size 640x360 --samples 1",
        live: Some(Live { scene: "plant:bays=3,pipes=1", state: "layout=split&ghosts.form=solid" }),
        chapter: "occlusion.md#what-it-gives",
        check: scenes::power_plant,
        ..BLANK
    },
    Item {
        number: 85,
        title: "The implicit line and plane",
        places: &[kaist("Lines and Planes")],
        claim: "A line n·p − d = 0, a plane in space, is a row T = [n −d] with T·p = 0 for the homogeneous point p. If n has unit \
                length, d is the distance of the line from the origin along n.",
        command: "cullet cut solids --plane 0,1,0,1 --cap -o half.glb",
        chapter: "frustum.md#signed-distance",
        check: regions::implicit_planes,
        ..BLANK
    },
    Item {
        number: 86,
        title: "Negative half-spaces make a convex region",
        places: &[kaist("Lines and Planes"), kaist("Testing Objects for Containment")],
        claim: "A plane parts space into a positive and a negative half-space. Where negative half-spaces meet is a convex region, and \
                an instance is outside of it, inside, or straddles it.",
        command: "cullet picture map city:cells=6,objects=200 --only frustum --path walk --views 4 --view 1",
        live: Some(Live {
            scene: "city:cells=12,objects=1500",
            state: "layout=split&stages.backface=off&stages.occlusion=false&look.colour=reason&map=false",
        }),
        chapter: "frustum.md#the-test",
        check: regions::convex,
        ..BLANK
    },
    Item {
        number: 87,
        title: "Cheap tests first",
        places: &[kaist("Conservative Testing")],
        claim: "Cheap bounds that err on the safe side decide the simple cases. Where they do not decide, tests can follow that are \
                more exact and cost more.",
        command: "cullet report city:cells=6,objects=200 --exact-frustum",
        live: Some(Live {
            scene: "city:cells=12,objects=1500",
            state: "layout=split&stages.frustum_exact=true&stages.depth=triangles&map=false",
        }),
        chapter: "frustum.md#from-instances-to-triangles",
        check: regions::cheap_first,
        ..BLANK
    },
    Item {
        number: 88,
        title: "While indeterminate, recurse",
        places: &[kaist("Hierarchical Culling")],
        claim: "A hierarchy of boxes along the axes rejects or accepts whole subtrees at a time: only while a node is neither are its \
                children visited.",
        command: "cullet bench hierarchy",
        live: Some(Live {
            scene: "city:cells=12,objects=1500",
            state: "camera.distance=200&camera.pitch=-35&layout=split&stages.backface=off&stages.depth=instances&structure.level=2&map=false",
        }),
        chapter: "hierarchy.md#the-shape-that-is-fast",
        check: trees::recursion,
        ..BLANK
    },
    Item {
        number: 89,
        title: "Where the frustum's planes come from",
        places: &[kaist("View Frustum Culling")],
        claim: "How are the planes of the frustum computed? One after the other, all in the same way.",
        command: "cullet explain city:cells=6,objects=200 --path walk --views 4 --view 1 --pixel 640,360",
        chapter: "frustum.md#planes-out-of-a-matrix",
        check: regions::from_the_matrix,
        ..BLANK
    },
    Item {
        number: 90,
        title: "Back faces, by the plane of the face",
        places: &[kaist("Back-Face Culling"), kaist("Face Plane Test")],
        claim: "That the back of a closed body is hidden by its front is a special case of occlusion. A face has the plane \
                n = (v₁ − v₀) × (v₂ − v₀), d = n·v₀, and is culled if the eye lies in its negative half-space.",
        command: "cullet verify solids --only backface --views 4",
        live: Some(Live {
            scene: "solids",
            state: "look.colour=sides&look.cull=none&look.face_normals=true",
        }),
        chapter: "backface.md#the-face-normal",
        check: faces::face_planes,
        ..BLANK
    },
    Item {
        number: 91,
        title: "Front faces can be culled too",
        places: &[kaist("Back-Face Culling in OpenGL")],
        claim: "Which side is culled is a setting: front faces can be left out in place of back faces.",
        command: "cullet view solids",
        live: Some(Live { scene: "solids", state: "look.cull=front&look.colour=sides" }),
        chapter: "backface.md#in-opengl-wgpu-and-direct3d",
        check: faces::front_faces,
        ..BLANK
    },
];
