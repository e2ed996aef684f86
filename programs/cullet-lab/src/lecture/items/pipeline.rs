//! The pipeline and its slowest link.

use std::process::Command;
use std::time::Duration;

use cullet::clip::{Clipper, space};
use cullet::{Culler, DrawList, Output, Scene, Stage, View};
use cullet_command::process::cpu_time;
use cullet_draw::{PixelId, RenderOptions, Selection, render};

use crate::lecture::finding::Finding;
use crate::lecture::item::{BLANK, Item, Live, zachmann};
use crate::lecture::lab::{Lab, LabError};
use crate::lecture::tools::{
    SIZE, all_triangles, cull, cull_triangles, draw, draw_of, grouped, mesh, percent, placed,
    scene_of, sheets, times,
};

pub(super) const ITEMS: &[Item] = &[
    Item {
        number: 1,
        title: "The pipeline",
        places: &[zachmann("slide 2")],
        claim: "A frame goes through three stages: the application says what is drawn, the geometry stage works on triangles in space, \
                and the rasteriser on flat ones.",
        command: "cullet picture pipeline",
        live: Some(Live { scene: "solids:n=9", state: "clipping.open=true" }),
        chapter: "bottleneck.md",
        check: three_stages,
        ..BLANK
    },
    Item {
        number: 2,
        title: "The slowest link",
        places: &[zachmann("slide 2")],
        claim: "A pipeline has the throughput of its slowest link. So more work for that link makes frames longer, and more work for another \
                one hardly does.",
        command: "cullet profile city --already frustum",
        chapter: "bottleneck.md#the-pipeline-and-its-slowest-link",
        check: slowest_link,
        ..BLANK
    },
    Item {
        number: 3,
        title: "Fill limited",
        places: &[zachmann("slide 2")],
        claim: "The slowest link may be the rasteriser: its work is the covered samples, and so it grows with the picture's area and \
                with the layers behind each pixel, whatever the triangles.",
        command: "cullet profile fill && cullet picture depth city --path walk",
        live: Some(Live { scene: "city:cells=12,objects=1500", state: "look.colour=overdraw" }),
        chapter: "bottleneck.md#four-limits",
        check: fill_limited,
        ..BLANK
    },
    Item {
        number: 4,
        title: "Transform limited",
        places: &[zachmann("slide 2")],
        claim: "It may be the geometry stage: its work is triangles and their vertices, and it is the same for a picture of any size.",
        command: "cullet profile transform",
        live: Some(Live { scene: "city:cells=6,objects=200,sub=4", state: "look.wireframe=true" }),
        chapter: "bottleneck.md#four-limits",
        check: transform_limited,
        ..BLANK
    },
    Item {
        number: 5,
        title: "Bus limited",
        places: &[zachmann("slide 2")],
        claim: "It may be the bus between the application and the graphics hardware: its work is the bytes that a frame hands over.",
        command: "cullet profile bus",
        live: Some(Live { scene: "city:cells=12,objects=1500", state: "stages.depth=instances" }),
        chapter: "bottleneck.md#four-limits",
        check: bus_limited,
        ..BLANK
    },
    Item {
        number: 6,
        title: "CPU limited",
        places: &[zachmann("slide 2")],
        claim: "It may be the application, if the graphics card draws faster than it is told what: one knows it by a processor that is \
                fully busy. Its work is draws and tests of instances.",
        said: Some("100 % CPU usage"),
        command: "cullet profile cpu",
        live: Some(Live { scene: "city:cells=12,objects=1500", state: "always=true" }),
        chapter: "bottleneck.md#four-limits",
        check: cpu_limited,
        ..BLANK
    },
];

const CITY: &str = "city:cells=6,objects=200";
/// The same buildings, of 64 times the triangles.
const FINE: &str = "city:cells=6,objects=200,sub=8";
const OFFICE: &str = "office";

fn street(lab: &Lab, words: &str, size: [u32; 2]) -> Result<View, LabError> {
    let model = lab.scene(words)?;
    Ok(lab.views(&model, "walk", 4, size)?.swap_remove(1))
}

/// The rasteriser alone, given flat triangles with depths, fills the pixels of the whole pipeline.
fn three_stages(lab: &Lab) -> Result<Finding, LabError> {
    let mut model = cullet_scenes::build(CITY)?;
    // Which side is seen would be decided in the geometry stage as well.
    model.scene.edit_meshes(|_, mesh| mesh.set_two_sided(true));
    model.scene.commit();
    let scene = &model.scene;
    let view = street(lab, CITY, SIZE)?;
    let whole = render(scene, &view, Selection::All, &RenderOptions::default());

    let handed_on = cull(&Culler::default().only(Stage::Frustum), scene, &view);
    let (flat, sources) = flattened(scene, &view, handed_on.slots())?;
    let entered = handed_on.triangle_count;
    let screen = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0];
    let screen = View::from_matrix(screen, view.depth(), SIZE)?;
    let raster = render(&flat, &screen, Selection::All, &RenderOptions::default());
    let source = |id: &PixelId| match *id {
        PixelId::NONE => PixelId::NONE,
        id => sources[id.triangle as usize],
    };
    let alike = whole.ids.iter().zip(&raster.ids).filter(|(a, b)| **a == source(b)).count();
    let pixels = whole.ids.len();
    Ok(Finding::if_so(
        // What is as near to another surface as f32 can tell may change owners.
        alike * 1000 >= pixels * 998 && whole.stats.covered_pixels as usize * 2 > pixels,
        format!(
            "the application hands on {} of {} instances with {} triangles, the geometry stage makes {} flat ones of them, and these alone \
             give {} of {} pixels the owner that they have in the whole pipeline",
            grouped(handed_on.instance_count),
            grouped(scene.instance_count()),
            grouped(entered),
            grouped(flat.triangle_count()),
            grouped(alike),
            grouped(pixels)
        ),
    ))
}

/// The triangles of instances as the geometry stage leaves them: clipped, divided, and each with its source.
fn flattened(
    scene: &Scene,
    view: &View,
    slots: impl Iterator<Item = u32>,
) -> Result<(Scene, Vec<PixelId>), LabError> {
    let volume = space::full::<f64>(view.depth());
    let mut clipper = Clipper::new();
    let (mut positions, mut sources) = (Vec::new(), Vec::new());
    for slot in slots {
        let place = scene.transform(slot);
        let mesh = scene.mesh(slot);
        for t in 0..mesh.triangle_count() - mesh.degenerate_count() {
            let corners = mesh.corners(t).map(|p| {
                let [x, y, z] = placed(place, p);
                times(&view.clip_from_world(), [x, y, z, 1.0])
            });
            let polygon: Vec<[f32; 3]> = clipper
                .clip(&volume, &corners)
                .iter()
                .filter_map(|p| space::divide(p).map(|p| p.map(|v| v as f32)))
                .collect();
            for pair in polygon.get(1..).unwrap_or_default().windows(2) {
                positions.extend([polygon[0], pair[0], pair[1]]);
                sources.push(PixelId { slot, triangle: mesh.original_triangle()[t as usize] });
            }
        }
    }
    let indices = (0..positions.len() as u32).collect();
    Ok((scene_of(mesh(positions, indices, true)?)?, sources))
}

/// Two kinds of frames on the reference renderer: of few triangles and many samples, and the other way around.
fn slowest_link(_: &Lab) -> Result<Finding, LabError> {
    let fill = Frames::new(4, 1, [640, 400])?;
    let transform = Frames::new(1, 120, [32, 20])?;
    // Something may disturb one of the frames all the time, but not three times in a row.
    let mut ratios = [[0.0; 2]; 2];
    let mut seen = false;
    for _ in 0..3 {
        ratios = [fill.elasticity(), transform.elasticity()];
        let [[fill_area, fill_triangles], [transform_area, transform_triangles]] = ratios;
        // By how much a frame takes longer for its own link's work, and for the other's.
        let stands_out = |own: f64, other: f64| own > 1.5 && own - 1.0 > 2.0 * (other - 1.0);
        seen = stands_out(fill_area, fill_triangles)
            && stands_out(transform_triangles, transform_area);
        if seen {
            break;
        }
    }
    let [[a, b], [c, d]] = ratios;
    Ok(Finding::if_so(
        seen,
        format!(
            "on the reference renderer four layers of {} triangles take {a:.1} times as long with twice the pixels and {b:.1} times with \
             twice the triangles, and a sheet of {} on a small picture {c:.1} and {d:.1} times",
            fill.triangles,
            grouped(transform.triangles)
        ),
    ))
}

/// A frame of sheets, one behind the other, that fill the picture; with twice the pixels; and with twice the triangles on as many samples.
struct Frames {
    frames: [(Scene, View); 3],
    triangles: u64,
}

impl Frames {
    fn new(layers: u32, columns: u32, [width, height]: [u32; 2]) -> Result<Self, LabError> {
        let view = |size| View::orthographic([0.0; 3], [0.0, 0.0, -1.0], 2.0, 0.1, 10.0, size);
        let larger = [width, height].map(|v| (f64::from(v) * std::f64::consts::SQRT_2) as u32);
        let plain = || sheets(layers, [columns, columns]);
        let triangles = plain()?.triangle_count();
        let frames = [
            (plain()?, view([width, height])?),
            (plain()?, view(larger)?),
            (sheets(layers, [columns, 2 * columns])?, view([width, height])?),
        ];
        Ok(Self { frames, triangles })
    }

    /// By how much frames take longer with twice the pixels, and with twice the triangles.
    fn elasticity(&self) -> [f64; 2] {
        let mut least = [Duration::MAX; 3];
        for _ in 0..5 {
            for ((scene, view), least) in self.frames.iter().zip(&mut least) {
                // Of the processor: other programs take none of it.
                let begin = cpu_time();
                std::hint::black_box(draw(scene, view));
                *least = cpu_time().saturating_sub(begin).min(*least);
            }
        }
        let [plain, area, triangles] = least.map(|t| t.as_secs_f64());
        [area / plain, triangles / plain]
    }
}

fn fill_limited(lab: &Lab) -> Result<Finding, LabError> {
    let model = lab.scene(OFFICE)?;
    let scene = &model.scene;
    let [small, large] = [street(lab, OFFICE, SIZE)?, street(lab, OFFICE, SIZE.map(|v| 2 * v))?];
    let frustum = Culler::default().only(Stage::Frustum);
    let kept = [&small, &large].map(|view| cull_triangles(&frustum, scene, view));
    let samples = [&small, &large].map(|view| draw(scene, view).stats.fragments);
    let of = |visible| draw_of(scene, &small, Selection::Visible(visible)).stats.fragments;
    let in_view = of(&kept[0]);
    let unhidden = of(&cull_triangles(&Culler::exact(), scene, &small));
    let ratio = samples[1] as f64 / samples[0] as f64;
    let holds = (3.9..4.1).contains(&ratio)
        && kept[0].triangles == kept[1].triangles
        && in_view == samples[0]
        && unhidden < in_view;
    let counted = format!(
        "at 320×200 {} samples are covered and at 640×400 {} ({ratio:.1} times), by the same {} triangles in view of an \
         office; frustum culling takes none of those samples, all culling {}",
        grouped(samples[0]),
        grouped(samples[1]),
        grouped(kept[0].triangle_count),
        percent(in_view - unhidden, in_view)
    );
    Ok(with_profile(lab, "fill", holds, counted))
}

fn transform_limited(lab: &Lab) -> Result<Finding, LabError> {
    let [coarse, fine] = [lab.scene(CITY)?, lab.scene(FINE)?];
    let view = street(lab, CITY, SIZE)?;
    let [before, after] = [&coarse, &fine].map(|model| draw(&model.scene, &view).stats.fragments);
    let [few, many] = [&coarse, &fine].map(|model| model.scene.triangle_count());
    let kept = cull_triangles(&Culler::default(), &fine.scene, &view).triangle_count;
    let holds = many > 5 * few && before.abs_diff(after) * 1000 < before && 2 * kept < many;
    let counted = format!(
        "of {} and of {} triangles, the same city covers {} and {} samples; culling leaves {} of the latter",
        grouped(few),
        grouped(many),
        grouped(before),
        grouped(after),
        grouped(kept)
    );
    Ok(with_profile(lab, "transform", holds, counted))
}

fn bus_limited(lab: &Lab) -> Result<Finding, LabError> {
    let model = lab.scene(CITY)?;
    let scene = &model.scene;
    let [small, large] = [street(lab, CITY, SIZE)?, street(lab, CITY, SIZE.map(|v| 2 * v))?];
    // Occlusion culling sees more in a larger buffer.
    let culler = Culler::default().without(Stage::Occlusion);
    let bytes = |culler: &Culler, view: &View| {
        let visible = cull_triangles(culler, scene, view);
        let mut list = DrawList::default();
        list.fill_triangles(scene, &visible, &[]);
        let numbers = list.instances.len() + list.indices.len();
        (size_of_val(&list.commands[..]) + numbers * size_of::<u32>()) as u64
    };
    let all = bytes(&culler.only(Stage::Layer), &small);
    let [culled, on_larger] = [&small, &large].map(|view| bytes(&culler, view));
    let vertices = all_triangles(scene).len() as u64 * 3 * size_of::<[f32; 3]>() as u64;
    let holds = culled == on_larger && 2 * culled < all && all < vertices;
    let counted = format!(
        "sent as corners, all triangles are {} bytes a frame; as lists of indices into vertices that the card keeps {}, and culled {}, for \
         pictures of two sizes alike",
        grouped(vertices),
        grouped(all),
        grouped(culled)
    );
    Ok(with_profile(lab, "bus", holds, counted))
}

fn cpu_limited(lab: &Lab) -> Result<Finding, LabError> {
    let culler = Culler { output: Output::Instances, ..Culler::default().only(Stage::Frustum) };
    let view = street(lab, CITY, SIZE)?;
    let draws = |words: &str, culler: &Culler| -> Result<_, LabError> {
        let model = lab.scene(words)?;
        let visible = cull(culler, &model.scene, &view);
        let mut list = DrawList::default();
        list.fill(&model.scene, &visible, &[]);
        Ok([visible.draws(&model.scene).len(), list.commands.len()])
    };
    let nothing = culler.only(Stage::Layer);
    let [one_each, _] = draws(CITY, &nothing)?;
    let [one_each_fine, _] = draws(FINE, &nothing)?;
    let [more, _] = draws("city:cells=6,objects=400", &nothing)?;
    let [culled, batched] = draws(CITY, &culler)?;
    let holds = one_each == one_each_fine
        && more > one_each + one_each / 2
        && culled < one_each
        && batched < culled;
    let counted = format!(
        "drawn one by one, the instances of a city take {} draws, also where it has many times the triangles, and those of one twice as \
         full {}; frustum culling leaves {}, which are {} if instances of a mesh share a draw",
        grouped(one_each),
        grouped(more),
        grouped(culled),
        grouped(batched)
    );
    Ok(with_profile(lab, "cpu", holds, counted))
}

/// What was counted, and what the profiler finds where there is one with a device: of frames that have hardly any work but that of one link.
fn with_profile(lab: &Lab, link: &str, holds: bool, counted: String) -> Finding {
    let told = lab.profiler.as_ref().and_then(|program| {
        let run = Command::new(program).args(["profile", link, "--rounds", "9"]).output().ok()?;
        run.status.success().then(|| String::from_utf8_lossy(&run.stdout).into_owned())
    });
    judged(link, holds, counted, told.as_deref().and_then(sentence))
}

/// Which link a profile names, in its own words.
fn sentence(profile: &str) -> Option<&str> {
    profile.lines().map(str::trim).find(|l| l.starts_with("you are ") || l.starts_with("no link "))
}

fn judged(link: &str, holds: bool, counted: String, told: Option<&str>) -> Finding {
    match told {
        Some(told) if holds => {
            let measured = format!(
                "{counted}; of frames of hardly any other work the profiler says on this device: {told}"
            );
            // A device may be such that not even those frames wait for it, as where the bus is memory.
            let is_named = told.contains(&format!("you are {link} limited"));
            if is_named { Finding::holds(measured) } else { Finding::differs(measured) }
        }
        _ => Finding::if_so(holds, counted),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lecture::finding::Outcome;

    #[test]
    fn what_the_profiler_says_counts_beside_what_was_counted() {
        let profile =
            "fill: 3.10 ms a frame on a device, 9 rounds\n\n  fill  98 %\n\nyou are fill limited\n";
        let told = sentence(profile);
        assert_eq!(told, Some("you are fill limited"));
        let outcome = |link, holds, told| judged(link, holds, "counts".to_owned(), told).outcome;
        assert_eq!(outcome("fill", true, told), Outcome::Holds);
        assert_eq!(outcome("bus", true, told), Outcome::Differs);
        assert_eq!(outcome("fill", false, told), Outcome::Fails);
        assert_eq!(outcome("fill", true, None), Outcome::Holds);
        assert_eq!(sentence("no device"), None);
    }
}
