//! The tour: every kind of culling has a stop, every stop is reached, and what it asks is answered
//! by the engine.

mod shown;

use std::sync::Arc;

use cullet::Stage;
use cullet_viewer::link;
use cullet_viewer::session::{Given, STOPS, Session, Stop, Tour};
use cullet_viewer::state::Layout;
use cullet_viewer::world::Source;
use eframe::egui::{self, Key, Pos2};

use shown::{Panels, SIZE};

/// A phone, held upright, as narrow as they come.
const PHONE: egui::Vec2 = egui::vec2(360.0, 740.0);

/// Returns the stop that the tour is at, once it is there.
fn stop(panels: &mut Panels) -> &'static Stop {
    panels.settle();
    (0..4).for_each(|_| panels.frame(Vec::new()));
    let tour = panels.session.tour.as_ref().map(Tour::stop);
    tour.unwrap_or_else(|| panic!("the tour has ended: {:?}", panels.session.notices))
}

/// Answers by a key, and returns what is said to it.
fn answered(panels: &mut Panels, key: Key) -> Given {
    panels.press(key);
    panels.frame(Vec::new());
    panels.session.tour.as_ref().and_then(Tour::given).cloned().expect("an answer was given")
}

#[test]
fn every_stage_of_the_engine_has_a_stop() {
    for stage in Stage::ALL {
        let has = STOPS.iter().any(|stop| stop.stages.first() == Some(&stage));
        assert!(has, "no stop of the tour is about {}", stage.name());
    }
    for Stop { title, words, state, question, choices, .. } in &STOPS {
        let state = link::from_text(state).unwrap_or_else(|e| panic!("{title}: {e}"));
        let source = Source::of_text(&state.scene);
        assert!(matches!(source, Source::Builtin(_)), "{title}: {} is a file", state.scene);
        assert!((2..=3).contains(&choices.len()) && question.ends_with('?'), "{title}");
        // A card of a phone must leave room for the picture.
        assert!(words.len() <= 240 && question.len() <= 90, "{title}: {}", words.len());
    }
}

/// The choices that are right in a window as large as that of these tests. The tour itself asks the
/// engine.
const RIGHT: [&str; STOPS.len()] = [
    "All of it",
    "More than two thirds",
    "More than two thirds",
    "Yes: what it drops may own pixels",
    "About half",
    "Fewer",
    "Some, and never a front face",
    "No: it makes new ones",
    "Before all other tests",
    "None",
    "A tenth to a half",
    "More than two thirds",
    "The set",
    "Frustum",
];

#[test]
fn every_stop_is_reached_and_its_answer_is_the_engines() {
    let mut panels = Panels::open("city:sub=1", "look.wireframe=true");
    let before = panels.session.state.clone();
    let world = panels.session.world.clone().expect("a scene");
    panels.click("Show me what is culled");
    let mut rights = Vec::new();
    for n in 0..STOPS.len() {
        let stop = stop(&mut panels);
        assert_eq!(stop.title, STOPS[n].title);
        let said = |panels: &Panels, text: &str| panels.texts.iter().any(|(t, _)| t.contains(text));
        for text in [stop.title, stop.words, stop.question] {
            assert!(said(&panels, text), "{}: '{text}' is not shown", stop.title);
        }
        let session = &panels.session;
        let wanted = link::from_text(stop.state).expect("a link");
        assert_eq!(session.state.scene, wanted.scene, "{}", stop.title);
        assert_eq!(session.state.stages, wanted.stages, "{}", stop.title);
        assert!(session.notices.is_empty(), "{}: {:?}", stop.title, session.notices);
        let funnel = &session.decision.as_ref().expect("decided").visible.funnel;
        let dropped = |stage: &Stage| funnel.dropped(*stage).triangles;
        assert!(stop.stages.iter().all(|s| dropped(s) > 0), "{}: {funnel:?}", stop.title);
        let words = session.tour_in_words().expect("in words");
        assert!(words.contains(stop.question) && words.contains(stop.choices[1]), "{words}");

        let given = answered(&mut panels, Key::Num2);
        println!("{}: {}: {}", stop.title, stop.choices[given.right], given.because);
        rights.push(stop.choices[given.right]);
        assert_eq!(given.is_right(), given.right == 1);
        assert!(!given.because.contains(['{', '}']), "{}", given.because);
        assert!(said(&panels, &given.because), "{}", stop.title);
        let words = panels.session.tour_in_words().expect("in words");
        let opening = if given.is_right() { "Right." } else { "Not quite. Right is: " };
        assert!(words.starts_with(opening) && words.ends_with(&given.because), "{words}");
        // The first answer stands, and its key does nothing else.
        assert_eq!(answered(&mut panels, Key::Num1), given);
        assert_ne!(panels.session.state.layout, Layout::Wipe);
        panels.press(Key::Enter);
    }
    assert_eq!(rights, RIGHT);
    assert!(panels.session.tour.is_none() && panels.session.tour_in_words().is_none());
    assert_eq!(panels.session.state, before);
    let after = panels.session.world.as_ref().expect("a scene");
    assert!(Arc::ptr_eq(after, &world), "the scene is not loaded again");
    panels.settle();
    panels.press(Key::Num3);
    assert_eq!(panels.session.state.layout, Layout::Wipe);
}

/// Exact stages leave every picture of the tour as it is, and lossy ones do not: by the proof that
/// draws both.
#[test]
fn only_lossy_stops_change_what_is_seen() {
    let mut panels = Panels::open("example:balls", "");
    panels.press(Key::Enter);
    for at in 0..STOPS.len() {
        let stop = stop(&mut panels);
        let is_lossy = [Stage::Detail, Stage::Lod].iter().any(|s| stop.stages.contains(s));
        // Another level is another mesh, whose triangles no comparison of triangles knows; a city
        // takes long to draw.
        let is_drawn = stop.stages != [Stage::Lod] && (is_lossy || at > 3);
        if is_drawn {
            panels.press(Key::V);
            panels.settle();
            let finding = panels.session.truth.finding().expect("proved");
            assert!(finding.visible > 0, "{}", stop.title);
            assert_eq!(finding.lost.is_empty(), !is_lossy, "{}", stop.title);
        }
        panels.press(Key::Enter);
    }
}

#[test]
fn one_goes_back_and_ends_by_keys_and_by_buttons() {
    let mut panels = Panels::open("solids", "dark=false");
    let before = panels.session.state.clone();
    let at = |panels: &Panels| panels.session.tour.as_ref().map(Tour::at);
    panels.click("Tour");
    stop(&mut panels);
    panels.click("Next");
    stop(&mut panels);
    panels.click("1  Less than a third");
    assert!(panels.session.tour.as_ref().and_then(Tour::given).is_some());
    panels.click("Back");
    stop(&mut panels);
    assert_eq!(at(&panels), Some(0));
    panels.press(Key::Backspace);
    panels.press(Key::Enter);
    assert_eq!(at(&panels), Some(1));
    panels.press(Key::Backspace);
    assert_eq!(at(&panels), Some(0));
    panels.press(Key::Escape);
    assert_eq!((at(&panels), &panels.session.state), (None, &before));
    panels.settle();

    // While a scene is loaded, and where another one is opened.
    panels.press(Key::Enter);
    assert!(panels.session.loading().is_some());
    panels.session.answer(0);
    assert!(panels.session.tour.as_ref().and_then(Tour::given).is_none());
    panels.session.open(Source::of_text("example:balls"));
    panels.settle();
    assert_eq!((at(&panels), panels.session.state.scene.as_str()), (None, "example:balls"));

    // And from no scene to none.
    panels.press(Key::Backslash);
    panels.press(Key::Enter);
    stop(&mut panels);
    panels.press(Key::Escape);
    assert!(panels.session.world.is_none() && panels.session.is_settled());
}

#[test]
fn with_reduced_motion_the_camera_jumps() {
    let flies = |calm: bool| {
        let mut session =
            Session::new(egui::Context::default(), "", Some(Source::of_text("example:balls")));
        session.calm = calm;
        let until = |session: &mut Session| {
            while !session.is_settled() || session.world.is_none() {
                session.advance(0.02, [480, 300]);
                std::thread::sleep(std::time::Duration::from_millis(2));
            }
        };
        until(&mut session);
        // From the stop before that about back faces, of the same scene, to the one after it, and
        // back.
        (0..7).for_each(|_| session.tour_on());
        until(&mut session);
        let near = session.chase;
        session.tour_on();
        session.advance(0.1, [480, 300]);
        let first = session.chase;
        until(&mut session);
        (near != first && first != session.chase, first == session.chase, near != session.chase)
    };
    assert_eq!(flies(false), (true, false, true));
    assert_eq!(flies(true), (false, true, true));
}

#[test]
fn on_a_phone_no_text_of_the_tour_is_cut() {
    let mut panels = Panels::open_in(PHONE, "example:balls", "");
    let screen = egui::Rect::from_min_size(Pos2::ZERO, PHONE);
    panels.press(Key::Enter);
    for _ in STOPS {
        let stop = stop(&mut panels);
        for given in [false, true] {
            if given {
                answered(&mut panels, Key::Num1);
                (0..4).for_each(|_| panels.frame(Vec::new()));
            }
            let words = panels.session.tour.as_ref().and_then(Tour::given);
            let because = words.map(|g| g.because.clone()).unwrap_or_default();
            let texts = [stop.title, stop.words, stop.question, &because];
            for text in texts.into_iter().chain(stop.choices.iter().copied()) {
                let place = panels.places.iter().find(|(shown, _)| shown.contains(text));
                let place = place.unwrap_or_else(|| panic!("{}: '{text}' is cut", stop.title)).1;
                assert!(screen.contains_rect(place), "'{text}': {place:?}");
            }
        }
        panels.press(Key::Enter);
    }
    assert!(SIZE.x > PHONE.x && panels.session.tour.is_none());
}
