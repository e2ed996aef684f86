//! A cluster, the eyes from which all of it faces away, and an eye that goes round.

use crate::teach::CullingVolume;
use cullet_command::exit::Failure;
use cullet_draw::Picture;
use cullet_io::Model;

use super::args::FilmArgs;
use super::script::Script;

/// The film.
pub(super) struct Volume<'a> {
    volume: CullingVolume<'a>,
    size: [u32; 2],
}

impl<'a> Volume<'a> {
    pub(super) fn new(model: &'a Model, args: &FilmArgs) -> Result<Self, Failure> {
        let scene = &model.scene;
        let of = |slot: u32| CullingVolume::new(scene, slot, args.cluster);
        let found = match args.cluster {
            Some(_) => scene.slots().next().and_then(of),
            None => scene.slots().find_map(of),
        };
        let volume = found.ok_or_else(|| match args.cluster {
            Some(n) => Failure::usage(format!(
                "--cluster {n}: the first mesh has none of that number, or from no eye near it do all of its triangles \
                 face away; leave it out to take the widest that has a volume"
            )),
            None => Failure::input(format!(
                "{}: no cluster has a culling volume: try a model of more triangles, such as knobs, or --one-sided for \
                 a scan with holes",
                model.name
            )),
        })?;
        Ok(Self { volume: volume.around_mesh(), size: args.size })
    }
}

impl Script for Volume<'_> {
    fn frame(&mut self, share: f64) -> Result<Picture, Failure> {
        let eye = self.volume.circle(share);
        let (mut picture, [ideal, proved]) = self.volume.seen_by(eye, self.size);
        let words = match (ideal, proved) {
            (_, true) => "the eye is in the volume: the cluster is culled as a whole",
            (true, _) => {
                "all of it faces away, but the bound does not prove it: its triangles are tested"
            }
            _ => "some of the cluster may face the eye: its triangles are tested",
        };
        cullet_draw::caption(&mut picture, words);
        Ok(picture)
    }
}
