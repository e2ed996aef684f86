//! Buffers, layouts and pipelines of the passes.

use wgpu::{
    BindGroup, BindGroupDescriptor, BindGroupEntry, BindGroupLayout, BindGroupLayoutDescriptor,
    BindGroupLayoutEntry, BindingResource, BindingType, Buffer, BufferBindingType,
    BufferDescriptor, BufferUsages, ComputePass, ComputePipeline, ComputePipelineDescriptor,
    Device, PipelineCompilationOptions, PipelineLayoutDescriptor, ShaderModuleDescriptor,
    ShaderSource, ShaderStages,
};

use super::checked::checked;
use super::error::GpuError;
use super::tier::ROW;

/// A buffer of some items, none of which is written; at least 16 bytes.
///
/// # Errors
/// If it would be larger than a buffer, or what a shader may see of one, is on the device; or if
/// there is no memory left for it.
pub(crate) fn buffer(
    device: &Device,
    what: &'static str,
    items: usize,
    size: usize,
    usage: BufferUsages,
) -> Result<Buffer, GpuError> {
    let limits = device.limits();
    let limit = match usage.contains(BufferUsages::STORAGE) {
        true => limits.max_buffer_size.min(limits.max_storage_buffer_binding_size),
        false => limits.max_buffer_size,
    };
    let bytes = (items as u64).saturating_mul(size as u64).max(16).next_multiple_of(4);
    if bytes > limit {
        return Err(GpuError::TooLarge { what, bytes, limit });
    }
    let wanted =
        BufferDescriptor { label: Some(what), size: bytes, usage, mapped_at_creation: false };
    checked(device, || device.create_buffer(&wanted))
}

/// Access of a shader to a buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Access {
    Read,
    Write,
    Uniform,
}

impl Access {
    pub(crate) fn entry(self, binding: u32, stages: ShaderStages) -> BindGroupLayoutEntry {
        let ty = match self {
            Self::Uniform => BufferBindingType::Uniform,
            _ => BufferBindingType::Storage { read_only: self == Self::Read },
        };
        BindGroupLayoutEntry {
            binding,
            visibility: stages,
            ty: BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None },
            count: None,
        }
    }
}

/// A layout of entries.
pub(crate) fn layout(
    device: &Device,
    label: &'static str,
    entries: &[BindGroupLayoutEntry],
) -> BindGroupLayout {
    device.create_bind_group_layout(&BindGroupLayoutDescriptor { label: Some(label), entries })
}

/// A layout of buffers, with their bindings in order, as compute shaders see them.
pub(crate) fn buffers_layout(
    device: &Device,
    label: &'static str,
    access: &[Access],
) -> BindGroupLayout {
    let entry = |(binding, access): (u32, &Access)| access.entry(binding, ShaderStages::COMPUTE);
    layout(device, label, &(0..).zip(access).map(entry).collect::<Vec<_>>())
}

/// Compute pipelines of one shader, one for each name.
pub(crate) fn pipelines<const N: usize>(
    device: &Device,
    label: &'static str,
    source: &str,
    layouts: &[&BindGroupLayout],
    constants: &[(&str, f64)],
    names: [&'static str; N],
) -> [ComputePipeline; N] {
    let layouts: Vec<_> = layouts.iter().map(|layout| Some(*layout)).collect();
    let of_all = device.create_pipeline_layout(&PipelineLayoutDescriptor {
        label: Some(label),
        bind_group_layouts: &layouts,
        immediate_size: 0,
    });
    let module = device.create_shader_module(ShaderModuleDescriptor {
        label: Some(label),
        source: ShaderSource::Wgsl(format!("{source}\nconst ROW = {ROW}u;\n").into()),
    });
    names.map(|name| {
        device.create_compute_pipeline(&ComputePipelineDescriptor {
            label: Some(name),
            layout: Some(&of_all),
            module: &module,
            entry_point: Some(name),
            compilation_options: PipelineCompilationOptions {
                constants,
                ..PipelineCompilationOptions::default()
            },
            cache: None,
        })
    })
}

/// Resources in the order of their bindings.
pub(crate) fn group(
    device: &Device,
    label: &'static str,
    layout: &BindGroupLayout,
    resources: &[BindingResource<'_>],
) -> BindGroup {
    let entries: Vec<_> = (0..)
        .zip(resources)
        .map(|(binding, resource)| BindGroupEntry { binding, resource: resource.clone() })
        .collect();
    device.create_bind_group(&BindGroupDescriptor { label: Some(label), layout, entries: &entries })
}

/// Dispatches a workgroup for each of some blocks, in rows.
pub(crate) fn dispatch_rows(pass: &mut ComputePass<'_>, pipeline: &ComputePipeline, blocks: u32) {
    if blocks > 0 {
        pass.set_pipeline(pipeline);
        pass.dispatch_workgroups(blocks.min(ROW), blocks.div_ceil(ROW), 1);
    }
}
