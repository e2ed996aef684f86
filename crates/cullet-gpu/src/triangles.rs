//! The pass that tests the triangles of single draws, and what is left of them.
//!
//! ```text
//!  once         Triangles ──► MeshTriangles        what is known of a mesh, on the CPU and on the device
//!  each frame   TriangleView::set ──► TriangleList::set ──► TrianglePass::record ──► TriangleList::draw
//!               masks, or an eye      upload                test, scan, scatter       one indirect draw
//! ```

use wgpu::{
    BindGroup, BindGroupLayout, Buffer, BufferUsages, CommandEncoder, ComputePass,
    ComputePassDescriptor, ComputePipeline, Device, IndexFormat, Queue, RenderPass,
};

use super::buffers::{Access, buffer, buffers_layout, dispatch_rows, group, pipelines};
use super::checked::checked;
use super::error::GpuError;
use super::facing::{PlaneUniform, TriangleTest, TriangleView};
use super::lists::DrawArguments;
use super::masks::Triangles;
use super::tier::Tier;

/// The pipelines that test triangles and list what is left: eight storage buffers, no optional
/// feature.
#[derive(Debug)]
pub struct TrianglePass {
    lists: BindGroupLayout,
    masks: BindGroupLayout,
    planes: BindGroupLayout,
    count_masks: ComputePipeline,
    count_planes: ComputePipeline,
    scan: ComputePipeline,
    scatter: ComputePipeline,
}

/// The triangles of a mesh on a device, shared by all draws of it: two bytes a triangle for its
/// class, five for its plane, and twelve for its indices.
#[derive(Debug)]
pub struct MeshTriangles {
    classes: Buffer,
    planes: Buffer,
    sizes: Buffer,
    indices: Buffer,
    blocks: Buffer,
    block_count: u32,
    triangles: u32,
    groups: usize,
}

/// The triangles that a view left of one draw, and the arguments of the draw of them.
///
/// It has room for all of them, 12 bytes a triangle: none is ever left out.
#[derive(Debug)]
pub struct TriangleList {
    list: Buffer,
    arguments: Buffer,
    masks: Buffer,
    eye: Buffer,
    scratch: [Buffer; 2],
    lists_group: BindGroup,
    masks_group: BindGroup,
    planes_group: BindGroup,
    blocks: u32,
    groups: usize,
    test: TriangleTest,
}

/// Shader of a test of triangles.
macro_rules! of_triangles {
    ($test:literal) => {
        concat!(
            include_str!($test),
            include_str!("shaders/scan.wgsl"),
            include_str!("shaders/triangles.wgsl")
        )
    };
}

impl TrianglePass {
    /// Compiles the pass.
    ///
    /// # Errors
    /// If the device has not [`Tier::Compute`].
    pub fn new(device: &Device) -> Result<Self, GpuError> {
        Tier::Compute.demand(device)?;
        checked(device, || Self::compile(device))
    }

    fn compile(device: &Device) -> Self {
        use Access::{Read, Uniform, Write};
        let lists =
            buffers_layout(device, "triangles", &[Read, Read, Write, Write, Write, Write, Uniform]);
        let masks = buffers_layout(device, "classes of normals", &[Read, Read]);
        let planes = buffers_layout(device, "planes of triangles", &[Read, Read, Uniform]);
        let by_masks = of_triangles!("shaders/masks.wgsl");
        let by_planes = of_triangles!("shaders/planes.wgsl");
        let count = |source, test| {
            let [made] = pipelines(device, "triangles", source, &[&lists, test], &[], ["count"]);
            made
        };
        let (count_masks, count_planes) = (count(by_masks, &masks), count(by_planes, &planes));
        let names = ["scan", "scatter"];
        let [scan, scatter] = pipelines(device, "triangles", by_masks, &[&lists], &[], names);
        Self { lists, masks, planes, count_masks, count_planes, scan, scatter }
    }

    /// Records how lists are made, of the views that were [set](TriangleList::set) last; they are
    /// right when the pass is done.
    pub fn record<'a>(
        &self,
        encoder: &mut CommandEncoder,
        lists: impl IntoIterator<Item = &'a TriangleList> + Clone,
    ) {
        let mut pass = encoder.begin_compute_pass(&ComputePassDescriptor {
            label: Some("triangles"),
            timestamp_writes: None,
        });
        // One step of all lists after the other: what waits waits for all of them at once.
        for list in lists.clone() {
            self.count(&mut pass, list);
        }
        for list in lists.clone() {
            pass.set_bind_group(0, &list.lists_group, &[]);
            dispatch_rows(&mut pass, &self.scan, 1);
        }
        for list in lists {
            pass.set_bind_group(0, &list.lists_group, &[]);
            dispatch_rows(&mut pass, &self.scatter, list.blocks);
        }
    }

    fn count(&self, pass: &mut ComputePass<'_>, list: &TriangleList) {
        let (pipeline, test) = match list.test {
            TriangleTest::Masks => (&self.count_masks, &list.masks_group),
            TriangleTest::Planes => (&self.count_planes, &list.planes_group),
        };
        pass.set_bind_group(0, &list.lists_group, &[]);
        pass.set_bind_group(1, test, &[]);
        dispatch_rows(pass, pipeline, list.blocks);
    }
}

impl MeshTriangles {
    /// Uploads the triangles of a mesh. O(triangles).
    ///
    /// # Errors
    /// If a buffer would be larger than the device allows.
    pub fn new(device: &Device, queue: &Queue, triangles: &Triangles) -> Result<Self, GpuError> {
        let upload = |what, bytes: &[u8]| {
            let usage = BufferUsages::STORAGE | BufferUsages::COPY_DST;
            let made = buffer(device, what, bytes.len(), 1, usage)?;
            let mut words = bytes.to_vec();
            words.resize(bytes.len().next_multiple_of(4), 0);
            queue.write_buffer(&made, 0, &words);
            Ok(made)
        };
        Ok(Self {
            classes: upload("classes of normals", bytemuck::cast_slice(triangles.classes()))?,
            planes: upload("planes of triangles", triangles.planes().as_flattened())?,
            sizes: upload("sizes of triangles", triangles.sizes())?,
            indices: upload("indices of triangles", bytemuck::cast_slice(triangles.indices()))?,
            blocks: upload("blocks of triangles", bytemuck::cast_slice(triangles.blocks()))?,
            block_count: triangles.blocks().len() as u32,
            triangles: triangles.len() as u32,
            groups: triangles.groups().len(),
        })
    }

    /// Bytes that they take on the device.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        let all = [&self.classes, &self.planes, &self.sizes, &self.indices, &self.blocks];
        all.into_iter().map(Buffer::size).sum()
    }
}

impl TriangleList {
    /// Room for what is left of the triangles of a mesh, and for the masks of its groups. Of `draw`
    /// the number of instances and the base vertex are taken; a list is of one instance, for
    /// another is seen from elsewhere.
    ///
    /// # Errors
    /// If a buffer would be larger than the device allows.
    pub fn new(
        device: &Device,
        queue: &Queue,
        pass: &TrianglePass,
        mesh: &MeshTriangles,
        draw: DrawArguments,
    ) -> Result<Self, GpuError> {
        let (storage, written) = (BufferUsages::STORAGE, BufferUsages::COPY_DST);
        let read_back = storage | BufferUsages::COPY_SRC;
        let blocks = mesh.block_count as usize;
        let index = read_back | BufferUsages::INDEX;
        let list = buffer(device, "triangles that are left", mesh.triangles as usize, 12, index)?;
        let indirect = read_back | written | BufferUsages::INDIRECT;
        let size = size_of::<DrawArguments>();
        let arguments = buffer(device, "argument of a draw of triangles", 1, size, indirect)?;
        let words = buffer(device, "bits of triangles", blocks * 8, 8, storage)?;
        let places = buffer(device, "places of triangles", blocks, 4, storage)?;
        let masks = buffer(device, "masks", mesh.groups, 256, storage | written)?;
        let uniform = BufferUsages::UNIFORM | written;
        let eye = buffer(device, "eye for planes", 1, size_of::<PlaneUniform>(), uniform)?;
        let which = buffer(device, "how many blocks", 4, 4, uniform)?;
        // Nothing is drawn before the pass ran.
        let empty = DrawArguments { index_count: 0, first_index: 0, first_instance: 0, ..draw };
        queue.write_buffer(&arguments, 0, bytemuck::bytes_of(&empty));
        queue.write_buffer(&which, 0, bytemuck::cast_slice(&[mesh.block_count, 0, 0, 0]));
        let bind = |layout: &BindGroupLayout, buffers: &[&Buffer]| {
            let resources: Vec<_> = buffers.iter().map(|b| b.as_entire_binding()).collect();
            group(device, "triangles", layout, &resources)
        };
        let own = [&mesh.blocks, &mesh.indices, &words, &places, &list, &arguments, &which];
        Ok(Self {
            lists_group: bind(&pass.lists, &own),
            masks_group: bind(&pass.masks, &[&mesh.classes, &masks]),
            planes_group: bind(&pass.planes, &[&mesh.planes, &mesh.sizes, &eye]),
            list,
            arguments,
            masks,
            eye,
            scratch: [words, places],
            blocks: mesh.block_count,
            groups: mesh.groups,
            test: TriangleTest::default(),
        })
    }

    /// Uploads what a view tests with: 256 bytes a group for masks, 32 for planes. To be called
    /// before the pass is [recorded](TrianglePass::record); once between two submissions.
    ///
    /// # Panics
    /// If the view was not set for triangles in as many groups.
    pub fn set(&mut self, queue: &Queue, view: &TriangleView) {
        self.test = view.test();
        match self.test {
            TriangleTest::Masks => {
                assert_eq!(view.masks().len(), self.groups, "masks of other triangles");
                queue.write_buffer(&self.masks, 0, view.masks().as_flattened());
            }
            TriangleTest::Planes => {
                queue.write_buffer(&self.eye, 0, bytemuck::bytes_of(view.planes()));
            }
        }
    }

    /// Draws what is left, in one indirect draw, by the pipeline, bind groups and vertex buffers
    /// that are set. Instances count from 0: the vertex buffer of instances begins at the one that
    /// is drawn.
    pub fn draw(&self, pass: &mut RenderPass<'_>) {
        pass.set_index_buffer(self.list.slice(..), IndexFormat::Uint32);
        pass.draw_indexed_indirect(&self.arguments, 0);
    }

    /// Indices, u32 each, as many as the [arguments](Self::arguments) say.
    #[must_use]
    pub fn list(&self) -> &Buffer {
        &self.list
    }

    /// [`DrawArguments`], once.
    #[must_use]
    pub fn arguments(&self) -> &Buffer {
        &self.arguments
    }

    /// Bytes that it takes on the device.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        let [words, places] = &self.scratch;
        let all = [&self.list, &self.arguments, &self.masks, &self.eye, words, places];
        all.into_iter().map(Buffer::size).sum()
    }
}
