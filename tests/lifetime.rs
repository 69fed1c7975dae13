//! Rung 9: a render leaves nothing behind, accounts for every byte it copied, and can be stopped at any run.
//!
//! Comes in: scenes of the repository, each test on a context of its own under validation with synchronisation validation.
//! Messages are read after everything is dropped, when leaks show. Comparisons are exact. That messages and leaks are
//! counted at all is shown by the canaries in `tests/device.rs`.

mod harness;

use harness::device::{Silent, assert_same, bits, load};
use texray::bvh::Builder;
use texray::gpu::{Context, ContextOptions, Direction};
use texray::render::{Observer, Progress, Rendered, Renderer, Settings, StopReason, Tuning, startup};
use texray::scene::{Filter, Scene};
use texray::settings::{AccelKind, Buffers, LightPick, Sampler};

/// What a test does with its context, between a clean start and a clean end.
fn leaving_nothing(work: impl FnOnce(&Context)) {
    let options = ContextOptions { validation: true, ..ContextOptions::default() };
    let context = Context::new(&options).unwrap_or_else(|error| panic!("a device and the validation layer: {error}"));
    let (watch, before) = (context.validation_watch(), context.device_bytes());
    work(&context);
    assert_eq!(context.device_bytes(), before, "buffers that outlive the render");
    assert!(context.device_bytes_peak() > before, "no work was done");
    drop(context);
    assert!(watch.report().is_clean(), "{:#?}", watch.report());
}

fn settings(scene: &Scene, spp: u32) -> Settings {
    Settings { width: 26, height: 21, spp, ..Settings::for_scene(scene) }
}

/// Several tiles, and runs of four samples.
fn in_pieces() -> Tuning {
    Tuning { tile: Some([13, 11]), run_samples: Some(4), budget: Some(500), ..Tuning::default() }
}

fn render(context: &Context, scene: &Scene, settings: &Settings, tuning: &Tuning) -> Rendered {
    let renderer = Renderer::new(context, scene, settings, tuning).expect("the scene can be rendered");
    renderer.render(&mut Silent).expect("the render ends")
}

#[test]
fn renders_leave_neither_messages_nor_memory() {
    leaving_nothing(|context| {
        for (name, accel, buffers) in [
            ("cornell-glass", AccelKind::Wide, Buffers::Texel),
            ("teapot", AccelKind::Binary, Buffers::Storage),
            ("cornell-box", AccelKind::Brute, Buffers::Texel),
        ] {
            let scene = load(name);
            let settings = Settings { accel, buffers, builder: Builder::Median, ..settings(&scene, 6) };
            for tuning in [Tuning::default(), in_pieces()] {
                render(context, &scene, &settings, &tuning);
            }
        }
    });
}

#[test]
fn a_renderer_that_never_renders_leaves_nothing() {
    leaving_nothing(|context| {
        let scene = load("cornell-box");
        drop(Renderer::new(context, &scene, &settings(&scene, 4), &Tuning::default()).expect("a renderer"));
    });
}

/// Stops the render once so many samples are done; counts what it was told.
struct StopsAfter {
    samples: u32,
    done: u32,
    fraction: f64,
}

impl Observer for StopsAfter {
    fn progress(&mut self, progress: &Progress) {
        assert!(progress.spp_done >= self.done && progress.spp_done <= progress.spp_target, "{progress:?}");
        assert!(progress.fraction >= self.fraction && progress.fraction <= 1.0, "{progress:?} after {}", self.fraction);
        (self.done, self.fraction) = (progress.spp_done, progress.fraction);
    }

    fn stop_requested(&self) -> bool {
        self.done >= self.samples
    }
}

#[test]
fn a_stopped_render_is_the_shorter_render() {
    leaving_nothing(|context| {
        let scene = load("cornell-mirror");
        // Inside a block, at its end, and in the first run, which always ends: it is the first picture.
        for (stop_after, spp) in [(8, 8), (16, 16), (20, 20), (0, 4)] {
            let mut observer = StopsAfter { samples: stop_after, done: 0, fraction: 0.0 };
            let renderer = Renderer::new(context, &scene, &settings(&scene, 4000), &in_pieces()).expect("a renderer");
            let stopped = renderer.render(&mut observer).expect("the render ends");
            assert_eq!((stopped.report.stop_reason, stopped.report.spp), (StopReason::Interrupted, spp));
            let whole = render(context, &scene, &settings(&scene, spp), &Tuning::default());
            assert_eq!((whole.report.stop_reason, whole.report.spp), (StopReason::Spp, spp));
            assert_same(&bits(&whole), &bits(&stopped), &format!("stopped after {spp} samples"));
            assert_eq!(whole.film.estimate().variance.len(), stopped.film.estimate().variance.len());
            let counts = |rendered: &Rendered| rendered.film.sample_counts();
            assert_eq!(counts(&whole), counts(&stopped));
            assert!(counts(&whole).iter().all(|&count| count == u64::from(spp)), "samples were left out");
        }
    });
}

#[test]
fn every_copied_byte_is_in_the_ledger() {
    leaving_nothing(|context| {
        // The device is asked once, before its first render; what that copies is no render's.
        startup::probe(context).expect("the device answers");
        for (name, buffers, tuning) in [
            ("cornell-box", Buffers::Texel, Tuning::default()),
            ("teapot", Buffers::Texel, in_pieces()),
            ("teapot", Buffers::Storage, Tuning::default()),
        ] {
            let scene = load(name);
            let before = context.copied_bytes();
            let rendered = render(context, &scene, &Settings { buffers, ..settings(&scene, 6) }, &tuning);
            let after = context.copied_bytes();
            let (up, down) = (after.0 - before.0, after.1 - before.1);
            assert!(up > 0 && down > 0, "{name}: {up} {down}");
            let (ledger, bytes) = (&rendered.ledger, rendered.report.bytes);
            assert_eq!((ledger.bytes_up(), ledger.bytes_down()), (up, down), "{name}: ledger and copy calls");
            assert_eq!((bytes.uploaded, bytes.read_back), (up, down), "{name}: report and copy calls");
            let document = serde_json::to_value(ledger).expect("the ledger is JSON");
            assert_eq!((&document["bytes_up"], &document["bytes_down"]), (&up.into(), &down.into()), "{name}: JSON");
            let of = |direction: &str| -> u64 {
                let entries = document["entries"].as_array().expect("entries").iter();
                entries
                    .filter(|entry| entry["direction"] == direction)
                    .filter_map(|entry| entry["bytes"].as_u64())
                    .sum()
            };
            assert_eq!((of("up"), of("down"), of("absent")), (up, down, 0), "{name}: entries of the JSON");
            // What the records alone take is in it by name, byte for byte.
            let up_to = |buffer: &str| -> u64 {
                ledger.entries().iter().filter(|entry| entry.buffer == buffer).map(|entry| entry.bytes).sum()
            };
            assert_eq!(up_to("triangles"), 48 * scene.triangles.len() as u64, "{name}");
            assert_eq!(up_to("surfaces"), 16 * scene.triangles.len() as u64, "{name}");
            assert!(ledger.entries().iter().all(|entry| !entry.why.is_empty()), "{name}: every entry says why");
        }
    });
}

#[test]
fn what_a_scene_does_not_call_for_is_absent() {
    leaving_nothing(|context| {
        let absent = |name: &str, change: &dyn Fn(&mut Settings)| -> Vec<String> {
            let scene = load(name);
            let mut settings = settings(&scene, 1);
            change(&mut settings);
            let ledger = render(context, &scene, &settings, &Tuning::default()).ledger;
            let entries = ledger.entries().into_iter().filter(|entry| entry.direction == Direction::Absent);
            entries.map(|entry| entry.buffer).collect()
        };
        assert_eq!(absent("cornell-box", &|_| ()), ["corners", "random", "light nodes"]);
        let least = |settings: &mut Settings| {
            settings.accel = AccelKind::Brute;
            settings.filter = Filter::Box;
        };
        assert_eq!(absent("cornell-box", &least), ["nodes", "corners", "filter", "random", "light nodes"]);
        assert_eq!(absent("teapot", &|settings| settings.sampler = Sampler::Table), ["light nodes"]);
        let most = |settings: &mut Settings| {
            settings.sampler = Sampler::Table;
            settings.light_pick = LightPick::Tree;
        };
        assert_eq!(absent("teapot", &most), [""; 0]);
        // Asking for every effect brings code, not records.
        assert_eq!(
            absent("cornell-box", &|settings| settings.all_effects = true),
            ["corners", "random", "light nodes"]
        );
    });
}
