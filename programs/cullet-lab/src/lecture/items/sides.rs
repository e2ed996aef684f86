//! Sides of triangles, and the switches of graphics interfaces.

use crate::methods::screen::ndc_normal_z;
use cullet::cull::backface::{Facing, ObjectEye, facing_ref};
use cullet::{Camera, Culler, Depth, FrontFace, Projection, Scene, Stage, Transform, View};
use cullet_io::Model;
use cullet_scenes::knobbly_ball;

use crate::lecture::finding::Finding;
use crate::lecture::geometry::{along, dot, in_clip, verified};
use crate::lecture::item::{BLANK, Item, Live, kaist, ucsd};
use crate::lecture::lab::{Lab, LabError};
use crate::lecture::tools::{SIZE, draw, grouped, mesh, placed, scene_of};

pub(super) const ITEMS: &[Item] = &[
    Item {
        number: 74,
        title: "Half of all triangles face away",
        places: &[ucsd("Backface Culling")],
        claim: "Triangles of a closed body count as visible from their front alone, for what faces away from the eye is not seen. \
                Those are about half of all.",
        said: Some("roughly 50 %"),
        command: "cullet report solids --only backface",
        live: Some(Live {
            scene: "knobs",
            state: "frozen.target=[0,1.15,0]&frozen.distance=4&camera.target=[0,1.15,0]&camera.distance=5&camera.yaw=135&stages.frustum=false&map=false",
        }),
        chapter: "backface.md#what-can-be-reached",
        check: about_half,
        ..BLANK
    },
    Item {
        number: 75,
        title: "Front is counter-clockwise",
        places: &[ucsd("Backface Culling")],
        claim: "By convention a triangle shows its front where its corners are seen in counter-clockwise order.",
        command: "cullet info solids",
        live: Some(Live { scene: "solids", state: "look.colour=sides&look.cull=none" }),
        chapter: "backface.md#the-test",
        check: counter_clockwise,
        ..BLANK
    },
    Item {
        number: 76,
        title: "The normal after projection",
        places: &[ucsd("Backface Culling")],
        claim: "The normal of a triangle can be taken after the divide; then the sign of its third component alone tells which side is \
                seen.",
        fault: Some(
            "A negative third component is said to be a front, because projection turns the third component around. But that \
             component comes from the first two coordinates of the corners alone, which projection does not turn: with the vertical \
             axis up it is positive where the corners run counter-clockwise, whatever becomes of depth.",
        ),
        command: "cullet verify solids --only backface --views 4",
        live: Some(Live { scene: "solids", state: "look.colour=sides&look.cull=none" }),
        chapter: "backface.md#after-projection",
        check: after_projection,
        ..BLANK
    },
    Item {
        number: 77,
        title: "Culling of faces on and off",
        places: &[ucsd("OpenGL"), kaist("Back-Face Culling in OpenGL")],
        claim: "A graphics interface takes triangles as one-sided or two-sided by a switch. Of closed bodies both pictures are the \
                same; where a back is in sight, they are not.",
        command: "cullet picture kinds solids --no-backface && cullet picture kinds solids",
        live: Some(Live {
            scene: "knobs",
            state: "layout=wipe&look.hardware=true&look.colour=sides",
        }),
        chapter: "backface.md#in-opengl-wgpu-and-direct3d",
        check: on_and_off,
        ..BLANK
    },
];

/// How many triangles of instances show their front, their back, or neither, as the eye of the view tells.
fn facing(scene: &Scene, view: &View) -> [u64; 3] {
    let mut counts = [0; 3];
    for slot in scene.slots() {
        let eye = ObjectEye::of_view(view, scene.transform(slot));
        let mesh = scene.mesh(slot);
        for t in 0..mesh.triangle_count() {
            counts[eye.facing(&mesh.corners(t)) as usize] += 1;
        }
    }
    counts
}

/// The shares from near and from afar, and that a closed body loses nothing that is seen.
fn about_half(lab: &Lab) -> Result<Finding, LabError> {
    let bunny = lab.model("stanford-bunny/bun_zipper_res2.ply")?;
    let named = match bunny {
        Some(bunny) => ("the bunny", bunny),
        None => ("a finer ball with knobs", lab.scene("knobs:n=40")?),
    };
    let solids = lab.scene("solids")?;
    let (mut shares, mut is_half) = (Vec::new(), true);
    for (name, model) in [("a ball with knobs", lab.scene("knobs")?), named] {
        let extent = model.scene.extent();
        let half = extent.half_extent();
        let radius = dot(half, half).sqrt();
        let [near, far] = [1.5, 50.0].map(|radii| share_away(&model.scene, radius * radii));
        let [near, far] = [near?, far?];
        is_half &= near > far && (0.48..0.53).contains(&far);
        shares.push(format!("{:.0} % and {:.1} % of {name}", near * 100.0, far * 100.0));
    }
    let lost = lost_of_solids(lab, &solids)?;
    Ok(Finding::if_so(
        is_half && lost == 0,
        format!(
            "from 1.5 and from 50 radii {} face away, more from near than from afar; of solids {lost} triangles that are seen are \
             lost with them",
            shares.join(", ")
        ),
    ))
}

/// The share of triangles that face away, on average over eyes around the scene at a distance from its middle.
fn share_away(scene: &Scene, distance: f64) -> Result<f64, LabError> {
    let middle = along(scene.origin(), 1.0, scene.extent().center());
    let (mut back, mut all) = (0, 0);
    for i in 0..8 {
        let signs = [0, 1, 2].map(|axis| if i >> axis & 1 == 1 { 1.0 } else { -1.0 });
        let eye = along(middle, distance / 3.0_f64.sqrt(), signs);
        let view = View::perspective(eye, middle, 1.0, 1e-3 * distance, f64::INFINITY, SIZE)?;
        let [front, away, edge] = facing(scene, &view);
        back += away;
        all += front + away + edge;
    }
    Ok(back as f64 / all as f64)
}

fn lost_of_solids(lab: &Lab, solids: &Model) -> Result<usize, LabError> {
    let culler = Culler::exact().only(Stage::Backface);
    let views = lab.views(solids, "orbit", 2, SIZE)?;
    Ok(views.iter().map(|view| verified(&culler, &solids.scene, view).false_culls.len()).sum())
}

/// Corners in normalised device coordinates, with y up; `None` where one is not in front of the eye.
fn on_screen(scene: &Scene, view: &View, slot: u32, t: u32) -> Option<[[f64; 2]; 3]> {
    let clip = scene.mesh(slot).corners(t).map(|p| in_clip(view, placed(scene.transform(slot), p)));
    clip.iter().all(|p| p[3] > 0.0).then(|| clip.map(|p| [p[0] / p[3], p[1] / p[3]]))
}

/// The sum over the edges of (x₂ − x₁)(y₂ + y₁): below zero where they run counter-clockwise with y up.
fn run(corners: &[[f64; 2]; 3]) -> f64 {
    (0..3)
        .map(|i| {
            let ([x1, y1], [x2, y2]) = (corners[i], corners[(i + 1) % 3]);
            (x2 - x1) * (y2 + y1)
        })
        .sum()
}

/// Which side is seen follows the order on the screen, and turns with it.
fn counter_clockwise(lab: &Lab) -> Result<Finding, LabError> {
    let model = lab.scene("solids")?;
    let scene = &model.scene;
    let (mut triangles, mut differ, mut turned, mut downward) = (0, 0, 0, 0);
    for view in lab.views(&model, "orbit", 4, SIZE)? {
        for slot in scene.slots().filter(|&slot| !scene.transform(slot).is_mirrored()) {
            let eye = ObjectEye::of_view(&view, scene.transform(slot));
            let mut clockwise = view.clone();
            clockwise.front_face = FrontFace::Clockwise;
            let other_way = ObjectEye::of_view(&clockwise, scene.transform(slot));
            for t in 0..scene.mesh(slot).triangle_count() {
                let [a, b, c] = scene.mesh(slot).corners(t);
                let (Some(corners), side) =
                    (on_screen(scene, &view, slot, t), eye.facing(&[a, b, c]))
                else {
                    continue;
                };
                // Seen from the edge, the order is one of rounding.
                if side == Facing::Edge || run(&corners).abs() < 1e-9 {
                    continue;
                }
                triangles += 1;
                differ += u32::from((side == Facing::Front) != (run(&corners) < 0.0));
                let opposite = if side == Facing::Front { Facing::Back } else { Facing::Front };
                turned += u32::from(
                    eye.facing(&[a, c, b]) == opposite && other_way.facing(&[a, b, c]) == opposite,
                );
                // Rows of pixels count down.
                let pixels = corners.map(|[x, y]| [x * 160.0, -y * 100.0]);
                downward += u32::from((side == Facing::Front) != (run(&pixels) < 0.0));
            }
        }
    }
    Ok(Finding::if_so(
        triangles > 1000 && differ == 0 && turned == triangles && downward == triangles,
        format!(
            "of {} triangles {differ} show another side than their order on the screen says; all turn when two corners or the \
             convention are exchanged, and where rows of pixels count down the order is the other one",
            grouped(triangles)
        ),
    ))
}

/// The rule as written keeps the backs and loses the fronts, in perspective and in parallel, with depth either way.
fn after_projection(lab: &Lab) -> Result<Finding, LabError> {
    let model = lab.scene("solids")?;
    let scene = &model.scene;
    let mut views = Vec::new();
    for depth in [Depth::Standard, Depth::Reversed] {
        let perspective =
            Projection::Perspective { fov_y_radians: 1.0, aspect: 1.6, near: 0.5, far: 500.0 };
        let parallel = Projection::Orthographic {
            left: -16.0,
            right: 16.0,
            bottom: -10.0,
            top: 10.0,
            near: 0.5,
            far: 500.0,
        };
        for projection in [perspective, parallel] {
            let camera = Camera::look_at([25.0, 18.0, 40.0], [0.0; 3], projection);
            views.push(View::new(&camera, depth, SIZE)?);
        }
    }
    let (mut fronts, mut lost_by_text, mut lost, mut backs_kept) = (0, 0, 0, 0);
    for view in &views {
        for slot in scene.slots().filter(|&slot| !scene.transform(slot).is_mirrored()) {
            let transform: &Transform = scene.transform(slot);
            for t in (0..scene.mesh(slot).triangle_count()).step_by(29) {
                let Some(corners) = on_screen(scene, view, slot, t) else { continue };
                let third = ndc_normal_z(&corners);
                // The oracle is exact: what is edge-on to within rounding is on one side all the same.
                if third.abs() < 1e-12 {
                    continue;
                }
                match facing_ref(view, transform, &scene.mesh(slot).corners(t)) {
                    Facing::Front => {
                        fronts += 1;
                        lost_by_text += u32::from(third >= 0.0);
                        lost += u32::from(third <= 0.0);
                    }
                    Facing::Back => backs_kept += u32::from(third > 0.0),
                    Facing::Edge => {}
                }
            }
        }
    }
    let measured = format!(
        "of {} fronts in four views the rule as written loses {}; with positive as front {lost} are lost and {backs_kept} backs kept",
        grouped(fronts),
        grouped(lost_by_text)
    );
    let shown = fronts > 1000 && lost_by_text == fronts && lost == 0 && backs_kept == 0;
    Ok(if shown { Finding::mended(measured) } else { Finding::fails(measured) })
}

/// Pictures of closed bodies are the same, of an open bowl they are not.
fn on_and_off(lab: &Lab) -> Result<Finding, LabError> {
    let model = lab.scene("solids")?;
    let (mut all, mut left, mut differ) = (0, 0, 0);
    for view in lab.views(&model, "orbit", 3, SIZE)? {
        let found = verified(&Culler::exact().only(Stage::Backface), &model.scene, &view);
        all += found.all;
        left += found.potentially_visible;
        let pairs = found.frame.ids.iter().zip(&found.culled_frame.ids);
        differ += pairs.filter(|(off, on)| off != on).count();
    }
    // A bowl: the ball without what lies above its middle, seen from above.
    let (positions, indices) = knobbly_ball(8);
    let middle = |t: &&[u32; 3]| t.iter().map(|&v| positions[v as usize][1]).sum::<f32>() < 0.0;
    let lower: Vec<u32> =
        indices.as_chunks::<3>().0.iter().filter(middle).flatten().copied().collect();
    let view = View::perspective([0.0, 3.0, 1.5], [0.0; 3], 1.0, 0.1, 10.0, SIZE)?;
    let mut pictures = Vec::new();
    for two_sided in [true, false] {
        let bowl = scene_of(mesh(positions.clone(), lower.clone(), two_sided)?)?;
        pictures.push(draw(&bowl, &view));
    }
    let inside = pictures[0].ids.iter().zip(&pictures[1].ids).filter(|(off, on)| off != on).count();
    Ok(Finding::if_so(
        differ == 0 && left < all && inside > 0,
        format!(
            "with culling {} of {} triangles of closed solids are left and {differ} pixels differ; of an open bowl {} pixels do",
            grouped(left),
            grouped(all),
            grouped(inside)
        ),
    ))
}
