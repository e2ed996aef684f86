//! Capability tiers of graphics devices.

use std::fmt;

use wgpu::{Adapter, AdapterInfo, Backend, Device, DownlevelFlags, Features, Limits};

/// Workgroups in a row of a dispatch, in all shaders too: 65,535 are the most along one dimension.
pub(crate) const ROW: u32 = 32768;

/// Items that a workgroup takes.
pub(crate) const GROUP: u32 = 256;

/// Storage buffers of the pass that binds most.
const STORAGE_BUFFERS: u32 = 8;

/// Flags of [`Tier::Compute`]. Vertex shaders read the places of instances from a storage buffer.
const COMPUTE: DownlevelFlags = DownlevelFlags::COMPUTE_SHADERS
    .union(DownlevelFlags::INDIRECT_EXECUTION)
    .union(DownlevelFlags::VERTEX_STORAGE);

/// Capability of a graphics device. Each tier has all of the one before.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Tier {
    /// Draws what the CPU lists: every device, WebGL2 too.
    Draw,
    /// Lists what is in the view, by compute passes and indirect draws: OpenGL 4.3 too.
    Compute,
    /// Culls what is hidden, against a pyramid of depth that compute passes make: every device of
    /// Vulkan, Metal, DirectX 12 and WebGPU. Not OpenGL, where no shader that reads a depth texture
    /// compiles.
    Pyramid,
    /// Takes many draws in one call, which [`Features::INDIRECT_FIRST_INSTANCE`] makes possible.
    MultiDraw,
    /// Reads the number of draws from a buffer ([`Features::MULTI_DRAW_INDIRECT_COUNT`]): Vulkan
    /// and DirectX 12.
    MultiDrawCount,
}

/// Capability that a device lacks for a tier.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Lack {
    /// Capabilities that every device for WebGPU has.
    #[error("it has no {0:?}")]
    Flags(DownlevelFlags),
    /// A limit is too low.
    #[error("it has {limit} {what}, and {needed} are needed")]
    Limit {
        /// Name of the limit.
        what: &'static str,
        /// The number that the passes need.
        needed: u32,
        /// The number that the device has.
        limit: u32,
    },
    /// Compute shaders that read depth textures do not compile for OpenGL.
    #[error("compute shaders cannot read depth textures")]
    Depth,
    /// Optional features, absent or not asked for when the device was opened.
    #[error("it has no {0:?}")]
    Features(Features),
}

/// Offers of a device, from which tiers are derived.
struct Offered {
    backend: Backend,
    features: Features,
    limits: Limits,
    flags: DownlevelFlags,
}

impl Tier {
    /// All tiers, the least first.
    pub const ALL: [Self; 5] =
        [Self::Draw, Self::Compute, Self::Pyramid, Self::MultiDraw, Self::MultiDrawCount];

    /// Returns the highest tier of an opened device. It may be lower than its adapter's, which was
    /// perhaps opened with less.
    #[must_use]
    pub fn of(device: &Device) -> Self {
        Offered::by_device(device).highest()
    }

    /// Returns the highest tier that a device of this adapter can have.
    #[must_use]
    pub fn of_adapter(adapter: &Adapter) -> Self {
        Offered::by_adapter(adapter).highest()
    }

    /// Returns what an adapter lacks for this tier, or `None`.
    #[must_use]
    pub fn lack(self, adapter: &Adapter) -> Option<Lack> {
        Offered::by_adapter(adapter).lack(self)
    }

    /// Returns what an opened device lacks of this tier, if anything.
    pub(crate) fn lack_of_device(self, device: &Device) -> Option<Lack> {
        Offered::by_device(device).lack(self)
    }

    /// Returns the optional features that a device of this tier is opened with.
    #[must_use]
    pub const fn features(self) -> Features {
        match self {
            Self::Draw | Self::Compute | Self::Pyramid => Features::empty(),
            Self::MultiDraw => Features::INDIRECT_FIRST_INSTANCE,
            Self::MultiDrawCount => {
                Features::INDIRECT_FIRST_INSTANCE.union(Features::MULTI_DRAW_INDIRECT_COUNT)
            }
        }
    }

    /// Returns the tier's name in the environment (`CULLET_REQUIRE_GPU`).
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Draw => "draw",
            Self::Compute => "compute",
            Self::Pyramid => "pyramid",
            Self::MultiDraw => "multi-draw",
            Self::MultiDrawCount => "multi-draw-count",
        }
    }
}

impl fmt::Display for Tier {
    /// Writes what the tier can do, to follow "can".
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Draw => "draw",
            Self::Compute => "run compute passes",
            Self::Pyramid => "read depth in compute passes",
            Self::MultiDraw => "take many draws in one call",
            Self::MultiDrawCount => "read the number of draws from a buffer",
        })
    }
}

impl Offered {
    fn by_adapter(adapter: &Adapter) -> Self {
        Self {
            backend: adapter.get_info().backend,
            features: adapter.features(),
            limits: adapter.limits(),
            flags: adapter.get_downlevel_capabilities().flags,
        }
    }

    /// A device does not tell its flags. Where it has no compute shaders, its limits of them are 0.
    /// So a device of WebGL2 has no more than the first tier, and a browser's need not be asked
    /// which it is: not all browsers answer.
    fn by_device(device: &Device) -> Self {
        let backend = match cfg!(target_arch = "wasm32") {
            true => Backend::BrowserWebGpu,
            false => device.adapter_info().backend,
        };
        Self { backend, features: device.features(), limits: device.limits(), flags: COMPUTE }
    }

    fn highest(&self) -> Tier {
        let has = |tier: &Tier| self.own_lack(*tier).is_none();
        Tier::ALL.into_iter().take_while(has).last().unwrap_or(Tier::Draw)
    }

    fn lack(&self, tier: Tier) -> Option<Lack> {
        Tier::ALL.into_iter().filter(|t| *t <= tier).find_map(|t| self.own_lack(t))
    }

    /// Returns what is missing for a tier beyond the needs of the tiers before.
    fn own_lack(&self, tier: Tier) -> Option<Lack> {
        match tier {
            Tier::Draw => None,
            Tier::Compute => {
                let missing = COMPUTE - self.flags;
                let flags = (!missing.is_empty()).then_some(Lack::Flags(missing));
                flags.or_else(|| self.low_limit())
            }
            Tier::Pyramid => (self.backend == Backend::Gl).then_some(Lack::Depth),
            Tier::MultiDraw | Tier::MultiDrawCount => {
                let missing = tier.features() - self.features;
                (!missing.is_empty()).then_some(Lack::Features(missing))
            }
        }
    }

    /// The first limit below what the passes take, which is no more than any device for
    /// [WebGPU](https://www.w3.org/TR/webgpu/#limits) has.
    fn low_limit(&self) -> Option<Lack> {
        let own = &self.limits;
        let taken = [
            (
                "storage buffers a shader stage",
                STORAGE_BUFFERS,
                own.max_storage_buffers_per_shader_stage,
            ),
            ("invocations a workgroup", GROUP, own.max_compute_invocations_per_workgroup),
            ("invocations of a workgroup along x", GROUP, own.max_compute_workgroup_size_x),
            ("workgroups a dimension", ROW, own.max_compute_workgroups_per_dimension),
            ("storage textures a shader stage", 1, own.max_storage_textures_per_shader_stage),
        ];
        let low = taken.into_iter().find(|(_, needed, limit)| limit < needed);
        low.map(|(what, needed, limit)| Lack::Limit { what, needed, limit })
    }
}

/// Describes an adapter for a message.
pub(crate) fn described(info: &AdapterInfo) -> String {
    let backend = match info.backend {
        Backend::Gl => "OpenGL".to_owned(),
        Backend::Dx12 => "DirectX 12".to_owned(),
        Backend::BrowserWebGpu => "WebGPU".to_owned(),
        other => format!("{other:?}"),
    };
    match info.name.as_str() {
        "" => backend,
        name => format!("{name} by {backend}"),
    }
}

/// Says how a better adapter is had on this machine.
pub(crate) fn cure() -> String {
    let install = match cfg!(target_os = "linux") {
        true => {
            "install a driver of Vulkan (Debian: apt-get install mesa-vulkan-drivers libvulkan1; software will do)"
        }
        false => "install the newest graphics driver",
    };
    match std::env::var("WGPU_BACKEND") {
        Ok(own) => {
            format!(
                "unset WGPU_BACKEND, which is '{own}' and leaves other backends out, or {install}"
            )
        }
        Err(_) => install.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn offered(backend: Backend, features: Features) -> Offered {
        Offered { backend, features, limits: Limits::default(), flags: DownlevelFlags::all() }
    }

    #[test]
    fn each_tier_is_a_superset_of_the_one_before() {
        let count = Tier::MultiDrawCount.features();
        let all = [
            (offered(Backend::Vulkan, count), Tier::MultiDrawCount),
            (offered(Backend::Metal, Tier::MultiDraw.features()), Tier::MultiDraw),
            (offered(Backend::BrowserWebGpu, Features::empty()), Tier::Pyramid),
            // A feature of a higher tier counts for nothing without the tiers below.
            (offered(Backend::Vulkan, Features::MULTI_DRAW_INDIRECT_COUNT), Tier::Pyramid),
            (offered(Backend::Gl, count), Tier::Compute),
            (Offered { flags: DownlevelFlags::empty(), ..offered(Backend::Gl, count) }, Tier::Draw),
        ];
        for (offered, highest) in all {
            assert_eq!(offered.highest(), highest);
            for tier in Tier::ALL {
                assert_eq!(offered.lack(tier).is_none(), tier <= highest, "{tier:?}");
            }
        }
    }

    #[test]
    fn what_is_missing_is_the_least_that_is() {
        let gl = offered(Backend::Gl, Features::empty());
        assert_eq!(gl.lack(Tier::MultiDrawCount), Some(Lack::Depth));
        let limits = Limits { max_storage_buffers_per_shader_stage: 4, ..Limits::default() };
        let few = Offered { limits, ..offered(Backend::Vulkan, Features::all()) };
        let Some(lack @ Lack::Limit { needed: 8, limit: 4, .. }) = few.lack(Tier::Pyramid) else {
            panic!("{:?}", few.lack(Tier::Pyramid))
        };
        assert!(lack.to_string().contains("4 storage buffers a shader stage"), "{lack}");
        let webgl = Limits::downlevel_webgl2_defaults();
        let webgl = Offered { limits: webgl, ..offered(Backend::Gl, Features::empty()) };
        assert_eq!(webgl.highest(), Tier::Draw);
        let plain = offered(Backend::Vulkan, Features::empty());
        let lack = plain.lack(Tier::MultiDrawCount);
        assert_eq!(lack, Some(Lack::Features(Features::INDIRECT_FIRST_INSTANCE)));
    }
}
