//! Claims of the occlusion buffer, held against samples of what was drawn into it.

use cullet::Simd;
use cullet::cull::occlusion::OcclusionBuffer;
use cullet_lab::claims::{ClaimOptions, Claims, SceneOccluders, check_claims};
use cullet_scenes::adversaries::adversary;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // Walls with hairline gaps between them; any scene and view will do.
    let walls = adversary(3, 1, 1, [320, 180]);
    let view = &walls.views[0];

    let occluders = SceneOccluders::new(&walls.scene);
    let mut buffer = OcclusionBuffer::new(view.viewport())?;
    occluders.draw(view, Simd::best(), &mut buffer);
    let mut claims = Claims::of(&buffer);
    let triangles = occluders.triangles(view);
    let check = check_claims(view, &claims, &triangles, &ClaimOptions::default());
    println!("{}: {} of {} pixels claimed", walls.name, check.claimed, check.pixels);
    assert_eq!(check.wrong, 0, "{:?}", check.first);

    // Had the buffer closed the gaps, which are open pixels between two that are covered:
    for y in 0..180 {
        for x in 1..319 {
            let beside = claims.nearness(x - 1, y).min(buffer.nearness(x + 1, y));
            if buffer.nearness(x, y) == 0.0 {
                claims.claim(x, y, beside);
            }
        }
    }
    let check = check_claims(view, &claims, &triangles, &ClaimOptions::default());
    println!("with the gaps closed: {} wrong, such as {:?}", check.wrong, check.first.first());
    Ok(())
}
