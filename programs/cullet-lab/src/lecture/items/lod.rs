//! Levels of detail.

mod impostor;
mod levels;
mod popping;

use crate::lecture::item::{BLANK, Item, Live, ucsd};

pub(super) const ITEMS: &[Item] = &[
    Item {
        number: 80,
        title: "Small features pop",
        places: &[ucsd("Level-of-Detail Techniques")],
        claim: "What is smaller than a threshold is not drawn. As the eye moves, instances come and go at once: they pop.",
        command: "cullet verify city --detail 8 --views 4",
        live: Some(Live {
            scene: "city",
            state: "stages.detail_px=8&look.colour=pops&stages.detail_fade=0.5",
        }),
        chapter: "popping.md#cures",
        check: popping::popping,
        ..BLANK
    },
    Item {
        number: 81,
        title: "Impostors",
        places: &[ucsd("Level-of-Detail Techniques")],
        claim: "Far away a picture of an instance, as a texture on planes, stands for its triangles.",
        command: "cullet picture impostor knobs",
        chapter: "impostors.md#the-error",
        check: impostor::impostor,
        ..BLANK
    },
    Item {
        number: 82,
        title: "Triangles by the size on the screen",
        places: &[ucsd("Level-of-Detail Techniques"), ucsd("Size dependent mesh reduction")],
        claim: "The smaller a model is on the screen, the fewer triangles are enough for it, as a row of armadillos shows that become \
                smaller and coarser.",
        command: "cullet reproduce mesh-reduction --model armadillo.obj",
        live: Some(Live {
            scene: "city",
            state: "stages.lod_px=1&look.colour=levels&look.wireframe=true",
        }),
        chapter: "popping.md#the-row-of-the-lectures",
        check: levels::by_size,
        ..BLANK
    },
];
