//! Cost of the border: a frame by the C interface beside the same in Rust, in one process, turn by
//! turn.
//!
//! `cargo run --release -p cullet-c --example border -- libborder.so`, of `tests/border.c`; `cargo xtask bindings c` makes it.

use std::error::Error;
use std::ffi::{CString, c_char, c_int, c_void};
use std::time::Instant;

use engine::bounds::{Aabb, Boxes};
use engine::cull::frustum::batch::{Planes, mask_boxes, mask_words};
use engine::cull::occlusion::{Convex, OcclusionBuffer};
use engine::{
    Camera, Culler, Depth, DrawList, Instance, Mesh, MeshData, Projection, Scene, Simd, Transform,
    View, ViewState, Visible, mesh::Part,
};

unsafe extern "C" {
    fn dlopen(path: *const c_char, flags: c_int) -> *mut c_void;
    fn dlsym(library: *mut c_void, name: *const c_char) -> *mut c_void;
}

const SIDE: usize = 317;
const FRAMES: u32 = 629;

struct InRust {
    scene: Scene,
    culler: Culler,
    state: ViewState,
    visible: Visible,
    slots: Vec<u32>,
    draws: DrawList,
}

impl InRust {
    fn new() -> Result<Self, Box<dyn Error>> {
        let positions = [
            [0, 0, 0],
            [1, 0, 0],
            [1, 1, 0],
            [0, 1, 0],
            [0, 0, 1],
            [1, 0, 1],
            [1, 1, 1],
            [0, 1, 1],
        ];
        let indices = vec![
            0, 2, 1, 0, 3, 2, 4, 5, 6, 4, 6, 7, 0, 1, 5, 0, 5, 4, 3, 6, 2, 3, 7, 6, 0, 4, 7, 0, 7,
            3, 1, 2, 6, 1, 6, 5,
        ];
        let positions = positions.map(|p| p.map(|v: u8| f32::from(v))).to_vec();
        let parts = vec![Part { triangle_count: 12, ..Part::default() }];
        let mut scene = Scene::new();
        let mesh = scene.add_mesh(Mesh::new(MeshData {
            positions,
            indices,
            parts,
            ..MeshData::default()
        })?);
        for i in 0..SIDE * SIDE {
            let at = [3.0 * (i % SIDE) as f64, 0.0, 3.0 * (i / SIDE) as f64];
            scene.add(Instance::new(mesh, Transform::from_translation(at)))?;
        }
        scene.commit(&Culler::default());
        let (culler, state, visible) =
            (Culler::balanced(), ViewState::default(), Visible::default());
        Ok(Self { scene, culler, state, visible, slots: Vec::new(), draws: DrawList::default() })
    }

    fn frame(&mut self, frame: u32) -> Result<usize, Box<dyn Error>> {
        let view = view(frame, 20.0)?;
        self.culler.cull_one(&self.scene, &view, &mut self.state, &mut self.visible);
        self.slots.clear();
        self.slots.extend(self.visible.slots());
        self.draws.fill(&self.scene, &self.visible, &[])?;
        Ok(self.slots.len())
    }
}

/// The view of a frame, from the middle of the place at a height.
fn view(frame: u32, height: f64) -> Result<View, Box<dyn Error>> {
    let (angle, middle) = (0.01 * f64::from(frame), 1.5 * SIDE as f64);
    let target = [middle + 100.0 * angle.cos(), 0.0, middle + 100.0 * angle.sin()];
    let projection = Projection::Perspective {
        fov_y_radians: 0.9,
        aspect: 1280.0 / 720.0,
        near: 0.1,
        far: f64::INFINITY,
    };
    let camera = Camera::look_at([middle, height, middle], target, projection);
    Ok(View::new(&camera, Depth::Reversed, [1280, 720])?)
}

/// Boxes alone, over slices.
struct Slices {
    given: Vec<Aabb>,
    boxes: Boxes,
    walls: Vec<Convex>,
    buffer: OcclusionBuffer,
    words: [Vec<u64>; 3],
    flags: Vec<u8>,
}

impl Slices {
    fn new() -> Result<Self, Box<dyn Error>> {
        let place = |i: usize, side: usize, step: f32| {
            [step * (i % side) as f32, 0.0, step * (i / side) as f32]
        };
        let given: Vec<_> = (0..SIDE * SIDE)
            .map(|i| place(i, SIDE, 3.0))
            .map(|[x, _, z]| Aabb::new([x, 0.0, z], [x + 1.0, 1.0, z + 1.0]))
            .collect();
        let walls = (0..64)
            .map(|i| place(i, 8, 118.0))
            .map(|[x, _, z]| Convex::from_box(&Aabb::new([x, 0.0, z], [x + 40.0, 9.0, z + 2.0])));
        let words = [(); 3].map(|()| vec![0; mask_words(given.len())]);
        Ok(Self {
            boxes: Boxes::from_slice(&given),
            walls: walls.collect::<Result<_, _>>()?,
            buffer: OcclusionBuffer::new([640, 360])?,
            flags: vec![0; given.len()],
            given,
            words,
        })
    }

    fn frame(&mut self, frame: u32, sets: bool) -> Result<usize, Box<dyn Error>> {
        let (simd, view) = (Simd::best(), view(frame, 5.0)?);
        if sets {
            self.boxes.clear();
            self.boxes.extend_from_slice(&self.given);
        }
        let [within, visible, hidden] = &mut self.words;
        mask_boxes(simd, &Planes::new(&view.frustum()), &self.boxes, 0, within);
        self.buffer.begin(&view, [0.0; 3]);
        for wall in &self.walls {
            wall.draw(simd, &mut self.buffer, &Transform::IDENTITY);
        }
        self.buffer.test_boxes(simd, &self.boxes, 0, within, visible, hidden);
        for (flags, word) in self.flags.chunks_mut(64).zip(&*visible) {
            for (bit, flag) in flags.iter_mut().enumerate() {
                *flag = (word >> bit & 1) as u8;
            }
        }
        Ok(visible.iter().map(|word| word.count_ones() as usize).sum())
    }
}

/// Runs frames in Rust and in C, turn by turn, and prints the median of each.
fn compare(
    what: &str,
    mut in_rust: impl FnMut(u32) -> Result<usize, Box<dyn Error>>,
    in_c: impl Fn(u32) -> usize,
) -> Result<(), Box<dyn Error>> {
    let mut times = [Vec::new(), Vec::new()];
    let mut visible = 0;
    for round in 0..6 {
        for frame in 0..FRAMES {
            // Neither always runs in caches that the other warmed.
            let mut counts = [0; 2];
            for turn in 0..2 {
                let which = (frame as usize + turn) % 2;
                let start = Instant::now();
                counts[which] = if which == 0 { in_rust(frame)? } else { in_c(frame) };
                if round > 0 {
                    times[which].push(start.elapsed().as_secs_f64() * 1e6);
                }
            }
            if counts[0] != counts[1] {
                let [rust, c] = counts;
                return Err(format!("{what}, frame {frame}: {rust} in Rust, {c} in C").into());
            }
            visible += counts[0];
        }
    }
    let [rust, c] = times.map(|mut all| {
        all.sort_by(f64::total_cmp);
        all[all.len() / 2]
    });
    println!(
        "{what} of {}, {} visible: Rust {rust:.1} us, C {c:.1} us, {:.3} times",
        SIDE * SIDE,
        visible / (6 * FRAMES as usize),
        c / rust
    );
    Ok(())
}

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).ok_or("border LIBRARY: the one made of tests/border.c")?;
    let path = CString::new(path)?;
    // SAFETY: the text ends with 0; 2 is RTLD_NOW.
    let library = unsafe { dlopen(path.as_ptr(), 2) };
    if library.is_null() {
        return Err("the library cannot be opened: is libcullet.so.0 in LD_LIBRARY_PATH?".into());
    }
    // SAFETY: the library is open, and never closed.
    let symbols = [c"border_setup", c"border_frame", c"boxes_setup", c"boxes_frame"]
        .map(|name| unsafe { dlsym(library, name.as_ptr()) });
    if symbols.iter().any(|s| s.is_null()) {
        return Err("the library is not that of tests/border.c".into());
    }
    // SAFETY: this is what border.c declares.
    let setups: [extern "C" fn(); 2] =
        [symbols[0], symbols[2]].map(|symbol| unsafe { std::mem::transmute(symbol) });
    // SAFETY: this is what border.c declares.
    let in_c: extern "C" fn(u32) -> usize = unsafe { std::mem::transmute(symbols[1]) };
    // SAFETY: this is what border.c declares.
    let boxes_in_c: extern "C" fn(u32, u32) -> usize = unsafe { std::mem::transmute(symbols[3]) };
    setups.iter().for_each(|setup| setup());
    let mut in_rust = InRust::new()?;
    compare("a frame of instances", |frame| in_rust.frame(frame), |frame| in_c(frame))?;
    let mut slices = Slices::new()?;
    for (what, sets) in [("a cull of boxes", false), ("setting and culling boxes", true)] {
        let in_c = |frame| boxes_in_c(frame, sets.into());
        compare(what, |frame| slices.frame(frame, sets), in_c)?;
    }
    Ok(())
}
