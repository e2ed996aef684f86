//! Creation of objects on a device, with a check that it succeeded.

use wgpu::{BufferDescriptor, BufferUsages, Device, Error, ErrorFilter, MapMode};

use super::error::GpuError;
use super::read_back::wait;

/// Returns what `make` makes, or an error if the device says that it is not valid or has no room
/// for it. In a browser, which does not allow waiting, the device reports that later to the
/// listeners of its errors.
pub(crate) fn checked<T>(device: &Device, make: impl FnOnce() -> T) -> Result<T, GpuError> {
    if cfg!(target_arch = "wasm32") {
        return Ok(make());
    }
    wait(checked_later(device, make))
}

/// The same, awaited: for browsers too.
pub(crate) async fn checked_later<T>(
    device: &Device,
    make: impl FnOnce() -> T,
) -> Result<T, GpuError> {
    let memory = device.push_error_scope(ErrorFilter::OutOfMemory);
    // What a driver does not link is an internal error.
    let internal = device.push_error_scope(ErrorFilter::Internal);
    let validation = device.push_error_scope(ErrorFilter::Validation);
    let made = make();
    // The last that began ends first; they end here, and what they found is known later.
    let (validation, internal, memory) = (validation.pop(), internal.pop(), memory.pop());
    // Without memory what is made of it is not valid either: the cause is told.
    let found = [memory.await, validation.await, internal.await];
    let Some(error) = found.into_iter().flatten().next() else { return Ok(made) };
    Err(match refusal(&error) {
        GpuError::Refused(why) if is_lost(device).await => GpuError::Lost(why),
        GpuError::Refused(why) => GpuError::Passes(why),
        other => other,
    })
}

/// Converts an error of wgpu.
pub(crate) fn refusal(error: &Error) -> GpuError {
    let why = innermost(error);
    match error {
        Error::OutOfMemory { .. } => GpuError::OutOfMemory(why),
        _ => GpuError::Refused(why),
    }
}

/// Whether not even four bytes can be made any more: a lost device says nothing when it makes a
/// buffer, only when that is used.
async fn is_lost(device: &Device) -> bool {
    let memory = device.push_error_scope(ErrorFilter::OutOfMemory);
    let validation = device.push_error_scope(ErrorFilter::Validation);
    let four = device.create_buffer(&BufferDescriptor {
        label: Some("four bytes"),
        size: 4,
        usage: BufferUsages::MAP_WRITE,
        mapped_at_creation: false,
    });
    four.map_async(MapMode::Write, .., |_| {});
    let (validation, memory) = (validation.pop(), memory.pop());
    validation.await.is_some() && memory.await.is_none()
}

/// Returns what `make` makes, valid or not: errors are ignored.
pub(crate) fn unchecked<T>(device: &Device, make: impl FnOnce() -> T) -> T {
    let internal = device.push_error_scope(ErrorFilter::Internal);
    let validation = device.push_error_scope(ErrorFilter::Validation);
    let made = make();
    // The last that began ends first.
    drop(validation);
    drop(internal);
    made
}

/// Returns the root cause of an error.
fn innermost(error: &dyn std::error::Error) -> String {
    error.source().map_or_else(|| error.to_string(), innermost)
}

#[cfg(test)]
mod tests {
    use wgpu::{Extent3d, TextureDescriptor, TextureDimension, TextureFormat, TextureUsages};

    use super::*;
    use crate::buffers::{buffers_layout, pipelines};
    use crate::device::Gpu;
    use crate::testing;
    use crate::tier::Tier;

    #[test]
    fn what_there_is_no_memory_for_is_an_error() {
        // What a device says that has none left. Whether one says it of terabytes is its own
        // affair: some give out memory that they do not have.
        let full = Error::OutOfMemory { source: "no room for a texture".into() };
        let told = refusal(&full);
        assert!(matches!(&told, GpuError::OutOfMemory(why) if why.contains("a texture")), "{told}");
        assert!(told.to_string().contains("let the CPU decide"), "{told}");

        let Some(_) = testing::device(Tier::Draw, cullet_testkit::skip) else { return };
        let gpu = Gpu::open(Tier::Draw).unwrap();
        let limits = gpu.device.limits();
        let side = limits.max_texture_dimension_2d;
        let size = Extent3d {
            width: side,
            height: side,
            depth_or_array_layers: limits.max_texture_array_layers,
        };
        let make = || {
            gpu.device.create_texture(&TextureDescriptor {
                label: Some("more than there is"),
                size,
                mip_level_count: 1,
                sample_count: 1,
                dimension: TextureDimension::D2,
                format: TextureFormat::Rgba32Float,
                usage: TextureUsages::TEXTURE_BINDING,
                view_formats: &[],
            })
        };
        let made = checked(&gpu.device, make);
        assert!(matches!(made, Ok(_) | Err(GpuError::OutOfMemory(_))), "{made:?}");
        drop(made);
        // The device is there, and small things find room.
        assert!(!wait(is_lost(&gpu.device)));
        gpu.finish().unwrap();
        gpu.device.destroy();
        assert!(wait(is_lost(&gpu.device)));
    }

    #[test]
    fn a_shader_that_does_not_compile_is_an_error_with_its_cause() {
        let Some(gpu) = testing::device(Tier::Compute, cullet_testkit::skip) else { return };
        let compile = |source: &str| {
            let layout = buffers_layout(&gpu.device, "broken", &[]);
            let make = || pipelines(&gpu.device, "broken", source, &[&layout], &[], ["main"]);
            checked(&gpu.device, make).map(|_| ())
        };
        let good = "@compute @workgroup_size(1) fn main() {}";
        compile(good).unwrap();
        for (source, cause) in [
            ("@compute fn main( {}", "expected"),
            ("@compute @workgroup_size(1) fn main() { let a: u32 = 1.5; }", "a"),
            ("@compute @workgroup_size(1) fn other() {}", "main"),
            ("@compute @workgroup_size(9999) fn main() {}", "9999"),
        ] {
            let told = compile(source).unwrap_err();
            assert!(matches!(&told, GpuError::Passes(why) if why.contains(cause)), "{told}");
        }
        // What came before is as it was.
        compile(good).unwrap();
    }

    #[test]
    fn what_no_scope_catches_is_an_error_of_whoever_waits_and_told_once() {
        let Some(_) = testing::device(Tier::Draw, cullet_testkit::skip) else { return };
        let gpu = Gpu::open(Tier::Draw).unwrap();
        let odd = BufferUsages::MAP_READ | BufferUsages::MAP_WRITE | BufferUsages::COPY_SRC;
        let wanted =
            BufferDescriptor { label: None, size: 4, usage: odd, mapped_at_creation: false };
        let buffer = gpu.device.create_buffer(&wanted);
        let told = gpu.finish().unwrap_err();
        assert!(matches!(told, GpuError::Refused(_)), "{told}");
        gpu.finish().unwrap();
        assert!(gpu.read(&buffer, 4).is_err(), "nothing can be read from what was refused");
    }
}
