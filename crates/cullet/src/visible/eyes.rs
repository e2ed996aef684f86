//! Instances that each eye of a headset may see.

use super::Visible;
use crate::bits;
use crate::bounds::Side;
use crate::cull::frustum::batch::Planes;
use crate::scene::Scene;
use crate::view::View;

impl Visible {
    /// Returns the visible slots of a [stereo](View::stereo) view, each with the eyes in whose
    /// frustum it may be: bit 0 for `left`, bit 1 for `right`, at least one of them. A renderer
    /// that draws both eyes at once needs the slots alone.
    pub fn by_eye<'a>(
        &'a self,
        scene: &'a Scene,
        left: &View,
        right: &View,
    ) -> impl Iterator<Item = (u32, u8)> + 'a {
        let planes =
            [left, right].map(|eye| Planes::new(&eye.frustum().relative_to(scene.origin())));
        self.slots().map(move |slot| {
            let is_exempt = bits::get(scene.exempt(), slot as usize);
            let is_in = |eye: usize| {
                is_exempt
                    || planes[eye].classify_stored(scene.boxes(), slot as usize) != Side::Outside
            };
            let found = u8::from(is_in(0)) | u8::from(is_in(1)) << 1;
            // Between the two, in the frustum around both.
            (slot, if found == 0 { 3 } else { found })
        })
    }
}
