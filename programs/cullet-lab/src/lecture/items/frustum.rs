//! The frustum, bounding volumes and hierarchies.

mod groups;
mod planes;
mod views;
mod volumes;

use crate::lecture::item::{BLANK, Item, Live, kaist, ucsd};

/// A city that is quick to draw.
const CITY: &str = "city:cells=6,objects=200";
/// What a camera sees beside its frustum from outside.
const SPLIT: Live = Live {
    scene: "city:cells=12,objects=1500",
    state: "layout=split&stages.backface=off&ghosts.form=boxes&map=false",
};

pub(super) const ITEMS: &[Item] = &[
    Item {
        number: 61,
        title: "Five kinds of culling",
        places: &[ucsd("Visibility Culling")],
        claim: "Geometry that need not be drawn is left out to draw faster. There are five kinds: what is outside the frustum, \
                what is small, what is degenerate, what faces away, and what is occluded.",
        command: "cullet report city:cells=6,objects=200 --detail 4",
        live: Some(Live {
            scene: "city:cells=12,objects=1500",
            state: "layout=split&look.colour=reason&ghosts.form=solid&stages.detail_px=4",
        }),
        chapter: "kinds.md",
        check: views::five_kinds,
        ..BLANK
    },
    Item {
        number: 62,
        title: "With frustum culling and without",
        places: &[ucsd("View Frustum Culling")],
        claim: "Triangles outside the frustum are off the screen, so leaving them out changes nothing that is seen.",
        command: "cullet picture kinds city:cells=6,objects=200 --only frustum",
        live: Some(SPLIT),
        chapter: "frustum.md",
        check: views::pair_of_pictures,
        ..BLANK
    },
    Item {
        number: 63,
        title: "Frustum culling in motion",
        places: &[ucsd("Videos")],
        claim: "As the camera turns, instances go out behind it and come in before it, and who looks through it sees nothing of that.",
        command: "cullet film city:cells=6,objects=200 --of freeze",
        live: Some(Live {
            scene: "city:cells=12,objects=1500",
            state: "layout=split&stages.backface=off&stages.occlusion=false&ghosts.form=boxes&always=true",
        }),
        chapter: "frustum.md#try-it",
        check: views::turning,
        ..BLANK
    },
    Item {
        number: 64,
        title: "Spheres are cheap, boxes are tight",
        places: &[ucsd("Bounding Volumes")],
        claim: "A simple volume around an instance is tested in place of its primitives. A sphere takes less to test, a box fits \
                tighter.",
        command: "cullet report city:cells=6,objects=200",
        live: Some(SPLIT),
        chapter: "frustum.md#boxes-or-spheres",
        check: volumes::boxes_and_spheres,
        ..BLANK
    },
    Item {
        number: 65,
        title: "One box for many polygons",
        places: &[ucsd("Bounding Box")],
        claim: "An instance of many polygons is culled by one box: the smallest along the axes of its own space that holds all of \
                it.",
        command: "cullet picture map solids",
        live: Some(Live {
            scene: "solids",
            state: "layout=split&stages.backface=off&stages.occlusion=false&ghosts.form=boxes&map=false",
        }),
        chapter: "frustum.md#from-instances-to-triangles",
        check: volumes::one_box_for_many,
        ..BLANK
    },
    Item {
        number: 66,
        title: "Signed distance to a plane",
        places: &[ucsd("Distance to Plane"), kaist("Lines and Planes")],
        claim: "A point x is n·(x − p) from the plane through p with unit normal n: positive on the side that n points to, negative \
                on the other, zero on the plane. With d = n·p that is n·x − d, so n and d are the plane.",
        command: "cullet explain city --view 2 --pixel 640,360",
        chapter: "frustum.md#signed-distance",
        check: planes::signed_distance,
        ..BLANK
    },
    Item {
        number: 67,
        title: "Six planes whose normals point out",
        places: &[ucsd("Frustum With Signed Planes")],
        claim: "All normals of the frustum's planes point out of it, so a positive distance is outside and a negative one inside.",
        command: "cullet picture map city:cells=6,objects=200 --path walk --views 4 --view 2",
        live: Some(SPLIT),
        chapter: "frustum.md#the-test",
        check: planes::normals_point_out,
        ..BLANK
    },
    Item {
        number: 68,
        title: "A sphere against a plane",
        places: &[ucsd("Test Sphere and Plane")],
        claim: "The distance of its centre, held against its radius, tells whether a sphere is wholly above a plane, wholly below it, \
                or cut by it.",
        fault: Some(
            "The three cases are dist > r, dist < −r and −r < dist < r, so a sphere that touches the plane, |dist| = r, is in none. \
             It shares a point with the plane and belongs to those that are cut, which are kept: −r ≤ dist ≤ r.",
        ),
        command: "cullet bench frustum/spheres",
        chapter: "frustum.md#the-test",
        check: planes::sphere_and_plane,
        ..BLANK
    },
    Item {
        number: 69,
        title: "Six planes and a count",
        places: &[ucsd("Culling Summary")],
        claim: "In camera space the planes of the frustum are the same in every frame. A sphere is outside as soon as one plane has \
                it outside; it is inside if the count of planes that have it inside comes to six; else it straddles.",
        said: Some("a count of 6"),
        command: "cullet bench frustum/spheres",
        live: Some(SPLIT),
        chapter: "frustum.md#the-test",
        check: volumes::count_of_six,
        ..BLANK
    },
    Item {
        number: 70,
        title: "Groups, and groups of groups",
        places: &[
            ucsd("Culling Groups of Objects"),
            ucsd("Hierarchical Bounding Volumes"),
            ucsd("Hierarchical Culling"),
        ],
        claim: "Each volume of a hierarchy encloses those below it. A group that is outside goes whole, one that is inside is drawn \
                whole, and only of one that is neither are the members tested, down to single instances.",
        command: "cullet picture hierarchy city --path walk --views 8 --view 2",
        live: Some(Live {
            scene: "city:cells=12,objects=1500",
            state: "camera.distance=200&camera.pitch=-35&layout=split&stages.backface=off&stages.depth=instances&structure.level=1&map=false",
        }),
        chapter: "hierarchy.md",
        check: groups::walk,
        ..BLANK
    },
    Item {
        number: 71,
        title: "Planes of the frustum from the camera",
        places: &[ucsd("Find the frustum planes")],
        claim: "The planes follow from the camera's place p, its unit direction d, its up, and the width of its near window: near and \
                far lie across d at their distances, and a side is spanned by up and the line from p to the middle of that side of the \
                window.",
        fault: Some(
            "The vector called right is up × d, which points left in a right-handed space. So the plane called right is the left \
             one, and its normal points out, while near gets d and far −d, which point in: taken as the same lecture takes signs, \
             all that is seen would be outside. With right = d × up, a side normal of a × up, near −d and far d, all six point out.",
        ),
        command: "cullet picture map city:cells=6,objects=200 --eye 0,2,9 --target 0,1,0",
        live: Some(SPLIT),
        chapter: "frustum.md#planes-out-of-a-camera",
        check: planes::from_the_camera,
        ..BLANK
    },
];
