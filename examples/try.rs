use texray::render::*;
struct O;
impl Observer for O {
    fn progress(&mut self, p: &Progress) {
        eprint!("\r{:?}        ", p.fraction);
    }
    fn stop_requested(&self) -> bool {
        false
    }
}
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let t = std::time::Instant::now();
    let scene = texray::scene::Scene::load(a[1].as_ref()).unwrap();
    eprintln!("load {:?} {} triangles", t.elapsed(), scene.triangles.len());
    let ctx = texray::gpu::Context::new(&texray::gpu::ContextOptions {
        validation: std::env::var("VAL").is_ok(),
        ..Default::default()
    })
    .unwrap();
    let mut s = Settings::for_scene(&scene);
    s.spp = a[2].parse().unwrap();
    s.width = a[3].parse().unwrap();
    s.height = a[4].parse().unwrap();
    s.filter = texray::scene::Filter::Box;
    if std::env::var("NORR").is_ok() {
        s.roulette = Roulette::Off;
    }
    if let Ok(x) = std::env::var("SAMPLER") {
        if x == "ind" {
            s.sampler = Sampler::Independent
        }
    }
    let mut tuning = Tuning::default();
    if let Ok(x) = std::env::var("REFILL") {
        tuning.refill_eighths = Some(x.parse().unwrap())
    }
    if let Ok(x) = std::env::var("RUN") {
        tuning.run_samples = Some(x.parse().unwrap())
    }
    let r = Renderer::new(&ctx, &scene, &s, &tuning).unwrap().render(&mut O).unwrap();
    eprintln!("\n{:#?}", r.report);
    eprintln!(
        "Mpaths/s {:.3} Mrays/s {:.2} nodes/ray {:.2} tris/ray {:.2} rmse {:?}",
        r.report.paths as f64 / r.report.seconds.render / 1e6,
        r.report.rays as f64 / r.report.seconds.render / 1e6,
        r.report.node_visits as f64 / r.report.rays as f64,
        r.report.triangle_tests as f64 / r.report.rays as f64,
        r.film.relative_rmse()
    );
    let m = r.film.mean();
    let mean: [f64; 3] = std::array::from_fn(|c| m.iter().map(|p| p[c] as f64).sum::<f64>() / m.len() as f64);
    eprintln!("mean {mean:?} valid {:?}", ctx.validation());
    let bytes: Vec<u8> = m
        .iter()
        .flat_map(|p| {
            p.map(|x| {
                let x = x.clamp(0., 1.);
                let y = if x <= 0.0031308 { 12.92 * x } else { 1.055 * x.powf(1. / 2.4) - 0.055 };
                (y * 255.0 + 0.5) as u8
            })
        })
        .collect();
    image::save_buffer("/tmp/out.png", &bytes, s.width, s.height, image::ColorType::Rgb8).unwrap();
}
