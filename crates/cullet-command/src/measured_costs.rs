//! Costs of tests and of drawing, as `cullet calibrate` measures them.

use std::fmt;

use cullet::mesh::Alpha;

/// Costs of tests and of drawing on a machine with a renderer, in nanoseconds of one thread. All
/// must be finite, above 0 and at most [`Self::MOST_NS`]; [`Self::check`] says which is not.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeasuredCosts {
    /// The frustum test of one instance's box, in a batch.
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
}

impl MeasuredCosts {
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

    /// t/r: the test of a cluster, in opaque triangles drawn. Where it is far below 1, testing
    /// every cluster costs nothing that matters. NaN or infinite for costs that [`Self::check`]
    /// refuses.
    #[must_use]
    pub const fn t_over_r(&self) -> f64 {
        self.cluster_test_ns / self.opaque_triangle_ns
    }

    /// Every cost with its field's name without the unit, for tables and files; in the order of the
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
        }
    }

    /// Whether every cost is finite, above 0 and at most [`Self::MOST_NS`]; if not, the first that
    /// is not, in the order of the fields.
    ///
    /// # Errors
    /// See above.
    pub fn check(&self) -> Result<(), CostsError> {
        let wrong = |ns: f64| !(ns > 0.0 && ns <= Self::MOST_NS);
        match self.named().into_iter().find(|&(_, value)| wrong(value)) {
            Some((what, value)) => Err(CostsError { what, value }),
            None => Ok(()),
        }
    }
}

/// A cost that cannot be one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CostsError {
    /// Which, by its name in [`MeasuredCosts::named`].
    pub what: &'static str,
    /// The cost that was given, in nanoseconds.
    pub value: f64,
}

impl fmt::Display for CostsError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (Self { what, value }, most) = (self, MeasuredCosts::MOST_NS);
        write!(f, "{what} costs {value} ns; it must be above 0 and at most {most} ns, a second")
    }
}

impl std::error::Error for CostsError {}

#[cfg(test)]
mod tests {
    use super::*;

    /// A different value for each, in the order of the fields.
    fn counted() -> MeasuredCosts {
        let mut n = 0.0;
        MeasuredCosts::from_named(|_| {
            n += 1.0;
            n
        })
    }

    #[test]
    fn each_name_is_of_its_own_field() {
        let costs = counted();
        assert_eq!(costs.check(), Ok(()));
        assert_eq!(costs.named().map(|(_, v)| v), [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0]);
        let again = MeasuredCosts::from_named(|name| {
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
                let costs =
                    MeasuredCosts::from_named(|name| if name == what { value } else { 1.0 });
                let error = costs.check().unwrap_err();
                assert_eq!(error.what, what);
                assert!(error.to_string().contains(&format!("{what} costs {value} ns")), "{error}");
            }
        }
    }
}
