//! What effects and lights bring to the picture, shown beside their switches.

use crate::driver::{Files, Window};
use egui_kittest::kittest::Queryable;
use raymini::analysis::contributions::{Contributor, LONGER_SIDE, Whole};
use raymini::analysis::cost::Effect;
use raymini::gui::App;
use raymini::gui::jobs::Lane;
use raymini::render::RunConfig;

const SHADOWS: Contributor = Contributor::Effect(Effect::Shadows);

fn knows(contributor: Contributor) -> impl Fn(&App) -> bool {
    move |app| app.contributions().known(&contributor).is_some()
}

#[test]
fn what_shadows_bring_is_seen_beside_their_switch_and_in_a_window() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    let picture = window.harness.get_by_label("Contribution of shadows");
    picture.scroll_to_me();
    window.until("it is known what shadows bring", knows(SHADOWS));
    let found = window
        .app()
        .contributions()
        .known(&SHADOWS)
        .unwrap()
        .clone();
    let run = RunConfig::default();
    let whole = Whole::render(window.scene(), None, LONGER_SIDE, &run).unwrap();
    let expected = whole.unwrap().contribution(&SHADOWS, &run).unwrap();
    assert_eq!(Some(found), expected, "as the library says");

    window.operate("Contribution of shadows");
    assert!(window.has("Show: Change") && window.says("Mean change") && window.says("relMSE"));
    window.click("Show: Without");
    window.click("Show: With");
    window.harness.render().unwrap();

    // Of another scene it is found out anew.
    window.operate("Anti-aliasing");
    window.harness.run_steps(2);
    assert!(window.app().contributions().known(&SHADOWS).is_none());
    window.until("it is known again", knows(SHADOWS));

    // What is off brings nothing, and has no picture.
    window.operate("Shadows: Off");
    window.harness.run_steps(2);
    assert!(!window.has("Contribution of shadows") && !window.says("Mean change"));
}

#[test]
fn the_share_of_a_light_is_in_its_panel() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    window.click("Select Light 1");
    window.until(
        "it is known what the light brings",
        knows(Contributor::Light(0)),
    );
    window.harness.run_steps(2);
    assert!(window.says("+100 %"), "nothing else shines");
}

#[test]
fn nothing_is_found_out_where_it_is_switched_off_or_nobody_looks() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    window.until("all that is seen is known", |app| {
        !app.contributions().is_missing() && !app.works_in(Lane::Contributions)
    });
    assert!(
        window
            .app()
            .contributions()
            .known(&Contributor::Light(0))
            .is_none()
    );
    let frames = window.harness.try_run_realtime();
    assert!(frames.is_ok(), "the window comes to rest");
    let started = window.app().jobs_started(Lane::Contributions);
    window.operate("Contributions");
    window.operate("Anti-aliasing");
    // Longer than the user must rest for one.
    std::thread::sleep(std::time::Duration::from_millis(700));
    window.harness.run_steps(5);
    assert_eq!(window.app().jobs_started(Lane::Contributions), started);
    assert!(
        window
            .harness
            .query_by_label("Contribution of shadows")
            .is_none()
    );
}
