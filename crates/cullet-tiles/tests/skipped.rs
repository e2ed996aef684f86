//! The last program that `cargo test` runs before the doc tests, for cargo takes packages and programs in the order of their names:
//! it tells what tests of all packages skipped, unless the last doc test can.

fn main() {
    // With words it is asked for its tests, or for one of them: it has none.
    if std::env::args().len() == 1 {
        cullet_testkit::tell_skipped();
    }
}
