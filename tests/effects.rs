//! Rung 6: the least set of effects gives the same picture as all of them, bit for bit; taking out one that a scene calls for
//! changes it (the control: a comparison that cannot fail proves nothing).

mod harness;

use harness::device::{assert_same, bits, render, render_tuned, scene_files};
use texray::interface::EFFECTS;
use texray::render::effects::{EFFECT_NAMES, Effects};
use texray::render::{Settings, Tuning};
use texray::scene::{Filter, Scene};

fn small(scene: &Scene) -> Settings {
    Settings { width: 25, height: 19, spp: 2, ..Settings::for_scene(scene) }
}

#[test]
fn the_least_set_gives_the_same_picture_as_all_effects() {
    for file in scene_files() {
        let scene = Scene::load(&file).expect("a scene of the repository loads");
        for filter in [Filter::Box, Filter::BlackmanHarris] {
            let least = Settings { filter, ..small(&scene) };
            let all = Settings { all_effects: true, ..least.clone() };
            assert!(Effects::of(&scene, &least).names().len() < EFFECTS as usize, "{} tests nothing", file.display());
            let what = format!("{} with {filter:?}", file.display());
            assert_same(&bits(&render(&scene, &least)), &bits(&render(&scene, &all)), &what);
        }
    }
}

#[test]
fn every_effect_that_a_scene_calls_for_shows() {
    let mut shown = [false; EFFECTS as usize];
    for file in scene_files() {
        let scene = Scene::load(&file).expect("a scene of the repository loads");
        let settings = small(&scene);
        let effects = Effects::of(&scene, &settings);
        let reference = bits(&render(&scene, &settings));
        for effect in (0..EFFECTS).filter(|&effect| effects.is_on(effect)) {
            let tuning = Tuning { without_effect: Some(effect), ..Tuning::default() };
            let without = bits(&render_tuned(&scene, &settings, &tuning));
            let name = EFFECT_NAMES[effect as usize];
            assert_ne!(reference, without, "{}: leaving out {name} changes nothing", file.display());
            shown[effect as usize] = true;
        }
    }
    assert!(shown.iter().all(|&shown| shown), "no scene calls for some of {EFFECT_NAMES:?}: {shown:?}");
}
