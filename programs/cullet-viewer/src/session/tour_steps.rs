//! The stops of the tour: one flat table. A stop is words, the state of the viewer that shows it,
//! and a question whose answer the engine gives.

use cullet::Stage;

use super::Session;
use super::tour_facts::Facts;

/// A stop of the tour.
#[derive(Clone, Copy, Debug)]
pub struct Stop {
    /// Its title.
    pub title: &'static str,
    /// Its explanation.
    pub words: &'static str,
    /// The stages that it is about; figures are those of the first.
    pub stages: &'static [Stage],
    /// The state that shows it, as the text of a link with its scene. Without a camera one begins
    /// as the scene begins.
    pub state: &'static str,
    /// Where the camera outside stands: by how many degrees around from where it follows, and how
    /// much nearer.
    pub(super) outside: (f64, f64),
    /// Action once the scene is there.
    pub(super) order: fn(&mut Session),
    /// Question that is asked.
    pub question: &'static str,
    /// Two or three answers, of which one is right.
    pub choices: &'static [&'static str],
    /// The number of the right one, by what the engine found.
    pub(super) right: fn(&Facts<'_>) -> usize,
    /// Why, in a sentence; [`Facts::fill`] puts figures in.
    pub(super) because: &'static str,
}

fn nothing(_: &mut Session) {}

/// Shares of thirds.
const THIRDS: [f64; 2] = [1.0 / 3.0, 2.0 / 3.0];
const IN_THIRDS: &[&str] = &["Less than a third", "One to two thirds", "More than two thirds"];
const USUAL: (f64, f64) = (0.0, 1.0);

/// All stops, those of one scene after each other.
pub const STOPS: [Stop; 14] = [
    Stop {
        title: "Nothing is culled",
        words: "Left is what the camera sees. Right is the same from outside: white lines bound what the camera can \
                see. Without culling the renderer is handed all of it, seen or not.",
        stages: &[],
        state: "scene=city&layout=split&stages.on=false",
        outside: USUAL,
        order: nothing,
        question: "How much of the city goes to the renderer now?",
        choices: &["All of it", "What lies between the white lines", "What the left picture shows"],
        right: |f| usize::from(f.left() < f.all()),
        because: "All {all} triangles do: the cost grows with what there is, not with what is seen.",
    },
    Stop {
        title: "View frustum",
        words: "What lies wholly outside the white lines cannot be in the left picture, so it is dropped: blue on the \
                right. The left picture has not changed.",
        stages: &[Stage::Frustum],
        state: "scene=city&layout=split&ghosts.form=solid&stages.backface=off&stages.degenerate=false\
                &stages.occlusion=false&stages.depth=instances",
        outside: USUAL,
        order: nothing,
        question: "How much of the city does this one test drop?",
        choices: IN_THIRDS,
        right: |f| f.band(f.share_dropped(), &THIRDS),
        because: "It drops {dropped} of {entered} triangles, by a few planes and one box for each instance, or for many \
                  at once.",
    },
    Stop {
        title: "Occlusion",
        words: "What lies behind something nearer is not seen either: orange. Near walls are drawn into a small depth \
                buffer, and boxes are tested against it.",
        stages: &[Stage::Occlusion],
        state: "scene=city&layout=split&ghosts.form=solid&stages.backface=off&stages.degenerate=false\
                &stages.occlusion_budget=2000&stages.depth=instances",
        outside: USUAL,
        order: nothing,
        question: "Of what the frustum leaves, how much is proved to be hidden?",
        choices: IN_THIRDS,
        right: |f| f.band(f.share_dropped(), &THIRDS),
        because: "{dropped} of {entered} triangles are; what cannot be proved hidden is kept, so the picture stays.",
    },
    Stop {
        title: "Small size",
        words: "What covers less than 8 pixels is dropped here: violet. This kind is lossy. It is off until one asks \
                for it, and the limit says by how much the picture may be wrong.",
        stages: &[Stage::Detail],
        state: "scene=city&layout=split&ghosts.form=solid&stages.backface=off&stages.degenerate=false\
                &stages.occlusion=false&stages.depth=instances&stages.detail_px=8",
        outside: USUAL,
        order: nothing,
        question: "Can this change the left picture?",
        choices: &["No: no culling does", "Yes: what it drops may own pixels"],
        right: |f| usize::from(f.drops_what_may_be_seen()),
        because: "{dropped} triangles go for their size, some of them in plain sight.",
    },
    Stop {
        title: "Back faces",
        words: "Of a closed body only the near side is seen. Right, from aside and near: triangles that face away from \
                the camera are dropped, and bodies stand open.",
        stages: &[Stage::Backface],
        state: "scene=solids&layout=split&stages.occlusion=false&stages.backface=exact&stages.depth=triangles",
        outside: (62.0, 8.0),
        order: nothing,
        question: "Of closed bodies, how many triangles face away?",
        choices: &["About a tenth", "About half", "Nearly all"],
        right: |f| f.nearest(f.share_dropped(), &[0.1, 0.5, 0.95]),
        because: "{dropped} of {entered}: a closed surface turns away as much as it turns towards the eye.",
    },
    Stop {
        title: "Back faces by clusters",
        words: "A test for each triangle takes time. So neighbours form clusters of up to 124, each with a cone around \
                its normals: where all of the cone faces away, the cluster goes at once.",
        stages: &[Stage::Backface],
        state: "scene=solids&layout=split&stages.occlusion=false&look.colour=clusters",
        outside: (62.0, 8.0),
        order: nothing,
        question: "Do clusters find as many back faces as single triangles?",
        choices: &["As many", "Fewer", "More"],
        right: |f| f.clusters_against_triangles(),
        because: "{dropped} triangles go with their clusters: a cluster that bends around the edge is kept, back faces \
                  and all.",
    },
    Stop {
        title: "Back faces by masks",
        words: "Or normals fall into 384 classes, cells on a cube, dark where they face away from all lines of sight. A \
                bit for each class: one AND says whether a triangle, or a group, faces away.",
        stages: &[Stage::Backface],
        state: "scene=solids&layout=split&stages.occlusion=false&study.cube=true&study.by=masks",
        outside: (62.0, 8.0),
        order: Session::inspect_finest,
        question: "Which back faces of the outlined body do masks of groups find?",
        choices: &[
            "All of them",
            "Some, and never a front face",
            "Some, and now and then a front face",
        ],
        right: |f| f.masks_against_triangles(),
        because: "They prove {proved} of {away}: a class goes only if all of it faces away from the whole body, so what \
                  is in doubt stays.",
    },
    Stop {
        title: "Clipping and cut-aways",
        words: "Culling drops what is wholly beyond a plane; clipping also cuts what straddles it. A cut-away clips a \
                scene to look into it, and closes cut bodies with caps.",
        stages: &[],
        state: "scene=solids&cut.on=true",
        outside: USUAL,
        order: nothing,
        question: "Does a cut-away only drop triangles, as culling does?",
        choices: &["Yes", "No: it makes new ones"],
        right: |f| usize::from(f.caps() > 0),
        because: "{caps} triangles of caps alone are new, and the picture is meant to change.",
    },
    Stop {
        title: "Layers",
        words: "Instances and views have layers, a mask of bits. The cages are in no layer that the camera has, as the \
                helpers of an editor are: grey on the right.",
        stages: &[Stage::Layer],
        state: "scene=example:balls&layout=split&ghosts.form=solid&map=false",
        outside: USUAL,
        order: nothing,
        question: "When are the cages dropped?",
        choices: &[
            "Before all other tests",
            "After the frustum",
            "Triangle by triangle, at the end",
        ],
        right: |f| f.place_in_the_funnel(),
        because: "One AND an instance is the cheapest test there is, so it comes first: {dropped} triangles go.",
    },
    Stop {
        title: "Degenerate triangles",
        words: "These balls are made of quads. At the poles quads come to a point, and half of each has no area. Such \
                triangles are known when a mesh is made, and dropping them costs nothing.",
        stages: &[Stage::Degenerate],
        state: "scene=example:balls&layout=split&look.wireframe=true&stages.backface=off&stages.occlusion=false\
                &stages.depth=triangles&map=false",
        outside: USUAL,
        order: nothing,
        question: "How many pixels can such a triangle cover?",
        choices: &["None", "One", "As many as its neighbours"],
        right: |f| f.pixels_of_degenerate(),
        because: "Two corners of each of these {dropped} triangles are one point: no area, from wherever one looks.",
    },
    Stop {
        title: "Levels of detail",
        words: "Far away a ball needs fewer triangles. Each is drawn at the coarsest level that is off by less than a \
                pixel: cream in full, then blue, green and red. Lossy, too, within that pixel.",
        stages: &[Stage::Lod],
        state: "scene=example:levels&layout=split&stages.lod_px=1&look.colour=levels&stages.backface=off\
                &stages.occlusion=false&camera.target=[28.5,0,40]&camera.distance=24&camera.yaw=0&camera.pitch=-12\
                &map=false",
        outside: USUAL,
        order: nothing,
        question: "How many of the triangles in view are left?",
        choices: &["More than half", "A tenth to a half", "Less than a tenth"],
        right: |f| f.band(f.share_dropped(), &[0.5, 0.9]),
        because: "{kept} of {entered} are enough for the same balls.",
    },
    Stop {
        title: "Portals",
        words: "Rooms are cells, doors and windows are portals. The eye looks through those in sight, from there through \
                the next, and so on. Rooms in green are reached; the others are dropped: teal.",
        stages: &[Stage::Portal],
        state: "scene=office&layout=split&ghosts.form=solid&structure.cells=true&structure.portals=true\
                &stages.backface=off&stages.degenerate=false&stages.occlusion=false&stages.depth=instances\
                &camera.target=[26.6,1.7,18.2]&camera.distance=6&camera.yaw=-8&camera.pitch=-4&camera.near=0.05",
        outside: USUAL,
        order: nothing,
        question: "How much of what the frustum leaves do portals drop?",
        choices: IN_THIRDS,
        right: |f| f.band(f.share_dropped(), &THIRDS),
        because: "{dropped} of {entered} triangles are where no chain of portals leads.",
    },
    Stop {
        title: "Potentially visible sets",
        words: "The same without a walk: what can be seen from anywhere in a room was worked out beforehand. A frame \
                looks up the set of the eye's room; what is not in it is dropped: lime.",
        stages: &[Stage::Pvs],
        state: "scene=example:office&layout=split&ghosts.form=solid&structure.cells=true&stages.portal=false\
                &stages.backface=off&stages.degenerate=false&stages.occlusion=false&stages.depth=instances\
                &camera.target=[26.6,1.7,18.2]&camera.distance=6&camera.yaw=-8&camera.pitch=-4&camera.near=0.05",
        outside: USUAL,
        order: nothing,
        question: "Which leaves more: the set, or a walk through portals?",
        choices: &["The set", "The walk", "Both the same"],
        right: |f| f.set_against_walk(),
        because: "The set is right for every eye in the room, the walk for this one alone.",
    },
    Stop {
        title: "Why is it missing?",
        words: "All kinds together. Click an instance on the right: Inspect, in the panel, says which test dropped it, \
                with the numbers, and the funnel what each stage left.",
        stages: &[Stage::Frustum, Stage::Pvs, Stage::Portal],
        state: "scene=example:office&layout=split&ghosts.form=solid\
                &camera.target=[26.6,1.7,18.2]&camera.distance=6&camera.yaw=-8&camera.pitch=-4&camera.near=0.05",
        outside: USUAL,
        order: nothing,
        question: "Which kind dropped the most triangles here?",
        choices: &["Frustum", "Sets of rooms", "Portals"],
        right: |f| f.greediest(),
        because: "{left} of {all} triangles are left: each kind is given what the ones before it left.",
    },
];
