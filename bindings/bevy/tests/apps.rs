//! Two apps in one process: neither sees the other's entities.
mod common;

use common::{Headless, cube};

#[test]
fn two_apps_in_one_process_keep_to_themselves() {
    let mut apps = [Headless::with_plugin(), Headless::with_plugin()];
    let cameras = [0, 1].map(|i| apps[i].camera());
    let seen = cube(&mut apps[0], [0.0, 0.0, -5.0]);
    cube(&mut apps[1], [0.0, 0.0, 5.0]);
    apps.iter_mut().for_each(|app| app.frames(2));
    assert_eq!(apps[0].seen(cameras[0]), [seen]);
    assert_eq!(apps[1].seen(cameras[1]), []);
}
