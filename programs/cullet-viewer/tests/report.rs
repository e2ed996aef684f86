//! The button that makes a report, where the program `cullet` is not to be found: alone in its
//! program, for what it writes goes into the present folder.

use std::time::{Duration, Instant};

use cullet_viewer::session::Session;
use cullet_viewer::world::Source;
use eframe::egui;

#[test]
fn without_the_program_the_cameras_are_written_and_the_command_is_told() {
    let folder = std::env::temp_dir().join(format!("cullet-no-report-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder of ours");
    std::env::set_current_dir(&folder).expect("it is there");
    let mut session = Session::new(egui::Context::default(), "", Some(Source::of_text("solids")));
    let settle = |session: &mut Session| {
        let began = Instant::now();
        while !session.is_settled() || session.world.is_none() {
            session.advance(0.02, [320, 200]);
            assert!(began.elapsed() < Duration::from_secs(240), "it does not settle");
            std::thread::sleep(Duration::from_millis(2));
        }
    };
    settle(&mut session);
    let program = session.order().expect("a scene").program();
    session.make_report();
    assert!(session.is_reporting());
    settle(&mut session);
    let told = session.notices.last().expect("told").clone();
    let cameras = std::fs::read_to_string("cullet-report/cameras.json").expect("written");
    assert!(cameras.contains("eye"), "{cameras}");
    match program {
        None => {
            let command = "type: cullet report solids --path file:cullet-report/cameras.json";
            assert!(told.bad && told.text.contains(command), "{}", told.text);
        }
        // Whoever has it in PATH gets a report.
        Some(_) => assert!(told.text.contains("index.html"), "{}", told.text),
    }
    std::env::set_current_dir(std::env::temp_dir()).expect("it is there");
    std::fs::remove_dir_all(&folder).expect("ours to remove");
}
