//! Costs of tests and of drawing: the only way in which time enters a decision.

use thiserror::Error;

use crate::mesh::Alpha;

/// Costs of tests and of drawing on a machine with a renderer, in nanoseconds. Plain data that the caller
/// passes in: nothing here reads a clock, so the same costs give the same decisions anywhere. The program
/// `cullet calibrate` measures them.
///
/// Times are of one thread. They scale what is decided and never what is right: with any values every
/// exact test stays conservative. All must be finite, above 0 and at most [`Self::MOST_NS`];
/// [`Self::check`] says which is not.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Costs {
    /// The frustum test of one object's box, in a batch.
    pub object_test_ns: f64,
    /// t: the back-face test of one cluster's elliptic cone, in a batch.
    pub cluster_test_ns: f64,
    /// The back-face test of one triangle's 8-bit plane, in a batch.
    pub triangle_test_ns: f64,
    /// Cost to the renderer of a triangle that it rejects by itself, because it faces away: what
    /// culling saves it there. It fills no pixel.
    pub rejected_triangle_ns: f64,
    /// r: an opaque triangle drawn, pixels apart.
    pub opaque_triangle_ns: f64,
    /// An alpha-masked triangle drawn, pixels apart.
    pub masked_triangle_ns: f64,
    /// A blended triangle drawn, pixels apart.
    pub blended_triangle_ns: f64,
    /// One more instance, or range of triangles, drawn by itself: a draw call.
    pub draw_ns: f64,
    /// Occlusion culling itself. `cullet calibrate` leaves them at their default, for which occluders are chosen
    /// depends on them: with the same costs the same ones are, on every machine.
    #[cfg_attr(feature = "serde", serde(default))]
    pub occluders: OccluderCosts,
}

impl Default for Costs {
    /// A renderer on a GPU, as a guess and not a measurement: ten nanoseconds a triangle with its share of the pixels, a
    /// microsecond a draw. The tests are those of `cullet calibrate` on one machine of 2026, in whole or half nanoseconds.
    fn default() -> Self {
        Self {
            object_test_ns: 0.5,
            cluster_test_ns: 0.5,
            triangle_test_ns: 0.2,
            rejected_triangle_ns: 1.0,
            opaque_triangle_ns: 10.0,
            masked_triangle_ns: 10.0,
            blended_triangle_ns: 10.0,
            draw_ns: 1000.0,
            occluders: OccluderCosts::default(),
        }
    }
}

/// Costs of occlusion culling: of drawing occluders of each kind, and of testing. [`Culler::costs`](crate::Culler::costs)
/// has the choice of occluders go by them, and whether there is one.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct OccluderCosts {
    /// Convex bodies and polygons.
    pub convex: DrawingCosts,
    /// Patches of a surface.
    pub patch: DrawingCosts,
    /// Looking at a shape, whether it is chosen or not.
    pub look_ns: f64,
    /// Testing an instance or a cluster, its share of the nodes above it included.
    pub test_ns: f64,
    /// Emptying the buffer and taking samples of what is left, however little that is.
    pub begin_ns: f64,
}

/// Costs of drawing one shape into an occlusion buffer, in nanoseconds: `base_ns` + `edge_ns` · its edges + `outline_ns` ·
/// √ its pixels + `pixel_ns` · its pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct DrawingCosts {
    /// However small it is.
    pub base_ns: f64,
    /// For each edge.
    pub edge_ns: f64,
    /// For each pixel of the root of its area: the outline.
    pub outline_ns: f64,
    /// For each pixel.
    pub pixel_ns: f64,
}

impl Default for OccluderCosts {
    /// Fitted to the fastest of six to eight draws of each of 4,000 boxes, and of 5,500 patches of a castle and a hall, at
    /// 640 pixels across: half are off by less than a tenth. The facets of a patch cost, those around it too.
    fn default() -> Self {
        Self {
            convex: DrawingCosts { base_ns: 330.0, edge_ns: 5.0, outline_ns: 5.0, pixel_ns: 0.02 },
            patch: DrawingCosts { base_ns: 650.0, edge_ns: 7.0, outline_ns: 2.0, pixel_ns: 0.03 },
            look_ns: 30.0,
            test_ns: 20.0,
            begin_ns: 10_000.0,
        }
    }
}

impl Costs {
    /// The most that anything may cost, in nanoseconds: a second. Longer is a unit mistaken.
    pub const MOST_NS: f64 = 1e9;

    /// r: a triangle of a material class drawn, pixels apart; in nanoseconds.
    #[must_use]
    pub const fn drawn_ns(&self, alpha: Alpha) -> f64 {
        match alpha {
            Alpha::Opaque => self.opaque_triangle_ns,
            Alpha::Masked => self.masked_triangle_ns,
            Alpha::Blended => self.blended_triangle_ns,
        }
    }

    /// t/r: the test of a cluster, in opaque triangles drawn. Where it is far below 1, testing every
    /// cluster costs nothing that matters. NaN or infinite for costs that [`Self::check`] refuses.
    #[must_use]
    pub const fn t_over_r(&self) -> f64 {
        self.cluster_test_ns / self.opaque_triangle_ns
    }

    /// Every cost that is measured with its field's name without the unit, for tables and files; in the order of the
    /// fields.
    #[must_use]
    pub const fn named(&self) -> [(&'static str, f64); 8] {
        [
            ("object_test", self.object_test_ns),
            ("cluster_test", self.cluster_test_ns),
            ("triangle_test", self.triangle_test_ns),
            ("rejected_triangle", self.rejected_triangle_ns),
            ("opaque_triangle", self.opaque_triangle_ns),
            ("masked_triangle", self.masked_triangle_ns),
            ("blended_triangle", self.blended_triangle_ns),
            ("draw", self.draw_ns),
        ]
    }

    /// Costs from a value for each name of [`Self::named`]; in nanoseconds, and not yet checked.
    pub fn from_named(mut value: impl FnMut(&'static str) -> f64) -> Self {
        Self {
            object_test_ns: value("object_test"),
            cluster_test_ns: value("cluster_test"),
            triangle_test_ns: value("triangle_test"),
            rejected_triangle_ns: value("rejected_triangle"),
            opaque_triangle_ns: value("opaque_triangle"),
            masked_triangle_ns: value("masked_triangle"),
            blended_triangle_ns: value("blended_triangle"),
            draw_ns: value("draw"),
            occluders: OccluderCosts::default(),
        }
    }

    /// Whether every cost is finite, above 0 and at most [`Self::MOST_NS`]; if not, the first that is
    /// not, in the order of the fields.
    pub fn check(&self) -> Result<(), CostsError> {
        for (what, value) in self.named() {
            if !(value > 0.0 && value <= Self::MOST_NS) {
                return Err(CostsError { what, value });
            }
        }
        Ok(())
    }
}

/// A cost that cannot be one.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[error("{what} costs {value} ns; it must be above 0 and at most {} ns, a second", Costs::MOST_NS)]
pub struct CostsError {
    /// Which, by its name in [`Costs::named`].
    pub what: &'static str,
    /// Its value, in nanoseconds.
    pub value: f64,
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A different value for each, in the order of the fields.
    fn counted() -> Costs {
        let mut n = 0.0;
        Costs::from_named(|_| {
            n += 1.0;
            n
        })
    }

    #[test]
    fn each_name_is_of_its_own_field() {
        let costs = counted();
        assert_eq!(costs.check(), Ok(()));
        assert_eq!(costs.named().map(|(_, v)| v), [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0]);
        let again = Costs::from_named(|name| {
            costs.named().into_iter().find(|(n, _)| *n == name).map_or(f64::NAN, |(_, v)| v)
        });
        assert_eq!(again, costs);
    }

    #[test]
    fn a_class_has_its_own_cost_and_t_over_r_takes_opaque() {
        let costs = counted();
        let drawn = [Alpha::Opaque, Alpha::Masked, Alpha::Blended].map(|a| costs.drawn_ns(a));
        assert_eq!(drawn, [5.0, 6.0, 7.0]);
        assert_eq!(costs.t_over_r(), 0.4);
    }

    #[test]
    fn what_costs_nothing_or_forever_is_named() {
        for value in [0.0, -1.0, f64::NAN, f64::INFINITY, 2e9] {
            for (what, _) in counted().named() {
                let costs = Costs::from_named(|name| if name == what { value } else { 1.0 });
                let error = costs.check().unwrap_err();
                assert_eq!(error.what, what);
                assert!(error.to_string().contains(&format!("{what} costs {value} ns")), "{error}");
            }
        }
    }
}
